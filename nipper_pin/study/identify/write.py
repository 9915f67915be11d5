"""An identified model as a folder that every command accepts, its provenance stated."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from ...mechanism import Mechanism, changed, load
from ...mechanism.export import write_texts
from ...texts import followed
from .fitting.fit import Fit
from .fitting.goodness import Goodness


def write_model(fit: Fit, judged: Goodness, folder: str | Path) -> Mechanism:
    """Write the identified model.

    Args:
        judged: How good it is; the files say so.
        folder: Folder to write; its name becomes the model's. It may exist if it is empty.

    Raises:
        InputError: The folder cannot be written, or holds something else; then nothing is written.
    """
    target = followed(folder)
    problem = fit.objective.problem
    found = changed(problem.mechanism, fit.values)
    document: dict[str, Any] = {**found.description}
    document["title"] = f"{problem.title} (identified: an estimate, not the maker's data)"
    document["provenance"] = _provenance(fit, document.get("provenance", {}))
    heading = [
        f"Identified by nipper-pin identify: {problem.title}",
        f"from the model {problem.mechanism.name}, {len(fit.descents)} starts, seed {fit.seed}.",
        "AN ESTIMATE: fitted to the targets, which does not validate it. Never the maker's data.",
        judged.sentence(),
    ]
    change = _show_collision_shapes if _moves_pins(fit) else None
    write_texts(target, found.urdf, document, Path(found.mesh_folder), heading, change)
    return load(target)


def _provenance(fit: Fit, old: object) -> dict[str, str]:
    """Where every number comes from; identified ones first."""
    problem = fit.objective.problem
    found: dict[str, str] = {}
    for item in problem.parameters:
        value = fit.values[item.path]
        found[item.path] = (
            f"identified: {value:.9g} between {item.low:g} and {item.high:g} (before: "
            f"{item.start:.9g}) from {len(problem.targets)} targets; not measured, not the maker's"
        )
    if _moves_pins(fit):
        found["urdf.visuals"] = "illustration: the collision shapes"
    if isinstance(old, Mapping):
        for key, words in old.items():
            found.setdefault(str(key), str(words))
    return found


def _moves_pins(fit: Fit) -> bool:
    return any(item.path.startswith("points.") for item in fit.objective.problem.parameters)


def _show_collision_shapes(root: ElementTree.Element) -> None:
    """Let moved links show their plain bodies: meshes were drawn for the old places of the pins."""
    for link in root.findall("link"):
        drawn = [item for item in link.findall("visual") if item.find("geometry/mesh") is not None]
        if not drawn:
            continue
        # Half-redrawn links would show a part twice.
        for item in link.findall("visual"):
            link.remove(item)
        for shape in link.findall("collision"):
            picture = copy.deepcopy(shape)
            picture.tag = "visual"
            link.append(picture)

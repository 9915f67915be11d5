"""Models to start from: a commented drawing, and a URDF that another program exported.

The drawing is the least machine that does what a comber's nipper does. Of a URDF the TOML is
written, as far as the URDF tells it. What it does not say is proposed: frames of two bodies that
stand in one place, within what rounded numbers explain, are a pin that closes a loop; limits of
joints are stops; joints on the frame may be drives. `check` on the model says what is left, lengths
in mm and masses in g among it.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from ...arrays import FloatArray
from ...errors import InputError, ModelError, with_words
from ...texts import followed, is_path
from ...tolerances.mechanics import ROUNDED_SHARE
from ...units import MM_PER_M
from ..build.closures import PLANE, frame_point
from ..build.placements import joint_placements
from ..files import parse_xml, toml
from ..files.schema import write_document
from ..files.xml_text import as_unicode, encoding_of
from ..limits import joint_limits, without_room
from ..load import from_sources
from ..mechanism import Mechanism
from ..model_files import check_model_folder, new_folder, new_model, read_model_text

# A frame may have a mass, by that of the machine: some programs write no link without one.
_LIGHT = 1e-3


def write_skeleton(target: str | Path) -> Path:
    """Write a model that can be checked and simulated, with a comment for every decision in it.

    Target, what is returned, and errors as of :func:`new_model`.
    """
    return new_model(target, Path(__file__).with_name("press.toml").read_text(encoding="utf-8"))


@dataclass(frozen=True)
class Exported:
    """What was found in a URDF.

    Attributes:
        closures: Pins that close loops, as the table of the model has them.
        gaps_mm: What the frames of each miss one another by [mm].
        stops: Limits of joints, likewise.
        drives: Joints on the frame, which drives may move, and whether each is a slide.
        unused: Frames without mass that no closure uses.
        lost: Meshes that are not there.
        wrong: Why the model cannot be loaded as it is; empty if it can.
    """

    closures: dict[str, dict[str, str]]
    gaps_mm: dict[str, float]
    stops: dict[str, dict[str, Any]]
    drives: dict[str, bool]
    unused: tuple[str, ...]
    lost: tuple[str, ...]
    wrong: str = ""


def take_urdf(urdf: str | Path, folder: str | Path) -> Exported:
    """Write a model folder of an exported URDF: a copy, its meshes, and a TOML to complete.

    Args:
        folder: Folder to write; its name becomes the model's. It may exist if it is empty.

    Raises:
        InputError: There is no such file, or the folder cannot be written or is not empty.
        ModelError: The URDF is none of a planar machine, or a mesh of a collision is missing.
    """
    path, target = followed(urdf), check_model_folder(folder)
    name, file = target.name, f"{target.name}.urdf"
    if not path.is_file():
        message = f"{urdf} is no file: name the URDF that was exported"
        raise InputError(message, file=str(urdf))
    root = parse_xml(as_unicode(read_model_text(path, encoding_of)), path.name)
    with new_folder(target) as partial:
        lost = _take_meshes(root, path, partial)
        text = '<?xml version="1.0"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"
        (partial / file).write_text(text, encoding="utf-8")
        moving = [item for item in root.findall("joint") if item.get("type") != "fixed"]
        free = sum(item.find("mimic") is None for item in moving)
        document = _document(root.get("name") or name, path.name, free)
        try:
            mechanism = from_sources(name, text, document, partial)
        except InputError as error:
            raise with_words(error, {file: path.name}) from error
        found = _found(root, mechanism, lost)
        document["degrees_of_freedom"] = max(free - 2 * len(found.closures), 1)
        first = next(iter(found.stops), "")
        document |= {"closures": found.closures, "stops": found.stops, "transition_stop": first}
        if first:
            document["shortcuts"] = {"restitution": f"stops.{first}.restitution"}
        try:
            from_sources(name, text, document, partial)
        except InputError as error:
            found = replace(found, wrong=error.message)
        if found.wrong and free <= 2 * len(found.closures):
            wrong = "all pins closed, nothing can move: one may slide in a slot (slot_axis)"
            found = replace(found, wrong=wrong)
        written = {key: value for key, value in document.items() if value}
        lines = ["", toml(written), *_proposals(found), ""]
        write_document(partial / f"{name}.toml", "\n".join(lines))
    return found


def _document(title: str, file: str, freedoms: int) -> dict[str, Any]:
    """The TOML document of a tree alone, whose shaft is a guess."""
    return {
        "format": 1,
        "title": title,
        "degrees_of_freedom": max(freedoms, 1),
        "gravity_m_s2": 9.81,
        "initial_phase": 1,
        "cylinder": {
            "rated_speed_rpm": 60.0,
            "direction": "counter-clockwise",
            "angle_at_touch_deg": 0.0,
            "reference_index": 24.0,
            "reference_angle_deg": 0.0,
        },
        "phases": [{"number": 1, "name": "running", "closed": []}],
        "provenance": {
            "urdf": f"export: {file}",
            "cylinder": "a guess",
            "stops": "limits of the URDF; restitutions are guesses",
            "closures": "proposed: frames that stand in one place",
        },
    }


def _found(root: ElementTree.Element, mechanism: Mechanism, lost: tuple[str, ...]) -> Exported:
    fixed = {
        child.get("link")
        for joint in root.findall("joint")
        if joint.get("type") == "fixed" and (child := joint.find("child")) is not None
    }
    total = sum(inertia.mass for inertia in mechanism.model.inertias)
    frames = [
        name
        for link in root.findall("link")
        if (name := link.get("name", "")) in fixed and _mass(link) <= _LIGHT * total
    ]
    pairs = dict[str, tuple[str, str, float]]()
    for a, b, gap in _closures(frames, mechanism):
        pairs[a if a not in pairs else f"{a}_{b}"] = a, b, gap
    stops = dict(
        limit.stop()
        for limits in joint_limits(root, mechanism)
        for limit in limits
        if limit.narrow(mechanism) and not without_room(limits)
    )
    followers = {coupling.index for coupling in mechanism.couplings}
    used = {name for a, b, _ in pairs.values() for name in (a, b)}
    parents = mechanism.model.parents
    return Exported(
        {name: {"frame_a": a, "frame_b": b} for name, (a, b, _) in pairs.items()},
        {name: MM_PER_M * gap for name, (_, _, gap) in pairs.items()},
        stops,
        {
            joint.name: joint.kind == "prismatic"
            for joint in mechanism.joints
            if not parents[mechanism.model.getJointId(joint.name)] and joint.index not in followers
        },
        tuple(name for name in frames if name not in used),
        lost,
    )


def _mass(link: ElementTree.Element) -> float:
    mass = link.find("inertial/mass")
    return 0.0 if mass is None else float(mass.get("value", "0"))


def _closures(frames: list[str], mechanism: Mechanism) -> list[tuple[str, str, float]]:
    """Frames of two bodies that meet, and which no pin joins there, with the gap between them [m].

    They meet within what rounded numbers explain, which the loader closes.
    """
    model = mechanism.model
    placements = joint_placements(model)
    near = ROUNDED_SHARE * mechanism.reach_m
    place = {name: frame_point(name, model, placements) for name in frames}
    body = {
        name: model.frames[model.getFrameId(name, pin.FrameType.BODY)].parentJoint
        for name in frames
    }
    hinges = [model.getJointId(item.name) for item in mechanism.joints if item.kind == "revolute"]
    found: list[tuple[str, str, float]] = []
    for first, second in combinations(frames, 2):
        gap = _apart(place[first], place[second])
        if body[first] == body[second] or gap > near:
            continue
        pins = [
            {number, model.parents[number]}
            for number in hinges
            if _apart(placements[number].translation, place[first]) <= near
        ]
        pins += [{body[a], body[b]} for a, b, _ in found if _apart(place[a], place[first]) <= near]
        if not _joined(body[first], body[second], pins):
            found.append((first, second, gap))
    return found


def _apart(one: FloatArray, other: FloatArray) -> float:
    """Distance of two points in the side view [m]."""
    return float(np.linalg.norm((one - other)[[*PLANE]]))


def _joined(one: int, other: int, pins: list[set[int]]) -> bool:
    """Whether a chain of pins leads from one body to another."""
    reached = {one}
    while more := {body for pair in pins if pair & reached for body in pair} - reached:
        reached |= more
    return other in reached


def _proposals(found: Exported) -> Iterator[str]:
    """Comments at the end of the file: what only the user can decide."""
    if found.drives:
        yield "# Joints on the frame. Take the # away from what a motor or a cam drives; a driven"
        yield "# joint has no stops. Other laws: fourier, table, cam (the model format lists them)."
    for name, slides in found.drives.items():
        law = 'law = "screw", lead_mm_per_turn = 10.0' if slides else (
            'law = "constant_speed", ratio = 1.0'
        )  # fmt: skip
        (drive,) = toml({"drives": {name: {}}}).strip().splitlines()[-1:]
        yield f"# {drive}"
        yield from (f"# {part}" for part in (f'joint = "{name}"', *law.split(", ")))
    if found.closures:
        yield "#"
        yield "# A closure is a pin. One that slides in a slot has, beside its frames,"
        yield '# slot_axis = "x" (or "z"): along that axis of frame_a, and block_mass_kg = 0.01.'
    if found.unused:
        yield "#"
        yield f"# Frames without mass that nothing uses: {', '.join(found.unused)}."
        yield "# A pin, which may slide in a slot of the other link:"
        yield "# [closures.NAME]"
        yield '# frame_a = ""'
        yield '# frame_b = ""'
        yield '# slot_axis = "x"'
        yield "# block_mass_kg = 0.01"


def _take_meshes(root: ElementTree.Element, urdf: Path, folder: Path) -> tuple[str, ...]:
    """Copy meshes into ``meshes``, where the URDF then names them; tell which are missing."""
    lost, taken = [], dict[Path, str]()
    touching = {id(mesh) for mesh in root.iterfind("link/collision/geometry/mesh")}
    for mesh in root.iter("mesh"):
        written = mesh.get("filename", "")
        source = _mesh(written, urdf)
        if source is None and id(mesh) in touching:
            allowed = f"a file in {urdf.parent}, or in the two folders above: bodies meet by it"
            raise ModelError(file=urdf.name, key="collision mesh", value=written, allowed=allowed)
        if source is None:
            # What is only seen may be missing, and its path must stay in the folder.
            lost.append(written)
            mesh.set("filename", f"meshes/{Path(written).name or 'none'}")
            continue
        name = taken.get(source, source.name)
        if source not in taken and name in taken.values():
            name = f"{source.stem}_{len(taken)}{source.suffix}"
        taken[source] = name
        mesh.set("filename", f"meshes/{name}")
    for source, name in taken.items():
        (folder / "meshes").mkdir(exist_ok=True)
        shutil.copyfile(source, folder / "meshes" / name)
    return tuple(dict.fromkeys(lost))


def _mesh(written: str, urdf: Path) -> Path | None:
    """The file of a mesh: beside the URDF, or in the package in which that lies."""
    inner = written.removeprefix("file://")
    if written.startswith("package://"):
        inner = written.removeprefix("package://").partition("/")[2]
    if not inner or not is_path(inner):
        return None
    homes = (home / inner for home in urdf.parents[:3])
    return next((file for file in homes if file.is_file()), None)

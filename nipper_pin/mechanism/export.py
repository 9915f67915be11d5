"""A model as a folder of its own: URDF, TOML, schema and the meshes that are there."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from .files import parse_xml, path_inside, toml
from .files.schema import write_document
from .load import load
from .mechanism import Mechanism
from .model_files import check_model_folder, new_folder


def export(mechanism: Mechanism, folder: str | Path) -> Path:
    """Write a mechanism, its changed numbers among it, as a folder that every command takes.

    Args:
        mechanism: The mechanism.
        folder: Folder to write; its name becomes the model's. It may exist if it is empty.

    Returns:
        The folder, resolved.

    Raises:
        InputError: The name cannot be a model's, or the folder cannot be written or is not empty.
    """
    target = check_model_folder(folder)
    write_texts(target, mechanism.urdf, mechanism.description, Path(mechanism.mesh_folder))
    return target


def write_texts(
    target: Path,
    urdf: str,
    document: Mapping[str, Any],
    meshes: Path,
    heading: Sequence[str] = (),
    change: Callable[[ElementTree.Element], None] | None = None,
) -> None:
    """Write the folder of a model complete, and such that it can be read, or not at all.

    Args:
        meshes: Folder that relative mesh paths start from.
        heading: Comment at the top of both files, in lines.

    Raises:
        InputError: It cannot be written, is not empty, or cannot be read back.
    """
    name = target.name
    root = parse_xml(urdf, f"{name}.urdf")
    root.set("name", name)
    _without_comments(root)
    if heading:
        note = ElementTree.Comment("\n  " + "\n  ".join(heading) + "\n")
        note.tail = "\n"
        root.insert(0, note)
    if change is not None:
        change(root)
    lines = [*(f"# {line}" for line in heading), "", toml(document)]
    with new_folder(target) as partial:
        _copy_meshes(root, meshes, partial)
        text = '<?xml version="1.0"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"
        (partial / f"{name}.urdf").write_text(text, encoding="utf-8")
        write_document(partial / f"{name}.toml", "\n".join(lines))
        # What cannot be read back does not take its place.
        load(partial)


def _without_comments(root: ElementTree.Element) -> None:
    """Take out comments: they may speak of other numbers, and of another name."""
    for parent in list(root.iter()):
        for item in list(parent):
            if not isinstance(item.tag, str):
                parent.remove(item)


def _copy_meshes(root: ElementTree.Element, old: Path, new: Path) -> None:
    for mesh in root.iter("mesh"):
        file = path_inside(mesh.get("filename", ""), "mesh", f"{new.name}.urdf")
        if not (old / file).is_file():
            # A mesh that is only drawn may be missing.
            continue
        (new / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(old / file, new / file)

"""Changing single values of a model by their paths, before anything is validated."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from ...errors import ModelError, UnknownNameError
from ...units import DEG_PER_TURN
from ..files.csv_tables import inline_tables
from ..files.describe import describe
from ..files.xml_text import parse_xml
from .dimensions import HEADS, change_dimensions, read_dimension
from .paths import UNWRITTEN, in_unit_of, number_at, number_from, replace_value, steps_of
from .points import Layout, read_layout

__all__ = [
    "HEADS",
    "Layout",
    "apply_overrides",
    "by_path",
    "number_at",
    "read_dimension",
    "read_layout",
    "with_tables",
]


# Squares and products of larger numbers overflow before they can be checked.
LARGEST = 1e12


def by_path(
    overrides: Mapping[str, object], data: Mapping[str, object], file: str
) -> dict[str, object]:
    """Overrides by their paths, shortcuts replaced.

    Args:
        overrides: New values by path, or by a shortcut that the document defines.

    Raises:
        UnknownNameError: A name without a dot is no shortcut and no key.
        ModelError: A number has two values: by its path and by a shortcut.
    """
    table = data.get("shortcuts")
    shortcuts = table if isinstance(table, Mapping) else {}
    known = {*shortcuts, *data, *HEADS, *UNWRITTEN}
    found: dict[str, object] = {}
    given: dict[str, str] = {}
    for name, value in overrides.items():
        written = str(shortcuts.get(name, name))
        path, factor = in_unit_of(data, written)
        steps = steps_of(name)
        if len(steps) == 1 and name not in known and steps[0] not in known:
            raise UnknownNameError(kind="key or shortcut", name=name, known=known, where=file)
        if path in found:
            allowed = f"a number once: {given[path]} gives the same one"
            raise ModelError(file=file, key=name, value=value, allowed=allowed)
        found[path] = value if path == written else factor * number_from(value, written, file)
        given[path] = f"{name} = {value!r}"
    return found


def with_tables(
    data: Mapping[str, object], overrides: Mapping[str, object], folder: Path, file: str
) -> tuple[dict[str, object], dict[str, object]]:
    """Write the tables of a document out, so that overrides reach their rows.

    Args:
        overrides: New values by path. Those that name another CSV file count before it is read.

    Returns:
        The document with its tables, and the overrides that are left.

    Raises:
        UnknownNameError: The path of a file leads nowhere.
        ModelError: A file is missing, lies outside the folder or is not such a table.
    """
    named, left = copy.deepcopy(dict(data)), dict(overrides)
    for path in overrides:
        if steps_of(path)[2:] == ["file"]:
            replace_value(named, path, left.pop(path), file)
    return inline_tables(named, folder, file), left


def apply_overrides(
    data: Mapping[str, object], urdf: str, overrides: Mapping[str, object], name: str
) -> tuple[dict[str, object], str]:
    """Apply overrides to the two texts of a model of that name.

    Args:
        data: The TOML document, its tables written out.
        overrides: New values by path: a path into the TOML document such as
            ``stops.jaw.restitution`` (:mod:`.paths`), or one of ``points.``, ``links.`` and
            ``urdf.`` into the URDF (:mod:`.dimensions`). Strings are converted to the type of the
            value that they replace.

    Returns:
        Changed copies of the document and of the URDF text.

    Raises:
        UnknownNameError: A path leads nowhere.
        ModelError: A value cannot be used, or paths contradict one another.
    """
    file, urdf_file = f"{name}.toml", f"{name}.urdf"
    changed = copy.deepcopy(dict(data))
    dimensions: dict[str, float] = {}
    for path, value in overrides.items():
        steps = steps_of(path)
        if steps and steps[0] in HEADS:
            dimensions[path] = number = number_from(value, path, urdf_file)
            # Also false for NaN.
            if not abs(number) <= LARGEST:
                allowed = f"a finite number of the size of a machine's, at most {LARGEST:g}"
                raise ModelError(file=urdf_file, key=path, value=value, allowed=allowed)
        else:
            replace_value(changed, path, value, file)
    _close_turns(changed, overrides, file)
    if dimensions:
        # Points follow closures, guides and contacts, so the document is checked first.
        describe(changed, file)
        root = parse_xml(urdf, urdf_file)
        changed = change_dimensions(root, changed, dimensions, urdf_file)
        urdf = ElementTree.tostring(root, encoding="unicode")
    return changed, urdf


def _close_turns(document: dict[str, Any], written: Iterable[str], file: str) -> None:
    """Change the other end of a drive table too: its first and last row are equal, a turn apart."""
    ends = {tuple(steps_of(path)): path for path in written}
    for steps, path in ends.items():
        if len(steps) != 4 or steps[0] != "drives":
            continue
        _, drive, column, place = steps
        table = document["drives"][drive]
        if table.get("law") != "table":
            continue
        last = f"[{len(table[column]) - 1}]"
        other = {"[0]": last, last: "[0]"}.get(place)
        if other is None or (*steps[:3], other) in ends:
            continue
        turn = DEG_PER_TURN if column == "cylinder_angle_deg" else 0.0
        value = number_at(document, path, file) + (turn if place == "[0]" else -turn)
        replace_value(document, f"drives.{drive}.{column}{other}", value, file)

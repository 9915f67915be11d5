"""Numbers under keys with another unit, ``stiffness_N_per_mm``, brought to the unit of the table.

A key is that of another unit if it differs from a known one in the unit alone, and the two units
are of one kind: ``at_cm`` and ``at_m`` for ``at_mm``, ``density_g_per_cm3`` for ``density_kg_m3``.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any

from ...errors import ModelError
from ...written_units import known_key
from .describe import kind_of_entry
from .description import CylinderDescription, Description

Kinds = Callable[[str, Mapping[str, Any]], Any]
"""The table that an entry of a section is read by, of the section's name and the entry."""


def in_known_units(
    document: Mapping[str, Any],
    file: str,
    top: Collection[str] = Description.__struct_fields__,
    kinds: Kinds = kind_of_entry,
) -> dict[str, Any]:
    """A document in which every number has a key that the tables know, if there is one.

    Args:
        top: Keys that are known above its first table.
        kinds: Tables of its sections; those of a model's file by default.

    Raises:
        ModelError: A number is given in two units.
    """
    found = _table(document, top, "", file)
    for section, entries in found.items():
        where = f"{section}.{{}}"
        if section == "cylinder" and isinstance(entries, Mapping):
            found[section] = _table(entries, CylinderDescription.__struct_fields__, section, file)
        elif isinstance(entries, Mapping):
            found[section] = {
                name: _entry(entry, kinds, section, where.format(name), file)
                for name, entry in entries.items()
            }
        elif isinstance(entries, list | tuple):
            where = f"{section}[{{}}]"
            found[section] = [
                _entry(entry, kinds, section, where.format(number), file)
                for number, entry in enumerate(entries)
            ]
    return found


def _entry(entry: Any, kinds: Kinds, section: str, where: str, file: str) -> Any:
    kind = kinds(section, entry) if isinstance(entry, Mapping) else None
    return entry if kind is None else _table(entry, kind.__struct_fields__, where, file)


def _table(
    table: Mapping[str, Any], known: Collection[str], where: str, file: str
) -> dict[str, Any]:
    """A table whose keys are known, as far as they differ in their units."""
    if table.keys() <= {*known, "law"}:
        return dict(table)
    found: dict[str, Any] = {}
    for key, value in table.items():
        name, factor = (None if key in known else known_key(key, known)) or (key, 1.0)
        if name in found or (name != key and name in table):
            path = f"{where}.{key}" if where else key
            raise ModelError(file=file, key=path, value=value, allowed=f"one number: {name} is it")
        found[name] = value if name == key else _times(value, factor)
    return found


def _times(value: Any, factor: float) -> Any:
    """A number, or a list of them, in another unit; what is none is refused by what reads it."""
    if isinstance(value, list | tuple):
        return [_times(item, factor) for item in value]
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return value * factor if number else value

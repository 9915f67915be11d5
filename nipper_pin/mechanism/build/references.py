"""What tables of a model file name: parts in other tables, and laws; refused if they are none."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeVar

from ...errors import InputError, ModelError, UnknownNameError
from ..files.description import TomlTable

_T = TypeVar("_T")


def named(kind: str, name: str, known: Mapping[str, _T], where: str) -> _T:
    """The part of a name.

    Args:
        kind: What it should be, such as "joint".
    """
    if name not in known:
        raise UnknownNameError(kind=kind, name=name, known=known, where=where)
    return known[name]


def built(build: Callable[[str], _T], kind: str, table: TomlTable, where: str, file: str) -> _T:
    """What a table with a law gives on a joint of a kind, in SI units.

    Args:
        where: Path of the table.

    Raises:
        ModelError: The values of the table make nothing; names the law if that names no key.
    """
    try:
        return build(kind)
    except InputError as error:
        key = str(error.evidence.get("key", "law"))
        value = getattr(table, key, table.__struct_config__.tag)
        raise ModelError(
            file=file, key=f"{where}.{key}", value=value, allowed=error.message
        ) from error

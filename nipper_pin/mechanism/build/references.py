"""What tables of a model file name: parts in other tables, and laws; refused if they are none."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeVar

from ...errors import InputError, ModelError, UnknownNameError

_T = TypeVar("_T")


def named(kind: str, name: str, known: Mapping[str, _T], where: str) -> _T:
    """The part of a name.

    Args:
        kind: What it should be, such as "joint".

    Raises:
        UnknownNameError: There is none.
    """
    if name not in known:
        raise UnknownNameError(kind=kind, name=name, known=known, where=where)
    return known[name]


def built(
    build: Callable[[str], _T],
    kind: str,
    table: object,
    where: str,
    file: str,
    law: str | None = None,
) -> _T:
    """What a table with a law gives on a joint of a kind, in SI units.

    Args:
        where: Path of the table.
        law: Value that is refused where the law does not say which key is wrong.

    Raises:
        ModelError: The values of the table make nothing.
    """
    try:
        return build(kind)
    except InputError as error:
        key = str(error.evidence.get("key", "law"))
        value = getattr(table, key, law)
        raise ModelError(
            file=file, key=f"{where}.{key}", value=value, allowed=error.message
        ) from error

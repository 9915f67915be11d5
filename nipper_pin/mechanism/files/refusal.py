"""Errors of plain data that do not fit their typed tables, with the key and what is allowed."""

from __future__ import annotations

import types
import typing
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import msgspec

Step = str | int
"""A key of a table, or a place in a list."""


@dataclass(frozen=True)
class Refusal:
    """The first value that does not fit.

    Attributes:
        path: Keys and places from the outermost value to this one.
        kind: What it should be, a type hint.
        unknown: A key of it that its type does not have; None if that is not what is wrong.
        missing: A key that it lacks; None if that is not what is wrong.
        text: What the converter says of a value that is itself at fault.
    """

    path: tuple[Step, ...]
    value: object
    kind: Any
    unknown: str | None = None
    missing: str | None = None
    text: str = ""

    @property
    def key(self) -> str:
        """The path as text, such as ``phases[0].name``; "" for the outermost value."""
        steps = (f"[{step}]" if isinstance(step, int) else f".{step}" for step in self.path)
        return "".join(steps).removeprefix(".")


def first_refusal(value: object, kind: Any, path: tuple[Step, ...] = ()) -> Refusal | None:
    """The first place where a value does not fit a type, in the order of the file.

    Args:
        value: Plain data of a TOML document.
        kind: A type hint that :func:`msgspec.convert` can use.
        path: Keys and places that led to the value.

    Returns:
        The place; None if the value fits.
    """
    inner = member_of(kind, value)
    if is_table(inner) and isinstance(value, Mapping):
        return _in_table(value, inner, path)
    for step, item, hint in _items(value, inner):
        found = first_refusal(item, hint, (*path, step))
        if found is not None:
            return found
    return _whole(value, kind, path)


def is_table(kind: Any) -> bool:
    """Whether a type is a table whose keys are known."""
    return isinstance(kind, type) and issubclass(kind, msgspec.Struct)


def may_be_table(kind: Any) -> bool:
    """Whether a type, or one of a union, is a table of any kind."""
    members = (kind, *typing.get_args(kind)) if _is_union(kind) else (kind,)
    return any(is_table(item) or typing.get_origin(item) is dict for item in members)


def member_of(kind: Any, value: object) -> Any:
    """The type of a union that a value belongs to; the type itself if none does.

    Args:
        kind: A type hint.
        value: Plain data; a table belongs to the only table of the union.
    """
    if typing.get_origin(kind) is Annotated and isinstance(value, Mapping | list):
        kind = typing.get_args(kind)[0]
    if not _is_union(kind):
        return kind
    members = typing.get_args(kind)
    tables = [item for item in members if is_table(item)]
    if isinstance(value, list):
        return next((item for item in members if typing.get_origin(item) is tuple), kind)
    return tables[0] if isinstance(value, Mapping) and len(tables) == 1 else kind


def _in_table(value: Mapping[Any, object], kind: Any, path: tuple[Step, ...]) -> Refusal | None:
    hints = typing.get_type_hints(kind, include_extras=True)
    for key, item in value.items():
        if key == kind.__struct_config__.tag_field:
            continue
        if key not in hints:
            return Refusal(path, value, kind, unknown=key)
        found = first_refusal(item, hints[key], (*path, key))
        if found is not None:
            return found
    for field in msgspec.structs.fields(kind):
        if field.required and field.name not in value:
            return Refusal(path, value, kind, missing=field.name)
    return _whole(value, kind, path)


def _items(value: object, kind: Any) -> Iterator[tuple[Step, object, Any]]:
    """Members of a list or of a table of names, with their types."""
    hints = typing.get_args(kind)
    origin = typing.get_origin(kind)
    if isinstance(value, Mapping) and origin is dict:
        yield from ((str(name), item, hints[1]) for name, item in value.items())
    elif isinstance(value, list) and origin is tuple:
        if hints[-1] is Ellipsis:
            yield from ((place, item, hints[0]) for place, item in enumerate(value))
        elif len(hints) == len(value):
            yield from zip(range(len(value)), value, hints, strict=True)


def _whole(value: object, kind: Any, path: tuple[Step, ...]) -> Refusal | None:
    """Error of a table each of whose values is valid."""
    try:
        msgspec.convert(value, kind)
    except msgspec.ValidationError as error:
        return Refusal(path, value, kind, text=str(error))
    return None


def _is_union(kind: Any) -> bool:
    return typing.get_origin(kind) in (typing.Union, types.UnionType)

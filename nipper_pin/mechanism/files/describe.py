"""From plain TOML data to the typed description, with errors that name key, value and choice."""

from __future__ import annotations

import math
import re
import types
import typing
from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeVar

import msgspec

from ...errors import ModelError
from .description import (
    ClosureDescription,
    DamperDescription,
    Description,
    DriveDescription,
    InitialDescription,
    PlanePoint,
    SpringDescription,
    StopDescription,
)

_SECTIONS: dict[str, Any] = {
    "drives": DriveDescription,
    "springs": SpringDescription,
    "dampers": DamperDescription,
    "stops": StopDescription,
    "closures": ClosureDescription,
    "initial": InitialDescription,
}
_MESSAGE = re.compile(r"^(?P<text>.*?)(?: - at `(?P<key>key in )?\$(?P<path>.*)`)?$", re.DOTALL)
_FIELD = re.compile(r"field `(?P<name>[^`]+)`")
_NOUNS: dict[Any, str] = {
    float: "a number",
    int: "a whole number",
    str: "a text that is not empty",
    PlanePoint: "two numbers, x and z",
}
_T = TypeVar("_T")


def describe(data: Mapping[str, object], file: str) -> Description:
    """Convert plain TOML data to the typed description.

    Args:
        data: The TOML document.
        file: Name of the file, for messages.

    Raises:
        ModelError: A key is unknown or missing, or a value cannot be used.
    """
    _refuse_unusable(data, "", file)
    for section, kind in _SECTIONS.items():
        entries = data.get(section, {})
        if not isinstance(entries, Mapping):
            raise ModelError(file=file, key=section, value=entries, allowed="a table of tables")
        # One entry at a time: the converter does not say under which name of a table it failed.
        for name, entry in entries.items():
            _convert(entry, kind, f"{section}.{name}", file)
    return _convert(data, Description, "", file)


def optional_numbers(section: str, entry: Mapping[str, object]) -> dict[str, float]:
    """Numbers that an entry may have and does not, and what they are then.

    Args:
        section: Name of a table of entries, such as ``drives``.
        entry: One of them.

    Returns:
        Defaults by key; 0 for a place that is not given. Empty for an unknown drive law.
    """
    kind = _choose(_SECTIONS[section], entry)
    if not (isinstance(kind, type) and issubclass(kind, msgspec.Struct)):
        return {}
    hints = typing.get_type_hints(kind)
    return {
        field.name: field.default or 0.0
        for field in msgspec.structs.fields(kind)
        if field.name not in entry
        and not field.required
        and hints[field.name] in (float, float | None)
    }


def _refuse_unusable(value: object, path: str, file: str) -> None:
    """Raise for the first NaN or infinity inside the value, and for names no message can show."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            if not str(key).isprintable():
                allowed = "keys and names without line breaks and control characters"
                raise ModelError(file=file, key=path or "the file", value=key, allowed=allowed)
            _refuse_unusable(item, f"{path}.{key}" if path else str(key), file)
    elif isinstance(value, list | tuple):
        for place, item in enumerate(value):
            _refuse_unusable(item, f"{path}[{place}]", file)
    elif isinstance(value, float) and not math.isfinite(value):
        raise ModelError(file=file, key=path, value=value, allowed="a finite number")


def _convert(value: object, kind: type[_T] | Any, prefix: str, file: str) -> _T:
    """Convert one value and turn a refusal into an error that names key, value and choice."""
    try:
        converted: _T = msgspec.convert(value, kind)
    except msgspec.ValidationError as error:
        raise _explain(error, value, kind, prefix, file) from None
    return converted


def _explain(
    error: msgspec.ValidationError, value: object, kind: Any, prefix: str, file: str
) -> ModelError:
    """Build the error for a refused value."""
    match = _MESSAGE.match(str(error))
    text = match["text"] if match else str(error)
    path = (match["path"] or "") if match else ""
    found, inner = _descend(value, kind, path)
    key = (prefix + path).lstrip(".")
    field = _FIELD.search(text)
    known = ", ".join(_keys(inner, found))
    if field and "unknown" in text:
        name = field["name"]
        missing = found.get(name) if isinstance(found, Mapping) else None
        allowed = f"unknown key; known here: {known}"
        return ModelError(
            file=file, key=f"{key}.{name}".lstrip("."), value=missing, allowed=allowed
        )
    if field:
        key = f"{key}.{field['name']}".lstrip(".")
        law = field["name"] == "law" and known == "law"
        choice = f"one of {', '.join(sorted(_laws()))}" if law else f"known here: {known}"
        allowed = f"a required key is missing; {choice}"
        return ModelError(file=file, key=key, value=None, allowed=allowed)
    if path.endswith(".law") or path == ".law":
        text = f"one of {', '.join(sorted(_laws()))}"
    else:
        text = _allowed(inner) or text[:1].lower() + text[1:]
    return ModelError(file=file, key=key or "the file", value=found, allowed=text)


def _descend(value: object, kind: Any, path: str) -> tuple[object, Any]:
    """Follow a path like ``.phases[0].name`` into a value and its type."""
    for name, place in re.findall(r"\.([^.\[\]]+)|\[(\d+)\]", path):
        kind = _member(kind, name, value)
        if name:
            value = value.get(name) if isinstance(value, Mapping) else None
        else:
            value = value[int(place)] if isinstance(value, list | tuple) else None
    return value, kind


def _choose(kind: Any, value: object) -> Any:
    """Pick the struct type that a value of a union type belongs to, or the type itself."""
    if typing.get_origin(kind) is Annotated:
        kind = typing.get_args(kind)[0]
    if typing.get_origin(kind) not in (typing.Union, types.UnionType):
        return kind
    structs = [
        item
        for item in typing.get_args(kind)
        if isinstance(item, type) and issubclass(item, msgspec.Struct)
    ]
    law = value.get("law") if isinstance(value, Mapping) else None
    for item in structs:
        if len(structs) == 1 or item.__struct_config__.tag == law:
            return item
    return kind


def _member(kind: Any, name: str, value: object) -> Any:
    """Type of a field, or of the items of a sequence if the name is empty."""
    kind = _choose(kind, value)
    if not name:
        arguments = typing.get_args(kind)
        return arguments[0] if arguments else None
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        return typing.get_type_hints(kind, include_extras=True).get(name)
    return None


def _keys(kind: Any, value: object) -> list[str]:
    """Keys that a table of this type may have."""
    kind = _choose(kind, value)
    if not (isinstance(kind, type) and issubclass(kind, msgspec.Struct)):
        return ["law"]
    tag = kind.__struct_config__.tag_field
    return sorted([field.name for field in msgspec.structs.fields(kind)] + ([tag] if tag else []))


def _allowed(kind: Any) -> str:
    """What a value of this type may be, in words; empty if the converter says it well enough."""
    arguments = typing.get_args(kind)
    if type(None) in arguments:
        return _allowed(next(item for item in arguments if item is not type(None)))
    if typing.get_origin(kind) is Literal:
        return f"one of {', '.join(str(item) for item in arguments)}"
    if typing.get_origin(kind) is not Annotated:
        return _NOUNS.get(kind, "")
    meta = arguments[1]
    limits = {
        "above": meta.gt,
        "at least": meta.ge,
        "below": meta.lt,
        "at most": meta.le,
    }
    words = [f"{word} {limit:g}" for word, limit in limits.items() if limit is not None]
    if meta.min_length is not None and arguments[0] is not str:
        return "a list that is not empty"
    return " ".join([_NOUNS.get(arguments[0], ""), " and ".join(words)]).strip()


def _laws() -> list[str]:
    """Names of the drive laws."""
    return [str(item.__struct_config__.tag) for item in typing.get_args(DriveDescription)]

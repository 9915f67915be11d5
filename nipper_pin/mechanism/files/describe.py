"""From plain TOML data to the typed description, with errors that name key, value and choice.

Numbers under keys with another unit, ``stiffness_N_per_mm``, are brought to the unit of the table.
A key is that of another unit if it differs from a known one in the unit alone, and the two units
are of one kind: ``at_cm`` and ``at_m`` for ``at_mm``, ``density_g_per_cm3`` for ``density_kg_m3``.
"""

from __future__ import annotations

import types
import typing
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, Literal, TypeVar

import msgspec

from ...errors import ModelError, meant
from ...written_units import known_key
from .description import (
    LARGEST,
    ClosureDescription,
    CylinderDescription,
    DamperDescription,
    Description,
    InitialDescription,
    PlanePoint,
    SpringDescription,
    StopDescription,
)
from .register import DRIVES, FORCES, RESTITUTIONS, STOPS, Register

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


def first_refusal(value: Any, kind: Any, text: str, path: tuple[Step, ...] = ()) -> Refusal:
    """The first place, in the order of the file, where a value does not fit a type.

    Args:
        value: Plain data of a TOML document, which :func:`msgspec.convert` has refused.
        kind: The type hint by which it has.
        text: What it says of the value.
        path: Keys and places that led to the value.
    """
    inner = member_of(kind, value)
    for step, item, hint in _items(value, inner):
        if hint is None:
            return Refusal(path, value, inner, unknown=str(step))
        try:
            msgspec.convert(item, hint)
        except msgspec.ValidationError as error:
            return first_refusal(item, hint, str(error), (*path, step))
    if not is_table(inner):
        return Refusal(path, value, kind, text=text)
    required = [field.name for field in msgspec.structs.fields(inner) if field.required]
    missing = next((name for name in required if name not in value), None)
    return Refusal(path, value, inner, missing=missing, text=text)


def is_table(kind: Any) -> bool:
    """Whether a type is a table whose keys are known."""
    return isinstance(kind, type) and issubclass(kind, msgspec.Struct)


def member_of(kind: Any, value: object) -> Any:
    """The type of a table or list, or that of a union, which a table or list belongs to.

    Returns:
        None if there is none, and of values that are neither.
    """
    if typing.get_origin(kind) is Annotated:
        kind = typing.get_args(kind)[0]
    union = typing.get_origin(kind) in (typing.Union, types.UnionType)
    for member in typing.get_args(kind) if union else (kind,):
        origin = typing.get_origin(member)
        if isinstance(value, Mapping) and (is_table(member) or origin is dict):
            return member
        if isinstance(value, list) and origin is tuple:
            return member
    return None


def _items(value: Any, kind: Any) -> Iterator[tuple[Step, object, Any]]:
    """Members of a table or list with their types; None of a key that its table does not have."""
    hints = typing.get_args(kind)
    if is_table(kind):
        tag, known = kind.__struct_config__.tag_field, typing.get_type_hints(kind, None, None, True)
        yield from ((key, item, known.get(key)) for key, item in value.items() if key != tag)
    elif typing.get_origin(kind) is dict:
        yield from ((str(name), item, hints[1]) for name, item in value.items())
    elif kind is not None and hints[-1] is Ellipsis:
        yield from ((place, item, hints[0]) for place, item in enumerate(value))
    elif kind is not None and len(hints) == len(value):
        yield from zip(range(len(value)), value, hints, strict=True)


_SECTIONS: dict[str, Any] = {
    "springs": SpringDescription,
    "dampers": DamperDescription,
    "stops": StopDescription,
    "closures": ClosureDescription,
    "initial": InitialDescription,
}
_LAWS: dict[str, Register[Any]] = {"drives": DRIVES, "forces": FORCES}
_LAWS_OF_STOPS: dict[str, Register[Any]] = {"restitution_law": RESTITUTIONS, "adjusted": STOPS}
_NOUNS: dict[Any, str] = {
    float: "a number",
    int: "a whole number",
    str: "a text that is not empty",
    PlanePoint: "two numbers, x and z",
}
# Every phase is checked with all closures and stops.
_MOST_ENTRIES, _MOST_PHASES = 300, 64
_T = TypeVar("_T")


def describe(data: Mapping[str, object], file: str) -> Description:
    """Convert plain TOML data to the typed description."""
    _check_size(data, file)
    refuse_unusable(data, "", file)
    # Errors of single elements are reported before errors of the whole.
    elements = {section: _entries(data, section, file) for section in (*_LAWS, *_SECTIONS)}
    rest = {key: value for key, value in data.items() if key not in elements}
    whole: Description = converted(rest, Description, "", file)
    return msgspec.structs.replace(whole, **elements)


def describe_entry(data: Mapping[str, Any], section: str, name: str, file: str) -> Any:
    """One entry of a section, as :func:`describe` gives it."""
    entry = {section: {name: data[section][name]}}
    refuse_unusable(entry, "", file)
    return _entries(entry, section, file)[name]


def _check_size(data: Mapping[str, object], file: str) -> None:
    """Refuse more entries than can be checked while somebody waits."""
    limits = {**dict.fromkeys((*_LAWS, *_SECTIONS), _MOST_ENTRIES), "phases": _MOST_PHASES}
    for section, most in limits.items():
        entries = data.get(section)
        if isinstance(entries, Mapping | list) and len(entries) > most:
            value = f"{len(entries)} entries"
            raise ModelError(file=file, key=section, value=value, allowed=f"at most {most}")


def _with_law(register: Register[Any], entry: object, prefix: str, file: str) -> Any:
    """Convert an entry by the table of the law that it names; laws may be added at any time."""
    if not isinstance(entry, Mapping):
        raise ModelError(file=file, key=prefix, value=entry, allowed="a table with a law")
    name = entry.get("law")
    kind = register.kind(name)
    if kind is None:
        known = register.names()
        lacking = "" if "law" in entry else "a required key is missing; "
        near = meant(name, known) if isinstance(name, str) else ""
        allowed = f"{lacking}{near}one of {', '.join(known)}"
        raise ModelError(file=file, key=f"{prefix}.law", value=name, allowed=allowed)
    return converted(entry, kind, prefix, file)


def _entries(data: Mapping[str, object], section: str, file: str) -> dict[str, Any]:
    """Convert the entries of a section of named tables."""
    entries = data.get(section, {})
    if not isinstance(entries, Mapping):
        raise ModelError(file=file, key=section, value=entries, allowed="a table of tables")
    found: dict[str, Any] = {}
    for name, entry in entries.items():
        where = f"{section}.{name}"
        if section in _LAWS:
            found[name] = _with_law(_LAWS[section], entry, where, file)
            continue
        found[name] = converted(entry, _SECTIONS[section], where, file)
        for key, register in _LAWS_OF_STOPS.items() if section == "stops" else ():
            if (table := getattr(found[name], key)) is not None:
                law = {key: _with_law(register, table, f"{where}.{key}", file)}
                found[name] = msgspec.structs.replace(found[name], **law)
    return found


def kind_of_entry(section: str, entry: Mapping[str, object]) -> Any:
    """The table that an entry of a section is read by; None of an unknown law or section."""
    register = _LAWS.get(section)
    return _SECTIONS.get(section) if register is None else register.kind(entry.get("law"))


def optional_numbers(section: str, entry: Mapping[str, object]) -> dict[str, float]:
    """Defaults of the numbers that an entry omits.

    Returns:
        Defaults by key; 0 for a place that is not given. Empty for an unknown drive law.
    """
    kind = kind_of_entry(section, entry)
    if kind is None:
        return {}
    return {key: value for key, value in _defaults(kind).items() if key not in entry}


@cache
def _defaults(kind: type[msgspec.Struct]) -> dict[str, float]:
    """Numbers of a table that need not be written, and what they are then."""
    hints = typing.get_type_hints(kind)
    return {
        field.name: field.default or 0.0
        for field in msgspec.structs.fields(kind)
        if not field.required and hints[field.name] in (float, float | None)
    }


def refuse_unusable(value: object, path: str, file: str) -> None:
    """Raise for the first NaN or infinity inside the value, and for names no message can show."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            if not str(key).isprintable():
                allowed = "keys and names without line breaks and control characters"
                raise ModelError(file=file, key=path or "the file", value=key, allowed=allowed)
            refuse_unusable(item, f"{path}.{key}" if path else str(key), file)
    elif isinstance(value, list | tuple):
        # Tables of many rows are usual, and wrong ones seldom.
        if all(type(item) is float and -LARGEST <= item <= LARGEST for item in value):
            return
        for place, item in enumerate(value):
            refuse_unusable(item, f"{path}[{place}]", file)
    elif isinstance(value, int | float) and not abs(value) <= LARGEST:
        allowed = f"a finite number of at most {LARGEST:g}"
        raise ModelError(file=file, key=path, value=value, allowed=allowed)


def converted(value: object, kind: type[_T] | Any, prefix: str, file: str) -> _T:
    """One value of a document as a type that ``msgspec.convert`` knows.

    Args:
        prefix: Path of the value; "" for the whole document.

    Raises:
        ModelError: It does not fit; names key, value and choice.
    """
    try:
        found: _T = msgspec.convert(value, kind)
    except msgspec.ValidationError as error:
        raise _explain(first_refusal(value, kind, str(error)), prefix, file) from None
    return found


def _explain(refusal: Refusal, prefix: str, file: str) -> ModelError:
    """Build the error for a refused value."""
    found = refusal.value
    key = ".".join(part for part in (prefix, refusal.key) if part)
    known = ", ".join(_keys(refusal.kind))
    if refusal.unknown is not None:
        value = found[refusal.unknown] if isinstance(found, Mapping) else None
        near = meant(refusal.unknown, _keys(refusal.kind))
        key, allowed = f"{key}.{refusal.unknown}", f"unknown key; {near}known here: {known}"
    elif refusal.missing is not None:
        key, value = f"{key}.{refusal.missing}", None
        allowed = f"a required key; known here: {known}"
    else:
        text = refusal.text
        value, allowed = found, allowed_values(refusal.kind) or text[:1].lower() + text[1:]
        if isinstance(found, list) and "of length 2" in text and len(found) > 2:
            allowed = "two numbers; decimals have a point, and a comma divides numbers"
    return ModelError(
        file=file, key=key.removeprefix(".") or "the file", value=value, allowed=allowed
    )


def _keys(kind: Any) -> list[str]:
    """Keys that a table of this type may have."""
    if not is_table(kind):
        return []
    tag = kind.__struct_config__.tag_field
    return sorted([field.name for field in msgspec.structs.fields(kind)] + ([tag] if tag else []))


def allowed_values(kind: Any) -> str:
    """Return the allowed values of a type in words; empty if the converter's message suffices."""
    arguments = typing.get_args(kind)
    if type(None) in arguments:
        return allowed_values(next(item for item in arguments if item is not type(None)))
    if typing.get_origin(kind) is Literal:
        return f"{'one of ' if arguments[1:] else ''}{', '.join(str(item) for item in arguments)}"
    if typing.get_origin(kind) is not Annotated:
        return _NOUNS.get(kind, "")
    meta = arguments[1]
    limits = {
        "above": meta.gt,
        "at least": meta.ge,
        "below": meta.lt,
        "at most": meta.le,
    }
    words = [f"{word} {limit:.12g}" for word, limit in limits.items() if limit is not None]
    if meta.min_length is not None and arguments[0] is not str:
        return "a list that is not empty"
    allowed = " ".join([_NOUNS.get(arguments[0], ""), " and ".join(words)]).strip()
    return "; ".join([allowed, *(meta.extra or {}).values()])


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
        if section == "cylinder" and isinstance(entries, Mapping):
            found[section] = _table(entries, CylinderDescription.__struct_fields__, section, file)
        elif isinstance(entries, Mapping):
            found[section] = {
                name: _entry(entry, kinds, section, f"{section}.{name}", file)
                for name, entry in entries.items()
            }
        elif isinstance(entries, list | tuple):
            found[section] = [
                _entry(entry, kinds, section, f"{section}[{number}]", file)
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

"""Changing single values of a model by their dotted paths, before anything is validated."""

from __future__ import annotations

import copy
import numbers
import tomllib
from collections.abc import Mapping
from xml.etree import ElementTree

from ..errors import ModelError, UnknownNameError
from .describe import describe
from .dimensions import HEADS, change_dimensions
from .urdf import parse_xml
from .urdf_paths import steps_of

# Squares and products of what is larger leave the range of a float before anything can be checked.
_LARGEST = 1e12


def apply_overrides(
    data: Mapping[str, object],
    urdf: str,
    overrides: Mapping[str, object],
    file: str,
    urdf_file: str,
) -> tuple[dict[str, object], str]:
    """Apply overrides to a model's two texts.

    Args:
        data: The TOML document.
        urdf: The URDF text.
        overrides: New values by path: a path into the TOML document such as
            ``stops.jaw.restitution``, or one of ``points.``, ``links.`` and ``urdf.`` into the URDF
            (:mod:`.dimensions`). Strings are converted to the type of the value that they replace.
        file: Name of the TOML file, for messages.
        urdf_file: Name of the URDF file, for messages.

    Returns:
        Changed copies of the document and of the URDF text.

    Raises:
        UnknownNameError: A path leads nowhere.
        ModelError: A value cannot be used, or paths contradict one another.
    """
    changed = copy.deepcopy(dict(data))
    dimensions: dict[str, float] = {}
    for path, value in overrides.items():
        steps = steps_of(path)
        if steps[:1] and steps[0] in HEADS:
            dimensions[path] = number = _number(value, path, urdf_file)
            # Also false for NaN.
            if not abs(number) <= _LARGEST:
                allowed = f"a finite number of the size of a machine's, at most {_LARGEST:g}"
                raise ModelError(file=urdf_file, key=path, value=value, allowed=allowed)
        else:
            _replace(changed, steps, path, value, file)
    if dimensions:
        # Points follow closures, guides and contacts, which have to be what they should be.
        describe(changed, file)
        root = parse_xml(urdf, urdf_file)
        changed = change_dimensions(root, changed, dimensions, urdf_file)
        urdf = ElementTree.tostring(root, encoding="unicode")
    return changed, urdf


def _replace(
    data: dict[str, object], steps: list[str], path: str, value: object, file: str
) -> None:
    """Replace one value of the document in place."""
    where = f"override {path}"
    holder: object = data
    for step in steps[:-1]:
        holder = _item(holder, step, where)
    if not steps:
        raise UnknownNameError(kind="key", name=path, known=data, where=where)
    old = _item(holder, steps[-1], where)
    if isinstance(old, dict):
        raise UnknownNameError(
            kind="value", name=path, known=(f"{path}.{key}" for key in old), where=where
        )
    new = _convert(value, old, path, file)
    if isinstance(holder, dict):
        holder[steps[-1]] = new
    elif isinstance(holder, list):
        holder[int(steps[-1][1:-1])] = new


def _item(holder: object, step: str, where: str) -> object:
    """One step down a path."""
    if isinstance(holder, dict) and step in holder:
        return holder[step]
    if isinstance(holder, list):
        places = {f"[{place}]": item for place, item in enumerate(holder)}
        if step in places:
            return places[step]
        raise UnknownNameError(kind="place", name=step, known=places, where=where)
    raise UnknownNameError(
        kind="key", name=step, known=holder if isinstance(holder, dict) else (), where=where
    )


def _number(value: object, path: str, file: str) -> float:
    """Convert an override to a number."""
    if isinstance(value, bool) or not isinstance(value, numbers.Real | str):
        raise ModelError(file=file, key=path, value=value, allowed="a number")
    try:
        return float(value)
    except ValueError:
        raise ModelError(file=file, key=path, value=value, allowed="a number") from None


def _convert(value: object, old: object, path: str, file: str) -> object:
    """Convert a string to the type of the value that it replaces, a foreign number to Python's."""
    # What is validated and saved is plain Python, not a number of numpy or the like.
    if isinstance(value, numbers.Integral) and not isinstance(value, bool):
        value = int(value)
    elif isinstance(value, numbers.Real) and not isinstance(value, bool):
        value = float(value)
    if not isinstance(value, str) or isinstance(old, str):
        return list(value) if isinstance(value, tuple) else value
    if isinstance(old, int | float) and not isinstance(old, bool):
        number = _number(value, path, file)
        return int(number) if isinstance(old, int) and number.is_integer() else number
    try:
        return tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        allowed = f"a value like {old!r}"
        raise ModelError(file=file, key=path, value=value, allowed=allowed) from None

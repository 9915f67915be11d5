"""What differs in machine and setting of two runs, by paths of the model's files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any
from xml.etree import ElementTree

from ...errors import NipperError
from ...hybrid import Solution
from ...mechanism import Mechanism, layout_of
from ...mechanism.edit import Layout, read_dimension
from ...tolerances.study import SAME_DIMENSION

# Texts about a model, and settings of a run that change none of its numbers.
_TEXTS = ("format", "title", "provenance", "shortcuts")
_WITHOUT_EFFECT = ("window", "reuse_cycles", "max_collisions")
_POINT, _LINK = ("x_mm", "z_mm"), ("mass_kg", "inertia_kg_m2", "com_x_mm", "com_z_mm")
# More places of one list than this are told together.
_MOST_PLACES = 3
Value = float | str | None


@dataclass(frozen=True)
class Change:
    """One number or word that differs.

    Attributes:
        path: As ``--set`` takes it, or a field of ``Case``; of what one machine alone has, that of
            the table.
        a: In A, in the unit that the path ends with; None if A has none.
        b: In B.
    """

    path: str
    a: Value
    b: Value


def changes(a: Solution, b: Solution) -> tuple[Change, ...]:
    """What differs: settings, then the description, then dimensions and masses."""
    settings = (_without(asdict(run.case), _WITHOUT_EFFECT) for run in (a, b))
    one, other = a.mechanism, b.mechanism
    texts = (_without(item.description, _TEXTS) for item in (one, other))
    return (*_between("", *settings), *_between("", *texts), *_dimensions(one, other))


def _without(values: Mapping[str, Any], names: tuple[str, ...]) -> dict[str, Any]:
    return {key: value for key, value in values.items() if key not in names}


def _between(path: str, a: Any, b: Any) -> Iterator[Change]:
    """Differences of two values and of all that they hold."""
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        for key in dict.fromkeys((*a, *b)):
            yield from _between(f"{path}.{key}" if path else str(key), a.get(key), b.get(key))
    elif _is_list(a) and _is_list(b) and len(a) == len(b):
        found = [
            item
            for place, pair in enumerate(zip(a, b, strict=True))
            for item in _between(f"{path}[{place}]", *pair)
        ]
        if len(found) <= _MOST_PLACES:
            yield from found
        else:
            yield Change(path, f"{len(a)} values", f"{len(found)} of them differ")
    elif a != b:
        yield Change(path, _value(a), _value(b))


def _is_list(value: Any) -> bool:
    return isinstance(value, Sequence) and not isinstance(value, str)


def _value(value: Any) -> Value:
    """A leaf as a number or a word; tables and lists by their size."""
    if value is None or isinstance(value, str):
        # A choice of a setting as its word alone.
        return None if value is None else str(value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return float(value)
    return "there" if isinstance(value, Mapping) else f"{len(value)} values"


def _dimensions(a: Mechanism, b: Mechanism) -> Iterator[Change]:
    """Points and masses of links that both machines have, each pin once."""
    if a.urdf == b.urdf:
        return
    one, other = layout_of(a), layout_of(b)
    pins = [name for name in one.points if name == one.meeting[name][0]]
    paths = [f"points.{name}.{key}" for name in pins if name in other.points for key in _POINT]
    paths += [f"links.{name}.{key}" for name in a.links if name in b.links for key in _LINK]
    for path in paths:
        first, second = _number(one, path), _number(other, path)
        if first is None or second is None:
            continue
        if abs(second - first) > SAME_DIMENSION * max(1.0, abs(first), abs(second)):
            yield Change(path, first, second)
    if _shapes(one) != _shapes(other):
        yield Change("shapes of the links", "as in its URDF", "as in its URDF")


def _number(layout: Layout, path: str) -> float | None:
    try:
        return read_dimension(layout, path)
    except NipperError:
        # A link without a mass has none of these numbers.
        return None


def _shapes(layout: Layout) -> list[str]:
    """Shapes that are touched or drawn, as text."""
    return [
        ElementTree.tostring(item, encoding="unicode")
        for kind in ("collision", "visual")
        for item in layout.root.iter(kind)
    ]

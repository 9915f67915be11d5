"""Parameters of a model in words: what their paths in its file say."""

from __future__ import annotations

import re

from .shown import Shown, shown_in
from .table import TERMS

# What a name can end with, and how people write it.
_UNITS = {"rpm": "r/min", "kg": "kg", "N": "N", "J": "J", "mm": "mm", "m": "m", "m2": "m2"}
_UNITS |= {"rad": "rad", "deg": "deg", "s": "s", "hz": "Hz", "per": "/", "turn": "turn"}
_UNITS |= {"s2": "/ s2"}
NONE = "1"
"""Unit of a number without one."""
# Numbers whose names say little without a drawing, by their last two steps.
_WORDS = {
    "points": {
        "x_mm": "pin {} forward",
        "z_mm": "pin {} upward",
        "radius_mm": "distance of pin {} from its shaft",
        "angle_deg": "angle of pin {} about its shaft",
    },
    "links": {
        "mass_kg": "mass of {}",
        "gyration_mm": "radius of gyration of {}",
        "com_x_mm": "centre of mass of {} forward",
        "com_z_mm": "centre of mass of {} upward",
    },
}


def unit_of(name: str) -> str:
    """The unit that the last part of a path ends with.

    Args:
        name: The last part.

    Returns:
        The unit, such as "N/m"; "1" if there is none.
    """
    return _split(name)[1] or NONE


def parameter_shown(path: str) -> Shown:
    """How people read a parameter of a model.

    Args:
        path: Its path, such as ``springs.steeve.stiffness_N_per_m``, or ``speed_rpm``.
    """
    *head, last = path.split(".")
    if not head and last in TERMS:
        return TERMS[last].shown()
    if head[:1] == ["urdf"]:
        # Names of numbers in a URDF carry no unit, and only the whole path says what they are.
        return Shown(words=path)
    what, file_unit = _split(last)
    unit, factor = shown_in(file_unit)
    return Shown(words=_words(head, last, what), unit=unit, factor=factor)


def _words(head: list[str], last: str, what: str) -> str:
    """A number with its owner: a spring, a stop, a drive, a pin or a link."""
    if len(head) != 2:
        return f"{head[-1]} {what}".replace("_", " ") if head else what
    kind, owner = head[0], head[1].replace("_", " ")
    if last in _WORDS.get(kind, {}):
        return _WORDS[kind][last].format(owner.removesuffix(" pin"))
    return f"{what} of {kind.removesuffix('s')} {owner}"


def _split(name: str) -> tuple[str, str]:
    """Words of a name and the unit behind them."""
    place = re.search(r"\[[0-9]+\]$", name)
    words = name.removesuffix(place[0] if place else "").split("_")
    found: list[str] = []
    # The first word is what is measured, never its unit.
    while words[1:] and words[-1] in _UNITS:
        found.insert(0, _UNITS[words.pop()])
    what = " ".join([*words, place[0]] if place else words)
    return what, " ".join(found).replace(" / ", "/")

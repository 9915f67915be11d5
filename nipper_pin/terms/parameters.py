"""Parameters of a model in words: what their paths in its file say."""

from __future__ import annotations

import re

from .shown import Shown, shown_in
from .table import TERMS

# What a name can end with, and how people write it.
_UNITS = {"rpm": "r/min", "kg": "kg", "N": "N", "J": "J", "mm": "mm", "m": "m", "m2": "m2"}
_UNITS |= {"rad": "rad", "deg": "deg", "s": "s", "hz": "Hz", "per": "/", "turn": "turn"}
# What stands in these tables of a model, behind its name; elsewhere the name alone says it.
_NOUNS = {"springs": "spring", "dampers": "damper", "drives": "drive"}
NONE = "1"
"""Unit of a number without one."""


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
    head, _, last = path.rpartition(".")
    if not head and last in TERMS:
        return TERMS[last].shown()
    if head.startswith("urdf."):
        # Names of numbers in a URDF carry no unit, and only the whole path says what they are.
        return Shown(words=path)
    what, file_unit = _split(last)
    unit, factor = shown_in(file_unit)
    owner = head.rpartition(".")[2].replace("_", " ")
    noun = _NOUNS.get(head.partition(".")[0], "")
    if owner and noun and not owner.endswith(noun):
        owner += f" {noun}"
    words = f"{what} of the {owner}" if owner else what
    return Shown(words=words, unit=unit, factor=factor)


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

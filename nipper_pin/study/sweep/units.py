"""Units of the columns of a sweep, as its names carry them."""

from __future__ import annotations

import re
from collections.abc import Sequence

from ...mechanism import Mechanism
from .axes import Axis
from .quantities import quantity_unit

# What a name can end with, and how people write it.
_WORDS = {"rpm": "r/min", "kg": "kg", "N": "N", "J": "J", "mm": "mm", "m": "m", "m2": "m2"}
_WORDS |= {"rad": "rad", "deg": "deg", "s": "s", "per": "/", "turn": "turn"}
NONE = "1"
"""Unit of a number without one."""


def unit_of(name: str) -> str:
    """The unit that the last part of a path ends with.

    Args:
        name: The last part.

    Returns:
        The unit, such as "N/m"; "1" if there is none.
    """
    plain = re.sub(r"\[[0-9]+\]$", "", name)
    # The first word is what is measured, never its unit.
    words = plain.split("_")[1:]
    found: list[str] = []
    while words and words[-1] in _WORDS:
        found.insert(0, _WORDS[words.pop()])
    return " ".join(found).replace(" / ", "/") or NONE


def units_of(
    axes: Sequence[Axis], quantities: Sequence[str], mechanism: Mechanism, *, turns: bool = False
) -> dict[str, str]:
    """Unit of every column of numbers, parameters as in the model's file.

    Numbers of a URDF are left out: their names do not say.

    Args:
        axes: The parameters.
        quantities: What is kept.
        mechanism: The model.
        turns: Whether the quantities are those of whole turns.
    """
    found = {name: quantity_unit(name, mechanism, turns=turns) or NONE for name in quantities}
    for axis in axes:
        head, _, last = axis.target.path.rpartition(".")
        if not head.startswith("urdf."):
            found[axis.name] = unit_of(last)
    return found

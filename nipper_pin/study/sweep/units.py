"""Units of the columns of a sweep, as its names carry them."""

from __future__ import annotations

from collections.abc import Sequence

from ...mechanism import Mechanism
from ...terms import NONE, unit_of
from .axes import Axis
from .quantities import quantity_unit


def units_of(
    axes: Sequence[Axis], quantities: Sequence[str], mechanism: Mechanism, *, turns: bool = False
) -> dict[str, str]:
    """Unit of every column of numbers, parameters as in the model's file.

    Numbers of a URDF are left out: their names do not say.

    Args:
        axes: The parameters.
        quantities: What is kept.
        turns: Whether the quantities are those of whole turns.
    """
    found = {name: quantity_unit(name, mechanism, turns=turns) or NONE for name in quantities}
    for axis in axes:
        head, _, last = axis.target.path.rpartition(".")
        if not head.startswith("urdf."):
            found[axis.name] = unit_of(last)
    return found

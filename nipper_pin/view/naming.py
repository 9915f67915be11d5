"""Names in files as people read them, for one machine."""

from __future__ import annotations

from ..hybrid.result.quantities import coordinate_unit
from ..mechanism import Mechanism
from ..terms import Shown, named


def shown(mechanism: Mechanism, name: str) -> Shown:
    """How people read a quantity of the transition stop or of a turn, or a parameter.

    Args:
        mechanism: The machine.
        name: Its name in files, as :func:`~nipper_pin.terms.named` takes it, or a shortcut.
    """
    units = [
        coordinate_unit(mechanism, stop.index)
        for stop in mechanism.stops
        if stop.name == mechanism.transition_stop
    ]
    return named(mechanism.shortcuts.get(name, name), *units)

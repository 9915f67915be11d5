"""Names in files as people read them, for one machine."""

from __future__ import annotations

from dataclasses import replace

from ..hybrid.result.quantities import coordinate_unit
from ..mechanism import Mechanism, Stop
from ..terms import Shown, named, shown_in
from ..units import MM_PER_M

# As fine as what can be made.
AT_CONTACT = Shown(words="gap at the contact", unit="mm", factor=MM_PER_M, decimals=4)
"""Of a gap at a contact point [m]."""


def shown(mechanism: Mechanism, name: str) -> Shown:
    """How people read a quantity of the transition stop or of a turn, or a parameter.

    Args:
        name: Its name in files, as :func:`~nipper_pin.terms.named` takes it, or a shortcut.
    """
    units = [
        coordinate_unit(mechanism, stop.index)
        for stop in mechanism.stops
        if stop.name == mechanism.transition_stop
    ]
    return named(mechanism.shortcuts.get(name, name), *units)


def coordinate_shown(mechanism: Mechanism, index: int, *, small: bool = False) -> Shown:
    """How people read a coordinate, by its place in q; those of rebounds are small."""
    file_unit = coordinate_unit(mechanism, index)
    unit, factor = shown_in(file_unit, small=small)
    return Shown(words="stroke" if file_unit == "m" else "angle", unit=unit, factor=factor)


def stiffness_shown(mechanism: Mechanism, index: int) -> Shown:
    """How people read the rate of a spring, by the place of its joint in q."""
    turns = coordinate_unit(mechanism, index) == "rad"
    unit, factor = shown_in("N m/rad" if turns else "N/m")
    return Shown(words="stiffness", unit=unit, factor=factor)


def contact_shown(stop: Stop) -> Shown | None:
    """How people read the gap at the contact point of a stop; None of a stop along its joint."""
    return None if stop.contact is None else replace(AT_CONTACT, factor=MM_PER_M * stop.lever)


def lips_shown(mechanism: Mechanism, stop: Stop) -> Shown | None:
    """How people read that gap beside the angle of a hinge; None of a slide, whose gap is one."""
    return contact_shown(stop) if coordinate_unit(mechanism, stop.index) == "rad" else None


def lips_phrase(mechanism: Mechanism, stop: Stop, gap: float | None) -> str:
    """What follows an angle: the gap at the contact point; nothing without one."""
    lips = lips_shown(mechanism, stop)
    return "" if lips is None or gap is None else f" ({lips.phrase(gap)} at the contact)"


def rate_shown(mechanism: Mechanism, index: int) -> Shown:
    """How people read the rate of a coordinate, by its place in q."""
    unit, factor = shown_in(f"{coordinate_unit(mechanism, index)}/s")
    return Shown(words="rate", unit=unit, factor=factor)

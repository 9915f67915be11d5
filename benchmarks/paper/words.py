"""Names and units of one machine in the table and the figures of its study."""

from __future__ import annotations

from nipper_pin.hybrid.result.quantities import coordinate_unit
from nipper_pin.mechanism import Mechanism
from nipper_pin.terms import shown_in

from .ratios import ratio_values
from .study import PaperStudy


def rate_unit(mechanism: Mechanism) -> tuple[str, float]:
    """Unit in which people read the spring's rate, and its factor."""
    return shown_in("N m/rad" if _turns(mechanism) else "N/m")


def preload_unit(mechanism: Mechanism) -> tuple[str, float]:
    """Unit in which people read the spring's preload, and its factor."""
    return shown_in("rad" if _turns(mechanism) else "m")


def _turns(mechanism: Mechanism) -> bool:
    return coordinate_unit(mechanism, mechanism.springs[0].index) == "rad"


def ratio_words(study: PaperStudy) -> dict[str, str]:
    """All ratios by name in words: what changes, and between which two cases."""
    unit, factor = rate_unit(study.mechanism)
    given = study.published
    ends = {
        "speed": "{:g} to {:g} r/min".format(*given.speeds_rpm[:: len(given.speeds_rpm) - 1]),
        "restitution": f"e = {given.restitutions[0]:g} to {given.restitutions[-1]:g}",
        "stiffness": f"{factor * given.stiffnesses[0]:.3g} to "
        f"{factor * given.stiffnesses[-1]:.3g} {unit}",
    }
    found = {}
    for name in ratio_values(study.studies):
        over, _, quantity = name.partition(".")
        what, _, last = quantity.rpartition("_")
        shared = last.replace(".", "").isdigit()
        found[name] = (
            f"share of the first two rebounds, {last} r/min"
            if shared
            else f"{what.replace('_', ' ')}, {ends[over]}"
        )
    return found

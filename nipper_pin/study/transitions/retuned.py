"""The mechanism of one case."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ...arrays import FloatArray
from ...mechanism import Mechanism


def retuned(
    mechanism: Mechanism,
    restitution: float | Mapping[str, float],
    stiffness: FloatArray,
    preload: FloatArray,
) -> Mechanism:
    """The mechanism with other values; its tree does not depend on them and is not built again.

    Args:
        restitution: e_N of the transition stop, or of stops by name.
        stiffness: Spring rates, shape (springs,) [N/m or N m/rad].
        preload: Deflections in the springs at zero, shape (springs,) [m or rad].
    """
    if not isinstance(restitution, Mapping):
        restitution = {mechanism.transition_stop: restitution}
    stops = tuple(
        replace(stop, restitution=restitution[stop.name]) if stop.name in restitution else stop
        for stop in mechanism.stops
    )
    springs = tuple(
        replace(spring, stiffness=float(k), preload=float(p))
        for spring, k, p in zip(mechanism.springs, stiffness, preload, strict=True)
    )
    return replace(mechanism, stops=stops, springs=springs)

"""Quantities that can be minimised or limited, by name, and how each is computed.

Bounces come from one transition, and what is said of a whole turn from turns that are followed.
Timing and forces of the working cycle come from its kinematics:
with held drives phases 1 and 2 have no freedom, so no cycle is simulated, and they are smooth where
a simulated cycle has events that come and go.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ....arrays import FloatArray
from ....errors import InputError
from ....hybrid.result.quantities import coordinate_unit, force_unit
from ....mechanism import Mechanism
from ....terms import term_of
from ....units import MM_PER_M
from ...identify.problem.working_cycle import Phase, WorkingCycle, unfit

Source = Literal["setting", "transition", "cycle", "turn"]


@dataclass(frozen=True)
class Quantity:
    """One quantity.

    Attributes:
        source: What it takes to find it.
        joint: Kind of joint that its stop must be on, or None for any.
        waiting: Whether its stop is the one that is closed in the initial phase, and not the
            transition stop.
        force: Whether it is a force, which the transition stop must have in this unit.
    """

    source: Source
    joint: str | None = None
    waiting: bool = False
    force: bool = False


MARGIN = "rest_margin"
"""Name of the indices from rest to opening."""


QUANTITIES: Mapping[str, Quantity] = {
    **{
        name: Quantity("transition")
        for name in ("rebound_amplitude_1", "rebound_time_s_1", "duration_s")
    },
    "clamping_force_N": Quantity("cycle"),
    "stop_force_N": Quantity("cycle"),
    "closing_index": Quantity("cycle"),
    "opening_index": Quantity("cycle"),
    "jaw_opening_deg": Quantity("cycle", joint="revolute"),
    "stroke_mm": Quantity("cycle", joint="prismatic", waiting=True),
    "speed_rpm": Quantity("setting"),
    "clamped_time_s": Quantity("turn"),
    "clamped_share": Quantity("turn"),
    "rest_index": Quantity("turn"),
    MARGIN: Quantity("turn"),
    "least_clamping_force_N": Quantity("turn", force=True),
    "largest_clamping_force_N": Quantity("turn", force=True),
    "largest_gap": Quantity("turn"),
    "energy_lost_turn_J": Quantity("turn"),
}
"""All quantities by name."""


def units(names: Iterable[str], mechanism: Mechanism) -> dict[str, str]:
    """Units of quantities of a mechanism by name, empty for a number without one."""
    stop = mechanism.stop(mechanism.transition_stop)
    gap = coordinate_unit(mechanism, stop.index)
    return {name: term_of(name)[0].unit.format(gap=gap) for name in names}


def check_fit(names: Iterable[str], mechanism: Mechanism, where: str) -> None:
    """Refuse quantities that a mechanism cannot have, whatever its numbers.

    Args:
        names: Names of known quantities.
        where: File and key, for messages.

    Raises:
        InputError: A quantity does not fit.
    """
    for name in names:
        item = QUANTITIES[name]
        reason = unfit(mechanism) if item.source == "cycle" else None
        if reason is not None:
            message = f"{where}: {name} cannot be used: {reason}"
            raise InputError(message, quantity=name, model=mechanism.name)
        if item.force and force_unit(mechanism, mechanism.stop(mechanism.transition_stop)) != "N":
            message = f"{where}: {name} cannot be used: its stop has a moment in N m and no force"
            raise InputError(message, quantity=name, model=mechanism.name)
        stops = mechanism.phase(mechanism.initial_phase).closed if item.waiting else ()
        stop = mechanism.stop(min(stops, default=mechanism.transition_stop))
        kind = mechanism.joints[stop.index].kind
        if item.joint not in (None, kind):
            message = (
                f"{where}: {name} cannot be used: stop {stop.name} is on a {kind} joint, and it "
                f"needs a {item.joint} one"
            )
            raise InputError(message, quantity=name, joint=kind)


def cycle_values(cycle: WorkingCycle) -> dict[str, float]:
    """Quantities of a working cycle."""
    waiting, clamping = cycle.waiting, cycle.clamping
    return {
        "clamping_force_N": cycle.clamping_force,
        "stop_force_N": float(lowest(waiting.index, waiting.force).min()),
        "closing_index": cycle.closing_index,
        "opening_index": cycle.opening_index,
        "stroke_mm": -MM_PER_M * float(lowest(clamping.index, -clamping.gap).min()),
        "jaw_opening_deg": float(np.degrees(-lowest(waiting.index, -waiting.gap).min())),
    }


def thinned(cycle: WorkingCycle) -> WorkingCycle:
    """The same cycle with every second sample of its phases left out."""
    waiting, clamping = (
        Phase(item.index[::2], item.gap[::2], item.force[::2])
        for item in (cycle.waiting, cycle.clamping)
    )
    return replace(cycle, waiting=waiting, clamping=clamping)


def lowest(places: FloatArray, values: FloatArray) -> FloatArray:
    """Least value of a sampled curve in every interval between two samples.

    The samples alone miss the bottom of a narrow dip, by 0.4 N of the stop force of the E62 at 650
    r/min; the spline through them finds it to 1e-3 N. A least value over all intervals has a kink
    where another dip becomes the lowest; those of the single intervals have none.

    Args:
        places: Increasing, shape (N,).
        values: Shape (N,).

    Returns:
        Shape (N - 1,).
    """
    from scipy.interpolate import CubicSpline

    least = np.minimum(values[:-1], values[1:])
    spline = CubicSpline(places, values)
    turns = spline.derivative().roots(extrapolate=False)
    turns = turns[np.isfinite(turns)]
    number = np.clip(np.searchsorted(places, turns, side="right") - 1, 0, len(least) - 1)
    np.minimum.at(least, number, spline(turns))
    return np.asarray(least)

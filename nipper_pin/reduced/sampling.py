"""From a mechanism to its reduced model: the domain, the degrees and the error of the tables."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..dynamics import DriveMode
from ..errors import InputError, NipperError, SimulationError
from ..given import LARGEST, number
from ..hybrid import State, comes_back
from ..hybrid.error_estimate.local_error import at_start
from ..made_once import made_once
from ..mechanism import Mechanism, Stop
from ..tolerances.reduced import ARRIVAL_TABLES, TRIMMED_SHARE
from .inputs import check_tolerance
from .model import FAST, LIVELY, MARGIN, Arrival, ReducedModel, lively_speed, numbers_of
from .tables.functions import Sampler
from .tables.tables import Chart, Domain, stacked
from .turns.arcs import ContactArc, ContactContinuation
from .turns.charts import ChartSampler
from .turns.model import charts_of, unfit_turns

_MODEL = "reduced model"
# Travel of a domain where no opening is known, and the longest [rad].
_USUAL, _LONGEST = math.radians(95.0), math.radians(150.0)


def unfit(mechanism: Mechanism, drive: DriveMode | str = DriveMode.HELD) -> str | None:
    """Return why a mechanism cannot be reduced to one degree of freedom.

    Args:
        drive: Behaviour of the driven shafts.

    Returns:
        One sentence, or None if it can be.
    """
    reason = unfit_turns(mechanism, drive)
    if reason is not None:
        return reason
    others = [
        *(f"table of spring {item.name}" for item in mechanism.tabulated_springs),
        *(f"damper {item.name}" for item in mechanism.dampers),
        *(f"{item.kind} {item.name} between two points" for item in mechanism.struts),
    ]
    if others:
        return f"the reduced engine has linear springs on joints only, no {', '.join(others)}"
    if not mechanism.transition_stop:
        return "the reduced engine follows the bounces of a stop, and no stop strikes at the touch"
    other = next((stop.name for stop in mechanism.stops if not stop.plain), None)
    if other is not None:
        return f"the reduced engine needs lower stops at coordinate zero, and {other!r} is another"
    closed = mechanism.phase(mechanism.initial_phase).closed
    if mechanism.transition_stop in closed:
        return f"stop {mechanism.transition_stop!r} is closed in the initial phase"
    if len(closed) != 1:
        return "the initial phase leaves a freedom: its velocity does not follow from the drives"
    return None


def build(
    mechanism: Mechanism,
    *,
    travel_rad: float | None = None,
    gap_max: float | None = None,
    tolerance: float = 1e-11,
    drive: DriveMode | str = DriveMode.HELD,
) -> ReducedModel:
    """Sample the reduced model of a mechanism.

    The degrees grow (cells along u, degree along x) until the last coefficients of every function
    are below the tolerance or show only round-off. The error of a function is bounded by twice the
    largest difference from Pinocchio at random points off the grid, plus round-off.

    Args:
        travel_rad: Travel of the cylinder from the touch configuration that the domain covers; by
            default up to the opening of the transition stop, but no more than 150 degrees.
        gap_max: Largest coordinate of the transition stop [rad or m]; by default enough for
            restitution 0.5 at one and a half times the rated speed.
        tolerance: Relative accuracy of the tables.
        drive: Behaviour of the driven shafts; only held ones can be reduced.

    Returns:
        The model.

    Raises:
        InputError: The mechanism or the domain cannot be reduced.
        SimulationError: A point of the domain cannot be reached or is singular.
    """
    reason = unfit(mechanism, drive)
    if reason is not None:
        message = f"{mechanism.name}: {reason}; use the direct engine"
        raise InputError(message, model=mechanism.name, drive=str(drive))
    if travel_rad is not None:
        number("travel_rad", travel_rad, 0.0, math.tau, open_low=True, allowed="0 to 2 pi",
               where=_MODEL)  # fmt: skip
    check_tolerance(tolerance, _MODEL)
    if gap_max is not None:
        number("gap_max", gap_max, 0.0, LARGEST, open_low=True, allowed="above zero",
               where=_MODEL)  # fmt: skip
    stop = mechanism.stop(mechanism.transition_stop)
    # Of the arc that starts there the touch, in which all coordinates are zero.
    touch = ContactArc(stop, 0.0, 0.0, stop, np.zeros(1), np.zeros((1, len(mechanism.joints))))
    around = ChartSampler(mechanism, touch, mechanism.cylinder.angle_at_touch_rad, 0)
    rate, rounded = _approach_rate(around)
    w = -LIVELY * rate * lively_speed(mechanism)
    gap_max = around.rebound(w) if gap_max is None else gap_max
    if not gap_max > 0.0:
        message = (
            f"{mechanism.name}: stop {stop.name!r} is not pressed shut after its "
            f"first collision at {FAST:g} times the rated speed; use the direct engine, "
            "or nipper_pin.reduced.build with a gap_max"
        )
        raise InputError(message, stop=stop.name)
    arcs, why = _turn(mechanism, stop)
    if travel_rad is None:
        opening = next((arc.end for arc in arcs if arc.after.name != stop.name), _USUAL)
        travel_rad = min(opening, _LONGEST)
    domain = Domain(travel_rad, -MARGIN * gap_max, gap_max)
    chart = replace(around.over(domain, w, tolerance), meets=(rate, rounded, 0.0, 0.0))
    return ReducedModel(
        **numbers_of(mechanism),
        charts=stacked(mechanism, [chart]),
        stop=stop.name,
        touch_angle_rad=mechanism.cylinder.angle_at_touch_rad,
        sense=mechanism.cylinder.sense,
        tolerance=tolerance,
        arrival=_arrival(around, chart, arcs, why, tolerance),
    )


def _turn(mechanism: Mechanism, stop: Stop) -> tuple[list[ContactArc], str]:
    """Stretches of a turn, as far as can be followed, and why no further."""
    arcs: list[ContactArc] = []
    walk = ContactContinuation(mechanism, mechanism.cylinder.angle_at_touch_rad)
    try:
        for arc in walk.around(stop, np.zeros(len(mechanism.joints))):
            arcs.append(arc)
    except SimulationError as error:
        return arcs, error.message
    return arcs, ""


def _arrival(
    touch: ChartSampler, chart: Chart, arcs: list[ContactArc], why: str, tolerance: float
) -> Arrival:
    """Sample the turn around the touch: its clamping stop up to the opening, then the waiting one.

    Args:
        chart: The domain of the transition, which serves where it ends at the opening.
    """
    mechanism = touch.mechanism
    if not comes_back(touch.system):
        return Arrival(why="the drives do not come back with the cylinder", asked=False)
    (name,) = mechanism.phase(mechanism.initial_phase).closed
    if why:
        return Arrival(why=why)
    stops = [arc.stop.name for arc in arcs]
    if name not in stops:
        return Arrival(why=f"stop {name!r} does not come back to its place within a turn")
    if stops != [mechanism.transition_stop, name]:
        return Arrival(why=f"stops are closed in another order, or drives bend: {', '.join(stops)}")
    angle = mechanism.cylinder.angle_at_touch_rad
    first = chart if chart.domain.travel == arcs[0].end else None
    rough = max(tolerance, ARRIVAL_TABLES)
    try:
        around = [ChartSampler(mechanism, arc, angle, 1 - place) for place, arc in enumerate(arcs)]
        charts = charts_of(around, rough, of_gaps=TRIMMED_SHARE * rough, first=first)
        return Arrival(charts=charts)
    except NipperError as error:
        return Arrival(why=error.message)


def _approach_rate(touch: ChartSampler) -> tuple[float, float]:
    """Rate dx/du of the initial phase in the touch configuration, and its round-off.

    Raises:
        InputError: It is not negative, or the stop that is closed does not open by a rebound.
    """
    mechanism, system, stop = touch.mechanism, touch.system, touch.arc.stop
    closed = mechanism.phase(mechanism.initial_phase).closed
    (waiting,) = (mechanism.stop(name) for name in closed)
    u, q = np.zeros(1), touch.arc.path
    _, (v,) = Sampler(system, waiting, q[0]).rates(u, q)
    rate = stop.rate(v)
    if rate >= 0.0:
        message = (
            f"stop {stop.name!r} is not closing in the touch configuration (rate {rate:.3g} by the "
            "cylinder angle); check cylinder.angle_at_touch_deg and cylinder.direction"
        )
        raise InputError(message, stop=stop.name, rate=rate)
    (by_x,), _ = touch.sampler.rates(u, q)
    opening = waiting.rate(by_x)
    if opening <= 0.0:
        message = (
            f"{mechanism.name}: stop {waiting.name!r} does not open when "
            f"{stop.name!r} rebounds; use the direct engine"
        )
        raise InputError(message, stop=waiting.name, opening_rate=opening)
    rounded = at_start(system, State.at(system, 0.0, q[0], v, closed))
    return rate, rounded.size(len(v) + stop.index)


def reduced_model(mechanism: Mechanism, drive: DriveMode = DriveMode.HELD) -> ReducedModel:
    """Return the reduced model of a mechanism on its default domain, sampled at the first call.

    Mechanisms do not change and are known by identity: one with a single other number is another
    one, with tables of its own. A model lives as long as its mechanism.

    Args:
        drive: Behaviour of the driven shafts; only held ones can be reduced.

    Returns:
        What :func:`~nipper_pin.reduced.build` gives for it alone.

    Raises:
        InputError: The mechanism cannot be reduced, or not with these drives.
        SimulationError: A point of the domain cannot be reached or is singular.
    """
    return _model(mechanism, drive)


@made_once
def _model(mechanism: Mechanism, drive: DriveMode) -> ReducedModel:
    return build(mechanism, drive=drive)

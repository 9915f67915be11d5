"""What to know of a run: its premise, a law that it depends on, bounces that are summed up.

Does the machine arrive at the touch in its initial phase? A transition starts in the touch
configuration: the stops of the initial phase are closed and have come to rest. Whether a turn
brings the machine there is told by following the transition on, to the next touch. Where drives
determine the motion nothing of the past is left, so a machine that arrives in the initial phase
repeats this very transition in every turn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...dynamics import System
from ...dynamics.impact_laws import same_by_every_law, solve_impact
from ...errors import ImpactError, SimulationError
from ...mechanism import Mechanism, Simultaneous, Stop
from ...tolerances.hybrid import (
    DECISION_TOLERANCE,
    DROPPED_SERIES,
    REST_BEFORE_TOUCH,
    SAME_ASSEMBLY,
)
from ...tolerances.mechanics import FAINT_GAP_RATE
from ...units import MS_PER_S
from ..case import Case, Resolution, Window
from ..contact.active_set import active_set
from ..history import Event, EventKind, State
from ..run.phase_manager import go_on
from ..run.windows import comes_back, winding
from .trajectory import Trajectory

MOST_IN_TURN = 10_000
"""Collisions of a turn that are followed."""
_PANELS = 6


@dataclass(frozen=True)
class Premise:
    """Whether the premise of a transition holds.

    Attributes:
        holds: True or False; None where it was not asked or cannot be told.
        why: One sentence.
    """

    holds: bool | None
    why: str


def premise_of(
    system: System, case: Case, events: Sequence[Event], trajectory: Trajectory
) -> Premise:
    """Follow a transition to the next touch and see in which phase the machine arrives.

    Events and motion are those of the system that was followed; whole turns assume nothing.
    """
    if case.window is not Window.TRANSITION:
        return Premise(None, "Whole turns assume nothing of how the machine arrives.")
    touch = events[0]
    reason = _unanswerable(system, touch)
    if reason:
        return Premise(None, reason)
    before = (1.0 - REST_BEFORE_TOUCH) * system.shaft.period
    start = _end(system, events[-1], trajectory)
    further = replace(
        case,
        max_collisions=MOST_IN_TURN,
        resolution=Resolution(
            tolerance=max(case.resolution.tolerance, DECISION_TOLERANCE),
            panels_per_turn=_PANELS,
        ),
    )
    try:
        end, later = go_on(system, further, start, before)
    except SimulationError as error:
        return Premise(None, f"The turn cannot be followed to the next touch: {error.message}")
    if end is None:
        return Premise(None, "The turn has too many collisions to be followed to the next touch.")
    return _judged(system, touch, end, (*events, *later))


def _unanswerable(system: System, touch: Event) -> str:
    """Reason why the premise cannot be checked; empty if it can."""
    if not system.held:
        return "Inertial shafts remember the turns before, which a transition does not know."
    if system.constraint_set(touch.closed_before).freedom != 0:
        return "The initial phase leaves a freedom, whose motion the drives do not determine."
    if not comes_back(system):
        return "The drives do not come back with the cylinder, so no turn repeats the touch."
    return ""


def _end(system: System, last: Event, trajectory: Trajectory) -> State:
    """State at the end of a run, from which it can be followed on."""
    t, q, v = last.t, last.q, last.v_after
    if trajectory.segments:
        _, t = trajectory.span
        if t > last.t:
            state = trajectory.evaluate(np.array([t]), left=True)
            q, v = state.q[0], state.v[0]
    return State.at(system, t, q, v, last.closed_after)


def _judged(system: System, touch: Event, end: State, events: tuple[Event, ...]) -> Premise:
    """Compare the state just before the next touch with the one that the transition starts from."""
    names, period = touch.closed_before, system.shaft.period
    there = "one turn later, where the next transition would start"
    if off := sorted(names - end.closed):
        return Premise(False, f"{_listed(off)} off its stop {there}.")
    if early := sorted(end.closed - names):
        return Premise(False, f"{_listed(early)} already closed {there}.")
    rests = [event.t + event.series_error for event in events if event.kind is EventKind.REST]
    if max(rests, default=0.0) > (1.0 - REST_BEFORE_TOUCH) * period:
        return Premise(False, f"a stop still bounces {there}.")
    left = REST_BEFORE_TOUCH * period
    arrived = touch.q - left * touch.v_before
    if winding(system.mechanism, arrived, end.q, SAME_ASSEMBLY) is None:
        return Premise(False, f"the links stand in another assembly {there}.")
    stay = active_set(system, State.at(system, 0.0, touch.q, touch.v_before, names), names)
    if off := sorted(names - stay):
        return Premise(False, f"{_listed(off)} just leaving its stop {there}.")
    return Premise(True, "The machine arrives at the next touch as at this one.")


def _listed(stops: list[str]) -> str:
    return " and ".join(stops) + (" is" if len(stops) == 1 else " are")


# Enough for rows of ten balls, in a tenth of a second.
_MOST_STRIKES = 10_000
# Times the rated speed; nobody asks for that much.
_TOO_FAST = 100.0
_OTHER: dict[Simultaneous, Simultaneous] = {"newton": "sequential", "sequential": "newton"}
_MEANS = {"newton": "all at once", "sequential": "from contact to contact"}


def unusual(mechanism: Mechanism, case: Case) -> str:
    """What of the setting is hardly meant, in sentences; empty if nothing is."""
    rated = mechanism.cylinder.rated_speed_rpm
    told = []
    if case.speed_rpm > _TOO_FAST * rated:
        told.append(
            f"{case.speed_rpm:g} r/min is {case.speed_rpm / rated:.3g} times the rated speed of "
            f"{rated:g} r/min: is it meant?"
        )
    closed = mechanism.phase(mechanism.initial_phase).closed
    shut = {mechanism.stop(name).index for name in closed}
    for spring in mechanism.springs:
        if spring.preload < 0.0 and spring.index in shut:
            told.append(
                f"Spring {spring.name} has a preload below zero: it pulls the stop open that is "
                "closed in the initial phase."
            )
    return " ".join(told)


def law_that_matters(system: System, events: Sequence[Event]) -> str:
    """Return one sentence where the other law gives another outcome; empty if it gives the same.

    Only impacts at two stops or more that share a motion are looked at, until the first one that
    differs, in the system that was followed.
    """
    law = system.mechanism.simultaneous
    for event in events:
        if event.kind is not EventKind.COLLISION or event.source != event.number:
            continue
        for stops in system.apart([system.mechanism.stop(name) for name in event.P_N]):
            if len(stops) > 1 and _differs(system, event, stops, _OTHER[law]):
                names = " and ".join(", ".join(stop.name for stop in stops).rsplit(", ", 1))
                return (
                    f"The outcome depends on a choice of the model: at t = "
                    f"{MS_PER_S * event.t:.6g} ms stops that touch are struck together ({names}), "
                    f'here {_MEANS[law]}, simultaneous = "{law}", while "{_OTHER[law]}", '
                    f"{_MEANS[_OTHER[law]]}, gives other rates."
                )
    return ""


def _differs(system: System, event: Event, stops: Sequence[Stop], other: Simultaneous) -> bool:
    """Whether another law gives other rates after an event at stops that share a motion."""
    before, after = event.v_before, event.v_after
    if same_by_every_law(before, after, stops, event.P_N):
        return False
    jacobian = system.body.closures(event.q[None])[1][0]
    try:
        instead = solve_impact(system, event.q, before, jacobian, stops, other, _MOST_STRIKES)
    except ImpactError:
        # Strikes without a near end come to rest, as those without restitution do at once.
        return any(stop.restitution > 0.0 for stop in stops)
    least = FAINT_GAP_RATE * max(abs(stop.rate(before)) for stop in stops)
    rates = [(stop.rate(instead.v_after), stop.rate(after)) for stop in stops]
    return any(abs(one - another) > least for one, another in rates)


def bounces_summed_up(mechanism: Mechanism, case: Case, events: Sequence[Event]) -> str:
    """Return one sentence where a series ends at its limit with rebounds that are still large.

    A threshold of rates is a choice, and needs no sentence. The first such series is named.
    """
    if case.rest_rate is not None:
        return ""
    most = (DROPPED_SERIES * case.resolution.tolerance) ** (1.0 / 3.0)
    for rest in events:
        if rest.kind is not EventKind.REST or rest.source != rest.number:
            continue
        for stop in map(mechanism.stop, rest.stops):
            rebounds = _rebounds(events[: rest.number - 1], stop)
            if rebounds and rebounds[-1] > most * max(rebounds):
                return (
                    f"Of the bounces of stop {stop.name} {len(rebounds)} are computed. Those that "
                    f"follow, still {rebounds[-1] / max(rebounds):.2g} as fast as the fastest, are "
                    f"summed up: it rests at their limit, t = {rest.t:.6g} s, and pictures show "
                    "it closed before."
                )
    return ""


def _rebounds(events: Sequence[Event], stop: Stop) -> list[float]:
    """Rates of the rebounds of the series that the events end with [rad/s or m/s]."""
    rates: list[float] = []
    for event in reversed(events):
        if stop.name not in event.P_N:
            continue
        if event.kind is not EventKind.COLLISION or stop.rate(event.v_after) <= 0.0:
            break
        rates.insert(0, stop.rate(event.v_after))
    return rates

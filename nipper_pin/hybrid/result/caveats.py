"""What to know of a run: a law that it depends on, bounces that are summed up while still seen."""

from __future__ import annotations

from collections.abc import Sequence

from ...dynamics import System
from ...dynamics.impact_laws import same_by_every_law, solve_impact
from ...errors import ImpactError
from ...mechanism import Mechanism, Simultaneous, Stop
from ...tolerances.hybrid import DROPPED_SERIES
from ...tolerances.mechanics import FAINT_GAP_RATE
from ...units import MS_PER_S
from ..case import Case
from ..event import Event, EventKind

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

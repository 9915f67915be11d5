"""Does the outcome of a run depend on the law of stops that are struck together?"""

from __future__ import annotations

from collections.abc import Sequence

from ...dynamics import System
from ...dynamics.strike import same_by_every_law, strike
from ...errors import ImpactError
from ...mechanism import Simultaneous, Stop
from ...tolerances.mechanics import FAINT_GAP_RATE
from ...units import MS_PER_S
from ..event import Event, EventKind

# Enough for rows of ten balls, in a tenth of a second.
_MOST_STRIKES = 10_000
_OTHER: dict[Simultaneous, Simultaneous] = {"newton": "sequential", "sequential": "newton"}
_MEANS = {"newton": "all at once", "sequential": "from contact to contact"}


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
        instead = strike(system, event.q, before, jacobian, stops, other, _MOST_STRIKES)
    except ImpactError:
        # Strikes without a near end come to rest, as those without restitution do at once.
        return any(stop.restitution > 0.0 for stop in stops)
    least = FAINT_GAP_RATE * max(abs(stop.rate(before)) for stop in stops)
    rates = [(stop.rate(instead.v_after), stop.rate(after)) for stop in stops]
    return any(abs(one - another) > least for one, another in rates)

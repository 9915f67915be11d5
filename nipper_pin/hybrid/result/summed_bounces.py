"""Bounces that a run sums up to their limit while they can still be seen."""

from __future__ import annotations

from collections.abc import Sequence

from ...mechanism import Mechanism, Stop
from ...tolerances.hybrid import DROPPED_SERIES
from ..case import Case
from ..event import Event, EventKind


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

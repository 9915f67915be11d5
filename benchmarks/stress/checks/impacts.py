"""Checks of impacts: momentum, closures, the impact law and the energy lost."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nipper_pin.hybrid import EventKind, Solution

from ...tolerances import (
    CLOSURE_RATE,
    DRIVE_SHAKEN,
    ENERGY_LOST,
    EPS,
    IMPACT_LEFT,
    MOMENTUM,
    MOST_MOMENTUM,
    RESTITUTION_LAW,
)
from ..observations import EVENTS, beyond, some


def impulses(solution: Solution) -> Iterator[str]:
    """Momentum, closures, restitution, complementarity and energy of the impacts."""
    system = solution.system
    for place in some(len(solution.events), EVENTS):
        event = solution.events[place]
        if event.kind is EventKind.RELEASE or not event.delta.any():
            continue
        where, contact = f"event {event.number}", event.kind is EventKind.COLLISION
        M = system.body.mass_matrix(event.q)
        if not system.held:
            M += np.diag(system.drive_armature)
        G = system.body.closures(event.q[None])[1][0]
        terms = [M @ event.delta, -(event.P_g @ G)]
        sizes = [np.abs(M) @ np.abs(event.delta), np.abs(event.P_g) @ np.abs(G)]
        for name, impulse in event.P_N.items():
            row = np.zeros(len(event.q))
            stop = solution.mechanism.stop(name)
            row[stop.index] = -stop.sense * impulse
            terms.append(row)
            sizes.append(np.abs(row))
        left, size = sum(terms), sum(sizes)
        if system.held:
            # The residual in the driven coordinates is the impulse of the drives.
            left, size = np.delete(left, system.driven), np.delete(size, system.driven)
            yield from beyond(f"{where}: change of the drives' rates",
                               float(np.abs(event.delta[system.driven]).max(initial=0.0)),
                               DRIVE_SHAKEN * float(np.abs(event.delta).max()))  # fmt: skip
        inertias = np.diag(M)[~np.isin(np.arange(len(M)), system.held_coordinates)]
        widely = 64.0 * EPS * float(inertias.max() / inertias.min())
        share = max(MOMENTUM, min(widely, MOST_MOMENTUM))
        yield from beyond(f"{where}: momentum", float(np.abs(left).max()),
                           share * float(np.max(size)))  # fmt: skip
        # Of rates that an impact takes away altogether what its solution leaves is left, 1e-13 of
        # them; closures that move by drives alone see round-off of the others.
        widest = float(np.abs(G).max(initial=0.0))
        # Simultaneous impacts: a later one does not close a contact that an earlier one opened.
        latest = solution.events[max(place - 2, 0) : place]
        first = max((float(np.abs(old.v_before).max()) for old in latest), default=0.0)
        open_before = float(np.abs(G @ event.v_before).max(initial=0.0))
        inherited = min(open_before, IMPACT_LEFT * widest * first)
        for label, v, more in (("delta", event.delta, 0.0), ("v_after", event.v_after, inherited)):
            rates = np.abs(G @ v).max(initial=0.0)
            most = (np.abs(G) @ np.abs(v)).max(initial=0.0)
            fastest = max(np.abs(v).max(), np.abs(event.v_before).max())
            least = widest * float(IMPACT_LEFT * fastest + 16.0 * EPS * first) + more
            yield from beyond(f"{where}: closure rate of {label}", float(rates),
                               max(CLOSURE_RATE * float(most), least))  # fmt: skip
        off = np.abs(event.v_after - event.v_before - event.delta)
        speed = np.maximum(np.abs(event.v_after), np.abs(event.v_before))
        yield from beyond(f"{where}: v_after - v_before is not delta",
                           float((off - 1e-9 * np.abs(event.delta)).max()),
                           16.0 * EPS * float(speed.max())
                           + 1e-12 * float(np.abs(event.delta).max()))  # fmt: skip
        if contact:
            yield from _restitution(solution, place)


def _restitution(solution: Solution, place: int) -> Iterator[str]:
    """The law of impacts at one collision, and its loss of energy."""
    event = solution.events[place]
    # Impulses that pass from contact to contact end where none approaches.
    at_once = solution.mechanism.simultaneous == "newton"
    lost, fastest = 0.0, 0.0
    rates = []
    for name, impulse in event.P_N.items():
        stop = solution.mechanism.stop(name)
        before, after = stop.rate(event.v_before), stop.rate(event.v_after)
        xi = after + stop.restitution * before if at_once else after
        rates.append((name, impulse, before, xi))
        fastest = max(fastest, abs(before))
        lost -= 0.5 * impulse * (before + after)
    most = RESTITUTION_LAW * fastest
    for name, impulse, before, xi in rates:
        where = f"event {event.number}, stop {name}"
        yield from beyond(f"{where}: impulse pulls", -impulse, 0.0)
        yield from beyond(f"{where}: below the law", -xi, most)
        if impulse > 0.0 and at_once:
            yield from beyond(f"{where}: impulse and excess rate", abs(xi), most)
        if name in event.stops and name not in event.closed_before:
            yield from beyond(f"{where}: approach rate", before, 0.0)
    yield from beyond(f"event {event.number}: energy lost [J]", abs(event.energy_lost - lost),
                       ENERGY_LOST * abs(lost))  # fmt: skip
    yield from beyond(f"event {event.number}: energy gained [J]", -event.energy_lost,
                       ENERGY_LOST * sum(abs(p) * fastest for _, p, _, _ in rates))  # fmt: skip

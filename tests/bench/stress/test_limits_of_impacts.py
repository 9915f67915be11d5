"""Limits to which momentum, closures and the impact law are held, worked out anew."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from made_up_runs import EPS, STOPS, Body, Said, compared, mechanism, watched

from benchmarks.stress.checks import impacts as impact_invariants
from nipper_pin.hybrid.event import EventKind

# Of the momentum of machines of like links, of one heavy and one light one, and of extreme ones.
HEAVY = {"alike": 1.0, "unlike": 1e6, "extreme": 1e13}


def made(seed: int, kind: EventKind, names: tuple[str, ...], fast: float) -> Any:
    rng = np.random.default_rng(seed)
    v_before, v_after, delta, q = rng.normal(size=(4, 5))
    P_g, P_N, lost = rng.normal(size=2), rng.normal(size=len(names)), float(rng.normal())
    return SimpleNamespace(
        number=seed, kind=kind, stops=names[:1], q=q, v_before=fast * v_before,
        v_after=fast * v_after, delta=fast * delta, P_g=fast * P_g,
        P_N=dict(zip(names, (fast * P_N).tolist(), strict=True)), energy_lost=fast * lost,
        closed_before=frozenset({"far"}),
    )  # fmt: skip


def changed(event: Any, **changes: Any) -> Any:
    return SimpleNamespace(**{**vars(event), **changes})


def run(heavy: float, held: bool, rows: int = 2) -> Any:
    body = Body(3)
    body.M[4, 4] *= heavy
    # No closure moves with the driven coordinate.
    body.G[:, 0] = 0.0
    body.G = body.G[:rows]
    collision, rest = EventKind.COLLISION, EventKind.REST
    events = [
        made(1, collision, ("low",), 1.0), made(2, collision, ("high", "low"), 1e3),
        made(3, rest, ("low",), 1e-5), made(4, collision, ("far", "high"), 1e-9),
        made(5, EventKind.RELEASE, ("far",), 1.0), made(6, collision, ("low", "far"), 2e-2),
        # Nothing changes; nothing is left over; only the drive moves, before and after.
        changed(made(7, collision, ("far",), 1.0), delta=np.zeros(5)),
        changed(made(8, rest, (), 1.0), v_before=np.arange(5.0), delta=np.arange(5.0) - 2.0,
                v_after=2.0 * np.arange(5.0) - 2.0),
        changed(made(9, rest, (), 1.0), v_before=np.array([-6e4, 0.0, 1.0, -1.0, 0.0])),
        changed(made(10, rest, (), 1.0), v_after=np.array([-7e4, 0.0, 1.0, -1.0, 0.0])),
        changed(made(11, rest, (), 1.0), v_before=1e-13 * np.arange(5.0)),
    ]  # fmt: skip
    for event in events:
        event.P_g = event.P_g[:rows]
    for event in events if held else ():
        event.delta[0] *= 1e-18
    events[5].delta[0] = 0.0
    system = SimpleNamespace(
        held=held, body=body, driven=np.array([0]), held_coordinates=(0,) if held else (),
        drive_armature=np.array([50.0, 0.0, 0.0, 0.0, 0.0]),
    )  # fmt: skip
    return SimpleNamespace(system=system, events=events, mechanism=mechanism())


def wanted(solution: Any) -> list[Said]:
    """The same, sum by sum."""
    system, found = solution.system, []
    stops = {stop.name: stop for stop in STOPS}
    for place, event in enumerate(solution.events):
        if event.kind is EventKind.RELEASE or all(x == 0.0 for x in event.delta):
            continue
        where = f"event {event.number}"
        M = system.body.M * (1.0 + event.q[0] ** 2)
        if not system.held:
            M[0, 0] += 50.0
        G = system.body.G * (1.0 + abs(event.q[1]))
        left, size = [0.0] * 5, [0.0] * 5
        for i in range(5):
            terms = [M[i, j] * event.delta[j] for j in range(5)]
            pulls = [event.P_g[k] * G[k, i] for k in range(len(G))]
            pushes = [stops[n].sense * P for n, P in event.P_N.items() if stops[n].index == i]
            left[i] = sum(terms) - sum(pulls) - sum(pushes)
            size[i] = sum(map(abs, (*terms, *pulls, *pushes)))
        moving = range(1, 5) if system.held else range(5)
        if system.held:
            most = 1e-20 * max(map(abs, event.delta))
            found.append((f"{where}: change of the drives' rates", abs(event.delta[0]), most))
        inertias = [M[i, i] for i in moving]
        share = 64.0 * EPS * max(inertias) / min(inertias)
        share = 1e-9 if share < 1e-9 else 1e-4 if share > 1e-4 else share
        found.append((f"{where}: momentum", max(abs(left[i]) for i in moving),
                      share * max(size[i] for i in moving)))  # fmt: skip
        widest = max((abs(x) for row in G for x in row), default=0.0)
        old = [np.sort(np.abs(e.v_before))[-1] for e in solution.events[:place][-2:]]
        first = max(old) if old else 0.0

        def rate(v: Any, G: Any = G) -> float:
            return max((abs(sum(row[j] * v[j] for j in range(5))) for row in G), default=0.0)

        inherited = min(rate(event.v_before), 1e-12 * widest * first)
        for label, more in (("delta", 0.0), ("v_after", inherited)):
            v = getattr(event, label)
            whole = max((sum(abs(row[j] * v[j]) for j in range(5)) for row in G), default=0.0)
            fastest = max(*map(abs, v), *map(abs, event.v_before))
            least = widest * (1e-12 * fastest + 16.0 * EPS * first) + more
            found.append((f"{where}: closure rate of {label}", rate(v), max(1e-10 * whole, least)))
        off = [
            abs(event.v_after[j] - event.v_before[j] - event.delta[j]) - 1e-9 * abs(event.delta[j])
            for j in range(5)
        ]
        speed = max(*map(abs, event.v_after), *map(abs, event.v_before))
        found.append((f"{where}: v_after - v_before is not delta", max(off),
                      16.0 * EPS * speed + 1e-12 * max(map(abs, event.delta))))  # fmt: skip
        if event.kind is EventKind.COLLISION:
            found += law(event)
    return found


def law(event: Any) -> list[Said]:
    found, lost = [], 0.0
    stops = {stop.name: stop for stop in STOPS}
    before = {n: stops[n].sense * event.v_before[stops[n].index] for n in event.P_N}
    after = {n: stops[n].sense * event.v_after[stops[n].index] for n in event.P_N}
    fastest = max(map(abs, before.values()))
    for name, P in event.P_N.items():
        where = f"event {event.number}, stop {name}"
        xi = after[name] + stops[name].restitution * before[name]
        lost -= P * (before[name] + after[name]) / 2.0
        found += [(f"{where}: impulse pulls", -P, 0.0),
                  (f"{where}: below the law", -xi, 1e-11 * fastest)]  # fmt: skip
        if P > 0.0:
            found.append((f"{where}: impulse and excess rate", abs(xi), 1e-11 * fastest))
        if name == event.stops[0] and name != "far":
            found.append((f"{where}: approach rate", before[name], 0.0))
    most = sum(abs(P) for P in event.P_N.values()) * fastest
    where = f"event {event.number}"
    return [*found, (f"{where}: energy lost [J]", abs(event.energy_lost - lost), 1e-9 * abs(lost)),
            (f"{where}: energy gained [J]", -event.energy_lost, 1e-9 * most)]  # fmt: skip


@pytest.mark.parametrize("rows", [2, 0], ids=["loop", "tree"])
@pytest.mark.parametrize("held", [True, False], ids=["held", "inertial"])
@pytest.mark.parametrize("heavy", HEAVY)
def test_limits_of_impacts(
    monkeypatch: pytest.MonkeyPatch, heavy: str, held: bool, rows: int
) -> None:
    said, solution = watched(monkeypatch, impact_invariants), run(HEAVY[heavy], held, rows)
    assert list(impact_invariants.impulses(solution)) == []
    compared(said, wanted(solution))


def test_impacts_that_are_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    """Evenly chosen ones of many, the first and the last among them."""
    said, solution = watched(monkeypatch, impact_invariants), run(1.0, True)
    monkeypatch.setattr(impact_invariants, "some", lambda count, most: [count - 1, most - 100])
    solution.events = [made(k, EventKind.COLLISION, ("low",), 1.0) for k in range(1, 5)]
    assert list(impact_invariants.impulses(solution)) == []
    numbers = [what.split()[1].strip(":,") for what, _, _ in said if what.endswith("momentum")]
    assert numbers == ["4", "1"]

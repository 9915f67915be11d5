"""Machines of many parts that do not touch: each costs what it costs alone."""

from __future__ import annotations

import cProfile
import math
import pickle
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from small_machines import link, machine, slide

from nipper_pin import Case, Mechanism, Solution, Window, simulate
from nipper_pin.dynamics import Partition, ShaftMotion, System
from nipper_pin.hybrid.event_location.soonest import by_soonest, may_vanish
from nipper_pin.hybrid.motion.chebyshev import evaluate, nodes
from nipper_pin.hybrid.motion.panel import Panel
from nipper_pin.view.run.sampling import sample_forces

GRAVITY = 9.81
FEW, MANY = 4, 12
# Work of many balls by that of few; three if each costs what it costs alone.
GROWTH = 5.0


def balls(count: int, *, turned: bool = False) -> Mechanism:
    """Balls beside one another, each dropped 1 mm higher than the one before; e = 0.5."""
    parts, stops, initial = [], {}, {}
    for i in range(count)[:: -1 if turned else 1]:
        parts += [link(f"ball{i}"), slide(f"z{i}", "frame", f"ball{i}", (0.0, 1.0))]
        stops[f"floor{i}"] = {"joint": f"z{i}", "restitution": 0.5}
        initial[f"z{i}"] = {"at_mm": 100.0 + i}
    return machine(parts, count, gravity=GRAVITY, stops=stops, initial=initial)


def run(falling: Mechanism) -> Solution:
    """A turn of a second, in which all come to rest."""
    return simulate(falling, Case(speed_rpm=60.0, window=Window.CYCLE))


def calls(work: Callable[[], Any]) -> int:
    """Number of functions that some work calls: the same on every processor."""
    profile = cProfile.Profile()
    profile.runcall(work)
    return sum(entry.callcount for entry in profile.getstats())


def test_a_run_costs_what_its_parts_cost() -> None:
    few, many = balls(FEW), balls(MANY)
    # What is found once for a mechanism, and imports, are no work of a run.
    alone, together = run(few), run(many)
    assert len(together.segments) <= MANY / FEW * len(alone.segments)
    assert together.evaluations < GROWTH * alone.evaluations
    assert calls(lambda: run(many)) < GROWTH * calls(lambda: run(few))


def test_forces_of_all_stops_are_sampled_together() -> None:
    """A picture asks each piece of the motion once, and for no joint: stops are what it shows."""
    few, many = run(balls(FEW)), run(balls(MANY))
    first, second = (
        calls(lambda run=run: sample_forces(run, *run.trajectory.span)) for run in (few, many)
    )
    assert second < GROWTH * first
    t = np.linspace(*many.trajectory.span, 10)
    forces = many.trajectory.reactions(t)
    weight = np.array([forces.joints[f"z{i}"][-1, 1] for i in range(MANY)])
    assert weight == pytest.approx(np.full(MANY, GRAVITY), rel=1e-12)
    again = pickle.loads(pickle.dumps(many.trajectory.reactions(t)))
    assert [again.joints[name].tolist() for name in again.joints] == [
        forces.joints[name].tolist() for name in forces.joints
    ]


def random_panel(rng: np.random.Generator, count: int) -> Panel:
    """A panel of a hundredth of a second on which everything moves as polynomials do."""
    grid, h = nodes(13), 0.01
    powers = grid.sigma[:, None, None] ** np.arange(13)[:, None]
    a = (powers * rng.normal(0.0, rng.choice([1e2, 1e4], (13, count)), (13, count))).sum(axis=1)
    q0, v0 = rng.choice([1e-9, 1e-3, 0.1], count), rng.choice([-10.0, -0.1, 0.0, 0.3, 20.0], count)
    q = q0 + h * grid.sigma[:, None] * v0 + h**2 * grid.twice @ a
    v = v0 + h * grid.once @ a
    return Panel(1.0, h, q, v, a, Partition.of((), count), True)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("upwards", [False, True])
def test_no_gap_closes_sooner_than_it_may(seed: int, upwards: bool) -> None:
    """Against 4000 places of gaps that begin anywhere, and of their mirror images."""
    count = 12
    falling = balls(count)
    system, panel = System(falling, ShaftMotion(falling, 1.0, 0.0)), random_panel(
        np.random.default_rng(seed), count
    )  # fmt: skip
    stops = list(falling.stops)
    if upwards:
        stops = [replace(stop, sense=-1.0) for stop in stops]
        panel = replace(panel, q=-panel.q, v=-panel.v, a=-panel.a)
    found = by_soonest(system, panel, stops)
    assert [t for t, _ in found] == sorted(t for t, _ in found)
    assert {stop.name for _, stop in found} == {stop.name for stop in stops}
    t = panel.t + panel.h * np.linspace(0.0, 1.0, 4001)
    q, _ = panel.interpolate(t)
    told = 0
    for soonest, stop in found:
        closed = np.flatnonzero(stop.gaps(q) <= 0.0)
        told += panel.t < soonest < math.inf
        if closed.size:
            assert soonest <= t[closed[0]]
    assert told > 0


@pytest.mark.parametrize("seed", range(20))
def test_no_force_vanishes_that_may_not(seed: int) -> None:
    """Against 4000 places of forces that are far above zero, just above it, or below."""
    rng = np.random.default_rng(seed)
    forces = rng.normal(0.0, 1.0, (13, 12)) + rng.choice([0.0, 2.0, 30.0], 12)
    lowest = evaluate(forces, np.linspace(0.0, 1.0, 4001), 0).min(axis=0)
    possible = may_vanish(forces)
    assert possible[lowest <= 0.0].all()
    assert not possible.all()


def test_the_order_of_many_stops_tells_nothing() -> None:
    """Balls that are written down the other way round strike at the same times, to the last bit."""
    one, other = (run(balls(MANY, turned=turned)) for turned in (False, True))
    assert [(event.t, event.kind, event.stops) for event in one.events] == [
        (event.t, event.kind, event.stops) for event in other.events
    ]

"""Machines of many parts that do not touch: each costs what it costs alone."""

from __future__ import annotations

import cProfile
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from small_machines import link, machine, slide

from nipper_pin import Case, Mechanism, Solution, Window, simulate
from nipper_pin.view.run.sampling import sample_forces

GRAVITY = 9.81
FEW, MANY = 4, 12
# Work of many balls by that of few; three if each costs what it costs alone.
GROWTH = 5.0


def balls(count: int) -> Mechanism:
    """Balls beside one another, each dropped 1 mm higher than the one before; e = 0.5."""
    parts, stops, initial = [], {}, {}
    for i in range(count):
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

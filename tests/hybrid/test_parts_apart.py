"""Machines of many parts that do not touch: each has the cost and the errors that it has alone."""

from __future__ import annotations

import cProfile
import math
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from small_machines import hinge, link, machine, slide

from nipper_pin import Case, EventKind, Mechanism, Resolution, Solution, Window, simulate
from nipper_pin.hybrid.result.rebound_errors import rebound_error
from nipper_pin.view.run.sampling import sample_forces

GRAVITY, RESTITUTION = 9.81, 0.5
TOLERANCE = Resolution().tolerance

FEW, MANY = 4, 12

# Work of many balls by that of few; three if each costs what it costs alone.
GROWTH = 5.0


def balls(count: int, *, first: int = 0, order: int = 1, upwards: bool = False) -> Mechanism:
    """Balls beside one another, each dropped 1 mm higher than the one before; e = 0.5.

    They may be written down from the last one on, and their slides may count downwards.
    """
    parts, stops, initial = [], {}, {}
    sense, side = (-1.0, "upper") if upwards else (1.0, "lower")
    for i in range(first, first + count)[::order]:
        parts += [link(f"ball{i}"), slide(f"z{i}", "frame", f"ball{i}", (0.0, sense))]
        stops[f"floor{i}"] = {"joint": f"z{i}", "restitution": 0.5, "side": side}
        initial[f"z{i}"] = {"at_mm": sense * (100.0 + i)}
    return machine(parts, count, gravity=GRAVITY, stops=stops, initial=initial)


def run(falling: Mechanism, tolerance: float = TOLERANCE) -> Solution:
    """A turn of a second, in which all come to rest."""
    resolution = Resolution(tolerance=tolerance)
    return simulate(falling, Case(speed_rpm=60.0, window=Window.CYCLE, resolution=resolution))


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


def test_the_order_of_many_stops_tells_nothing() -> None:
    """Balls that are written down the other way round strike at the same times, to the last bit."""
    one, other = (run(balls(MANY, order=order)) for order in (1, -1))
    assert [(event.t, event.kind, event.stops) for event in one.events] == [
        (event.t, event.kind, event.stops) for event in other.events
    ]


def stated(solution: Solution, stop: str) -> list[tuple[float, float]]:
    """Times of the events of a stop and what is stated of them [s]."""
    return [
        (event.t, solution.errors[event.number - 1].at(stop).time)
        for event in solution.events
        if stop in event.stops
    ]


@pytest.mark.sampled(2)
@pytest.mark.parametrize("upwards", [False, True])
@pytest.mark.parametrize("count", [3, 12])
def test_errors_of_balls_hold_and_are_of_each_ball(count: int, upwards: bool) -> None:
    """Free fall with e = 0.5: bounces after t1 (3 - 2^(2-k)), rest after 3 t1; rebounds of e^2 h.

    What is stated is no less than what they are off by. No flight leaves more than its tolerance,
    and of polynomials it leaves round-off: no more than a flight alone does in each of the pieces
    into which the bounces of the others cut it. With one map of all 10 balls stated milliseconds.
    """
    heights = [0.1 + 1e-3 * i for i in range(count)]
    together = run(balls(count, upwards=upwards))
    for i, height in enumerate(heights):
        first, found = math.sqrt(2.0 * height / GRAVITY), stated(together, f"floor{i}")
        exact = [first * (3.0 - 2.0 ** (2 - k)) for k in range(1, len(found))] + [3.0 * first]
        for (t, error), right in zip(found, exact, strict=True):
            assert abs(t - right) <= error <= TOLERANCE * t
        hit = next(item for item in together.collisions if item.stop == f"floor{i}")
        of_rebound, duration = rebound_error(together, hit), 2.0 * RESTITUTION * first
        off = abs((hit.rebound_time or 0.0) - duration)
        assert off <= of_rebound.time <= TOLERANCE * duration
        off = abs((hit.rebound_amplitude or 0.0) - RESTITUTION**2 * height)
        assert off <= of_rebound.amplitude <= TOLERANCE * height
        if i % 6:
            continue
        alone = stated(run(balls(1, first=i, upwards=upwards)), f"floor{i}")
        for (_, error), (_, own) in zip(found, alone, strict=True):
            assert error <= count * own


def pendulum(beside: int) -> Mechanism:
    """A double pendulum whose lower rod strikes from both sides; balls fall beside it."""
    parts = [
        link("upper", 1.0, 0.01, (0.2, 0.0)), hinge("shoulder", "frame", "upper"),
        link("lower", 0.5, 0.004, (0.15, 0.02)), hinge("elbow", "upper", "lower", (0.4, 0.0)),
    ]  # fmt: skip
    stops: dict[str, dict[str, object]] = {
        "near": {"joint": "elbow", "restitution": 0.6, "side": "lower", "at_deg": -20.0},
        "far": {"joint": "elbow", "restitution": 0.7, "side": "upper", "at_deg": 10.0},
    }
    initial = {}
    for i in range(beside):
        parts += [link(f"ball{i}"), slide(f"z{i}", "frame", f"ball{i}", (0.0, 1.0))]
        stops[f"floor{i}"] = {"joint": f"z{i}", "restitution": 0.9}
        initial[f"z{i}"] = {"at_mm": 100.0 + 7.0 * i}
    return machine(parts, 2 + beside, gravity=GRAVITY, stops=stops, initial=initial)


def test_a_pendulum_beside_balls_has_its_own_errors() -> None:
    """Its first strikes against a run of tolerance 1e-13, and against what it states alone.

    Panels end where balls strike, so they are others than those that it has alone: what they leave
    unresolved is within the tolerance of either, and may differ by as much.
    """
    together, alone, fine = run(pendulum(3)), run(pendulum(0)), run(pendulum(0), 1e-13)
    strikes = [
        [
            (event.t, solution.errors[event.number - 1].time)
            for event in solution.events
            if event.kind is EventKind.COLLISION and event.stops[0] in ("near", "far")
        ][:6]
        for solution in (together, alone, fine)
    ]
    assert len(strikes[0]) == len(strikes[2]) > 2
    for (t, error), (_, own), (right, rest) in zip(*strikes, strict=True):
        assert abs(t - right) <= error + rest
        assert error <= 10.0 * own

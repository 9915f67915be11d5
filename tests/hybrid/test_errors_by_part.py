"""Stated errors of machines of many parts: each part has those that it has alone."""

from __future__ import annotations

import math

import pytest
from small_machines import hinge, link, machine, slide

from nipper_pin import (
    Case,
    EventKind,
    Mechanism,
    Resolution,
    Solution,
    Window,
    simulate,
)
from nipper_pin.hybrid.result.rebound_errors import rebound_error

GRAVITY, RESTITUTION = 9.81, 0.5
TOLERANCE = Resolution().tolerance


def balls(heights: list[float], *, upwards: bool = False) -> Mechanism:
    """Balls that fall from rest from these heights [m]; their slides may count downwards."""
    parts, stops, initial = [], {}, {}
    sense = -1.0 if upwards else 1.0
    for i, height in enumerate(heights):
        parts += [link(f"ball{i}"), slide(f"z{i}", "frame", f"ball{i}", (0.0, sense))]
        stops[f"floor{i}"] = {
            "joint": f"z{i}", "restitution": RESTITUTION, "side": "upper" if upwards else "lower"
        }  # fmt: skip
        initial[f"z{i}"] = {"at_mm": sense * 1e3 * height}
    return machine(parts, len(heights), gravity=GRAVITY, stops=stops, initial=initial)


def run(mechanism: Mechanism, tolerance: float = TOLERANCE) -> Solution:
    """A turn of a second, in which all balls come to rest."""
    resolution = Resolution(tolerance=tolerance)
    return simulate(mechanism, Case(speed_rpm=60.0, window=Window.CYCLE, resolution=resolution))


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
    """Free fall with e = 0.5: bounces after t1 (3 - 2^(2-k)), rest after 3 t1.

    What is stated is no less than what they are off by. No flight leaves more than its tolerance,
    and of polynomials it leaves round-off: no more than a flight alone does in each of the pieces
    into which the bounces of the others cut it. With one map of all, 20 balls had no errors at all,
    and 10 stated milliseconds.
    """
    heights = [0.1 + 1e-3 * i for i in range(count)]
    together = run(balls(heights, upwards=upwards))
    for i, height in enumerate(heights):
        first, found = math.sqrt(2.0 * height / GRAVITY), stated(together, f"floor{i}")
        exact = [first * (3.0 - 2.0 ** (2 - k)) for k in range(1, len(found))] + [3.0 * first]
        for (t, error), right in zip(found, exact, strict=True):
            assert abs(t - right) <= error <= TOLERANCE * t
        if i % 6:
            continue
        alone = stated(run(balls([height], upwards=upwards)), "floor0")
        for (_, error), (_, own) in zip(found, alone, strict=True):
            assert error <= count * own


def test_errors_of_rebounds_count_nothing_of_other_balls() -> None:
    """Height e^2 h and time 2 e t1 of the first rebound, within a tolerance of what is stated."""
    count = 10
    solution = run(balls([0.1 + 1e-3 * i for i in range(count)]))
    for i in range(count):
        hit = next(item for item in solution.collisions if item.stop == f"floor{i}")
        height = RESTITUTION**2 * (0.1 + 1e-3 * i)
        duration = 2.0 * RESTITUTION * math.sqrt(2.0 * (0.1 + 1e-3 * i) / GRAVITY)
        error = rebound_error(solution, hit)
        assert abs((hit.rebound_time or 0.0) - duration) <= error.time <= TOLERANCE * duration
        off = abs((hit.rebound_amplitude or 0.0) - height)
        assert off <= error.amplitude <= TOLERANCE * height


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

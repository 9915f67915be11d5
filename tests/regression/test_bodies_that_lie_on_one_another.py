"""A block on another one, both in free fall: round-off decided whether they touched.

Gap and rate are zero and nothing presses, so gap, rate and force of the upper one are a few
roundings of either sign. In 120 of 400 random cases it was taken to be open, struck the lower one
by itself and stayed, in the others both were thrown up together.
"""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt

import numpy as np
import pytest
from rows_of_balls import row
from small_machines import hinge, link, machine, slide, turn

from benchmarks.stress.checks.invariants import violations
from nipper_pin import EventKind, Mechanism, Solution, record


def fall(mechanism: Mechanism, most: int = 3) -> Solution:
    """A turn of three seconds, of so many collisions."""
    return turn(mechanism, 20.0, max_collisions=most)


def blocks(rng: np.random.Generator, *, gap_mm: float = 0.0, rate: float = 0.0) -> Mechanism:
    """Masses that differ by up to 1e8, a fall of 10 mm to 2 m."""
    starts = {
        "z0": {"at_mm": float(rng.uniform(10.0, 2000.0))},
        "z1": {"at_mm": gap_mm, "rate_mm_per_s": rate},
    }
    masses, e_N = 10.0 ** rng.uniform(-4.0, 4.0, 2), rng.uniform(0.1, 0.9, 2)
    return row(masses.tolist(), e_N.tolist(), wall=True, gravity=9.81, initial=starts)


def faint(rng: np.random.Generator) -> Mechanism:
    """As much between them as a number of 1 mm cannot hold, and a rate like it."""
    return blocks(rng, gap_mm=1e-14 * float(rng.random()), rate=1e-14 * float(rng.normal()))


def four(rng: np.random.Generator) -> Mechanism:
    """Three blocks on one another."""
    masses, e_N = 10.0 ** rng.uniform(-1.0, 1.0, 4), rng.uniform(0.1, 0.9, 4)
    starts = {"z0": {"at_mm": float(rng.uniform(10.0, 2000.0))}}
    return row(masses.tolist(), e_N.tolist(), wall=True, gravity=9.81, initial=starts)


def tied(rng: np.random.Generator) -> Mechanism:
    """Two blocks that fall by themselves; closures determine the gap, on a slide between them."""
    masses, height = 10.0 ** rng.uniform(-1.0, 1.0, 2), float(rng.uniform(10.0, 2000.0))
    parts = [
        link("low", float(masses[0])), slide("z0", "frame", "low", (0.0, 1.0)),
        link("high", float(masses[1])), slide("z", "frame", "high", (0.0, 1.0)),
        link("carriage", 1e-3), slide("z1", "low", "carriage", (0.0, 1.0)),
        link("end", 1e-3), slide("x", "carriage", "end"),
    ]  # fmt: skip
    return machine(
        parts, 2, gravity=9.81, closures={"tie": {"frame_a": "end", "frame_b": "high"}},
        stops={f"s{i}": {"joint": f"z{i}", "restitution": 0.5} for i in range(2)},
        initial={"z0": {"at_mm": height}, "z": {"at_mm": height}},
    )  # fmt: skip


@pytest.mark.parametrize(
    ("make", "lying"),
    [(blocks, ["s1"]), (faint, ["s1"]), (four, ["s1", "s2", "s3"]), (tied, ["s1"])],
)
def test_what_lies_on_one_another_is_in_contact(
    make: Callable[[np.random.Generator], Mechanism], lying: list[str]
) -> None:
    """At the start they are said to rest; then all are thrown up with the lowest one's rebound.

    That is Newton's law with no rate of those that touch. The impulse of one on the next is what
    those above it take: m (1 + e) v.
    """
    rng = np.random.default_rng(7)
    for _ in range(15):
        mechanism = make(rng)
        solution = fall(mechanism)
        rest, first = solution.events[:2]
        assert (rest.kind, rest.t, list(rest.stops)) == (EventKind.REST, 0.0, lying)
        assert first.kind is EventKind.COLLISION
        assert list(first.stops) == ["s0", *lying]
        height = next(item.at for item in mechanism.starts if item.joint == "z0")
        floor = mechanism.stop("s0")
        rate = -sqrt(2.0 * 9.81 * height)
        assert floor.rate(first.v_before) == pytest.approx(rate, rel=1e-12)
        assert floor.rate(first.v_after) == pytest.approx(-floor.restitution * rate, rel=1e-12)
        assert [mechanism.stop(name).rate(first.v_after) for name in lying] == [0.0] * len(lying)
        if make is not tied:
            masses = [inertia.mass for inertia in mechanism.model.inertias][1:]
            above = np.cumsum(masses[::-1])[::-1]
            jumps = -(1.0 + floor.restitution) * rate * above
            assert list(first.P_N.values()) == pytest.approx(jumps.tolist(), rel=1e-9)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_pendulum_on_a_pendulum_is_pressed_by_more_than_round_off(sense: float) -> None:
    """Two bars on one line without weight; what turns them together presses, or pulls, in earnest.

    The outer one's centre lies before (behind) the line from the first hinge to its own, so that
    centrifugal forces close (open) it: m w^2 a b, of which round-off is no part.
    """
    mechanism = machine(
        [
            link("inner", 1.0, 0.1, (0.3, 0.0)), hinge("low", "frame", "inner"),
            link("outer", 1.0, 0.1, (0.3, sense * 0.05)),
            hinge("high", "inner", "outer", (0.6, 0.0)),
        ], 2, stops={"s0": {"joint": "low", "restitution": 0.5, "at_deg": -60.0},
                     "s1": {"joint": "high", "restitution": 0.5}},
        initial={"low": {"rate_rad_per_s": -1.0}},
    )  # fmt: skip
    solution = fall(mechanism)
    start = [event.stops for event in solution.events if event.t == 0.0]
    assert start == ([("s1",)] if sense > 0.0 else [])
    assert violations(solution) == []


def cradle(law: str, gap_mm: float) -> Solution:
    """Five balls on a line without weight; the first one comes with 1 m/s from 100 mm away."""
    starts = {f"z{i}": {"at_mm": gap_mm} for i in range(1, 5)}
    starts["z0"] = {"at_mm": -100.0, "rate_mm_per_s": 1000.0}
    starts["z1"] = {"at_mm": 100.0, "rate_mm_per_s": -1000.0}
    return fall(row([1.0] * 5, 1.0, law=law, initial=starts))


@pytest.mark.parametrize("gap_mm", [0.0, 1e-14])
def test_both_laws_run_a_cradle(gap_mm: float) -> None:
    """At 0.1 s the law at once moves four balls, the one in sequence the last one alone."""
    for law, after in (
        ("newton", [-0.6, 0.4, 0.4, 0.4, 0.4]), ("sequential", [0.0, 0.0, 0.0, 0.0, 1.0])
    ):  # fmt: skip
        solution = cradle(law, gap_mm)
        rest, hit = solution.events[:2]
        assert (rest.stops, rest.t) == (("s2", "s3", "s4"), 0.0)
        assert hit.t == pytest.approx(0.1, rel=1e-14)
        assert np.cumsum(hit.v_after) == pytest.approx(after, abs=1e-14)
        assert violations(solution) == []
        (warning,) = solution.warnings
        assert f'simultaneous = "{law}"' in warning
        assert "t = 100 ms" in warning
        assert record(solution)["warnings"] == [warning]


def test_with_real_gaps_no_law_is_chosen() -> None:
    """Gaps of 1 um: the balls strike one after the other by themselves, the last one leaves."""
    starts = {f"z{i}": {"at_mm": 1e-3} for i in range(1, 5)}
    starts["z1"]["rate_mm_per_s"] = -1000.0
    initial = {"z0": {"rate_mm_per_s": 1000.0}, **starts}
    solution = fall(row([1.0] * 5, 1.0, initial=initial), 10)
    assert [event.stops for event in solution.events] == [(f"s{i}",) for i in range(1, 5)]
    last = solution.events[-1]
    assert np.cumsum(last.v_after) == pytest.approx([0.0, 0.0, 0.0, 0.0, 1.0], abs=1e-14)
    assert solution.warnings == ()
    assert "warnings" not in record(solution)


def test_forty_on_one_floor_and_forty_on_one_another() -> None:
    """Each strikes at sqrt(2 h / g); trying 2^40 sets of stops would take longer than the test."""
    beside = machine(
        [part for i in range(40) for part in (
            link(f"ball{i}", 1.0 + 0.1 * i), slide(f"z{i}", "frame", f"ball{i}", (0.0, 1.0)))],
        40, gravity=9.81, initial={f"z{i}": {"at_mm": 200.0} for i in range(40)},
        stops={f"s{i}": {"joint": f"z{i}", "restitution": 0.01 * (i + 1)} for i in range(40)},
    )  # fmt: skip
    stack = row([1.0] * 40, 0.5, wall=True, gravity=9.81, initial={"z0": {"at_mm": 200.0}})
    for mechanism in (beside, stack):
        solution = fall(mechanism, 1)
        hit = solution.events[-1]
        assert hit.t == pytest.approx(sqrt(0.4 / 9.81), rel=1e-14)
        assert len(hit.stops) == 40
        speed = sqrt(0.4 * 9.81)
        e_N = [0.01 * (i + 1) for i in range(40)] if mechanism is beside else [0.5] + [0.0] * 39
        after = [mechanism.stop(f"s{i}").rate(hit.v_after) for i in range(40)]
        assert after == pytest.approx([e * speed for e in e_N], rel=1e-13)

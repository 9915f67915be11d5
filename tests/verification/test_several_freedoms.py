"""Whole runs of machines with two to four free coordinates that hit stops on both sides.

Nothing is known of these motions beforehand; what must hold of any motion is checked: the impact
law, complementarity, the order of events, closures, the equations of motion and the energy balance.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from judged_runs import both
from planar_judge.run import judge
from random_chains import chain
from small_machines import SHAFT, SLED, frame, hinge, link, machine, slide

from benchmarks.stress.checks.invariants import violations
from nipper_pin import Case, DriveMode, EventKind, Mechanism, Outcome, Solution, Window, simulate

SEEDS = range(16)
modes = pytest.mark.parametrize("drive", list(DriveMode))


@cache
def run(seed: int, drive: DriveMode) -> Solution:
    """One turn of a second, from rest between the stops; some of them keep hitting for ever."""
    mechanism = chain(
        np.random.default_rng(seed), 2 + seed % 3, shaken=bool(seed % 2), tied=seed % 5 > 2
    )
    case = Case(
        speed_rpm=60.0, window=Window.CYCLE, start_index=0.0, drive=drive, max_collisions=200
    )
    return simulate(mechanism, case)


@pytest.mark.sampled(32)
@modes
@pytest.mark.parametrize("seed", SEEDS)
def test_what_must_hold_of_any_motion(seed: int, drive: DriveMode) -> None:
    """No invariant is violated, and the energy balances.

    A turn has up to 200 flights, each resolved to 1e-12 of its height: 2e-10 of the largest kinetic
    energy in all, if no error ever makes up for another.
    """
    solution = run(seed, drive)
    assert violations(solution) == []
    assert solution.checks.energy_balance <= 2e-10
    assert solution.collisions


@pytest.mark.campaign
def test_the_machines_show_what_they_are_meant_to() -> None:
    """Several stops closed at once, on either side, series, releases and instants of two impacts.

    Without these the invariants above would say nothing about them.
    """
    runs = [run(seed, DriveMode.HELD) for seed in SEEDS]
    closed = [segment.closed for solution in runs for segment in solution.segments]
    assert max(map(len, closed)) >= 3
    assert any(sum(name.endswith("upper") for name in names) >= 2 for names in closed)
    assert any(any(n.endswith("lower") for n in names) and any(n.endswith("upper") for n in names)
               for names in closed)  # fmt: skip
    kinds = {event.kind for solution in runs for event in solution.events}
    assert kinds == set(EventKind)
    instants = [
        np.array_equal(a.q, b.q) and a.kind is b.kind is EventKind.COLLISION
        for solution in runs
        for a, b in zip(solution.events, solution.events[1:], strict=False)
    ]
    assert any(instants)
    assert sum(solution.outcome is Outcome.COMPLETED for solution in runs) >= 8


# A body falls 0.1 m on a floor and bounces; its series of e = 0.5 ends at FALL + SERIES.
FALL = (0.2 / 9.81) ** 0.5
SERIES = 2.0 * 0.5 * FALL / (1.0 - 0.5)


def falling_pair(t: float, **case: float) -> Solution:
    """A body that bounces on the floor, and a second one that falls on it as it lies there at t."""
    parts = [
        link("a", 1.0), slide("a_z", "frame", "a", (0.0, 1.0)),
        link("b", 1.0), slide("b_z", "a", "b", (0.0, 1.0)),
    ]  # fmt: skip
    height = 0.5 * 9.81 * t**2 - 0.1
    stops = {
        "a on the floor": {"joint": "a_z", "restitution": 0.5, "at_mm": -100.0},
        "b on a": {"joint": "b_z", "restitution": 0.8, "at_mm": -1e3 * height},
    }
    window = Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0, **case)
    return simulate(machine(parts, 2, gravity=9.81, stops=stops), window)


def test_a_limit_waits_for_a_stop_that_closes_before_it() -> None:
    """A body that falls on one whose bounces are 20 us from their end meets it in the air.

    The bounces are 5 nm high then and could be taken for their limit, but a body at rest on the
    floor stays there when it is hit, and one in the air is thrown on it with 4 m/s: what follows
    differs by everything. The same run with all bounces followed to 1e-9 m/s says what is right.
    """
    t = FALL + SERIES - 20e-6
    found, followed = (falling_pair(t), falling_pair(t, rest_rate=1e-9))
    hits, wanted = (
        [(hit.stop, hit.t, hit.approach_rate) for hit in run.collisions if hit.t > t - 1e-6][:4]
        for run in (found, followed)
    )
    assert [hit[0] for hit in hits] == [hit[0] for hit in wanted]
    assert wanted[0][0] == "b on a"
    assert wanted[1][0] == "a on the floor"
    assert wanted[1][2] < -1.0
    for hit, right in zip(hits, wanted, strict=True):
        assert hit[1:] == pytest.approx(right[1:], rel=1e-9)


def test_a_collision_has_the_name_of_the_stop_that_closed() -> None:
    """A body that falls on one at rest collides at its own stop, at its own rate.

    The floor, first in the model, passes the impulse on with no rate before or after: both impulses
    are M (1 + e) w, and the row of the table is that of the stop that closed, w = g t.
    """
    t = FALL + SERIES + 0.05
    solution = falling_pair(t)
    hit = next(item for item in solution.collisions if item.t > t - 1e-6)
    assert hit.t == pytest.approx(t, rel=1e-11)
    assert hit.stop == "b on a"
    assert hit.approach_rate == pytest.approx(-9.81 * t, rel=1e-11)
    for name in ("a on the floor", "b on a"):
        assert hit.event.P_N[name] == pytest.approx(1.8 * 9.81 * t, rel=1e-11)


def test_a_machine_without_drives() -> None:
    """A pendulum let go at the horizontal bounces on a stop at the bottom, with restitution one.

    It is there after each odd quarter of the period of a free pendulum of that amplitude,
    4 K(sin 45 deg) sqrt(J / (m g l)); the elliptic integral is scipy's.
    """
    from scipy.special import ellipk

    mass, arm, inertia = 0.8, 0.3, 0.01
    parts = [link("bob", mass, inertia, (arm, 0.0)), hinge("axis", "frame", "bob")]
    stops = {"bottom": {"joint": "axis", "restitution": 1.0, "at_deg": -90.0}}
    mechanism = machine(parts, 1, gravity=9.81, stops=stops)
    solution = simulate(
        mechanism, Case(speed_rpm=60.0, window=Window.CYCLE, cycles=5, start_index=0.0)
    )
    about = inertia + mass * arm**2
    quarter = float(ellipk(0.5)) * (about / (mass * 9.81 * arm)) ** 0.5
    times = [hit.t for hit in solution.collisions]
    assert len(times) > 4
    assert times == pytest.approx([(2 * n + 1) * quarter for n in range(len(times))], rel=1e-11)


def test_three_drives() -> None:
    """Three laws at once, a shaft, a geared one and a screw, each met to the last bit.

    A free flap on the third keeps flying: the drives' powers and the flap's energy balance.
    """
    parts = [
        link("arm", 1.0, 0.1), hinge("arm_axis", "frame", "arm"),
        link("hand", 0.5, 0.05, (0.05, 0.0)), hinge("hand_axis", "arm", "hand", (0.3, 0.0)),
        link("sled", 0.4, 0.02), slide("sled_x", "hand", "sled", (1.0, 0.0), (0.1, 0.0)),
        link("flap", 0.2, 0.001, (0.05, 0.0)), hinge("flap", "sled", "flap"),
        frame("tool", "flap", (0.1, 0.0)),
    ]  # fmt: skip
    drives = {
        "arm": {"joint": "arm_axis", "law": "fourier", "sine_rad": [0.4], **SHAFT},
        "hand": {"joint": "hand_axis", "law": "geared", "of": "arm", "ratio": -1.5, **SHAFT},
        "sled": {"joint": "sled_x", "law": "screw", "lead_mm_per_turn": 80.0, **SLED},
    }
    stops = {
        "shut": {"joint": "flap", "restitution": 0.3},
        "wide": {"joint": "flap", "restitution": 0.5, "side": "upper", "at_deg": 3.0},
    }
    spring = {"joint": "flap", "stiffness_N_m_per_rad": 0.5, "preload_deg": 10.0}
    mechanism = machine(parts, 4, gravity=9.81, drives=drives, stops=stops, springs={"c": spring})
    case = Case(speed_rpm=240.0, window=Window.CYCLE, cycles=2, start_index=0.0)
    solution = simulate(mechanism, case)
    t = np.linspace(*solution.trajectory.span, 60)
    q = solution.trajectory.evaluate(t).q
    W = 8.0 * np.pi
    by_name = {joint.name: q[:, joint.index] for joint in mechanism.joints}
    assert by_name["arm_axis"] == pytest.approx(0.4 * np.sin(W * t), abs=1e-14)
    assert by_name["hand_axis"] == pytest.approx(-0.6 * np.sin(W * t), abs=1e-14)
    assert by_name["sled_x"] == pytest.approx(0.08 * W * t / (2.0 * np.pi), abs=1e-14)
    assert {hit.stop for hit in solution.collisions} == {"shut", "wide"}
    assert set(solution.trajectory.reactions(0.1).drives) == {"arm", "hand", "sled"}
    assert solution.checks.energy_balance <= 1e-12
    assert violations(solution) == []


# A chain of twenty links that falls onto a stop at its last hinge, against the planar solver.

LINKS, LENGTH, MASS, GRAVITY = 20, 0.1, 0.1, 9.81


def chain_of_links() -> Mechanism:
    """The chain, which begins level and at rest."""
    parts = []
    for number in range(LINKS):
        before = f"b{number - 1}" if number else "frame"
        at = (LENGTH if number else 0.0, 0.0)
        parts += [
            link(f"b{number}", MASS, MASS * LENGTH**2 / 12.0, (LENGTH / 2.0, 0.0)),
            hinge(f"j{number}", before, f"b{number}", at),
        ]
    stop = {"joint": f"j{LINKS - 1}", "restitution": 0.5, "side": "lower", "at_deg": -20.0}
    return machine(parts, LINKS, gravity=GRAVITY, stops={"end": stop})


@pytest.mark.slow
def test_a_long_chain_states_errors_that_bound_the_true_ones_and_tell_something() -> None:
    """Forty deviations in each of sixty panels: bounds of sets in as many dimensions add up.

    The independent solution, of bodies with constraints, is right to some 1e-14 s.
    """
    mechanism, other = both(chain_of_links())
    solution = simulate(mechanism, Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0))
    late = abs(solution.collisions[0].t - judge(other, 60.0, 0.0, most=1).events[0].t)
    stated = [error.time for error in solution.errors]
    assert late <= stated[0] + 1e-12
    assert max(stated) <= 1e-6

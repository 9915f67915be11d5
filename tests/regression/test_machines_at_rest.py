"""Round-off is no motion: what is at rest, and iterations that are to end when they have."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from small_machines import SLED, TURNING, frame, hinge, link, machine, slide, turn

from benchmarks.stress.checks.invariants import violations
from benchmarks.stress.machines.small_machines import four_bar
from nipper_pin import DriveMode, Mechanism, Resolution, Solution
from nipper_pin.chebyshev import nodes
from nipper_pin.dynamics import ShaftMotion, System
from nipper_pin.hybrid.motion.noise_floor import roughness
from nipper_pin.hybrid.motion.panel import Begin, defect, nearby
from nipper_pin.hybrid.motion.picard import flight_panel


def panels(solution: Solution, begin: float, end: float) -> int:
    """Number of panels that start in a time."""
    starts = np.array([panel.t for segment in solution.segments for panel in segment.panels])
    return int(np.count_nonzero((begin <= starts) & (starts < end)))


@pytest.mark.parametrize("damping", [0.0, 1.0])
def test_a_mass_that_hangs_in_balance_stays_there(damping: float) -> None:
    """k (l - l_0) = m g but for round-off of l, 1e-17 m: it is followed in steps of its swing.

    A turn of 1 s has 16 swings, of a few panels each; 2650 and 5733 panels were needed. What is
    left of the forces, k times 1e-17 m, moves the mass by no more than that, again and again.
    """
    m, k, length = 1.0, 1e4, 0.3
    points = {"frame_a": "post", "frame_b": "tip"}
    natural = 1e3 * (length - m * 9.81 / k)
    dampers = {"oil": {**points, "damping_N_s_per_m": damping}} if damping else {}
    hanging = machine(
        [link("mass", m), slide("z", "frame", "mass", axis=(0.0, 1.0)), frame("tip", "mass"),
         frame("post", "frame", (0.0, length))], 1, gravity=9.81, dampers=dampers,
        springs={"coil": {**points, "stiffness_N_per_m": k, "free_length_mm": natural}},
    )  # fmt: skip
    solution = turn(hanging)
    assert panels(solution, 0.0, 1.0) < 100
    assert np.abs(solution.trajectory.evaluate(np.linspace(0.0, 1.0, 50)).q).max() < 1e-14


def test_rest_is_followed_in_no_more_panels_than_motion() -> None:
    """A damped arm falls against a spring between two points, and has been at rest for long.

    It decays by e^-3 a second, so that after 20 s round-off is all there is. It hangs where the
    moments of weight and spring make up for one another.
    """
    arm = machine(
        [link("arm", 1.0, 0.1, (0.2, 0.1)), hinge("pin", "frame", "arm"),
         frame("tip", "arm", (0.3, 0.0)), frame("post", "frame", (0.3, 0.4))], 1, gravity=9.81,
        springs={"coil": {"frame_a": "post", "frame_b": "tip", "stiffness_N_per_m": 40.0,
                          "free_length_mm": 300.0}},
        dampers={"oil": {"joint": "pin", "damping_N_m_s_per_rad": 1.0}},
    )  # fmt: skip
    solution = turn(arm, cycles=40)
    moving, still = panels(solution, 0.0, 10.0), panels(solution, 30.0, 40.0)
    (angle,) = solution.trajectory.evaluate(np.array([40.0])).q[0]
    tip = 0.3 * np.array([math.cos(angle), math.sin(angle)])
    line = np.array([0.3, 0.4]) - tip
    pull = 40.0 * (1.0 - 0.3 / float(np.hypot(*line))) * line
    weight = -9.81 * (0.2 * math.cos(angle) - 0.1 * math.sin(angle))
    assert tip[0] * pull[1] - tip[1] * pull[0] + weight == pytest.approx(0.0, abs=1e-12)
    assert abs(angle) > 0.1
    assert 0 < still <= moving


def test_roughness_is_what_round_off_of_the_forces_makes() -> None:
    """Of a hanging mass: some units of k times the last digit of the length, and of g; no less."""
    m, k, length = 2.0, 1e6, 0.3
    hanging = machine(
        [link("mass", m), slide("z", "frame", "mass", axis=(0.0, 1.0)), frame("tip", "mass"),
         frame("post", "frame", (0.0, length))], 1, gravity=9.81,
        springs={"coil": {"frame_a": "post", "frame_b": "tip", "stiffness_N_per_m": k,
                          "free_length_mm": 1e3 * (length - m * 9.81 / k)}},
    )  # fmt: skip
    solution = turn(hanging)
    system, panel = solution.system, solution.segments[0].panels[0]
    rows = system.constraint_set(solution.segments[0].closed)
    found = roughness(system, rows, panel.t, panel.q[0], panel.v[0])
    eps = float(np.finfo(float).eps)
    least = eps * (k * length / m + 9.81)
    assert least < found[0] < 40.0 * least


@pytest.mark.parametrize("mass", [1e-3, 1.0, 1e6])
def test_a_load_that_lies_on_a_slow_lift_needs_no_more_panels(mass: float) -> None:
    """The motion is a straight line: the longest panels serve, whatever the load and the speed.

    The closed stop is held by an inertia that is finite, 2^100: 6,273 panels were needed.
    """
    lift = machine(
        [link("table", 1.0), link("load", mass), slide("lift", "frame", "table", axis=(0.0, 1.0)),
         slide("height", "table", "load", axis=(0.0, 1.0))], 2, gravity=9.81,
        drives={"lift": {"joint": "lift", "law": "screw", "lead_mm_per_turn": 0.01, **SLED}},
        stops={"floor": {"joint": "height", "side": "lower", "at_mm": 0.0, "restitution": 0.0}},
    )  # fmt: skip
    solution = turn(lift, 6.0)
    lying = solution.segments[-1]
    assert lying.closed == {"floor"}
    assert lying.kinematic
    assert len(lying.panels) <= solution.case.resolution.panels_per_turn + 1


def test_round_off_of_forces_in_balance_is_no_violation() -> None:
    """An arm on a stiff spring, so damped that it does not swing.

    Spring and weight are 17 rad/s2 together and make up for each other; what is left of them is
    1e-13 rad/s2. That a panel is off by 1e-10 is found.
    """
    arm = machine(
        [link("arm", 7.95, 0.25, (-0.0312, -0.0096)), hinge("pin", "frame", "arm")], 1,
        gravity=9.81,
        springs={"coil": {"joint": "pin", "stiffness_N_m_per_rad": 1.2373691708916865e7,
                          "preload_deg": 0.0}},
        dampers={"oil": {"joint": "pin", "damping_N_m_s_per_rad": 4725.9}},
    )  # fmt: skip
    solution = turn(arm, 600.0, 1e-9, cycles=2)
    assert violations(solution) == []
    last = solution.segments[-1]
    off = tuple(replace(panel, a=panel.a + 1e-10) for panel in last.panels)
    doctored = (*solution.segments[:-1], replace(last, panels=off))
    found = violations(replace(solution, segments=doctored))
    assert any("equations between nodes" in item.detail for item in found)


def evenly_lifted(gravity: float) -> Mechanism:
    """A mass on a slide that leans by 4 degrees; its weight pulls it off the stop that it is at."""
    return machine(
        [link("table"), link("load", 90.0), slide("lift", "frame", "table", axis=(0.0, 1.0)),
         slide("across", "table", "load", axis=(math.cos(0.07), -math.sin(0.07)))], 2,
        gravity=gravity,
        drives={"lift": {"joint": "lift", "law": "screw", "lead_mm_per_turn": 0.01, **SLED}},
        stops={"side": {"joint": "across", "side": "lower", "at_mm": 0.0, "restitution": 0.0}},
        phases=[{"number": 1, "name": "closed", "closed": ["side"]}],
    )  # fmt: skip


def test_the_round_off_of_a_drive_trains_torque_is_no_pull() -> None:
    """Nothing presses the stop, nothing opens it, and either may be shown.

    A weight of 1e-11 N that pulls at it is found, in the same motion.
    """
    solution = turn(evenly_lifted(0.0), cycles=2, drive="inertial")
    assert any(segment.closed for segment in solution.segments)
    assert violations(solution) == []
    weight = 1e-11 / (90.0 * math.sin(0.07))
    found = violations(replace(solution, mechanism=evenly_lifted(weight)))
    assert any("a closed stop pulls" in item.detail for item in found)


def test_what_a_dead_centre_makes_of_positions_is_no_roughness() -> None:
    """At a condition of 2e4 accelerations lose eight digits to positions, and none to forces.

    Forces that are the same but for round-off move the links by shares of round-off; were it more,
    a flight by a dead centre would be taken for resolved that is not.
    """
    both = 0.14 * (1.0 + 1e-9)
    linkage = four_bar(0.10, 0.04, 0.5 * both - 0.01, 0.5 * both + 0.01, (0.1, 0.2, 0.3))
    solution = turn(linkage.mechanism(), 300.0)
    system, segment = solution.system, solution.segments[0]
    rows = system.constraint_set(segment.closed)
    rough, lost = [], []
    for panel in segment.panels:
        q, v, a = panel.q[:1], panel.v[:1], panel.a[:1]
        motion = system.shaft.driven(panel.times[:1])
        there = system.accelerations(motion, *nearby(system, q, v, panel.split), rows)
        size = float(np.abs(a).max())
        lost.append(float(np.abs(there - a).max()) / size)
        rough.append(float(roughness(system, rows, panel.t, q[0], v[0]).max()) / size)
    assert max(lost) > 1e-8
    assert max(rough) < 1e-12


def test_the_round_off_of_a_length_of_nanometres_is_no_violation() -> None:
    """Case 23 of seed 311: an arm at rest, its spring as long as its free length to 1e-17 m.

    The check of flights knew the round-off of coordinates, which are zero, not that of places.
    """
    arm = machine(
        [link("arm", 0.4726461386305977, 0.01793539173542711,
              (-0.25866596415889076, 0.11778551845210816)),
         hinge("pin", "frame", "arm", (0.3364135485082328, -0.12455142386701773)),
         frame("post", "frame", (0.08069491425728259, 0.04774425600814569)),
         frame("tip", "arm", (-0.2557186373884912, 0.1722956848713434))], 1,
        springs={"coil": {"frame_a": "post", "frame_b": "tip",
                          "stiffness_N_per_m": 21.377344494083378,
                          "free_length_mm": 5.777957437852322e-06}},
        dampers={"oil": {"frame_a": "post", "frame_b": "tip",
                         "damping_N_s_per_m": 0.06448430888820239}},
    )  # fmt: skip
    solution = turn(arm, 152.53)
    assert panels(solution, 0.0, 1.0) < 100
    assert violations(solution) == []


TOLERANCE = 1e-12


@pytest.mark.parametrize(
    ("radius", "tilt", "inertia", "rpm"),
    [(0.0552, -0.3, 1.0, 54.93), (0.0552, 0.0, 1.0, 54.93), (0.0552, 1.2, 1.0, 54.93),
     (0.05, 1.0, 10.0, 30.0)],
)  # fmt: skip
def test_an_elastic_drive_train_is_iterated_to_its_end(
    radius: float, tilt: float, inertia: float, rpm: float
) -> None:
    """A scotch yoke on a free shaft: the nodes obey the equations of motion, and energy is kept.

    The first sweep's large change made the second one look like a contraction by 1e-5; what hardly
    moved towards its solution was left 1e-8 of its way from it. Both are asked of the finished
    motion.
    """
    parts = [
        link("crank", 2.0, 0.01, (0.01, 0.0)), hinge("shaft", "frame", "crank"),
        frame("pin", "crank", (radius, 0.0)),
        link("yoke", 1.5, 0.01), slide("x", "frame", "yoke", at=(radius, 0.0)),
        frame("line", "yoke", (0.0, 0.0), tilt),
    ]  # fmt: skip
    slot = {"frame_a": "line", "frame_b": "pin", "slot_axis": "z", "block_mass_kg": 0.01}
    shaft = {**TURNING, "reflected_inertia_kg_m2": inertia}
    yoke = machine(parts, 1, drives={"shaft": shaft}, closures={"slot": slot})
    solution = turn(yoke, rpm, drive=DriveMode.INERTIAL)
    assert solution.case.resolution.tolerance == TOLERANCE
    system = solution.system
    for segment in solution.segments:
        rows = system.constraint_set(segment.closed)
        for panel in segment.panels:
            left = defect(system, rows, panel, nodes(panel.order).sigma)
            moved = np.abs(panel.h * panel.v[0]) + panel.h**2 * np.abs(panel.a).max(axis=0)
            assert (panel.h**2 * left * rows.moving <= 10.0 * TOLERANCE * (moved + 1e-300)).all()
    assert solution.energy.relative < 100.0 * TOLERANCE


COARSE, LENGTH = 1e-10, 0.02


@pytest.mark.parametrize("round_off", [0.0, 1e-30, 1e-24])
def test_round_off_of_a_closed_stop_does_not_end_the_iteration(round_off: float) -> None:
    """Accelerations at the nodes are those of the states there, whatever the stop's was before.

    That is round-off of its infinite armature: it changed by 1 in the first sweep and not at all in
    the second, which was taken for a contraction. The shaft swings about its law by 1 mrad at 10
    Hz, so that it needs some five sweeps; after one or two the accelerations are wrong by 1e-4 of
    what moves it.
    """
    press = machine(
        [link("wheel"), hinge("shaft", "frame", "wheel"), link("block"),
         slide("lift", "frame", "block", (0.0, 1.0))],
        2,
        gravity=9.81,
        drives={"shaft": TURNING},
        stops={"lift": {"joint": "lift", "restitution": 0.5}},
    )  # fmt: skip
    shaft = ShaftMotion(press, 2.0 * np.pi, 0.0)
    system = System(press, shaft, DriveMode.INERTIAL)
    rows = system.constraint_set(frozenset({"lift"}))
    wheel, lift = (
        next(joint.index for joint in press.joints if joint.name == name)
        for name in ("shaft", "lift")
    )
    q, v = np.zeros(2), np.zeros(2)
    q[wheel], v[wheel] = 1e-3, 2.0 * np.pi
    motion = shaft.driven(np.zeros(1))
    start = system.accelerations(motion, q[None], v[None], rows)[0]
    assert abs(start[wheel]) > 1.0
    start[lift] = round_off
    none = np.zeros((0, 2))
    split = system.split(none, rows.given, (wheel,))
    begin = Begin(0.0, q, v, start, none)
    attempt = flight_panel(system, rows, split, begin, LENGTH, Resolution(tolerance=COARSE))
    panel = attempt.panel
    assert panel is not None
    exact = system.accelerations(shaft.driven(panel.times), panel.q, panel.v, rows)
    wrong = np.abs(exact - panel.a)[:, wheel].max() * LENGTH**2
    assert wrong <= 10.0 * COARSE * (LENGTH * v[wheel])

"""Springs, dampers and tables between two nodes and beyond their ends."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq
from small_machines import SLED, TURNING, frame, hinge, link, machine, slide, turn

from benchmarks.stress.checks.invariants import violations
from nipper_pin import DriveMode, ElementError, Mechanism
from nipper_pin.dynamics import Partition, ShaftMotion, System
from nipper_pin.hybrid.motion.panel import Panel, defect
from nipper_pin.hybrid.motion.residual_check import shows_turns


def pushed(force: float, start: float, distance: float, **tables: Any) -> Mechanism:
    """A mass of 1 kg on a slide; it starts beside an anchor, which lies off its way, and is pushed.

    Args:
        force: Along x [N].
        start: From the anchor's foot [m].
        distance: Of the anchor from the slide [m].
        **tables: Further tables, of the points ``mass`` and ``anchor``.
    """
    parts = [
        link("mass"), slide("x", "frame", "mass", at=(start, 0.0)),
        frame("anchor", "frame", (0.0, distance)),
    ]  # fmt: skip
    push = {"joint": "x", "coordinate_mm": [-1.0, 9e5], "force_N": [-force, -force]}
    return machine(parts, 1, **{**tables, "springs": {"push": push, **tables.get("springs", {})}})


def test_a_strut_in_a_machine_of_one_joint() -> None:
    """A mass on a spring between two points along its slide swings as the cosine.

    x = 0.1 (1 - cos W t), W^2 = k / m: the spring is 0.1 m longer than its free length at touch.
    """
    parts = [link("mass", 2.0), slide("x", "frame", "mass"), frame("wall", "frame", (1.0, 0.0))]
    spring = {"frame_a": "mass", "frame_b": "wall", "stiffness_N_per_m": 50.0,
              "free_length_mm": 900.0}  # fmt: skip
    solution = turn(machine(parts, 1, springs={"pull": spring}))
    t = np.linspace(0.0, 1.0, 41)
    wanted = 0.1 * (1.0 - np.cos(5.0 * t))
    assert solution.trajectory.evaluate(t).q[:, 0] == pytest.approx(wanted, abs=1e-12)


def test_tables_that_an_iteration_leaves_far_behind() -> None:
    """Steep tables that push apart: an error about the table's end, and no warning on the way.

    The trial states of an iteration reached cubes of 1e100; two such tables made infinity less
    infinity.
    """
    parts = [link("mass", 0.1), slide("x", "frame", "mass")]
    tables = {
        name: {"joint": "x", "coordinate_mm": [-10.0, -1.0, 1.0, 10.0], "force_N": force}
        for name, force in (("one", [900.0, 1e6, -1e6, -9e5]), ("two", [-1e5, 2.0, 1.0, 9e4]))
    }
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ElementError, match="add rows"):
            turn(machine(parts, 1, springs=tables, gravity=9.81), cycles=2)


@pytest.mark.parametrize("rpm", [20.0, 65.8])
def test_a_table_is_left_where_the_motion_leaves_it(rpm: float) -> None:
    """Two slides thrown off their stops by a spring, at a tolerance of 1e-3.

    It is refused where a panel is first looked at behind the end of the table. Time and place are
    those of the same motion by solve_ivp, with PCHIP of scipy. A refusal alone would not do: one of
    -69 m was given at 20 r/min, for a time at which the mass has gone 1.6 mm.
    """
    m, along = (2.0, 7.0), -0.92
    x = [-502.2, -305.7, -121.8, -77.8, 102.4, 506.9]
    f = [122.8, 153268.0, 165574.0, 178893.0, 189242.0, 189245.0]
    wall, walls = [-534.3, -533.7, 0.0, 760.9, 761.4], [-32.3, -1.6, 0.0, 1.6, 32.3]
    stop = {"side": "upper", "at_mm": 0.0}
    thrown = machine(
        [link("first", m[0]), slide("j0", "frame", "first"), link("second", m[1]),
         slide("j1", "first", "second", (along, (1.0 - along**2) ** 0.5))], 2,
        springs={"table": {"joint": "j0", "coordinate_mm": x, "force_N": f},
                 "walls": {"joint": "j1", "coordinate_mm": wall, "force_N": walls}},
        stops={"j0 upper": {"joint": "j0", "restitution": 1.0, **stop},
               "j1 upper": {"joint": "j1", "restitution": 0.6, **stop}},
        phases=[{"number": 1, "name": "closed", "closed": ["j0 upper", "j1 upper"]}],
    )  # fmt: skip
    with pytest.raises(ElementError, match="add rows") as caught:
        turn(thrown, rpm, 1e-3)

    first, second = (
        PchipInterpolator(1e-3 * np.array(rows), force) for rows, force in ((x, f), (wall, walls))
    )
    mass = np.array([[sum(m), m[1] * along], [m[1] * along, m[1]]])

    def rates(_: float, state: np.ndarray) -> np.ndarray:
        pull = -np.array([first(state[0]), second(state[1])])
        return np.concatenate([state[2:], np.linalg.solve(mass, pull)])

    t, place = caught.value.evidence["t"], caught.value.evidence["q"]
    known = solve_ivp(rates, (0.0, t), np.zeros(4), rtol=1e-11, atol=1e-11).y[:2, -1]
    assert place[0] < -0.5022
    assert place == pytest.approx(known, rel=2e-2)


def test_iterations_that_diverge_end_before_they_overflow() -> None:
    """A strut of 1e9 N/m and 9e4 N s/m between frame and the end of two links on a Scotch yoke.

    Its first panel is a thousand times too long: changes grew by 1e16 with every sweep. Warnings
    are errors here.
    """
    centre = 0.024085381177609794
    parts = [
        link("crank", 2.0, 0.01, (0.01, 0.0)), hinge("shaft", "frame", "crank"),
        frame("pin", "crank", (centre, 0.0)),
        link("yoke", 1.5, 0.01), slide("yoke_x", "frame", "yoke", at=(centre, 0.0)),
        frame("line", "yoke", (0.0, 0.0), 0.041150570266961894),
        link("arm", 10.0, 0.5143929972553989, (-0.08462270260654017, -0.03981860968102241)),
        hinge("arm", "yoke", "arm", (0.175373928131643, -0.13848149175702068)),
        link("sled", 1.9825045124307892, 0.0903087568287331,
             (0.030108024995285754, -0.1689056678566432)),
        slide("sled", "arm", "sled", (0.41005253350244125, 0.9120619056666216),
              (0.16245494610588473, -0.1490637210152893)),
        frame("wall", "frame", (-0.1063306157700345, -0.16266237284509535)),
        frame("eye", "sled", (-0.46650720116545713, 0.19731262754767562)),
    ]  # fmt: skip
    ends = {"frame_a": "wall", "frame_b": "eye"}
    yoke = machine(
        parts, 3,
        drives={"shaft": TURNING},
        closures={"slot": {"frame_a": "line", "frame_b": "pin", "slot_axis": "z",
                           "block_mass_kg": 0.4329644866438884}},
        springs={"arm": {"joint": "arm", "stiffness_N_m_per_rad": 199835.8162529677,
                         "preload_deg": 5.731931159194118},
                 "strut": {**ends, "stiffness_N_per_m": 1e9, "free_length_mm": 0.0}},
        dampers={"strut": {**ends, "damping_N_s_per_m": 89050.64878889517}},
        stops={
            "lower": {"joint": "sled", "restitution": 0.635619226326166, "side": "lower",
                      "at_mm": -0.0032803008814383614},
            "arm": {"joint": "arm", "restitution": 1.0, "side": "lower",
                    "at_deg": -0.0015318129110961408},
        },
    )  # fmt: skip
    case = {"drive": DriveMode.INERTIAL, "max_collisions": 3}
    solution = turn(yoke, 594.7886106682569, 1e-9, **case)
    assert len(solution.collisions) == 3
    assert solution.energy.relative < 1e-8


@pytest.mark.parametrize("distance", [1e-3, 1e-5, 1e-7])
def test_a_damper_whose_points_pass_closely_in_flight(distance: float) -> None:
    """A mass is pushed past the other point of a damper, which is slack in the instant of the pass.

    With the part x / l of the rate along the damper m v v' = F - c v x^2 / (x^2 + d^2). With
    x = d tan u the right side is smooth in u however small d is, and any integrator solves it.
    Nodes on both sides of the pass miss a gain of pi d c / m in v: 6e-5 m/s at 1e-5 m, of 0.9 m/s.
    """
    c, m, F, start = 2.0, 1.0, 3.0, -0.3
    dampers = {"brake": {"frame_a": "mass", "frame_b": "anchor", "damping_N_s_per_m": c}}
    solution = turn(pushed(F, start, distance, dampers=dampers))
    there = solution.trajectory
    # From 0.1 mm behind the start, where the mass moves already.
    first = brentq(lambda t: there.evaluate(t).q[0, 0] - 1e-4, 1e-4, 0.5, xtol=1e-15)
    (x0, x1), (v0, v1) = (
        (getattr(there.evaluate(np.array([first, 1.0])), name)[:, 0]) for name in "qv"
    )
    assert x1 + start > 0.05

    def slope(u: float, w: np.ndarray) -> np.ndarray:
        x = distance * np.tan(u)
        braked = c * np.sqrt(w) * x**2 / (x**2 + distance**2)
        return 2.0 / m * (F - braked) * distance / np.cos(u) ** 2

    angles = np.arctan2([x0 + start, x1 + start], distance)
    found = solve_ivp(slope, angles, [v0**2], rtol=1e-12, atol=1e-14, method="DOP853")
    assert v1 == pytest.approx(float(np.sqrt(found.y[0, -1])), rel=1e-8)
    assert violations(solution) == []


def test_a_damper_whose_points_pass_closely_in_a_phase_without_freedom() -> None:
    """The drive's work on a damper that its crank pin passes at 10 um of 50 mm is all heat.

    Nothing else acts, and the crank turns at constant speed. The power dips to zero within 1e-4 of
    a radian, and quadrature over whole panels sees the dip or not: 1e-5 of the work.
    """
    parts = [
        link("crank", 1.0), hinge("shaft", "frame", "crank"),
        frame("pin", "crank", (0.05, 0.0)), frame("anchor", "frame", (-0.05001, 0.0)),
    ]  # fmt: skip
    dampers = {"brake": {"frame_a": "pin", "frame_b": "anchor", "damping_N_s_per_m": 3.0}}
    energy = turn(machine(parts, 1, drives={"shaft": TURNING}, dampers=dampers)).energy
    # The distance is that of two points on circles: l^2 = r^2 + R^2 + 2 r R cos u.
    r, R, W = 0.05, 0.05001, 2.0 * np.pi

    def power(u: float) -> float:
        return 3.0 * (r * R * W * np.sin(u)) ** 2 / (r**2 + R**2 + 2.0 * r * R * np.cos(u))

    # Near the pass the half angle is what is small: no digits are lost.
    def near(w: float) -> float:
        s = np.sin(0.5 * w) ** 2
        return 3.0 * (r * R * W * np.sin(w)) ** 2 / ((R - r) ** 2 + 4.0 * r * R * s)

    points = [1e-5, 1e-4, 1e-3, 1e-2, 0.1]
    heat = quad(near, 0.0, 1.0, points=points, epsabs=0.0, epsrel=1e-12, limit=500)[0]
    heat += quad(power, 0.0, np.pi - 1.0, epsabs=0.0, epsrel=1e-12)[0]
    heat *= 2.0 / W
    assert energy.dissipated == pytest.approx(heat, rel=1e-9)
    assert energy.drive_work == pytest.approx(heat, rel=1e-9)


def test_panels_grow_again_after_a_short_one() -> None:
    """A pendulum that passes the anchor of its damper at 1 um needs no thousand panels.

    The pass itself takes panels of a microsecond, of so few nodes that the advice for the next one
    was one that just suits as few, for ever: 4,817 panels where 200 do.
    """
    parts = [
        link("bob", 1.0, 0.01, (0.0, -0.3)), hinge("axis", "frame", "bob"),
        frame("end", "bob", (0.3, 0.0)), frame("anchor", "frame", (0.0, -0.300001)),
    ]  # fmt: skip
    dampers = {"brake": {"frame_a": "end", "frame_b": "anchor", "damping_N_s_per_m": 0.05}}
    spring = {"joint": "axis", "stiffness_N_m_per_rad": 20.0, "preload_deg": 90.0}
    mechanism = machine(parts, 1, gravity=9.81, dampers=dampers, springs={"coil": spring})
    solution = turn(mechanism, cycles=2)
    axis = solution.trajectory.evaluate(np.linspace(0.0, 2.0, 400)).q[:, 0]
    assert axis.min() < -0.5 * np.pi < axis.max()
    assert sum(len(segment.panels) for segment in solution.segments) < 1500


@pytest.mark.parametrize("tolerance", [1e-3, 4e-5, 1e-6])
@pytest.mark.parametrize("distance", [1e-2, 1e-4, 1e-6])
def test_a_spring_whose_points_pass_closely_keeps_the_energy(
    tolerance: float, distance: float
) -> None:
    """A mass is pushed over the barrier of a spring that is too long for where it stands.

    F (x - x_0) = m v^2 / 2 + k ((l - l_0)^2 - (l_s - l_0)^2) / 2. The force of the spring changes
    from -k l_0 to k l_0, twenty times the push, within the distance.
    """
    m, F, k, natural, start = 1.0, 3.0, 100.0, 0.12, -0.3
    barrier = {"frame_a": "mass", "frame_b": "anchor", "stiffness_N_per_m": k,
               "free_length_mm": 1e3 * natural}  # fmt: skip
    mass = pushed(F, start, distance, springs={"barrier": barrier})
    there = turn(mass, tolerance=tolerance).trajectory
    t = np.linspace(0.0, 1.0, 101)
    motion = there.evaluate(t)
    x, v = motion.q[:, 0], motion.v[:, 0]
    length = np.hypot(start + x, distance)
    stretched = 0.5 * k * ((length - natural) ** 2 - (math.hypot(start, distance) - natural) ** 2)
    left = F * x - stretched - 0.5 * m * v**2
    assert start + x.max() > 0.05
    # Each of some two dozen panels leaves the tolerance of the travel, against the steepest force.
    # Where nodes alone decided, up to 0.028 J were missing at 4e-5 and 0.0009 J at 1e-6.
    assert np.abs(left).max() < 25.0 * tolerance * k * natural * x.max()


def test_the_work_against_a_table_is_integrated_between_its_rows() -> None:
    """A crank turns against a spring with a kink: its work is what the spring stores.

    The stored energy is a sum of integrals of cubics, the work one over time that bends wherever a
    row is passed. Across rows a quadrature of 16 points was wrong by 8e-4 of it.
    """
    rows = {"coordinate_deg": [-10.0, 17.0, 41.0, 44.0, 151.0, 233.0, 370.0],
            "torque_N_m": [-2.0, -1.0, 3.0, -8.0, 5.0, 6.0, 40.0]}  # fmt: skip
    crank = machine(
        [link("crank"), hinge("shaft", "frame", "crank")], 1,
        drives={"shaft": TURNING}, springs={"cam": {"joint": "shaft", **rows}},
    )  # fmt: skip
    energy = turn(crank).energy
    (table,) = crank.tabulated_springs
    low, high = table.characteristic.energies(np.array([0.0, math.tau]))
    assert energy.drive_work == pytest.approx(float(high - low), rel=1e-13)
    assert energy.spring_change == pytest.approx(float(high - low), rel=1e-13)


def test_round_off_of_a_light_block_does_not_cut_flights_to_pieces() -> None:
    """A block of 1 mg in a slot bears 0.8 N: round-off of that is 1e-10 m/s2 of its own.

    It follows from what moves it. A flight of the series is one panel; where the block was asked,
    too, some were cut into four, and every border costs a small gap digits.
    """
    lean, push = 0.4, 0.3
    parts = [
        link("arm", 1.0, 0.1, (0.3, 0.0)), hinge("turn", "frame", "arm"),
        link("sled", 0.5), slide("s", "arm", "sled", axis=(1.0, 0.3)),
        frame("tip", "sled", (0.2, 0.1)), frame("wall", "frame", (-1.0, 0.37)),
        frame("rail", "frame", (0.2 + push * math.sin(lean), 0.1 - push * math.cos(lean)), lean),
    ]  # fmt: skip
    springs = {
        "far": {"frame_a": "arm", "frame_b": "wall", "stiffness_N_per_m": 1.0,
                "free_length_mm": 0.0},
        "block": {"joint": "rail", "stiffness_N_per_m": 2.0, "preload_length_mm": -400.0},
        "arm": {"joint": "turn", "stiffness_N_m_per_rad": 2.0, "preload_deg": 46.0},
    }  # fmt: skip
    slot = {"frame_a": "rail", "frame_b": "tip", "slot_axis": "z", "block_mass_kg": 1e-6}
    floor = {"joint": "turn", "side": "lower", "at_deg": -1.2, "restitution": 0.5}
    swing = machine(
        parts, 1, gravity=9.81, springs=springs, stops={"floor": floor}, closures={"rail": slot}
    )
    late = turn(swing).segments[4:13]
    assert all(not segment.kinematic for segment in late)
    assert [len(segment.panels) for segment in late] == 9 * [1]


def test_round_off_does_not_refine_the_work_of_what_hardly_moves() -> None:
    """A ball on a stiff rod shakes, comes to rest in oil, and is then carried on very slowly.

    What the drive does then is next to nothing, and round-off of the rod's force is a large part of
    it. Sixteen evaluations a panel are one quadrature; on average it took 188.
    """
    parts = [
        link("base"), slide("shaft", "frame", "base"), link("ball"),
        slide("z", "base", "ball", axis=(0.6, 0.8)), frame("hook", "base", (0.0, 0.1)),
    ]  # fmt: skip
    ball = machine(
        parts, 2, gravity=9.81,
        drives={"shaft": {"joint": "shaft", "law": "screw", "lead_mm_per_turn": 0.01, **SLED}},
        springs={"rod": {"frame_a": "hook", "frame_b": "ball", "stiffness_N_per_m": 1e5,
                         "free_length_mm": 101.0}},
        dampers={"oil": {"joint": "z", "damping_N_s_per_m": 1e3}},
    )  # fmt: skip
    solution = turn(ball, 600.0)
    panels = sum(len(segment.panels) for segment in solution.segments)
    before = solution.system.body.evaluations
    assert solution.energy.relative < 1e-11
    assert solution.system.body.evaluations - before < 2 * 16 * panels


@pytest.mark.parametrize("distance", [1e-3, 1e-6, 1e-9])
def test_a_damper_whose_points_are_together_where_a_stop_closes(distance: float) -> None:
    """Pushed against a damper, a mass meets its stop where the damper stands across its way.

    There is nothing left of the damper's force then, half an instant before it had all of it, and
    no node lay there. An acceleration that knows nothing of that is off by c v / m, a half of F /
    m; with panels that end there it is off by what the tolerance leaves of a motion of their
    length.
    """
    F, c, way = 3.0, 5.0, 0.3
    dampers = {"pot": {"frame_a": "mass", "frame_b": "anchor", "damping_N_s_per_m": c}}
    wall = {"joint": "x", "side": "upper", "at_mm": 1e3 * way, "restitution": 0.0}
    tolerance = 1e-9
    mass = pushed(F, -way, distance, dampers=dampers, stops={"wall": wall})
    solution = turn(mass, tolerance=tolerance)
    flight, system = solution.segments[0], solution.system
    last = flight.panels[-1]
    assert solution.events[0].stops == ("wall",)
    end = np.array([(flight.t_end - last.t) / last.h])
    off = defect(system, system.constraint_set(flight.closed), last, end)[0, 0]
    moved = abs(last.h * last.v[0, 0]) + last.h**2 * np.abs(last.a).max()
    assert off <= 2.0 * (2.0 * last.order) ** 2 * tolerance * moved / last.h**2


RADIUS = 0.5

OIL = {"oil": {"frame_a": "post", "frame_b": "tip", "damping_N_s_per_m": 1.0}}


def swept(mechanism: Mechanism, rate: np.ndarray, middle: float = 0.0) -> bool:
    """Whether four nodes, at -1/2, -1/4, 1/4 and 1/2 of this way, show the damper's turning."""
    system = System(mechanism, ShaftMotion(mechanism, math.tau, 0.0))
    way = np.array([0.0, 0.25, 0.75, 1.0])[:, None] - 0.5
    q, v = middle + way * rate, np.repeat(rate[None], 4, axis=0)
    split = Partition((), tuple(range(len(rate))))
    assert system.elements is not None
    panel = Panel(0.0, 1.0, q, v, np.zeros_like(q), split, integrated=True)
    return shows_turns(system.elements, panel, 1e-12)


@pytest.mark.parametrize("beside_m", [-1e-10, 0.0, 1e-10])
@pytest.mark.parametrize("distance_m", [1.5e-8, 1e-6, 1e-4])
def test_a_chord_does_not_hide_that_points_pass(distance_m: float, beside_m: float) -> None:
    """The tip of an arm passes a post below its arc; the chord of two nodes meets the post.

    Half of the chord spans the angle whose cosine is 1 - d / R. Within 1 nm the chord takes the
    points for one, and the line between them for one that needs no direction; the arc does not.
    """
    half = math.acos(1.0 - distance_m / RADIUS)
    post = (0.0, RADIUS - distance_m + beside_m)
    arm = machine(
        [link("arm"), hinge("pin", "frame", "arm"), frame("tip", "arm", (0.0, RADIUS)),
         frame("post", "frame", post)], 1, dampers=OIL,
    )  # fmt: skip
    assert not swept(arm, np.array([4.0 * half]))


@pytest.mark.parametrize("turning", [0.0, 1e-3])
def test_points_that_meet_need_no_direction(turning: float) -> None:
    """A slide carries one point of a damper straight through the other, on a base that may turn."""
    slider = machine(
        [link("base"), hinge("shaft", "frame", "base"), link("mass"),
         slide("x", "base", "mass", axis=(0.6, 0.8), at=(-0.06, -0.08)),
         frame("tip", "mass"), frame("post", "base")], 2, dampers=OIL,
        drives={"shaft": TURNING},
    )  # fmt: skip
    assert swept(slider, np.array([turning, 0.02]), middle=0.1)


@pytest.mark.parametrize("distance_m", [1e-6, 1e-4])
def test_points_that_pass_in_many_nodes_are_shown(distance_m: float) -> None:
    """Nodes on a way as short as the distance see the line turn by and by."""
    arm = machine(
        [link("arm"), hinge("pin", "frame", "arm"), frame("tip", "arm", (0.0, RADIUS)),
         frame("post", "frame", (0.0, RADIUS - distance_m))], 1, dampers=OIL,
    )  # fmt: skip
    assert swept(arm, np.array([distance_m / RADIUS]))


@pytest.mark.parametrize(("damping", "distance_m"), [(5.0, 2e-9), (5.0, 1e-8), (20.0, 2e-9)])
def test_a_damper_that_turns_as_its_points_leave_each_other_keeps_its_impulse(
    damping: float, distance_m: float
) -> None:
    """A mass is pushed away from the post of its damper, at first a little aside.

    m v = F t - c int X^2 / (X^2 + d^2) dX = F t - c (x - d (atan(X / d) - atan(2))), X = 2 d + x.
    The line turns by half a radian where the mass hardly moves yet. Of a share of 1e-12 that a
    panel may leave nothing is seen; without short panels beside the post 0.46 c d is missing, a
    share of 15e-12 to 77e-12.
    """
    m, F, c, d = 1.0, 300.0, damping, distance_m
    oil = {"frame_a": "anchor", "frame_b": "mass", "damping_N_s_per_m": c}
    solution = turn(pushed(F, 2.0 * d, d, dampers={"oil": oil}))
    t = np.linspace(0.0, 1.0, 101)
    motion = solution.trajectory.evaluate(t)
    x, v = motion.q[:, 0], motion.v[:, 0]
    turned = np.arctan((2.0 * d + x) / d) - math.atan(2.0)
    assert np.abs(m * v - F * t + c * (x - d * turned)).max() < 1e-12 * F
    assert c * d * turned[-1] > 15e-12 * F

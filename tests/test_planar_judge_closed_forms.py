"""The independent planar solver against closed forms.

A run is resolved to 3e-11 of an acceleration inside a step, and to the square of that at its end,
so what is left at events is round-off: some 1e-16 of the time and the coordinates, times what the
motion amplifies. TIGHT is a hundred times that.
"""

from __future__ import annotations

import ast
import math
from pathlib import Path

import numpy as np
import pytest
from judged_runs import both
from lid_box import followed, lid_box
from mpmath import mp
from planar_judge.dynamics import Dynamics
from planar_judge.flight import Precision
from planar_judge.laws import extreme, read_laws
from planar_judge.machine import Machine, build
from planar_judge.record import Verdict
from planar_judge.run import judge
from planar_judge.verdict import Reason
from scipy.interpolate import make_interp_spline
from scipy.linalg import expm
from small_machines import SHAFT, frame, hinge, link, slide, sources

from benchmarks.stress.mechanics import model_text

TIGHT = 2e-14
G = 9.81
CRANK = {"joint": "crank", "law": "constant_speed", "ratio": 1.0, **SHAFT}
OMEGA = 2.0 * math.pi


def build_small(parts: list[str], freedom: int = 1, **tables: object) -> Machine:
    return build(*sources(parts, freedom, **tables))


def ran(machine: Machine, **case: object) -> Verdict:
    """One second, a turn at 60 r/min, from the drawing."""
    verdict = judge(machine, 60.0, 0.0, **case)
    assert verdict.reason == "", verdict.detail
    return verdict


def test_it_shares_nothing_with_what_it_judges() -> None:
    """Nor does the reader of links, which it has from the judge of the campaign."""
    files = (Path(__file__).parent / "planar_judge").glob("*.py")
    for file in (*files, Path(model_text.__file__)):
        for node in ast.walk(ast.parse(file.read_text())):
            names = [item.name for item in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and not node.level:
                names = [str(node.module)]
            names = [name for name in names if name != "benchmarks.stress.mechanics"]
            roots = {name.partition(".")[0] for name in names}
            allowed = {
                "__future__", "collections", "csv", "dataclasses", "enum", "functools", "itertools",
                "math", "numpy", "pathlib", "scipy", "tomllib", "typing", "xml",
            }  # fmt: skip
            assert roots <= allowed, (file.name, roots - allowed)


# Bounces.


@pytest.mark.parametrize("e", [0.0, 0.05, 0.5, 0.8])
def test_a_mass_bounces_to_its_rest(e: float) -> None:
    """Falls of h and (e^2)^k h; the series ends at t_0 + 2 e v / (g (1 - e))."""
    h = 0.02
    machine = build_small(
        [link("mass", 0.3), slide("z", "frame", "mass", (0.0, 1.0))], gravity=G,
        stops={"floor": {"joint": "z", "restitution": e, "at_mm": -1e3 * h}},
    )  # fmt: skip
    verdict = ran(machine)
    v, t = math.sqrt(2.0 * G * h), math.sqrt(2.0 * h / G)
    collisions = [item for item in verdict.events if item.kind == "collision"]
    for item in collisions[:12]:
        assert item.t == pytest.approx(t, abs=TIGHT)
        assert item.before["floor"] == pytest.approx(-v, rel=1e-12)
        assert item.after["floor"] == pytest.approx(e * v, rel=1e-12)
        assert item.impulses["floor"] == pytest.approx(0.3 * (1.0 + e) * v, rel=1e-12)
        assert item.lost == pytest.approx(0.15 * v * v * (1.0 - e * e), rel=1e-12)
        v *= e
        t += 2.0 * v / G
    (rest,) = (item for item in verdict.events if item.kind == "rest")
    v, t = math.sqrt(2.0 * G * h), math.sqrt(2.0 * h / G)
    assert rest.t == pytest.approx(t + 2.0 * e * v / (G * (1.0 - e)), abs=2.0 * TIGHT)
    assert verdict.stop_force("floor", 0.99) == pytest.approx(0.3 * G, rel=1e-13)


def test_an_upper_stop_and_one_that_lets_go() -> None:
    """A table that moves as sin(wt) leaves a mass behind where its acceleration is that of g."""
    radius, e = 0.4, 0.0
    machine = build_small(
        [
            link("table", 1.0), slide("lift", "frame", "table", (0.0, 1.0)),
            link("mass", 0.3), slide("gap", "table", "mass", (0.0, -1.0)),
        ], 2, gravity=G,
        drives={"lift": {"joint": "lift", "law": "fourier", "sine_rad": [radius], **SHAFT}},
        stops={"table": {"joint": "gap", "restitution": e, "side": "upper"}},
        phases=[{"number": 1, "name": "on", "closed": ["table"]},
                {"number": 2, "name": "off", "closed": []}],
    )  # fmt: skip
    verdict = ran(machine)
    release = verdict.events[0]
    assert release.kind == "release"
    t = math.asin(G / (radius * OMEGA**2)) / OMEGA
    assert release.t == pytest.approx(t, abs=TIGHT)
    force = 0.3 * (G - radius * OMEGA**2 * math.sin(OMEGA * 0.05))
    assert verdict.stop_force("table", 0.05) == pytest.approx(force, rel=1e-12)
    rate, height = radius * OMEGA * math.cos(OMEGA * t), radius * math.sin(OMEGA * t)
    landing = verdict.events[1]

    def gap(s: float) -> float:
        flown = height + rate * (s - t) - 0.5 * G * (s - t) ** 2
        return flown - radius * math.sin(OMEGA * s)

    slope = abs(gap(landing.t + 1e-6) - gap(landing.t - 1e-6)) / 2e-6
    assert landing.kind == "collision"
    assert abs(gap(landing.t)) / slope < 5.0 * TIGHT
    # Without restitution it stays.
    assert verdict.events[2].kind == "rest"


def test_impact_of_a_rod() -> None:
    """A carrier on a slide with an inclined rod on a pin: the rod yields by turning."""
    m, inertia, carrier, length, angle, e, h = 0.8, 3e-3, 0.2, 0.15, 0.5, 0.6, 0.01
    centre = (length * math.cos(angle), length * math.sin(angle))
    machine = build_small(
        [
            link("carrier", carrier), slide("z", "frame", "carrier", (0.0, 1.0)),
            link("rod", m, inertia, centre), hinge("pin", "carrier", "rod"),
        ], 2, gravity=G, stops={"floor": {"joint": "z", "restitution": e, "at_mm": -1e3 * h}},
    )  # fmt: skip
    event = ran(machine).events[0]
    v = math.sqrt(2.0 * G * h)
    coupling = m * centre[0]
    yields = np.linalg.inv([[carrier + m, coupling], [coupling, inertia + m * length**2]])[0, 0]
    assert event.t == pytest.approx(math.sqrt(2.0 * h / G), abs=TIGHT)
    assert event.impulses["floor"] == pytest.approx((1.0 + e) * v / yields, rel=1e-12)


def test_a_closed_stop_bears_its_share() -> None:
    """A mass falls onto one that stands on the floor: both stops pass the whole impulse on."""
    machine = build_small(
        [
            link("anvil", 2.0), slide("floor", "frame", "anvil", (0.0, 1.0)),
            link("mass", 0.5), slide("face", "anvil", "mass", (0.0, 1.0)),
        ], 2, gravity=G,
        stops={"floor": {"joint": "floor", "restitution": 0.3},
               "face": {"joint": "face", "restitution": 0.5, "at_mm": -20.0}},
        phases=[{"number": 1, "name": "stands", "closed": ["floor"]}],
    )  # fmt: skip
    event = ran(machine).events[0]
    impulse = 0.5 * 1.5 * math.sqrt(2.0 * G * 0.02)
    assert event.impulses["face"] == pytest.approx(impulse, rel=1e-12)
    assert event.impulses["floor"] == pytest.approx(impulse, rel=1e-12)
    assert event.closed == {"floor"}


@pytest.mark.slow
def test_stops_that_throw_one_another_open_come_to_rest() -> None:
    """A series of series, against every bounce followed in 60 digits."""
    numbers = (2.0, 0.5, 0.3, 0.4, 30.0)
    _, machine = both(lid_box(numbers))
    verdict = judge(machine, 60.0, 24.0)
    assert verdict.events[-1].closed == {"floor", "lid"}
    assert verdict.events[-1].t == pytest.approx(followed(numbers), abs=1e-13)


# Linkages.


def slider_crank(offset: float = 0.0) -> tuple[Machine, float, float]:
    """Crank of 40 mm, rod of 130 mm, slide along x that passes beside the axis by the offset."""
    r, length = 0.04, 0.13
    foot = r + math.sqrt(length**2 - offset**2)
    middle = (0.5 * (foot - r), 0.5 * offset)
    machine = build_small(
        [
            link("arm", 0.5, 2e-4, (0.015, 0.0)), hinge("crank", "frame", "arm"),
            link("rod", 0.4, 7e-4, middle), hinge("pin", "arm", "rod", (r, 0.0)),
            link("ram", 1.2, 1e-3), slide("travel", "frame", "ram", at=(foot, offset)),
            frame("end", "rod", (foot - r, offset)),
        ], gravity=G, drives={"crank": CRANK},
        closures={"pin": {"frame_a": "end", "frame_b": "ram"}},
    )  # fmt: skip
    return machine, r, length


@pytest.mark.parametrize("offset", [0.0, 0.02])
def test_slider_crank(offset: float) -> None:
    """Place of the ram; and the power of the drive is the change of all energies."""
    machine, r, length = slider_crank(offset)
    verdict = ran(machine)

    def place(psi):
        return r * mp.cos(psi) + mp.sqrt(length**2 - (offset - r * mp.sin(psi)) ** 2)

    def energy(t):
        rod_angle = mp.asin((offset - r * mp.sin(OMEGA * t)) / length)

        def centre(s):
            return (r * mp.cos(OMEGA * s) + place(OMEGA * s)) / 2, (
                r * mp.sin(OMEGA * s) + offset
            ) / 2

        speed = [mp.diff(lambda s, k=k: centre(s)[k], t) for k in (0, 1)]
        turning = OMEGA * r * mp.cos(OMEGA * t) / (length * mp.cos(rod_angle))
        moving = 1.2 * mp.diff(lambda s: place(OMEGA * s), t) ** 2 / 2
        moving += 0.4 * (speed[0] ** 2 + speed[1] ** 2) / 2 + 7e-4 * turning**2 / 2
        return moving + G * (0.5 * 0.015 * mp.sin(OMEGA * t) + 0.4 * centre(t)[1])

    with mp.workdps(40):
        for t in (0.11, 0.37, 0.62, 0.9):
            q, _ = verdict.motion(t)
            travel = q[verdict.coordinates.index("travel")]
            assert abs(travel - float(place(OMEGA * t) - place(0))) < TIGHT
            torque = float(mp.diff(energy, t)) / OMEGA
            assert verdict.drive_force("crank", t) == pytest.approx(torque, rel=1e-10)


def test_four_bar_against_its_closed_form() -> None:
    """Freudenstein: the rocker's angle is that of two circles that meet."""
    a, b, c, d = 0.05, 0.16, 0.12, 0.15
    # Crank along x at touch, so the rocker's pin lies where the circles of b and c meet.
    x = (a**2 - d**2 + c**2 - b**2) / (2.0 * (a - d))
    z = math.sqrt(c**2 - (x - d) ** 2)
    machine = build_small(
        [
            link("arm", 0.5, 2e-4), hinge("crank", "frame", "arm"),
            link("rod", 0.4, 7e-4), hinge("pin", "arm", "rod", (a, 0.0)),
            link("rocker", 0.3, 7e-4), hinge("rock", "frame", "rocker", (d, 0.0)),
            frame("end", "rod", (x - a, z)), frame("tip", "rocker", (x - d, z)),
        ], drives={"crank": CRANK}, closures={"pin": {"frame_a": "end", "frame_b": "tip"}},
    )  # fmt: skip
    verdict = ran(machine)

    def angle(psi: float) -> float:
        p = np.array([a * math.cos(psi), a * math.sin(psi)])
        line = np.array([d, 0.0]) - p
        far = float(np.hypot(*line))
        cosine = (c**2 + far**2 - b**2) / (2.0 * c * far)
        return math.atan2(-line[1], -line[0]) - math.acos(cosine)

    for t in np.linspace(0.02, 0.98, 13):
        q, _ = verdict.motion(t)
        turned = q[verdict.coordinates.index("rock")] - (angle(OMEGA * t) - angle(0.0))
        assert abs(math.remainder(turned, 2.0 * math.pi)) < TIGHT


def test_scotch_yoke_with_its_block() -> None:
    """x = r cos psi; the block is a mass on the crank pin."""
    r, block = 0.05, 0.3
    machine = build_small(
        [
            link("arm", 0.5, 2e-4), hinge("crank", "frame", "arm"), frame("tip", "arm", (r, 0.0)),
            link("yoke", 1.5), slide("travel", "frame", "yoke"), frame("slot", "yoke", (r, 0.0)),
        ], 1, gravity=G, drives={"crank": CRANK},
        closures={"yoke": {"frame_a": "slot", "frame_b": "tip", "slot_axis": "z",
                           "block_mass_kg": block}},
    )  # fmt: skip
    verdict = ran(machine)
    for t in (0.1, 0.45, 0.8):
        s, c = math.sin(OMEGA * t), math.cos(OMEGA * t)
        q, _ = verdict.motion(t)
        found = dict(zip(verdict.coordinates, q, strict=True))
        assert abs(found["travel"] - r * (c - 1.0)) < TIGHT
        assert abs(found["yoke"] - r * s) < TIGHT
        torque = 1.5 * r * OMEGA**2 * c * r * s + block * G * r * c
        assert verdict.drive_force("crank", t) == pytest.approx(torque, rel=1e-11)


def test_double_pendulum_keeps_its_energy() -> None:
    m, length = 0.7, 0.3
    machine = build_small(
        [
            link("one", m, 4e-3, (0.5 * length, 0.0)), hinge("first", "frame", "one"),
            link("two", m, 4e-3, (0.5 * length, 0.0)), hinge("second", "one", "two", (length, 0.0)),
        ], 2, gravity=G,
    )  # fmt: skip
    verdict = ran(machine, turns=2)

    def energy(t: float) -> float:
        (p, b), (p1, b1) = verdict.motion(t)
        o = p + b
        mid = [length * math.cos(p), length * math.sin(p)]
        one = 0.5 * (4e-3 + 0.25 * m * length**2) * p1**2
        x = -length * math.sin(p) * p1 - 0.5 * length * math.sin(o) * (p1 + b1)
        z = length * math.cos(p) * p1 + 0.5 * length * math.cos(o) * (p1 + b1)
        two = 0.5 * m * (x * x + z * z) + 0.5 * 4e-3 * (p1 + b1) ** 2
        return one + two + m * G * (0.5 * mid[1] + mid[1] + 0.5 * length * math.sin(o))

    # Between nodes the motion is known to the unresolved share of its accelerations, 3e-11.
    assert max(abs(energy(t)) for t in np.linspace(0.0, 1.99, 40)) < 3e-11 * 2.0 * m * G * length


# Springs, dampers, drives.


def test_damped_oscillator_and_its_order() -> None:
    """m x'' + c x' + k (x + p) = 0 from rest; a rule of s nodes is of order 2 s."""
    m, k, c, p = 0.5, 300.0, 1.2, 0.01
    machine = build_small(
        [link("mass", m), slide("x", "frame", "mass")],
        springs={"coil": {"joint": "x", "stiffness_N_per_m": k, "preload_length_mm": 1e3 * p}},
        dampers={"oil": {"joint": "x", "damping_N_s_per_m": c}},
    )
    decay, w = c / (2.0 * m), math.sqrt(k / m - (c / (2.0 * m)) ** 2)

    def x(t: float) -> float:
        swing = math.cos(w * t) + decay / w * math.sin(w * t)
        return p * (math.exp(-decay * t) * swing - 1.0)

    def end(precision: Precision | None = None) -> float:
        return float(ran(machine, precision=precision).stretches[-1].step.q_end[0])

    assert abs(end() - x(1.0)) < TIGHT
    for stages in (2, 3):
        coarse, fine = (
            abs(end(Precision(stages, math.inf, 1.0 / steps)) - x(1.0)) for steps in (32, 64)
        )
        assert math.log2(coarse / fine) == pytest.approx(2 * stages, abs=0.3)


def test_inertial_drive_train() -> None:
    """(I + J) y'' = I w^2 (law - y) + 2 zeta w I (law' - y') - k (preload + y)."""
    inertia, k, preload = 0.3, 40.0, 0.2
    train = {"reflected_inertia_kg_m2": 1.4, "shaft_frequency_hz": 3.0, "shaft_damping_ratio": 0.1}
    machine = build_small(
        [link("wheel", 1.0, inertia), hinge("crank", "frame", "wheel")],
        drives={"crank": {**CRANK, **train}},
        springs={"coil": {"joint": "crank", "stiffness_N_m_per_rad": k,
                          "preload_deg": math.degrees(preload)}},
    )  # fmt: skip
    verdict = ran(machine, drive="inertial")
    own, w, zeta = 1.4, 6.0 * math.pi, 0.1
    total = inertia + own
    # y, y', t and 1 as one linear system.
    matrix = np.array([
        [0.0, 1.0, 0.0, 0.0],
        [-(own * w * w + k) / total, -2.0 * zeta * w * own / total, own * w * w * OMEGA / total,
         (2.0 * zeta * w * own * OMEGA - k * preload) / total],
        [0.0, 0.0, 0.0, 1.0],
        [0.0, 0.0, 0.0, 0.0],
    ])  # fmt: skip
    for t in (0.3, 0.7, 0.99):
        y, rate = (expm(matrix * t) @ [0.0, OMEGA, 0.0, 1.0])[:2]
        q, v = verdict.motion(t)
        assert abs(q[0] - y) < 1e-11
        assert abs(v[0] - rate) < 1e-10
        torque = own * (w * w * (OMEGA * t - y) + 2.0 * zeta * w * (OMEGA - rate))
        assert verdict.drive_force("crank", t) == pytest.approx(torque, rel=1e-9)


def test_a_strut_between_points_keeps_the_energy() -> None:
    """A bead on a rail with a spring to a point beside it."""
    k, free, m = 120.0, 0.06, 0.4
    machine = build_small(
        [
            link("bead", m), slide("x", "frame", "bead"), frame("hook", "frame", (0.1, 0.08)),
        ],
        springs={"coil": {"frame_a": "hook", "frame_b": "bead", "stiffness_N_per_m": k,
                          "free_length_mm": 1e3 * free}},
    )  # fmt: skip
    verdict = ran(machine)

    def energy(t: float) -> float:
        (x,), (v,) = verdict.motion(t)
        return 0.5 * m * v * v + 0.5 * k * (math.hypot(x - 0.1, 0.08) - free) ** 2

    first = energy(0.0)
    assert max(abs(energy(t) - first) for t in np.linspace(0.0, 0.99, 30)) < 1e-10 * first


LAWS = {
    "guide": {"law": "oscillating_guide", "crank_radius_mm": 60.0, "crank_axis_mm": [10.0, 5.0],
              "guide_axis_mm": [-150.0, -30.0], "guide_offset_mm": 12.0},
    "gear": {"law": "geared", "of": "guide", "ratio": -2.5},
    "series": {"law": "fourier", "mean_rad": 0.2, "cosine_rad": [0.5, 0.1], "sine_rad": [0.3]},
    "rows": {"law": "table", "cylinder_angle_deg": [5.0, 50.0, 90.0, 140.0, 200.0, 260.0, 300.0,
             365.0], "coordinate_rad": [0.0, 0.3, 0.5, 0.2, -0.4, -0.3, 0.1, 0.0]},
}  # fmt: skip


@pytest.mark.parametrize("name", LAWS)
def test_slopes_of_a_law(name: str) -> None:
    """Both derivatives against differences of fourth order, whose error is 1e-10 of the value."""
    motion = read_laws(LAWS)[name].motion
    h = 1e-3
    for psi in (0.3, 2.2, 4.0, 5.9, 9.0):
        for k in (0, 1):
            near, far = (motion(psi + s * h)[k] - motion(psi - s * h)[k] for s in (1, 2))
            slope = (8.0 * near - far) / (12.0 * h)
            assert motion(psi)[k + 1] == pytest.approx(slope, rel=1e-7, abs=1e-9)


def test_guide_and_table_by_their_definitions() -> None:
    laws = read_laws(LAWS)
    for psi in np.linspace(0.0, 6.0, 9):
        pin = np.array([10.0 + 60.0 * math.cos(psi), 5.0 + 60.0 * math.sin(psi)])
        angle = laws["guide"].motion(psi)[0]
        left = np.array([-math.sin(angle), math.cos(angle)])
        assert float(left @ (pin - [-150.0, -30.0])) == pytest.approx(12.0, abs=1e-12)
    rows = np.radians(LAWS["rows"]["cylinder_angle_deg"])
    spline = make_interp_spline(rows, LAWS["rows"]["coordinate_rad"], k=5, bc_type="periodic")
    for psi in np.linspace(0.2, 6.2, 9):
        assert laws["rows"].motion(psi)[0] == pytest.approx(float(spline(psi)), abs=1e-13)
    lowest = extreme(laws["series"], "minimum")
    grid = np.linspace(0.0, 2.0 * math.pi, 5001)
    values = [laws["series"].motion(psi)[0] for psi in grid]
    assert laws["series"].motion(lowest)[0] <= min(values)


# What it refuses.


def test_it_says_why_it_does_not_go_on() -> None:
    short, _, _ = slider_crank()
    # A crank longer than the rod allows cannot go round.
    short.lines[0] = short.lines[0]._replace(direction=np.array([0.0, 1.0]))
    assert judge(short, 60.0, 0.0).reason in {Reason.ASSEMBLY, Reason.SINGULAR}
    jam = build_small(
        [
            link("crank", 1.0),
            slide("x", "frame", "crank"),
            link("mass", 1.0),
            slide("gap", "crank", "mass"),
            frame("end", "mass"),
        ],
        gravity=G,
        drives={"x": {"joint": "x", "law": "screw", "lead_mm_per_turn": 500.0, **SHAFT}},
        stops={"right": {"joint": "gap", "restitution": 0.5, "at_mm": -20.0}},
    )
    assert ran(jam).reason == ""
    beyond = jam
    beyond.stops[0] = beyond.stops[0]._replace(at=0.01)
    assert judge(beyond, 60.0, 0.0).reason == Reason.BEYOND


def test_independence_sees_a_dead_centre() -> None:
    machine, _, _ = slider_crank()
    dynamics = Dynamics(machine, OMEGA, 0.0, held=True)
    from planar_judge.start import start

    q, _ = start(dynamics)
    assert dynamics.independence(q[None], ()) > 1e-3
    machine.drives[0] = machine.drives[0]._replace(coordinate=machine.number("travel"))
    driven = Dynamics(machine, OMEGA, 0.0, held=True)
    assert driven.independence(q[None], ()) < 1e-10

"""The independent planar solver against closed forms of a bounce, of its order and of its laws.

Linkages, impacts and force elements have closed forms in tests/verification, which the package
meets; `test_planar_judge.py` has the solver agree with it on such machines.

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
from planar_judge.dynamics import Dynamics
from planar_judge.flight import Precision
from planar_judge.laws import extreme, read_laws
from planar_judge.machine import Machine, build
from planar_judge.record import Verdict
from planar_judge.run import judge
from planar_judge.verdict import Reason
from scipy.interpolate import make_interp_spline
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


@pytest.mark.slow
def test_stops_that_throw_one_another_open_come_to_rest() -> None:
    """A series of series, against every bounce followed in 60 digits."""
    numbers = (2.0, 0.5, 0.3, 0.4, 30.0)
    _, machine = both(lid_box(numbers))
    verdict = judge(machine, 60.0, 24.0)
    assert verdict.events[-1].closed == {"floor", "lid"}
    assert verdict.events[-1].t == pytest.approx(followed(numbers), abs=1e-13)


# Linkages.


def slider_crank() -> Machine:
    """Crank of 40 mm, rod of 130 mm, slide along x."""
    return build_small(
        [
            link("arm", 0.5, 2e-4, (0.015, 0.0)), hinge("crank", "frame", "arm"),
            link("rod", 0.4, 7e-4, (0.065, 0.0)), hinge("pin", "arm", "rod", (0.04, 0.0)),
            link("ram", 1.2, 1e-3), slide("travel", "frame", "ram", at=(0.17, 0.0)),
            frame("end", "rod", (0.13, 0.0)),
        ], gravity=G, drives={"crank": CRANK},
        closures={"pin": {"frame_a": "end", "frame_b": "ram"}},
    )  # fmt: skip


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
    short = slider_crank()
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
    machine = slider_crank()
    dynamics = Dynamics(machine, OMEGA, 0.0, held=True)
    from planar_judge.start import start

    q, _ = start(dynamics)
    assert dynamics.independence(q[None], ()) > 1e-3
    machine.drives[0] = machine.drives[0]._replace(coordinate=machine.number("travel"))
    driven = Dynamics(machine, OMEGA, 0.0, held=True)
    assert driven.independence(q[None], ()) < 1e-10

"""The independent planar solver against closed forms: series of bounces, elements, drives, laws.

Linkages and impacts of it are held against the package, which has closed forms of its own for them.

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
from planar_judge.flight import Precision
from planar_judge.laws import extreme, read_laws
from planar_judge.machine import Machine, build
from planar_judge.record import Verdict
from planar_judge.run import judge
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

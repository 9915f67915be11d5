"""Cams with dwell, and Fourier series and tables of slides, against closed forms."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nipper_pin import Case, Mechanism, ModelError, load, simulate
from nipper_pin.mechanism import from_sources, with_numbers
from nipper_pin.mechanism.drives.cam import Cam
from tests.small_machines import hinge, link, machine, slide, sources

RISE, DWELL, RETURN, START = 100.0, 40.0, 130.0, 25.0
ANGLES = {"start_deg": START, "rise_deg": RISE, "dwell_deg": DWELL, "return_deg": RETURN}
# Largest rate and acceleration for unit lift over a unit angle (Norton, table 3-3), and where.
PEAKS = {
    "cycloidal": (2.0, 0.5, 2.0 * math.pi, 0.25),
    "modified_sine": (4.0 * math.pi / (4.0 + math.pi), 0.5,
                      4.0 * math.pi**2 / (4.0 + math.pi), 0.125),
    "polynomial_345": (1.875, 0.5, 10.0 / math.sqrt(3.0), 0.5 - math.sqrt(3.0) / 6.0),
    "polynomial_4567": (2.1875, 0.5, 84.0 / math.sqrt(125.0), 0.5 - math.sqrt(0.05)),
}  # fmt: skip


def _cam(motion: str, lift: float = 0.02) -> Cam:
    return Cam(motion=motion, lift=lift, start_rad=math.radians(START),  # type: ignore[arg-type]
               rise_rad=math.radians(RISE), dwell_rad=math.radians(DWELL),
               return_rad=math.radians(RETURN))  # fmt: skip


@pytest.mark.parametrize("motion", PEAKS)
def test_peaks_are_those_of_the_handbook(motion: str) -> None:
    """Largest rate C h / beta and acceleration C h / beta2 of rise and return, where they are."""
    cam, lift = _cam(motion), 0.02
    fastest, middle, strongest, early = PEAKS[motion]
    up = START + RISE + DWELL
    for begin, width, sense in ((START, RISE, 1.0), (up, RETURN, -1.0)):
        psi = np.radians(begin + width * np.linspace(0.0, 1.0, 20001))
        beta = math.radians(width)
        value, first, second = cam.evaluate(psi)
        at = cam.evaluate(np.radians(begin + width * np.array([middle, early, 1.0 - early])))
        assert sense * at[1][0] == pytest.approx(fastest * lift / beta, rel=1e-13)
        assert sense * at[2][1:] == pytest.approx(
            np.array([1.0, -1.0]) * strongest * lift / beta**2, rel=1e-12
        )
        assert np.abs(first).max() <= fastest * lift / beta * (1.0 + 1e-13)
        assert np.abs(second).max() <= strongest * lift / beta**2 * (1.0 + 1e-13)
        assert at[0][0] == pytest.approx(0.5 * lift, rel=1e-14)
        # Terms of the polynomials are up to 209 times their sum, half an eps of round-off each.
        assert (sense * np.diff(value) > -209.0 * np.finfo(float).eps * lift).all()


@pytest.mark.parametrize("motion", PEAKS)
def test_derivatives_are_those_of_the_value(motion: str) -> None:
    """Central differences of eighth order inside every piece of the law."""
    cam = _cam(motion)
    knots = np.array(cam.knots_rad)
    weights = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
    h = 2e-3
    for begin, end in zip(knots, [*knots[1:], knots[0] + math.tau], strict=True):
        psi = np.linspace(begin + 5 * h, end - 5 * h, 23)
        for order in (0, 1):
            slope = (
                sum(
                    w * (cam.evaluate(psi + k * h)[order] - cam.evaluate(psi - k * h)[order])
                    for k, w in weights.items()
                )
                / h
            )
            assert slope == pytest.approx(cam.evaluate(psi)[order + 1], abs=1e-12)


@pytest.mark.parametrize("motion", PEAKS)
def test_it_is_continuous_and_repeats_each_turn(motion: str) -> None:
    cam = _cam(motion)
    knots = np.array(cam.knots_rad)
    for order, values in enumerate(zip(cam.evaluate(knots - 1e-9), cam.evaluate(knots + 1e-9),
                                       strict=True)):  # fmt: skip
        # Between the two lie 2e-9 rad times the next derivative; all of them are below 10 here.
        assert values[0] == pytest.approx(values[1], abs=2e-8), order
    psi = np.linspace(0.0, math.tau, 50)
    for turns in (1.0, -3.0):
        for one, other in zip(cam.evaluate(psi), cam.evaluate(psi + turns * math.tau), strict=True):
            assert one == pytest.approx(other, abs=1e-13)
    dwell, rest = np.radians([START + RISE + 20.0]), np.radians([START - 10.0])
    assert [float(item[0]) for item in cam.evaluate(dwell)] == [0.02, 0.0, 0.0]
    assert [float(item[0]) for item in cam.evaluate(rest)] == [0.0, 0.0, 0.0]


def _slide(**drive: Any) -> Mechanism:
    parts = [link("ram", mass=3.0), slide("ram", "frame", "ram")]
    return machine(parts, 1, drives={"cam": {"joint": "ram", **drive}})


def _turn(mechanism: Mechanism) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Angles since touch, and travel, rate by angle and force of the drive."""
    solution = simulate(mechanism, Case(speed_rpm=60.0, window="cycle", start_index=0.0))
    t = np.linspace(0.0, 1.0, 41)
    motion = solution.trajectory.evaluate(t)
    force = solution.trajectory.reactions(t).drives["cam"]
    return motion.cylinder_angle, motion.q[:, 0], motion.v[:, 0] / math.tau, force


@pytest.mark.parametrize("motion", PEAKS)
def test_a_cam_moves_a_slide(motion: str) -> None:
    """The force of the drive is mass times the acceleration of the law."""
    psi, x, rate, force = _turn(_slide(law="cam", motion=motion, lift_mm=20.0, **ANGLES))
    value, first, second = _cam(motion).evaluate(psi)
    at_touch = _cam(motion).evaluate(np.zeros(1))[0]
    assert x == pytest.approx(value - at_touch, abs=1e-15)
    assert rate == pytest.approx(first, abs=1e-14)
    assert force == pytest.approx(3.0 * second * math.tau**2, abs=1e-10)


def test_a_cam_swings_a_hinge() -> None:
    parts = [link("lever"), hinge("lever", "frame", "lever")]
    drive = {"joint": "lever", "law": "cam", "motion": "cycloidal", "lift_deg": 30.0, **ANGLES}
    _, angle, _, _ = _turn(machine(parts, 1, drives={"cam": drive}))
    assert angle.max() == pytest.approx(math.radians(30.0), rel=1e-14)


def test_a_series_moves_a_slide() -> None:
    series = {"mean_mm": 3.0, "cosine_mm": [10.0, -2.0], "sine_mm": [0.0, 1.0]}
    psi, x, _, _ = _turn(_slide(law="fourier", **series))
    expected = 0.01 * np.cos(psi) - 0.002 * np.cos(2 * psi) + 0.001 * np.sin(2 * psi) - 0.008
    assert x == pytest.approx(expected, abs=1e-15)


def test_a_table_moves_a_slide(tmp_path: Path) -> None:
    """A fine table of a sine, written out and from a file: the spline errs by h^6 / 30,000."""
    angles = np.linspace(0.0, 360.0, 73)
    rows = 8.0 * np.sin(np.radians(angles))
    rows[-1] = rows[0]
    table = {"cylinder_angle_deg": angles.tolist(), "coordinate_mm": rows.tolist()}
    psi, x, _, _ = _turn(_slide(law="table", **table))
    assert x == pytest.approx(8e-3 * np.sin(psi), abs=8e-3 * np.radians(5.0) ** 6 / 3e4 * 2.0)
    lines = [f"{a!r},{r!r}" for a, r in zip(angles.tolist(), rows.tolist(), strict=True)]
    (tmp_path / "cam.csv").write_text("\n".join(["cylinder_angle_deg,coordinate_mm", *lines]))
    drive = {"joint": "ram", "law": "table", "file": "cam.csv"}
    urdf, data = sources([link("ram"), slide("ram", "frame", "ram")], 1, drives={"cam": drive})
    law = from_sources("small", urdf, data, tmp_path).drives[0].law
    assert (
        law.evaluate(psi)[0] == _slide(law="table", **table).drives[0].law.evaluate(psi)[0]
    ).all()


CAM = {"law": "cam", "motion": "cycloidal", **ANGLES}


@pytest.mark.parametrize(
    ("drive", "words"),
    [
        ({**CAM, "lift_deg": 3.0}, r"lift_deg.*lift_mm and reflected_mass_kg for the prismatic"),
        (CAM, "lift_mm is missing.*with a lift_mm other than 0"),
        ({**CAM, "lift_mm": 0.0}, "lift_mm = 0.0.*with a lift_mm other than 0"),
        ({**CAM, "lift_mm": 3.0, "dwell_deg": 140.0}, "fit into a turn.*370 deg"),
        ({**CAM, "lift_mm": 3.0, "rise_deg": 0.0}, "rise_deg.*above 0"),
        ({**CAM, "lift_mm": 3.0, "motion": "harmonic"}, "motion.*one of cycloidal, modified_sine"),
        ({"law": "fourier", "sine_rad": [0.1]}, r"sine_rad.*mean_mm, cosine_mm, sine_mm"),
        ({"law": "constant_speed", "ratio": 1.0}, "screw: a slide"),
        ({**CAM, "lift_mm": 3.0, "reflected_inertia_kg_m2": 1.0}, "reflected_inertia_kg_m2"),
    ],
)
def test_a_law_that_does_not_fit_is_refused(drive: dict[str, Any], words: str) -> None:
    with pytest.raises(ModelError, match=words):
        _slide(**drive)


def test_a_cam_on_an_elastic_shaft_and_its_numbers_by_path() -> None:
    """Its lift has a path; the balance of energy holds with a mass on the drive train."""
    shaft = {"reflected_mass_kg": 5.0, "shaft_frequency_hz": 50.0, "shaft_damping_ratio": 0.5}
    mechanism = with_numbers(_slide(**CAM, lift_mm=3.0, **shaft), {"drives.cam.lift_mm": 4.0})
    law = mechanism.drives[0].law
    assert isinstance(law, Cam)
    assert law.lift == 0.004
    case = Case(speed_rpm=60.0, window="cycle", drive="inertial")
    assert simulate(mechanism, case).checks.energy_balance < 1e-12
    assert load("e62").drive_knots_rad.size == 0

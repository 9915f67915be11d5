"""Drive laws against closed forms and their own differences; shafts, and the scale of the index."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_machines import hinge, link, machine, slide, sources

from nipper_pin import Case, InputError, Mechanism, load, simulate
from nipper_pin.mechanism import (
    Characteristic,
    Cylinder,
    DriveLaw,
    counted_from,
    from_sources,
    index_difference,
    within_turn,
)
from nipper_pin.mechanism.build.laws import extreme_angle
from nipper_pin.mechanism.drives import Cam, ConstantSpeed, Fourier, Geared, OscillatingGuide, Table

GUIDE = OscillatingGuide(crank_radius_m=0.064, crank_axis=(0.0, 0.0), guide_axis=(-0.19, -0.02))
OFFSET = OscillatingGuide(
    crank_radius_m=0.064, crank_axis=(0.01, 0.02), guide_axis=(0.05, 0.3), guide_offset_m=0.03
)
# Of unit lift over a unit angle largest rate and acceleration (Norton, table 3-3), and where.
PEAKS = {
    "cycloidal": (2.0, 0.5, 2.0 * math.pi, 0.25),
    "modified_sine": (4.0 * math.pi / (4.0 + math.pi), 0.5,
                      4.0 * math.pi**2 / (4.0 + math.pi), 0.125),
    "polynomial_345": (1.875, 0.5, 10.0 / math.sqrt(3.0), 0.5 - math.sqrt(3.0) / 6.0),
    "polynomial_4567": (2.1875, 0.5, 84.0 / math.sqrt(125.0), 0.5 - math.sqrt(0.05)),
}  # fmt: skip
RISE, DWELL, RETURN, START, LIFT = 100.0, 40.0, 130.0, 25.0, 0.02
CAMS: dict[str, Cam] = {
    motion: Cam(motion=motion, lift=LIFT, start_rad=math.radians(START),  # type: ignore[arg-type]
                rise_rad=math.radians(RISE), dwell_rad=math.radians(DWELL),
                return_rad=math.radians(RETURN)) for motion in PEAKS
}  # fmt: skip
SERIES = [
    Fourier(mean=0.7, cosine=cosine, sine=sine)
    for cosine, sine in (((0.3,), (0.1, -0.2, 0.05)), ((0.1, 0.2, 0.3), ()), ((), ()))
]
PERIODIC: dict[str, DriveLaw] = {
    "guide": GUIDE, "offset guide": OFFSET, "geared": Geared(of=OFFSET, ratio=-2.2), **CAMS,
    **{f"series {number}": law for number, law in enumerate(SERIES)},
}  # fmt: skip
LAWS: dict[str, DriveLaw] = {**PERIODIC, "constant speed": ConstantSpeed(ratio=0.5)}


@pytest.mark.parametrize("name", LAWS)
def test_derivatives_are_those_of_the_value(name: str) -> None:
    """Central differences of eighth order inside every piece; of any shape of angles."""
    law = LAWS[name]
    weights = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
    h = 2e-3
    knots = law.knots_rad
    pieces = zip(knots, [*knots[1:], knots[0] + math.tau], strict=True) if knots else [(-3.0, 4.0)]
    for begin, end in pieces:
        psi = np.linspace(begin + 5 * h, end - 5 * h, 42).reshape(2, 21)
        found = law.evaluate(psi)
        for order in (0, 1):
            slope = sum(
                w * (law.evaluate(psi + k * h)[order] - law.evaluate(psi - k * h)[order])
                for k, w in weights.items()
            )
            # Half an eps of three times the angle, 2.1 (the weights) times a rate of 3, by h.
            np.testing.assert_allclose(slope / h, found[order + 1], rtol=0.0, atol=5e-12)
        for one, other in zip(found, law.evaluate(psi.ravel()), strict=True):
            np.testing.assert_allclose(one, other.reshape(2, 21), rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("name", PERIODIC)
def test_a_law_is_continuous_and_repeats_each_turn(name: str) -> None:
    """Also after a hundred turns: an angle has no branches."""
    law = PERIODIC[name]
    psi = np.linspace(0.0, math.tau, 2001)
    for turns in (1.0, -3.0, 100.0):
        for one, other in zip(law.evaluate(psi), law.evaluate(psi + turns * math.tau), strict=True):
            np.testing.assert_allclose(one, other, rtol=0.0, atol=2e-12)
    assert np.abs(np.diff(law.evaluate(psi)[0])).max() < 0.01
    knots = np.array(law.knots_rad)
    for before, after in zip(law.evaluate(knots - 1e-9), law.evaluate(knots + 1e-9), strict=True):
        # Between the two lie 2e-9 rad times the next derivative; all of them are below 10 here.
        np.testing.assert_allclose(before, after, rtol=0.0, atol=2e-8)


def test_guide_points_at_the_pin() -> None:
    psi = np.linspace(-20.0, 20.0, 999)
    pin = np.array(OFFSET.crank_axis)[:, None] + OFFSET.crank_radius_m * np.array(
        [np.cos(psi), np.sin(psi)]
    )
    reach = pin - np.array(OFFSET.guide_axis)[:, None]
    angle = OFFSET.evaluate(psi)[0]
    across = -np.sin(angle) * reach[0] + np.cos(angle) * reach[1]
    along = np.cos(angle) * reach[0] + np.sin(angle) * reach[1]
    np.testing.assert_allclose(across, OFFSET.guide_offset_m, rtol=0.0, atol=1e-15)
    assert along.min() > 0.0


def test_guide_extremes_in_closed_form() -> None:
    swing = math.asin(0.064 / math.hypot(0.19, 0.02))
    direction = math.atan2(0.02, 0.19)
    low, high = extreme_angle(GUIDE, "minimum"), extreme_angle(GUIDE, "maximum")
    assert low is not None
    assert high is not None
    value, first, _ = GUIDE.evaluate(np.array([low, high]))
    np.testing.assert_allclose(value, [direction - swing, direction + swing], rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(first, 0.0, rtol=0.0, atol=1e-15)
    # There the crank is square to the guide.
    np.testing.assert_allclose(np.cos([low, high] - value), 0.0, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("phase", [0.0, 0.4, 2.0, 4.0, 6.2])
@pytest.mark.parametrize("kind", ["minimum", "maximum"])
def test_extremes_of_a_series(phase: float, kind: Any) -> None:
    """Of sin(psi - phase): a quarter of a turn behind or before its zero, in [0, 2 pi)."""
    law = Fourier(mean=1.0, cosine=(-math.sin(phase),), sine=(math.cos(phase),))
    expected = (phase + (0.5 if kind == "maximum" else 1.5) * math.pi) % math.tau
    assert extreme_angle(law, kind) == pytest.approx(expected, abs=1e-9)
    assert extreme_angle(Fourier(mean=1.0, cosine=(4e-10,)), kind) is None
    assert extreme_angle(Fourier(mean=1.0, cosine=(6e-10,)), kind) is not None
    assert extreme_angle(ConstantSpeed(ratio=1e-9), kind) is None


def test_a_table_reproduces_a_smooth_law() -> None:
    angles = np.linspace(0.2, 0.2 + math.tau, 361)
    table = Table(cylinder_angle_rad=tuple(angles.tolist()),
                  coordinate=tuple(GUIDE.evaluate(angles)[0].tolist()))  # fmt: skip
    psi = np.linspace(-10.0, 10.0, 777)
    for one, other, tolerance in zip(
        table.evaluate(psi), GUIDE.evaluate(psi), (1e-11, 1e-9, 1e-7), strict=True
    ):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=tolerance)
    for first, last in table.evaluate(np.array([0.2, 0.2 + math.tau])):
        assert first == pytest.approx(last, abs=1e-12)


FLAT = tuple(np.linspace(0.0, math.tau, 9).tolist())


@pytest.mark.parametrize(
    ("law", "changes"),
    [
        (Geared(of=OFFSET, ratio=2.0), {"of": GUIDE}), (SERIES[0], {"sine": (0.1,)}),
        (CAMS["cycloidal"], {"dwell_rad": 0.1}),
        (Table(cylinder_angle_rad=FLAT, coordinate=(0.0,) * 9), {"coordinate": (1.0,) * 9}),
        (Characteristic(coordinate=(0.0, 0.1, 0.5), force=(0.0, 1.0, 9.0)),
         {"force": (0.0, 2.0, 9.0)}),
    ],
)  # fmt: skip
def test_laws_are_what_they_are_made_of(law: Any, changes: dict[str, Any]) -> None:
    """Equal and told by their numbers; what is computed from these is neither."""
    same, other = replace(law), replace(law, **changes)
    assert law == same != other
    assert hash(law) == hash(same)
    assert repr(law) == repr(same) != repr(other)
    for item in fields(law):
        assert (f"{item.name}=" in repr(law)) is not item.name.startswith("_"), item.name


def test_knots_of_laws() -> None:
    """Rows of a table but for the first, which is the last; of a cam ends and inner joints."""
    turn = tuple(math.radians(angle) for angle in range(0, 361, 45))
    table = Table(cylinder_angle_rad=turn, coordinate=(0.0, *np.sin(turn[1:-1]).tolist(), 0.0))
    assert table.knots_rad == turn[1:]
    assert Geared(of=table, ratio=3.0).knots_rad == table.knots_rad
    assert ConstantSpeed(ratio=2.0).knots_rad == Fourier(mean=0.0).knots_rad == ()
    cam = {"lift": 1.0, "start_rad": 0.2, "rise_rad": 1.6, "dwell_rad": 0.5, "return_rad": 0.8}
    ends = (0.2, 1.8, 2.3, 3.1)
    assert Cam(motion="cycloidal", **cam).knots_rad == pytest.approx(ends)
    inner = (0.2, 0.4, 1.6, 1.8, 2.3, 2.4, 3.0, 3.1)
    assert Cam(motion="modified_sine", **cam).knots_rad == pytest.approx(inner)
    full = {**cam, "dwell_rad": math.tau - 2.4}
    assert Cam(motion="cycloidal", **full).knots_rad[-1] == pytest.approx(0.2 + math.tau)
    assert load("e62").drive_knots_rad.size == 0


@pytest.mark.parametrize("motion", PEAKS)
def test_peaks_of_cams_are_those_of_the_handbook(motion: str) -> None:
    """Largest rate C h / beta and acceleration C h / beta2 of rise and return, where they are."""
    cam = CAMS[motion]
    fastest, middle, strongest, early = PEAKS[motion]
    up = START + RISE + DWELL
    for begin, width, sense in ((START, RISE, 1.0), (up, RETURN, -1.0)):
        psi = np.radians(begin + width * np.linspace(0.0, 1.0, 20001))
        beta = math.radians(width)
        value, first, second = cam.evaluate(psi)
        at = cam.evaluate(np.radians(begin + width * np.array([middle, early, 1.0 - early])))
        assert sense * at[1][0] == pytest.approx(fastest * LIFT / beta, rel=1e-13)
        assert sense * at[2][1:] == pytest.approx(
            np.array([1.0, -1.0]) * strongest * LIFT / beta**2, rel=1e-12
        )
        assert np.abs(first).max() <= fastest * LIFT / beta * (1.0 + 1e-13)
        assert np.abs(second).max() <= strongest * LIFT / beta**2 * (1.0 + 1e-13)
        assert at[0][0] == pytest.approx(0.5 * LIFT, rel=1e-14)
        # Terms of the polynomials are up to 209 times their sum, half an eps of round-off each.
        assert (sense * np.diff(value) > -209.0 * np.finfo(float).eps * LIFT).all()
    dwell, rest = np.radians([[START + RISE + 20.0], [START - 10.0]])
    assert [float(item[0]) for item in cam.evaluate(dwell)] == [LIFT, 0.0, 0.0]
    assert [float(item[0]) for item in cam.evaluate(rest)] == [0.0, 0.0, 0.0]


# --- laws in machines ---------------------------------------------------------------------------

ANGLES = {"start_deg": START, "rise_deg": RISE, "dwell_deg": DWELL, "return_deg": RETURN}


def ram(**drive: Any) -> Mechanism:
    parts = [link("ram", mass=3.0), slide("ram", "frame", "ram")]
    return machine(parts, 1, drives={"cam": {"joint": "ram", **drive}})


def turn_of(mechanism: Mechanism) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Angles since touch, and coordinate, its rate by angle and the force of the drive."""
    solution = simulate(mechanism, Case(speed_rpm=60.0, window="cycle", start_index=0.0))
    t = np.linspace(0.0, 1.0, 41)
    motion = solution.trajectory.evaluate(t)
    force = solution.trajectory.reactions(t).drives["cam"]
    return motion.cylinder_angle, motion.q[:, 0], motion.v[:, 0] / math.tau, force


SLIDES: dict[str, tuple[dict[str, Any], DriveLaw]] = {
    **{motion: ({"law": "cam", "motion": motion, "lift_mm": 1e3 * LIFT, **ANGLES}, CAMS[motion])
       for motion in PEAKS},
    "series": ({"law": "fourier", "mean_mm": 3.0, "cosine_mm": [10.0, -2.0], "sine_mm": [0.0, 1.0]},
               Fourier(mean=0.003, cosine=(0.01, -0.002), sine=(0.0, 0.001))),
}  # fmt: skip


@pytest.mark.parametrize("name", SLIDES)
def test_a_law_moves_a_slide(name: str) -> None:
    """The force of the drive is mass times the acceleration of the law."""
    drive, law = SLIDES[name]
    psi, x, rate, force = turn_of(ram(**drive))
    value, first, second = law.evaluate(psi)
    assert x == pytest.approx(value - law.evaluate(np.zeros(1))[0], abs=1e-15)
    assert rate == pytest.approx(first, abs=1e-14)
    assert force == pytest.approx(3.0 * second * math.tau**2, abs=1e-10)


def test_a_cam_swings_a_hinge() -> None:
    drive = {"joint": "lever", "law": "cam", "motion": "cycloidal", "lift_deg": 30.0, **ANGLES}
    lever = machine([link("lever"), hinge("lever", "frame", "lever")], 1, drives={"cam": drive})
    assert turn_of(lever)[1].max() == pytest.approx(math.radians(30.0), rel=1e-14)


def test_a_table_moves_a_slide() -> None:
    """A fine table of a sine: the spline errs by h^6 / 30,000."""
    angles = np.linspace(0.0, 360.0, 73)
    rows = 8.0 * np.sin(np.radians(angles))
    rows[-1] = rows[0]
    written = ram(law="table", cylinder_angle_deg=angles.tolist(), coordinate_mm=rows.tolist())
    psi, x, _, _ = turn_of(written)
    assert x == pytest.approx(8e-3 * np.sin(psi), abs=8e-3 * np.radians(5.0) ** 6 / 3e4 * 2.0)


@pytest.mark.parametrize("off_mm", [0.0, 0.9e-6, 1.1e-6])
@pytest.mark.parametrize("step_mm", [0.9e-9, 1.1e-9, 1.0])
def test_rows_of_a_file_are_judged_as_those_of_the_document(
    tmp_path: Path, off_mm: float, step_mm: float
) -> None:
    """In SI units: ends that differ by 1e-9 m, rows of a spring that are 1e-12 m apart."""
    angles = np.linspace(0.0, 360.0, 13)
    lift = 4.0 * (1.0 - np.cos(np.radians(angles)))
    lift[-1] = off_mm
    places, forces = [-5.0, 0.0, step_mm, 5.0], [-5.0, 0.0, 1e-3 * step_mm, 9.0]
    tables = {
        "drives": {"ram": {"cylinder_angle_deg": angles, "coordinate_mm": lift}},
        "springs": {"coil": {"coordinate_mm": places, "force_N": forces}},
    }
    joints = {"ram": {"joint": "ram", "law": "table"}, "coil": {"joint": "sled"}}
    parts = [slide("ram", "frame", "block"), link("block"), slide("sled", "frame", "cart")]
    verdicts = []
    for inline in (True, False):
        written: dict[str, dict[str, Any]] = {}
        for section, entries in tables.items():
            for name, columns in entries.items():
                rows = {key: [float(value) for value in column] for key, column in columns.items()}
                lines = [",".join(rows)]
                lines += [",".join(map(repr, row)) for row in zip(*rows.values(), strict=True)]
                (tmp_path / f"{name}.csv").write_text("\n".join(lines), encoding="utf-8")
                own = rows if inline else {"file": f"{name}.csv"}
                written[section] = {name: {**joints[name], **own}}
        urdf, document = sources([*parts, link("cart")], 2, **written)
        try:
            from_sources("small", urdf, document, tmp_path)
            verdicts.append("")
        except InputError as error:
            verdicts.append(str(error.evidence["allowed"]))
    assert verdicts[0] == verdicts[1]
    assert bool(verdicts[0]) == (off_mm > 1e-6 or step_mm < 1e-9)


SHAFTS = [link("a"), hinge("a", "frame", "a"), link("b"), hinge("b", "frame", "b"),
          link("c"), hinge("c", "frame", "c"), link("s"), slide("s", "frame", "s")]  # fmt: skip


def driven(**drives: Any) -> Mechanism:
    return machine(SHAFTS, 4, drives=drives)


def test_gear_trains_and_screws() -> None:
    """Ratios multiply, whatever the order of the drives; a lead is travel for a turn."""
    mechanism = driven(
        last={"joint": "c", "law": "geared", "of": "middle", "ratio": -3.0},
        middle={"joint": "b", "law": "geared", "of": "first", "ratio": 0.5},
        first={"joint": "a", "law": "fourier", "mean_rad": 0.3, "sine_rad": [0.2]},
        screw={"joint": "s", "law": "screw", "lead_mm_per_turn": 5.0, "shaft_damping_ratio": 0.0},
    )
    assert [item.name for item in mechanism.drives] == ["last", "middle", "first", "screw"]
    psi = np.array([0.4, 7.0])
    wave = 0.3 + 0.2 * np.sin(psi)
    values = [item.law.evaluate(psi)[0] for item in mechanism.drives]
    expected = [-1.5 * wave, 0.5 * wave, wave, 5e-3 * psi / math.tau]
    np.testing.assert_allclose(values, expected, rtol=1e-13)
    (series, ratios), (screw, alone) = mechanism.drive_trains
    assert series is mechanism.drives[2].law
    assert screw is mechanism.drives[3].law
    assert ratios.tolist() == [[-1.5, 0.5, 1.0, 0.0]]
    assert alone.tolist() == [[0.0, 0.0, 0.0, 1.0]]
    at_touch = [-0.45, 0.15, 0.3, 0.0]
    assert [item.law_at_touch for item in mechanism.drives] == pytest.approx(at_touch)
    np.testing.assert_allclose(mechanism.drive_offsets[:, 0].sum(0), [-x for x in at_touch])
    shaft = "shaft_frequency_hz", "shaft_damping_ratio"
    assert mechanism.drives[0].missing == ("reflected_inertia_kg_m2", *shaft)
    assert mechanism.drives[3].missing == ("reflected_mass_kg", "shaft_frequency_hz")


def test_the_index_goes_round_in_forty() -> None:
    """Both ways, whichever way the cylinder turns."""
    for sense in (1, -1):
        cylinder = Cylinder(angle_at_touch_rad=0.0, sense=sense, rated_speed_rpm=60.0,
                            reference_angle_rad=0.7, reference_index=24.0)  # fmt: skip
        assert cylinder.index_from_angle(0.7) == pytest.approx(24.0)
        assert cylinder.index_from_angle(0.7 + sense * math.pi) == pytest.approx(4.0)
        assert cylinder.angle_from_index(34.0) == pytest.approx(0.7 + sense * 0.5 * math.pi)
        at_zero = replace(cylinder, reference_angle_rad=0.0, reference_index=0.0)
        assert at_zero.index_from_angle(-sense * 1e-17) == 0.0
        angles = np.array([-sense * 1e-17, 0.0, sense * math.pi])
        assert at_zero.indices_from_angles(angles) == pytest.approx([0.0, 0.0, 20.0])


def test_indices_on_one_scale() -> None:
    """Places, where they count on from, and differences the short way around."""
    for index, place in ((47.5, 7.5), (-0.5, 39.5), (40.0, 0.0), (-1e-17, 0.0), (80.0, 0.0)):
        assert within_turn(index) == place
    assert np.isnan(within_turn(np.array([math.nan])))
    assert counted_from(24.0, np.array([7.5, 24.0, 23.5])) == pytest.approx([47.5, 24.0, 63.5])
    for index, other, apart in ((0.5, 39.5, 1.0), (39.5, 0.5, -1.0), (12.0, 9.0, 3.0)):
        assert index_difference(index, other) == apart

"""Drive laws: exact derivatives, closed-form extremes, continuity, refusals."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_machines import link, slide, sources

from nipper_pin.errors import InputError, ModelError
from nipper_pin.mechanism import DriveLaw, from_sources, load
from nipper_pin.mechanism.build.laws import extreme_angle
from nipper_pin.mechanism.drives import ConstantSpeed, Fourier, Geared, OscillatingGuide, Table

GUIDE = OscillatingGuide(crank_radius_m=0.064, crank_axis=(0.0, 0.0), guide_axis=(-0.19, -0.02))
OFFSET = OscillatingGuide(
    crank_radius_m=0.064, crank_axis=(0.01, 0.02), guide_axis=(0.05, 0.3), guide_offset_m=0.03
)
SERIES = Fourier(mean=0.3, cosine=(0.2, -0.05), sine=(0.1, 0.0, 0.02))
LAWS = {
    "guide": GUIDE,
    "offset guide": OFFSET,
    "geared": Geared(of=OFFSET, ratio=-2.2),
    "constant speed": ConstantSpeed(ratio=0.5),
    "series": SERIES,
}


def table_of(law: DriveLaw, count: int) -> Table:
    angles = np.linspace(0.2, 0.2 + math.tau, count)
    return Table(
        cylinder_angle_rad=tuple(angles.tolist()),
        coordinate=tuple(law.evaluate(angles)[0].tolist()),
    )


@pytest.mark.parametrize("name", LAWS)
def test_derivatives_agree_with_differences(name: str) -> None:
    law = LAWS[name]
    psi = np.linspace(-9.0, 17.0, 401)
    step = 1e-3
    # Five-point differences: error of order step^4 and round-off of order 1e-16 / step^2.
    left2, left, right, right2 = (
        law.evaluate(psi + shift * step)[0] for shift in (-2.0, -1.0, 1.0, 2.0)
    )
    value, first, second = law.evaluate(psi)
    assert value.shape == first.shape == second.shape == psi.shape
    np.testing.assert_allclose(
        (left2 - 8.0 * left + 8.0 * right - right2) / (12.0 * step), first, atol=1e-10
    )
    np.testing.assert_allclose(
        (-left2 + 16.0 * left - 30.0 * value + 16.0 * right - right2) / (12.0 * step**2),
        second,
        atol=1e-7,
    )


@pytest.mark.parametrize("name", LAWS)
def test_any_shape_is_kept(name: str) -> None:
    flat = LAWS[name].evaluate(np.arange(6.0))
    square = LAWS[name].evaluate(np.arange(6.0).reshape(2, 3))
    for one, other in zip(flat, square, strict=True):
        np.testing.assert_array_equal(one.reshape(2, 3), other)


def test_guide_points_at_the_pin() -> None:
    psi = np.linspace(-20.0, 20.0, 999)
    pin = np.array(OFFSET.crank_axis)[:, None] + OFFSET.crank_radius_m * np.array(
        [np.cos(psi), np.sin(psi)]
    )
    reach = pin - np.array(OFFSET.guide_axis)[:, None]
    angle = OFFSET.evaluate(psi)[0]
    across = -np.sin(angle) * reach[0] + np.cos(angle) * reach[1]
    along = np.cos(angle) * reach[0] + np.sin(angle) * reach[1]
    np.testing.assert_allclose(across, OFFSET.guide_offset_m, atol=1e-15)
    assert along.min() > 0.0
    assert np.abs(np.diff(angle)).max() < 0.1


def test_guide_extremes_in_closed_form() -> None:
    distance = math.hypot(0.19, 0.02)
    swing = math.asin(0.064 / distance)
    direction = math.atan2(0.02, 0.19)
    low, high = extreme_angle(GUIDE, "minimum"), extreme_angle(GUIDE, "maximum")
    assert low is not None
    assert high is not None
    at = GUIDE.evaluate(np.array([low, high]))
    np.testing.assert_allclose(at[0], [direction - swing, direction + swing], atol=1e-15)
    np.testing.assert_allclose(at[1], 0.0, atol=1e-15)
    # There the crank is square to the guide.
    np.testing.assert_allclose(
        [math.cos(low - at[0][0]), math.cos(high - at[0][1])], 0.0, atol=1e-14
    )


def test_guide_is_continuous_over_many_turns() -> None:
    psi = np.linspace(0.0, 1.0, 7)
    first, later = GUIDE.evaluate(psi), GUIDE.evaluate(psi + 100.0 * math.tau)
    for one, other in zip(first, later, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)


def test_constant_speed_has_no_extreme() -> None:
    assert extreme_angle(ConstantSpeed(ratio=1.0), "minimum") is None


def test_table_reproduces_a_smooth_law() -> None:
    table = table_of(GUIDE, 361)
    psi = np.linspace(-10.0, 10.0, 777)
    for one, other, tolerance in zip(
        table.evaluate(psi), GUIDE.evaluate(psi), (1e-11, 1e-9, 1e-7), strict=True
    ):
        np.testing.assert_allclose(one, other, atol=tolerance)
    at_ends = table.evaluate(np.array([0.2, 0.2 + math.tau]))
    for values in at_ends:
        assert values[0] == pytest.approx(values[1], abs=1e-12)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"drives.pendulum.guide_axis_mm[0]": -190.5}, r"\[-190\.5, -20\.0\] .* 0\.5 mm away"),
        ({"drives.pendulum.guide_axis_mm": "[-187, -16]"}, r"\[-187\.0, -16\.0\] .* 5 mm away"),
        ({"drives.pendulum.guide_axis_mm[1]": -20.000002}, r" 2e-06 mm away"),
    ],
)
def test_guide_beside_its_joint(changes: dict[str, object], words: str) -> None:
    """The bar is fixed to the link that it turns; the distance is in the message, 3-4-5 as well."""
    with pytest.raises(ModelError, match=words) as caught:
        load("e62", changes)
    assert caught.value.evidence["key"] == "drives.pendulum.guide_axis_mm"
    assert "joint pendulum_shaft" in caught.value.message
    assert "[-190, -20]" in caught.value.message
    assert "points.pendulum_shaft.x_mm" in caught.value.message


def test_guide_moves_with_its_joint() -> None:
    """What the message advises: the pin moves, the law's axis with it, and the machine loads."""
    moved = load("e62", {"points.pendulum_shaft.x_mm": -190.5, "points.pendulum_shaft.z_mm": -19.0})
    law = moved.drives[0].law
    assert isinstance(law, OscillatingGuide)
    assert law.guide_axis == pytest.approx((-0.1905, -0.019), abs=1e-15)


def write_table(folder: Path, rows: list[tuple[object, object]], header: str) -> None:
    lines = [header, *(f"{angle},{value}" for angle, value in rows)]
    (folder / "pendulum.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


TABLE_LINES = (
    ('law = "oscillating_guide"', 'law = "table"'),
    ("crank_radius_mm = 64.0 ", 'file = "pendulum.csv" #'),
    ("crank_axis_mm = [0.0, 0.0]", "#"),
    ("guide_axis_mm = [-190.0, -20.0]", "#"),
    ("guide_offset_mm = 0.0 ", "#"),
)
HEADER = "cylinder_angle_deg,coordinate_rad"


def rows_of_guide() -> list[tuple[object, object]]:
    angles = np.arange(0.0, 361.0, 1.0)
    values = GUIDE.evaluate(np.radians(angles))[0]
    return list(zip(angles.tolist(), values.tolist(), strict=True))


def test_table_file_in_a_model(spoil) -> None:  # type: ignore[no-untyped-def]
    folder = spoil(toml=TABLE_LINES)
    write_table(folder, rows_of_guide(), HEADER)
    mechanism, original = load(folder), load()
    assert isinstance(mechanism.drives[0].law, Table)
    psi = np.linspace(0.0, 7.0, 50)
    for one, other in zip(
        mechanism.drives[1].law.evaluate(psi), original.drives[1].law.evaluate(psi), strict=True
    ):
        np.testing.assert_allclose(one, other, atol=1e-6)
    # The plain data stands on its own: no file is read again.
    assert "file" not in mechanism.description["drives"]["pendulum"]  # type: ignore[index]


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

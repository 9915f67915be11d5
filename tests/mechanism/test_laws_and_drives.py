"""Drive laws: series, knots, extremes, gear trains, shafts; and the scale of the index."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nipper_pin import Case, ModelError, load, simulate
from nipper_pin.mechanism import Mechanism
from nipper_pin.mechanism.build.laws import extreme_angle
from nipper_pin.mechanism.cylinder import (
    Cylinder,
    counted_from,
    index_difference,
    within_turn,
)
from nipper_pin.mechanism.drives import ConstantSpeed, Fourier, Geared, Table
from nipper_pin.mechanism.drives.cam import Cam
from nipper_pin.mechanism.elements import Characteristic
from tests.refusals.bases import model
from tests.refusals.descriptions import CAM, ROWS, TABLE
from tests.small_machines import hinge, link, machine, slide

TURN = [math.radians(angle) for angle in range(0, 361, 45)]
Edits = str | tuple[str, str]
SWING = [0.1 * math.sin(angle) for angle in TURN[:-1]] + [0.0]


def test_force_and_energy_of_a_straight_table() -> None:
    """Rows on a line give the line, and beyond the ends for the length of the table, then no more.

    The energy is the integral from the first row.
    """
    rows = Characteristic(coordinate=(-1.0, 0.0, 2.0), force=(1.0, 3.0, 7.0))
    assert rows.reach == (-4.0, 5.0)
    x = np.array([-1.0, 0.5, 2.0, 4.0, 5.0])
    np.testing.assert_allclose(rows.forces(x), 3.0 + 2.0 * x, rtol=1e-14)
    np.testing.assert_allclose(rows.forces(np.array([-9.0, 9.0])), [-5.0, 13.0], rtol=1e-14)
    np.testing.assert_allclose(rows.energies(x), 3.0 * (x + 1.0) + x**2 - 1.0, rtol=1e-13)


def test_a_series_with_more_sines_than_cosines_or_the_other_way_round() -> None:
    psi = np.linspace(-3.0, 9.0, 41)
    for cosine, sine in (((0.3,), (0.1, -0.2, 0.05)), ((0.1, 0.2, 0.3), ()), ((), ())):
        value, first, second = Fourier(mean=0.7, cosine=cosine, sine=sine).evaluate(psi)
        terms = [(n, c, 0.0) for n, c in enumerate(cosine, 1)]
        terms += [(n, 0.0, s) for n, s in enumerate(sine, 1)]
        waves = [(n, c * np.cos(n * psi), s * np.sin(n * psi)) for n, c, s in terms]
        slopes = [(n, -c * np.sin(n * psi), s * np.cos(n * psi)) for n, c, s in terms]
        zero = 0.0 * psi
        np.testing.assert_allclose(value, sum((c + s for _, c, s in waves), zero + 0.7), atol=1e-14)
        np.testing.assert_allclose(
            first, sum((n * (c + s) for n, c, s in slopes), zero), atol=1e-14
        )
        expected = sum((-n * n * (c + s) for n, c, s in waves), zero)
        np.testing.assert_allclose(second, expected, atol=1e-13)


def test_knots_of_laws() -> None:
    """Rows of a table but for the first, which is the last; of a cam ends and inner joints."""
    table = Table(cylinder_angle_rad=tuple(TURN), coordinate=tuple(SWING))
    assert table.knots_rad == tuple(TURN[1:])
    assert Geared(of=table, ratio=3.0).knots_rad == table.knots_rad
    assert ConstantSpeed(ratio=2.0).knots_rad == Fourier(mean=0.0).knots_rad == ()
    cam = {"lift": 1.0, "start_rad": 0.2, "rise_rad": 1.6, "dwell_rad": 0.5, "return_rad": 0.8}
    ends = (0.2, 1.8, 2.3, 3.1)
    assert Cam(motion="cycloidal", **cam).knots_rad == pytest.approx(ends)
    inner = (0.2, 0.4, 1.6, 1.8, 2.3, 2.4, 3.0, 3.1)
    assert Cam(motion="modified_sine", **cam).knots_rad == pytest.approx(inner)
    full = {**cam, "dwell_rad": math.tau - 2.4}
    assert Cam(motion="cycloidal", **full).knots_rad[-1] == pytest.approx(0.2 + math.tau)


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
        screw={"joint": "s", "law": "screw", "lead_mm_per_turn": 5.0},
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
    assert mechanism.drives[0].missing == (
        "reflected_inertia_kg_m2", "shaft_frequency_hz", "shaft_damping_ratio",
    )  # fmt: skip


def test_an_inertial_drive_says_which_numbers_of_its_shaft_are_missing() -> None:
    """A held one needs none, and a slide has a mass in place of an inertia."""

    def turn(drive: str, **keys: float) -> None:
        shaft = {"joint": "a", "law": "constant_speed", "ratio": 1.0, **keys}
        simulate(driven(shaft=shaft), Case(speed_rpm=60.0, window="cycle", drive=drive))

    turn("held")
    with pytest.raises(ModelError) as caught:
        turn("inertial", shaft_frequency_hz=10.0)
    assert "small.toml: drives.shaft.reflected_inertia_kg_m2" in caught.value.message
    assert caught.value.message.endswith("missing: drives.shaft.shaft_damping_ratio")
    turn("inertial", shaft_frequency_hz=10.0, shaft_damping_ratio=0.0, reflected_inertia_kg_m2=1.0)
    (screw,) = driven(screw={"joint": "s", "law": "screw", "lead_mm_per_turn": 10.0}).drives
    assert screw.missing == ("reflected_mass_kg", "shaft_frequency_hz", "shaft_damping_ratio")


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


AXLE = 'joint = "axle", law = '
RATIO, RADIUS = "ratio = 2.2 ", "crank_radius_mm = 64.0"


@pytest.mark.parametrize(
    ("base", "edits", "others"),
    [
        ("small", *(f'drives.x = {{ {AXLE}"constant_speed", ratio = {k} }}' for k in (1.5, 2.5))),
        ("small", *(f'drives.x = {{ {AXLE}"fourier", cosine_rad = [0.0, {k}] }}' for k in (1, 2))),
        ("small", f"drives.x = {{ {TABLE} }}", f"drives.x = {{ {TABLE.replace('0.2,', '0.3,')} }}"),
        ("small", *(f"drives.x = {{ {CAM.replace('20.0', k)} }}" for k in ("10.0", "9.0"))),
        (
            "small",
            f"springs.x = {{ {ROWS} }}",
            f"springs.x = {{ {ROWS.replace('100.0', '99.0')} }}",
        ),
        ("e62", (RATIO, RATIO), (RATIO, "ratio = 2.3 ")),
        ("e62", (RADIUS, RADIUS), (RADIUS, "crank_radius_mm = 64.5")),
    ],
    ids=["speed", "series", "table", "cam", "spring", "gear", "guide that a gear follows"],
)
def test_laws_of_equal_numbers_are_equal(
    base: str, edits: Edits, others: Edits, tmp_path: Path
) -> None:
    """Those of one text, not those of another; what is prepared from numbers is not shown."""
    found: list[Any] = []
    for number, text in enumerate((edits, edits, others)):
        (tmp_path / str(number)).mkdir()
        mechanism = load(model(base, text, tmp_path / str(number)))
        laws = [item.law for item in mechanism.drives]
        found.append(laws or [item.characteristic for item in mechanism.tabulated_springs])
    one, same, other = (laws[-1] for laws in found)
    assert one is not same
    assert one == same
    assert one != other
    assert repr(one) == repr(same) != repr(other)
    assert " _" not in repr(one)

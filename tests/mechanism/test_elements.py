"""Springs and dampers: what those of a model file become, and forces of a table."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_machines import machine, sources

from nipper_pin.mechanism import Characteristic, Damper, Strut, from_sources, with_numbers
from tests.refusals.bases import PARTS
from tests.refusals.descriptions import HEAD, LINES

TIE = {"frame_a": "a", "frame_b": "b"}
RAIL, PIVOT = {"joint": "rail"}, {"joint": "pivot"}
TABLES: dict[str, Any] = {
    "springs": {
        "tie": {**TIE, "stiffness_N_per_m": 9000.0, "free_length_mm": 186.5},
        "lid": {**PIVOT, "coordinate_deg": [-90, 0, 180], "torque_N_m": [1, 2, 4]},
    },
    "dampers": {
        "oil": {**RAIL, "damping_N_s_per_m": 12.0},
        "lid": {**PIVOT, "damping_N_m_s_per_rad": 0.3},
        "stay": {**TIE, "damping_N_s_per_m": 5},
    },
}


def test_elements_in_si_units() -> None:
    mechanism = machine(PARTS, 3, **TABLES)
    index = {joint.name: joint.index for joint in mechanism.joints}
    assert mechanism.springs == ()
    assert mechanism.dampers == (
        Damper(name="oil", index=index["rail"], damping=12.0),
        Damper(name="lid", index=index["pivot"], damping=0.3),
    )
    assert mechanism.struts == (
        Strut(name="tie", kind="spring", frame_a="a", frame_b="b", stiffness=9000.0,
              free_length=pytest.approx(0.1865)),
        Strut(name="stay", kind="damper", frame_a="a", frame_b="b", damping=5.0),
    )  # fmt: skip
    (table,) = mechanism.tabulated_springs
    assert (table.name, table.index) == ("lid", index["pivot"])
    assert table.characteristic.coordinate == pytest.approx((-0.5 * math.pi, 0.0, math.pi))
    assert table.characteristic.force == (1.0, 2.0, 4.0)


def test_every_number_of_them_has_a_path() -> None:
    numbers = {"springs.tie.free_length_mm": 180.0, "springs.tie.stiffness_N_per_m": 7e3,
               "dampers.oil.damping_N_s_per_m": 0.0, "springs.lid.torque_N_m[1]": 2.5}  # fmt: skip
    mechanism = with_numbers(machine(PARTS, 3, **TABLES), numbers)
    spring, _ = mechanism.struts
    assert (spring.free_length, spring.stiffness) == (pytest.approx(0.18), 7e3)
    assert mechanism.dampers[0].damping == 0.0
    assert mechanism.tabulated_springs[0].characteristic.force == (1.0, 2.5, 4.0)


def test_table_in_a_file(tmp_path: Path) -> None:
    """The rows of a file make the spring that the same rows in the TOML make, and are kept."""
    rows = {"coordinate_mm": [0.0, 2.0, 5.0], "force_N": [90.0, 100.0, 130.0]}
    written = machine(PARTS, 3, springs={"coil": {**RAIL, **rows}})
    (tmp_path / "coil.csv").write_bytes(HEAD + LINES)
    urdf, document = sources(PARTS, 3, springs={"coil": {**RAIL, "file": "coil.csv"}})
    read = from_sources("small", urdf, document, tmp_path)
    assert read.tabulated_springs == written.tabulated_springs
    assert read.description["springs"] == written.description["springs"]


ROWS = Characteristic(coordinate=(-2.0, 0.0, 1.0, 4.0, 5.0), force=(-4.0, 0.0, 0.5, 8.0, 30.0))


def test_characteristic_keeps_to_its_rows() -> None:
    """Rows are met, and between two of them a table that rises never falls nor overshoots.

    A cubic spline through these rows falls between the second and the third.
    """
    x = np.linspace(-2.0, 5.0, 7001)
    f = ROWS.forces(x)
    np.testing.assert_allclose(ROWS.forces(np.array(ROWS.coordinate)), ROWS.force, rtol=1e-15)
    assert (np.diff(f) > 0.0).all()


def test_characteristic_has_a_continuous_slope() -> None:
    """One-sided differences at the inner rows meet as the step goes to zero; linear ones do not."""
    h = 1e-6
    for row in ROWS.coordinate[1:-1]:
        before, here, after = ROWS.forces(row + h * np.array([-1.0, 0.0, 1.0]))
        assert (after - here) / h == pytest.approx((here - before) / h, abs=1e-3)


def test_energy_is_the_integral_of_the_force() -> None:
    """Gauss quadrature with 8 points between rows, exact for cubics: 1e-14 of the energy."""
    points, weights = np.polynomial.legendre.leggauss(8)
    total = 0.0
    for low, high in zip(ROWS.coordinate, ROWS.coordinate[1:], strict=False):
        x = low + 0.5 * (high - low) * (points + 1.0)
        total += 0.5 * (high - low) * float(weights @ ROWS.forces(x))
        assert ROWS.energies(np.array([high]))[0] == pytest.approx(total, abs=1e-13)


def test_rows_on_a_line_are_the_line() -> None:
    """Force and energy of uneven rows on 3 (x + 0.2), to the round-off of some operations.

    Beyond the ends for the length of the table, then the force grows no more. The energy is the
    integral from the first row.
    """
    rows = np.array([-1.0, -0.3, 0.1, 2.0, 2.1])
    line = Characteristic(coordinate=tuple(rows), force=tuple(3.0 * (rows + 0.2)))
    assert line.reach == pytest.approx((-4.1, 5.2), rel=1e-15)
    # The cubic between rows that are 0.1 apart goes on for 3.1: an eps grows by (3.1 / 0.1)^3.
    for low, high, error in ((-1.0, 2.1, 1e-14), (-4.1, 5.2, 2e-11)):
        x = np.linspace(low, high, 101)
        np.testing.assert_allclose(line.forces(x), 3.0 * (x + 0.2), rtol=0.0, atol=error)
        energy = 1.5 * ((x + 0.2) ** 2 - 0.64)
        np.testing.assert_allclose(line.energies(x), energy, rtol=0.0, atol=3.1 * error)
    ends = line.forces(np.array([-9.0, 9.0]))
    np.testing.assert_allclose(ends, [-11.7, 16.2], rtol=0.0, atol=error)


def test_a_slope_that_is_nearly_none() -> None:
    """Its reciprocal overflows, which would be a warning; the force stays between its rows."""
    flat = Characteristic(coordinate=(0.0, 1.0, 2.0), force=(0.0, 1e-310, 1.0))
    assert flat.forces(np.array([0.5, 1.0])).max() <= 1e-310
    assert 0.0 < flat.forces(np.array([1.5]))[0] < 1.0

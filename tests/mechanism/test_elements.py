"""Springs and dampers: what those of a model file become, and forces of a table."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from nipper_pin.mechanism import Characteristic, Damper, Strut, from_sources, load

OLD = 'joint = "steeve"\nstiffness_N_per_m = 9000.0\npreload_length_mm = 11.0 '
POINTS = (
    'frame_a = "steeve_lower"\nframe_b = "eccentric_pin"\n'
    "stiffness_N_per_m = 9000.0\nfree_length_mm = 186.5\n"
)
TABLE = 'joint = "steeve"\ncoordinate_mm = [0.0, 2.0, 5.0]\nforce_N = [90.0, 100.0, 130.0]\n'
DAMPER = '[dampers.oil]\njoint = "steeve"\ndamping_N_s_per_m = 12.0\n'


def changed(spoil, text: str, extra: str = "") -> Path:  # type: ignore[no-untyped-def]
    """The E62 with another steeve spring and further tables; its shortcuts to the old one go."""
    folder: Path = spoil(toml=((OLD, f"{text} #"), ("[stops.jaw]", f"{extra}\n[stops.jaw]")))
    path = folder / "e62.toml"
    path.write_text(path.read_text(encoding="utf-8").partition("[shortcuts]")[0], encoding="utf-8")
    return folder


def test_elements_in_si_units(spoil) -> None:  # type: ignore[no-untyped-def]
    hinge = (
        '[springs.lid]\njoint = "jaw"\ncoordinate_deg = [-90, 0, 180]\ntorque_N_m = [1, 2, 4]\n'
        '[dampers.lid]\njoint = "jaw"\ndamping_N_m_s_per_rad = 0.3\n'
        '[dampers.stay]\nframe_a = "frame"\nframe_b = "rod_head"\ndamping_N_s_per_m = 5\n'
    )
    mechanism = load(changed(spoil, POINTS, DAMPER + hinge))
    index = {joint.name: joint.index for joint in mechanism.joints}
    assert mechanism.springs == ()
    assert mechanism.dampers == (
        Damper(name="oil", index=index["steeve"], damping=12.0),
        Damper(name="lid", index=index["jaw"], damping=0.3),
    )
    spring, stay = mechanism.struts
    assert spring == Strut(
        name="steeve", kind="spring", frame_a="steeve_lower", frame_b="eccentric_pin",
        stiffness=9000.0, free_length=pytest.approx(0.1865),
    )  # fmt: skip
    assert stay == Strut(
        name="stay", kind="damper", frame_a="frame", frame_b="rod_head", damping=5.0
    )
    (table,) = mechanism.tabulated_springs
    assert (table.name, table.index) == ("lid", index["jaw"])
    assert table.characteristic.coordinate == pytest.approx((-0.5 * math.pi, 0.0, math.pi))
    assert table.characteristic.force == (1.0, 2.0, 4.0)


def test_every_number_of_them_has_a_path(spoil) -> None:  # type: ignore[no-untyped-def]
    folder = changed(spoil, POINTS, DAMPER + f"[springs.table]\n{TABLE}")
    overrides = {
        "springs.steeve.free_length_mm": 180.0,
        "springs.steeve.stiffness_N_per_m": "7e3",
        "dampers.oil.damping_N_s_per_m": 0,
        "springs.table.force_N[1]": 95.5,
    }
    mechanism = load(folder, overrides)
    (spring,) = mechanism.struts
    assert (spring.free_length, spring.stiffness) == (pytest.approx(0.18), 7e3)
    assert mechanism.dampers[0].damping == 0.0
    assert mechanism.tabulated_springs[0].characteristic.force == (90.0, 95.5, 130.0)


CSV = "coordinate_mm,force_N\n0.0,90.0\n2.0,100.0\n5.0,130.0\n"


def test_table_in_a_file(spoil) -> None:  # type: ignore[no-untyped-def]
    """The rows of a file make the spring that the same rows in the TOML make, and are kept."""
    folder = changed(spoil, 'joint = "steeve"\nfile = "coil.csv"\n')
    (folder / "coil.csv").write_text(CSV, encoding="utf-8")
    mechanism = load(folder)
    written = load(changed(spoil, TABLE))
    assert mechanism.tabulated_springs == written.tabulated_springs
    (folder / "coil.csv").unlink()
    again = from_sources("e62", mechanism.urdf, mechanism.description, mechanism.mesh_folder)
    assert again.tabulated_springs == mechanism.tabulated_springs


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
    """Force and energy of uneven rows on 3 (x + 0.2), to the round-off of some operations."""
    rows = np.array([-1.0, -0.3, 0.1, 2.0, 2.1])
    line = Characteristic(coordinate=tuple(rows), force=tuple(3.0 * (rows + 0.2)))
    x = np.linspace(-1.0, 2.1, 101)
    np.testing.assert_allclose(line.forces(x), 3.0 * (x + 0.2), atol=1e-14)
    energy = 1.5 * ((x + 0.2) ** 2 - 0.64)
    np.testing.assert_allclose(line.energies(x), energy, atol=1e-14)


def test_a_slope_that_is_nearly_none() -> None:
    """Its reciprocal overflows, which would be a warning; the force stays between its rows."""
    flat = Characteristic(coordinate=(0.0, 1.0, 2.0), force=(0.0, 1e-310, 1.0))
    assert flat.forces(np.array([0.5, 1.0])).max() <= 1e-310
    assert 0.0 < flat.forces(np.array([1.5]))[0] < 1.0

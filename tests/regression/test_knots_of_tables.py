"""Found by the stress campaign (cases 34, 53 and 72 of seed 1): drives given by rough tables.

"no end after 60 s", and "times differ by 1.56e-13 s, stated 4.08e-15 s": panels lay across knots
of a table's spline, where no polynomial follows it; and panels whose last coefficients were only
round-off advised ever shorter ones, 42,140 of them in a turn.
"""

import numpy as np
import pytest

from nipper_pin import Case, Mechanism, Resolution, Window, simulate
from nipper_pin.mechanism import from_sources
from nipper_pin.study.stress.machines import e62 as e62_source


@pytest.fixture(scope="module")
def rough() -> Mechanism:
    """The E62-class model with its pendulum's motion in 24 rows, each off by up to 1 mrad."""
    source = e62_source()
    drive = source.description["drives"]["pendulum"]
    angle = np.linspace(0.0, 360.0, 25)
    crank, guide = np.array(drive["crank_axis_mm"]), np.array(drive["guide_axis_mm"])
    turn = np.radians(angle)
    along = (
        crank + drive["crank_radius_mm"] * np.stack([np.cos(turn), np.sin(turn)], axis=1) - guide
    )
    rows = np.unwrap(np.arctan2(along[:, 1], along[:, 0]))
    rows += 1e-3 * np.sin(37.0 * np.arange(25.0) ** 2)
    rows[-1] = rows[0]
    kept = {
        key: drive[key]
        for key in ("joint", "reflected_inertia_kg_m2", "shaft_frequency_hz", "shaft_damping_ratio")
    }
    table = {"cylinder_angle_deg": angle.tolist(), "coordinate_rad": rows.tolist()}
    source.description["drives"]["pendulum"] = {**kept, "law": "table", **table}
    return from_sources(source.name, source.urdf, source.description, source.folder)


def test_panels_end_at_the_knots(rough: Mechanism) -> None:
    """Every knot that the turn passes lies on a border of two panels, to round-off of an angle.

    24 knots on about as many panels: without them borders lie anywhere.
    """
    solution = simulate(rough, Case(speed_rpm=492.0, window=Window.CYCLE))
    borders = [panel.t for segment in solution.segments for panel in segment.panels]
    borders += [segment.t_end for segment in solution.segments]
    angles = np.degrees(solution.shaft.angle(np.array(borders)))
    knots = np.arange(24.0) * 15.0
    away = np.abs((angles[None, :] - knots[:, None] + 180.0) % 360.0 - 180.0).min(axis=1)
    assert away.max() <= 1e-7


def test_a_finer_tolerance_costs_no_more_than_it_must(rough: Mechanism) -> None:
    """Evaluations at 1e-13 are less than thrice those at 1e-10; they were 400 times as many."""
    work = [
        simulate(
            rough,
            Case(speed_rpm=492.0, window=Window.CYCLE, resolution=Resolution(tolerance=tolerance)),
        ).evaluations
        for tolerance in (1e-10, 1e-13)
    ]
    assert work[1] < 3 * work[0]

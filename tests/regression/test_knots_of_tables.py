"""Found by the stress campaign (cases 34, 53 and 72 of seed 1): drives given by rough tables.

"no end after 60 s", and "times differ by 1.56e-13 s, stated 4.08e-15 s": panels lay across knots
of a table's spline, where no polynomial follows it; and panels whose last coefficients were only
round-off advised ever shorter ones, 42,140 of them in a turn.

Case 847 of seed 141: "times differ by 3.4e-14 s, stated 3.22e-14 s": the limit of a series of
bounces was extrapolated across a knot, and seemed to converge, to the wrong time.
"""

import numpy as np
import pytest

from benchmarks.stress.machines.small_machines import (
    e62 as e62_source,
)
from nipper_pin import Case, Mechanism, Resolution, Window, simulate
from nipper_pin.mechanism import from_sources


def tabulated(count: int, noise: float) -> Mechanism:
    """The E62-class model, its pendulum's motion in so many rows, each off by some noise [rad]."""
    source = e62_source()
    drive = source.description["drives"]["pendulum"]
    angle = np.linspace(0.0, 360.0, count + 1)
    crank, guide = np.array(drive["crank_axis_mm"]), np.array(drive["guide_axis_mm"])
    turn = np.radians(angle)
    along = (
        crank + drive["crank_radius_mm"] * np.stack([np.cos(turn), np.sin(turn)], axis=1) - guide
    )
    rows = np.unwrap(np.arctan2(along[:, 1], along[:, 0]))
    rows += noise * np.sin(37.0 * np.arange(count + 1.0) ** 2)
    rows[-1] = rows[0]
    kept = {
        key: drive[key]
        for key in ("joint", "reflected_inertia_kg_m2", "shaft_frequency_hz", "shaft_damping_ratio")
    }
    table = {"cylinder_angle_deg": angle.tolist(), "coordinate_rad": rows.tolist()}
    source.description["drives"]["pendulum"] = {**kept, "law": "table", **table}
    return from_sources(source.name, source.urdf, source.description, source.folder)


@pytest.fixture(scope="module")
def rough() -> Mechanism:
    """24 rows, each off by up to 1 mrad."""
    return tabulated(24, 1e-3)


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


def test_limits_of_bounces_do_not_reach_across_knots() -> None:
    """Knots every 7 deg: the jaw passes one while it bounces, and comes to rest 0.05 deg behind it.

    Three collisions behind the knot show the limit. With those before it a run ended one collision
    sooner, and its time of rest was off from a finer one's by 0.96 of what both state.
    """
    mechanism = tabulated(52, 1e-4)
    coarse, fine = (
        simulate(mechanism, Case(speed_rpm=680.0, resolution=Resolution(tolerance=tolerance)))
        for tolerance in (1e-12, 6e-14)
    )
    angles = np.degrees([hit.cylinder_angle for hit in coarse.collisions])
    knot = 20.0 * 360.0 / 52.0
    assert (angles > knot).sum() == 4
    assert (angles < knot).sum() >= 3
    stated = coarse.errors[-1].time + fine.errors[-1].time
    assert abs(coarse.events[-1].t - fine.events[-1].t) <= 0.1 * stated

"""Steps of differences: never zero, never outside what a number may be, and of the stated order."""

from __future__ import annotations

import numpy as np
import pytest

from nipper_pin.study.steps import step_of

RESTITUTION = "stops.jaw.restitution"


@pytest.mark.parametrize("value", [0.0, 1e-5, 3e-4, 0.2, 0.9985, 0.9999, 1.0])
def test_restitution_stays_between_0_and_1(value: float) -> None:
    """exp(3 x), refused outside as a model refuses it; slopes to the order of the differences.

    Central differences of h leave f''' h^2 / 6, one-sided ones f''' h^2 / 3 = 9 f h^2; with
    h = 2e-3 of the value or 2e-4, at most 4e-5 f. What is extrapolated leaves the next order,
    30 f h^3 at most: 3e-7.
    """
    asked = []

    def function(x: float) -> np.ndarray:
        assert 0.0 <= x <= 1.0
        asked.append(x)
        return np.array([np.exp(3.0 * x)])

    step = step_of(RESTITUTION, value)
    true, h = 3.0 * np.exp(3.0 * value), step.half_width
    assert step.slope(function, value)[0] == pytest.approx(true, rel=4.0 * h**2 + 1e-11)
    assert abs(step.extrapolated(function, value)[0] / true - 1.0) < 30.0 * h**3 + 1e-10
    assert len(set(asked)) >= 4


@pytest.mark.parametrize(
    ("path", "value"),
    [("points.eccentric_pin.radius_mm", 0.03), ("springs.steeve.stiffness_N_per_m", 0.0),
     ("links.rocker.mass_kg", 0.0)],
)  # fmt: skip
def test_what_may_not_be_negative_is_not(path: str, value: float) -> None:
    step = step_of(path, value)

    def function(x: float) -> np.ndarray:
        assert x >= 0.0
        return np.array([x * x])

    assert step.extrapolated(function, value)[0] == pytest.approx(2.0 * value, abs=1e-9)


@pytest.mark.parametrize(
    ("path", "value", "unit", "amount", "width", "sense"),
    [
        ("points.a.x_mm", 80.0, "mm", 1.0, 0.05, 0), ("points.a.x_mm", 0.0, "mm", 1.0, 0.05, 0),
        ("points.a.radius_mm", 0.09, "mm", 1.0, 0.05, 1),
        ("points.a.angle_deg", 3.0, "deg", 1.0, 0.05, 0),
        ("stops.a.restitution", 0.5, "%", 5e-3, 1e-3, 0),
        ("stops.a.restitution", 0.0099, "0.01", 0.01, 2e-4, 0),
        ("stops.a.restitution", 3e-4, "0.01", 0.01, 2e-4, 1),
        ("stops.a.restitution", 0.997, "%", 9.97e-3, 1.994e-3, -1),
        ("stops.a.restitution", 0.995, "%", 9.95e-3, 1.99e-3, 0),
        ("springs.a.stiffness_N_per_m", 500.0, "%", 5.0, 1.0, 0),
        ("springs.a.stiffness_N_per_m", 9.0, "10 N/m", 10.0, 0.2, 0),
        ("springs.a.stiffness_N_m_per_rad", 0.0, "0.01 N m/rad", 0.01, 2e-4, 1),
        ("dampers.a.damping_N_s_per_m", 0.05, "0.1 N s/m", 0.1, 2e-3, 0),
        ("dampers.a.damping_N_m_s_per_rad", 0.0, "0.001 N m s/rad", 1e-3, 2e-5, 1),
        ("springs.a.preload_N_m", -0.001, "0.01 N m", 0.01, 2e-4, 0),
        ("springs.a.preload_N", 0.0, "1 N", 1.0, 0.02, 0),
        ("links.a.inertia_kg_m2", 0.0, "1e-7 kg m2", 1e-7, 2e-9, 1),
        ("links.a.mass_kg", 5e-5, "0.1 g", 1e-4, 2e-6, 0),
        ("speed_rpm", 0.5, "1 r/min", 1.0, 0.02, 0), ("speed_rpm", 0.0, "1 r/min", 1.0, 0.02, 1),
        ("speed_rpm", 500.0, "%", 5.0, 1.0, 0),
        ("drives.a.ratio", 0.0, "0.01", 0.01, 2e-4, 0),
        ("drives.a.ratio", -2.0, "%", -0.02, 4e-3, 0),
    ],
)  # fmt: skip
def test_units_widths_and_senses(
    path: str, value: float, unit: str, amount: float, width: float, sense: int
) -> None:
    """A percentage where there is something to take it of; an amount of its kind near zero.

    Half widths: 0.05 mm or degrees, else 0.2 % of the value and at least 2 % of the amount.
    """
    step = step_of(path, value)
    assert (step.unit, step.sense) == (unit, sense)
    assert step.amount == pytest.approx(amount)
    assert step.half_width == pytest.approx(width)

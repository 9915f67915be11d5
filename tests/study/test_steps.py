"""Steps of differences: never zero, never outside what a number may be, and of the stated order."""

from __future__ import annotations

import numpy as np
import pytest

from nipper_pin.study.steps import step_of

RESTITUTION = "stops.jaw.restitution"


@pytest.mark.parametrize(
    ("path", "value", "unit", "amount"),
    [
        ("springs.steeve.preload_length_mm", 0.0, "mm", 1.0),
        ("points.eccentric_pin.angle_deg", -30.0, "deg", 1.0),
        ("springs.steeve.stiffness_N_per_m", 9000.0, "%", 90.0),
        ("drives.tension.ratio", -2.0, "%", -0.02),
        (RESTITUTION, 0.2, "%", 0.002),
        (RESTITUTION, 0.0, "0.01", 0.01),
        ("springs.steeve.stiffness_N_per_m", 0.0, "10 N/m", 10.0),
        ("dampers.steeve.damping_N_s_per_m", 0.0, "0.1 N s/m", 0.1),
        ("dampers.jaw.damping_N_m_s_per_rad", 0.0, "0.001 N m s/rad", 0.001),
        ("links.rocker.mass_kg", 0.0, "0.1 g", 1e-4),
        ("drives.tension.ratio", 0.0, "0.01", 0.01),
    ],
)
def test_one_unit_more(path: str, value: float, unit: str, amount: float) -> None:
    """A percentage where there is something to take it of; an amount of its kind near zero."""
    step = step_of(path, value)
    assert (step.unit, step.amount) == (unit, pytest.approx(amount))
    assert step.half_width > 0.0


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

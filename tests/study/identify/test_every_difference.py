"""Derivatives of a fit, and how far a working cycle is outside its limits: all by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from linear_problem import AT

from nipper_pin.errors import SimulationError
from nipper_pin.study.identify.fitting.differences import jacobian, slopes
from nipper_pin.study.identify.fitting.limits import excesses, limit_rows
from nipper_pin.study.identify.problem.problem import Limits
from nipper_pin.tolerances.study import FIT_STEP


def parabola(low: float, high: float, asked: list[float] | None = None) -> Any:
    """x^2 and 3 x of the second coordinate; no machine outside of a stretch."""

    def function(z: np.ndarray) -> np.ndarray:
        if asked is not None:
            asked.append(float(z[1]))
        if not low <= z[1] <= high:
            words = "outside"
            raise SimulationError(words)
        return np.array([z[1] ** 2, 3.0 * z[1], z[0]])

    return function


@pytest.mark.parametrize(
    ("z", "low", "high", "first"),
    [
        # Inwards by 1e-4, from either half; outwards where there is no machine inwards.
        (0.25, 0.0, 1.0, 1e-4), (0.75, 0.0, 1.0, -1e-4), (0.25, 0.0, 0.25, -1e-4),
        (0.75, 0.75, 1.0, 1e-4), (0.5, 0.0, 1.0, -1e-4),
    ],
)  # fmt: skip
def test_slopes_to_go_down(z: float, low: float, high: float, first: float) -> None:
    asked: list[float] = []
    found = slopes(parabola(low, high, asked), np.array([0.5, z]))
    assert found.shape == (3, 2)
    assert found[:, 1] == pytest.approx([2.0 * z + first, 3.0, 0.0], abs=1e-9)
    assert found[:, 0] == pytest.approx([0.0, 0.0, 1.0])
    with pytest.raises(SimulationError, match="outside"):
        slopes(parabola(0.5, 0.5), np.array([0.5, 0.5]))


@pytest.mark.parametrize(
    ("z", "low", "high", "places"),
    [
        (0.5, 0.0, 1.0, (1, -1)), (FIT_STEP, 0.0, 1.0, (1, -1)),
        (1.0 - FIT_STEP, 0.0, 1.0, (1, -1)),
        (0.5 * FIT_STEP, -1.0, 2.0, (1, 2)), (1.0 - 0.5 * FIT_STEP, -1.0, 2.0, (-1, -2)),
        (0.3, 0.3, 1.0, (1, 2)), (0.3, 0.0, 0.3, (-1, -2)), (0.7, 0.7, 1.0, (1, 2)),
    ],
)  # fmt: skip
def test_derivatives_of_the_second_order(
    z: float, low: float, high: float, places: tuple[int, int]
) -> None:
    """Exact for parabolas; both sides inside the bounds, one beside a bound or an edge."""
    asked: list[float] = []
    found = jacobian(parabola(low, high, asked), np.array([0.5, z]))
    assert found == pytest.approx(np.array([[0.0, 2.0 * z], [0.0, 3.0], [1.0, 0.0]]), abs=1e-9)
    steps = {round((x - z) / FIT_STEP) for x in asked if low <= x <= high}
    assert set(places) <= steps <= {*places, 0}


def cycle(closing: float, opening: float, gap: float, force: float) -> Any:
    waiting = SimpleNamespace(gap=np.full(48, math.radians(gap)), force=np.full(48, force))
    waiting.gap[7] += math.radians(1.0)
    waiting.force[9] -= 2.0
    return SimpleNamespace(closing_index=closing, opening_index=opening, waiting=waiting)


@pytest.mark.parametrize(
    ("found", "wanted"),
    [
        (cycle(34.0, 8.0, 30.0, 12.0), (0.0, 0.0, 0.0, 0.0)),
        (cycle(35.1, 6.9, 28.8, 11.5), (2.0, -2.0, -1.0, -0.5)),
        (cycle(32.9, 9.1, 29.0, 10.0), (-2.0, 2.0, 0.0, -2.0)),
        # The short way around the turn of 40.
        (cycle(34.0, 39.0, 29.0, 12.0), (0.0, -160.0, 0.0, 0.0)),
    ],
)  # fmt: skip
def test_how_far_a_cycle_is_outside(found: Any, wanted: tuple[float, ...]) -> None:
    limits = Limits(at=AT, closing_index=(33.0, 35.0), opening_index=(7.0, 9.0), stop_force_N=10.0,
                    jaw_opening_deg=30.0)  # fmt: skip
    assert excesses(limits, found) == pytest.approx(wanted)
    rows = limit_rows(limits, found)
    assert rows.shape == (51,)
    assert rows[3 + 9] == pytest.approx(wanted[3])
    assert rows[3] == pytest.approx(min(0.0, wanted[3] + 2.0))
    none = Limits(at=AT, closing_index=None, opening_index=None, stop_force_N=None,
                  jaw_opening_deg=None)  # fmt: skip
    assert not limit_rows(none, found).any()

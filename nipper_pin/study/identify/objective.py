"""From values of the free numbers to residuals, each in units of its own uncertainty."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...errors import NipperError
from ...mechanism import Mechanism
from .parameters import with_values
from .problem import Limits, Problem
from .targets import predict, with_settings
from .working import SAMPLES, WorkingCycle, working_cycle

INDEX_SIGMA = 0.05
"""Uncertainty of an index limit: a limit broken by this counts like a target off by one sigma."""
FORCE_SIGMA_N = 1.0
"""The same for the stop force [N]."""
OPENING_SIGMA_DEG = 0.2
"""The same for the opening of the jaw [deg]."""
UNUSABLE = 1e3
"""Residual of values that make no machine, or one that cannot be simulated."""

STEP = 1e-3
"""Step of differences in unit coordinates: a thousandth of a range leaves a truncation of about
1e-6 and keeps the tolerance of the transitions a factor of 1e5 below the difference."""

_SHORT = 1e-4

LIMITS = ("closing_index", "opening_index", "least_opening_deg", "least_stop_force_N")
"""Limits of the working cycle."""


@dataclass(frozen=True)
class Objective:
    """Residuals of a problem as a function of unit coordinates.

    A unit coordinate z runs from 0 at the lower bound of a free number to 1 at the upper one.

    Attributes:
        problem: The problem.
    """

    problem: Problem

    @property
    def low(self) -> FloatArray:
        """Lower bounds, shape (free,)."""
        return np.array([item.low for item in self.problem.free])

    @property
    def width(self) -> FloatArray:
        """Widths of the ranges, shape (free,)."""
        return np.array([item.high - item.low for item in self.problem.free])

    @property
    def start(self) -> FloatArray:
        """Unit coordinates of the model's own values, shape (free,)."""
        return (np.array([item.start for item in self.problem.free]) - self.low) / self.width

    def values(self, z: FloatArray) -> dict[str, float]:
        """Values of the free numbers by path."""
        numbers = self.low + self.width * z
        return {item.path: float(x) for item, x in zip(self.problem.free, numbers, strict=True)}

    def mechanism(self, z: FloatArray) -> Mechanism:
        """Return the mechanism with these values.

        Raises:
            InputError: They make none.
        """
        return with_values(self.problem.sources, self.values(z)).build()

    def predicted(self, z: FloatArray) -> FloatArray:
        """Values of all targets, shape (targets,).

        Raises:
            NipperError: These values make no machine, or it cannot be simulated.
        """
        return self._predicted(self.mechanism(z))

    def residuals(self, z: FloatArray) -> FloatArray:
        """Residuals of targets, limits and prior, shape (rows,); large without a machine."""
        problem = self.problem
        prior = problem.prior_weight * (z - self.start)
        try:
            mechanism = self.mechanism(z)
            misfit = self.misfit(self._predicted(mechanism))
            broken = np.zeros(0)
            if problem.limits is not None:
                broken = limit_rows(problem.limits, self.cycle(mechanism, problem.limits))
        except NipperError:
            misfit = np.full(len(problem.targets), UNUSABLE)
            broken = np.zeros(0 if problem.limits is None else 3 + SAMPLES)
        return np.concatenate([misfit, broken, prior])

    def slopes(self, z: FloatArray) -> FloatArray:
        """Derivatives of the residuals by z, one-sided: half the work, enough to go down.

        Args:
            z: Unit coordinates, shape (free,).

        Returns:
            Shape (rows, free).
        """
        here = self.residuals(z)
        columns = []
        for place in range(len(z)):
            step = np.zeros(len(z))
            step[place] = _SHORT if z[place] < 0.5 else -_SHORT
            columns.append((self.residuals(z + step) - here) / step[place])
        return np.array(columns).T

    def cycle(self, mechanism: Mechanism, limits: Limits) -> WorkingCycle:
        """Working cycle of a mechanism at the settings of limits.

        Raises:
            SimulationError: The links cannot follow the drives, or the jaw does not open again.
        """
        return working_cycle(with_settings(mechanism, limits.at), limits.at.speed_rpm)

    def misfit(self, predicted: FloatArray) -> FloatArray:
        """Distances from the targets in sigmas, shape (targets,)."""
        value = np.array([target.value for target in self.problem.targets])
        sigma = np.array([target.sigma for target in self.problem.targets])
        return np.asarray((predicted - value) / sigma)

    def jacobian(
        self, z: FloatArray, of: Callable[[FloatArray], FloatArray] | None = None
    ) -> FloatArray:
        """Derivatives of the residuals (or of another function) by z, by central differences.

        Inside the bounds the step goes both ways; at a bound it goes inwards, with the formula of
        the same order.

        Args:
            z: Unit coordinates, shape (free,).
            of: Function of z; the residuals by default.

        Returns:
            Shape (rows, free).
        """
        function = self.residuals if of is None else of
        columns = []
        for place in range(len(z)):
            step = np.zeros(len(z))
            step[place] = STEP
            if STEP <= z[place] <= 1.0 - STEP:
                columns.append((function(z + step) - function(z - step)) / (2.0 * STEP))
                continue
            if z[place] > 0.5:
                step = -step
            first, second = function(z + step), function(z + 2.0 * step)
            columns.append((4.0 * first - second - 3.0 * function(z)) / (2.0 * step[place]))
        return np.array(columns).T

    def _predicted(self, mechanism: Mechanism) -> FloatArray:
        problem = self.problem
        return predict(mechanism, problem.targets, problem.tolerance, problem.rest_rate)


def excesses(limits: Limits, cycle: WorkingCycle) -> FloatArray:
    """How far a working cycle is outside its limits, in sigmas, in the order of :data:`LIMITS`.

    Args:
        limits: The limits.
        cycle: The working cycle.

    Returns:
        Zero inside, shape (4,); of the stop force the worst.
    """
    rows = limit_rows(limits, cycle)
    return np.array([*rows[:3], rows[3:].min()])


def limit_rows(limits: Limits, cycle: WorkingCycle) -> FloatArray:
    """Rows of the residuals for limits.

    The stop force has a row for each of its samples: the least of them alone would have a kink
    wherever another sample becomes the least, and a descent would stick there.

    Args:
        limits: The limits.
        cycle: The working cycle.

    Returns:
        Closing and opening index, opening of the jaw, and the force of every sample, in sigmas
        outside the limits, shape (3 + SAMPLES,).
    """
    rows = np.zeros(3 + SAMPLES)
    for row, (value, bounds) in enumerate(
        (
            (cycle.closing_index, limits.closing_index),
            (cycle.opening_index, limits.opening_index),
        )
    ):
        if bounds is not None:
            rows[row] = _outside(value, *bounds) / INDEX_SIGMA
    if limits.least_opening_deg is not None:
        widest = math.degrees(cycle.waiting.gap.max())
        rows[2] = min(0.0, widest - limits.least_opening_deg) / OPENING_SIGMA_DEG
    if limits.least_stop_force_N is not None:
        short = np.minimum(0.0, cycle.waiting.force - limits.least_stop_force_N)
        rows[3:] = short / FORCE_SIGMA_N
    return rows


def _outside(index: float, low: float, high: float) -> float:
    """Distance of an index from a range, the short way around the turn, with its sign."""
    middle = 0.5 * (low + high)
    away = (index - middle + 20.0) % 40.0 - 20.0
    half = 0.5 * (high - low)
    return float(np.sign(away) * max(0.0, abs(away) - half))

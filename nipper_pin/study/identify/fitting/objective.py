"""Residuals by the values of the free numbers, each in units of its uncertainty."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ....arrays import FloatArray
from ....errors import NipperError
from ....mechanism import Mechanism, changed
from ..problem.problem import Limits, Problem
from ..problem.targets import predict, with_settings
from ..problem.working_cycle import SAMPLES, WorkingCycle, working_cycle
from .limits import limit_rows

UNUSABLE = 1e3
"""Least residual of values that make no machine, or one that cannot be simulated."""


@dataclass(frozen=True)
class Objective:
    """Residuals of a problem as a function of unit coordinates.

    A unit coordinate z runs from 0 at the lower bound of a free number to 1 at the upper one.

    Attributes:
        unusable: Residual of values that make no machine, or one that cannot be simulated: above
            all residuals of a machine that a descent may start from.
        true: Whether the transition of the turn is taken where the machine does not arrive as a
            transition assumes.
    """

    problem: Problem
    unusable: float = UNUSABLE
    true: bool = False

    @property
    def low(self) -> FloatArray:
        """Lower bounds, shape (free,)."""
        return np.array([item.low for item in self.problem.parameters])

    @property
    def width(self) -> FloatArray:
        """Widths of the ranges, shape (free,)."""
        return np.array([item.width for item in self.problem.parameters])

    @property
    def start(self) -> FloatArray:
        """Unit coordinates of the model's own values, shape (free,)."""
        return (np.array([item.start for item in self.problem.parameters]) - self.low) / self.width

    def values(self, z: FloatArray) -> dict[str, float]:
        """Values of the free numbers by path."""
        numbers = self.low + self.width * z
        return {
            item.path: float(x) for item, x in zip(self.problem.parameters, numbers, strict=True)
        }

    def mechanism(self, z: FloatArray) -> Mechanism:
        """Return the mechanism with these values.

        Raises:
            InputError: They make none.
        """
        return changed(self.problem.mechanism, self.values(z))

    def predicted(self, z: FloatArray) -> FloatArray:
        """Values of all targets, shape (targets,).

        Raises:
            NipperError: These values make no machine, or it cannot be simulated.
        """
        return self._predicted(self.mechanism(z))

    def rows(self, z: FloatArray) -> FloatArray:
        """Residuals of targets, limits and prior, shape (rows,).

        Raises:
            NipperError: These values make no machine, or it cannot be simulated.
        """
        problem = self.problem
        mechanism = self.mechanism(z)
        misfit = self.misfit(self._predicted(mechanism))
        broken = np.zeros(0)
        if problem.limits is not None:
            broken = limit_rows(problem.limits, self.cycle(mechanism, problem.limits))
        return np.concatenate([misfit, broken, problem.prior_weight * (z - self.start)])

    def residuals(self, z: FloatArray) -> FloatArray:
        """Residuals as :meth:`rows`; without a machine ``unusable`` for every target."""
        try:
            return self.rows(z)
        except NipperError:
            problem = self.problem
            misfit = np.full(len(problem.targets), self.unusable)
            broken = np.zeros(0 if problem.limits is None else 3 + SAMPLES)
            return np.concatenate([misfit, broken, problem.prior_weight * (z - self.start)])

    def failure(self, z: FloatArray) -> str:
        """Why these values make no machine that can be simulated; empty if they make one."""
        try:
            self.rows(z)
        except NipperError as error:
            return error.message
        return ""

    def fenced(self, rows: FloatArray) -> Objective:
        """Return the same with values that make no machine worse than some residuals.

        Args:
            rows: Residuals of a machine, however far off its data are, shape (rows,).
        """
        return replace(self, unusable=max(UNUSABLE, 10.0 * float(np.abs(rows).max())))

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

    def _predicted(self, mechanism: Mechanism) -> FloatArray:
        problem = self.problem
        return predict(
            mechanism, problem.targets, problem.tolerance, problem.rest_rate, true=self.true
        )

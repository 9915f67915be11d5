"""Tables of a domain: sampled until the series resolve the functions, and checked off the grid.

Negligible coefficients are left out, with bounds on the errors of the remaining series.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...arrays import FloatArray
from ...errors import ConvergenceError
from ...tolerances.mechanics import EPS
from ...tolerances.reduced import REFINEMENT_GAIN, TABLE_ERROR_SAFETY, TRIMMED_SHARE
from ..kernels.layout import Tables as Chart
from . import series2d
from .functions import Samples

CELL_RAD = 0.5
_COUNT_U = 16
_MOST_CELLS = 64
_MOST_X = 40
_CHECKS = 96


class PointSampler(Protocol):
    """Evaluates functions of travel and coordinate at points."""

    def grid(self, u: FloatArray, x: FloatArray) -> FloatArray:
        """Configurations on a grid, shape (U, X, nv)."""

    def at(self, u: FloatArray, x: FloatArray, guess: FloatArray) -> Samples:
        """The functions at points, from configurations near them, shape (N, nv)."""


@dataclass(frozen=True)
class Domain:
    """Travel u in [0, travel] and coordinate x in [low, high].

    Attributes:
        travel: Length of the domain [rad].
        low: Least coordinate.
        high: Largest coordinate.
        begin: Travel from the touch configuration at u = 0 [rad]: 0, or minus the length, so that
            the domain ends in the touch configuration.
        count_x: Nodes in x to start with.
    """

    travel: float
    low: float
    high: float
    begin: float = 0.0
    count_x: int = 12

    def coordinates(self, places: FloatArray) -> FloatArray:
        """Places in [-1, 1] to x."""
        return np.asarray(0.5 * (self.low + self.high) + 0.5 * (self.high - self.low) * places)

    def places(self, x: FloatArray) -> FloatArray:
        """Coordinates x to places in [-1, 1]."""
        return np.asarray((2.0 * x - self.low - self.high) / (self.high - self.low))


@dataclass(frozen=True)
class Tables:
    """Samples of a domain as series.

    Attributes:
        u: Travels of the grid, increasing, shape (U,).
        x: Coordinates of the grid, increasing, shape (X,).
        q: Configurations on the grid, shape (U, X, nv).
        equation: Coefficients, shape (functions, cells, Nu, Nx).
        gaps: Coefficients, shape (other stops, cells, Nu, Nx).
        slopes: Those of their derivatives by x, then by u, shape (2 other stops, cells, Nu, Nx).
        inertia: Coefficients at x = 0, shape (cells, Nu).
    """

    u: FloatArray
    x: FloatArray
    q: FloatArray
    equation: FloatArray
    gaps: FloatArray
    slopes: FloatArray
    inertia: FloatArray


def resolved(
    sampler: PointSampler, domain: Domain, weights: FloatArray, tolerance: float
) -> tuple[Tables, int]:
    """Refine cells and degrees until the tails of all functions are below the tolerance.

    Args:
        weights: Weight of an error of each function, shape (functions,).
        tolerance: Largest weighted tail.

    Returns:
        The tables and the number of points sampled for them and for coarser ones.

    Raises:
        ConvergenceError: The functions are not smooth enough on this domain.
    """
    cells, count_x = max(1, math.ceil(domain.travel / CELL_RAD)), domain.count_x
    sampled = 0
    before = (np.inf, np.inf)
    refined = (False, False)
    while True:
        tables = _sampled(sampler, domain, cells, count_x)
        sampled += cells * _COUNT_U * count_x
        by_u, by_x = series2d.tails(tables.equation, weights)
        floor_u = refined[0] and by_u > REFINEMENT_GAIN * before[0]
        floor_x = refined[1] and by_x > REFINEMENT_GAIN * before[1]
        refine = (by_u > tolerance and not floor_u, by_x > tolerance and not floor_x)
        if not any(refine):
            # Half of the digits at least, where round-off of the samples keeps the others.
            if max(by_u, by_x) > math.sqrt(tolerance):
                break
            return tables, sampled
        before, refined = (by_u, by_x), refine
        cells, count_x = cells * (1 + refine[0]), count_x * (1 + refine[1])
        if cells > _MOST_CELLS or count_x > _MOST_X:
            break
    message = (
        f"the motion is too rough here for its tables (unresolved: {by_u:.2g} along the travel, "
        f"{by_x:.2g} along the gap): a law of a drive bends, or a dead centre is near"
    )
    raise ConvergenceError(
        message, residual=max(by_u, by_x), tolerance=tolerance, iterations=sampled
    )


@dataclass(frozen=True)
class Checks:
    """Functions at random points off the grid.

    Attributes:
        u: Travels, shape (N,).
        x: Coordinates, shape (N,).
        true: The functions there.
        inertia: Inertia at x = 0 for these travels, shape (N,).
    """

    u: FloatArray
    x: FloatArray
    true: Samples
    inertia: FloatArray


def checks(sampler: PointSampler, domain: Domain, tables: Tables) -> Checks:
    """Evaluate the functions at random points off the grid.

    Args:
        tables: The tables, for guesses of the configurations.
    """
    # The points do not depend on the run: a model is built the same way every time.
    random = np.random.default_rng(20)
    u = random.uniform(0.0, domain.travel, _CHECKS)
    x = random.uniform(domain.low, domain.high, _CHECKS)
    # The edges of the domain are where series are worst, and x = 0 is where collisions are.
    u[:4], x[4:8] = (0.0, 0.0, domain.travel, domain.travel), (0.0, 0.0, 0.0, domain.high)
    row = np.minimum(np.searchsorted(tables.u, u), len(tables.u) - 1)
    column = np.minimum(np.searchsorted(tables.x, x), len(tables.x) - 1)
    past = domain.begin + u
    true = sampler.at(past, x, tables.q[row, column])
    at_rest = sampler.at(past, np.zeros_like(u), tables.q[row, np.argmin(np.abs(tables.x))])
    return Checks(u, x, true, at_rest.inertia)


def residuals(
    points: Checks, domain: Domain, equation: FloatArray, inertia: FloatArray
) -> tuple[FloatArray, float]:
    """Bound the errors of the series of an equation of motion from points off the grid.

    Args:
        equation: Coefficients that are kept, shape (functions, cells, Nu, Nx).
        inertia: Coefficients of the inertia that are kept, shape (cells, Nu).

    Returns:
        Bounds on the error of every function, shape (functions,), and the relative one of the
        inertia.
    """
    error = misfit(points, domain, equation, points.true.equation)
    relative = largest_error(points, domain, inertia[None, :, :, None], points.inertia[None], True)
    return error, float(TABLE_ERROR_SAFETY * relative[0] + 4.0 * EPS)


def misfit(points: Checks, domain: Domain, series: FloatArray, true: FloatArray) -> FloatArray:
    """Bound the errors of series from points off the grid.

    Args:
        series: Coefficients, shape (functions, cells, Nu, Nx).
        true: Values at the points, shape (functions, N).

    Returns:
        Bounds on the error of every function, shape (functions,).
    """
    scale = np.abs(true).max(axis=1, initial=0.0)
    error = largest_error(points, domain, series, true)
    return np.asarray(TABLE_ERROR_SAFETY * error + 4.0 * EPS * scale)


def largest_error(
    points: Checks, domain: Domain, series: FloatArray, true: FloatArray, relative: bool = False
) -> FloatArray:
    """Largest error of series at points, absolute or by the true value; as :func:`misfit`."""
    cells = series.shape[1]
    width = domain.travel / cells
    cell = np.minimum((points.u / width).astype(int), cells - 1)
    place = 2.0 * (points.u - cell * width) / width - 1.0
    error = np.zeros(len(series))
    for number in range(cells):
        chosen = cell == number
        if chosen.any():
            x = domain.places(points.x[chosen])
            found = series2d.evaluate(series[:, number], place[chosen], x)
            wrong = np.abs(found - true[:, chosen])
            if relative:
                wrong /= np.abs(true[:, chosen])
            error = np.maximum(error, wrong.max(axis=1))
    return error


def _sampled(sampler: PointSampler, domain: Domain, cells: int, count_x: int) -> Tables:
    width = domain.travel / cells
    inner = 0.5 * width * (series2d.gauss_nodes(_COUNT_U) + 1.0)
    u = (width * np.arange(cells)[:, None] + inner).ravel()
    x = domain.coordinates(series2d.gauss_nodes(count_x))
    past = domain.begin + u
    # Loops are closed from the touch configuration outwards.
    order = slice(None, None, -1 if domain.begin < 0.0 else 1)
    q = sampler.grid(past[order], x)[order]
    flat = q.reshape(len(u) * count_x, -1)
    found = sampler.at(np.repeat(past, count_x), np.tile(x, len(u)), flat)
    shape = (-1, cells, _COUNT_U, count_x)
    inertia = series2d.fit(found.inertia.reshape(shape))[0]
    zero = np.polynomial.chebyshev.chebvander(domain.places(np.zeros(1)), count_x - 1)[0]

    def fitted(values: FloatArray) -> FloatArray:
        return series2d.fit(values.reshape(len(values), *shape[1:]))

    equation, gaps, slopes = map(fitted, (found.equation, found.gaps, found.slopes))
    return Tables(u, x, q, equation, gaps, slopes, np.asarray(inertia @ zero))


def trimmed(
    points: Checks,
    domain: Domain,
    tables: Tables,
    weights: FloatArray,
    tolerance: float,
    least: tuple[int, int] = (2, 2),
) -> Chart:
    """Leave out the highest degrees while their weighted sums stay below a share of the tolerance.

    Args:
        points: The functions at points off the grid, for the errors.
        tables: The tables, resolved.
        weights: Weight of an error of each function, shape (functions,).
        tolerance: Relative accuracy of the tables.
        least: Least orders that are kept, by travel and by x.

    Returns:
        The series as compiled code reads them, without what the machine does at the touch.
    """
    count_u, count_x = series2d.needed(tables.equation, weights, TRIMMED_SHARE * tolerance)
    count_u, count_x = max(count_u, least[0]), max(count_x, least[1])
    equation = np.ascontiguousarray(tables.equation[:, :, :count_u, :count_x])
    inertia = np.ascontiguousarray(tables.inertia[:, :count_u])
    residual, inertia_residual = residuals(points, domain, equation, inertia)
    width = domain.travel / equation.shape[1]
    largest, steep_u, steep_x = series2d.largest(equation)
    return Chart(
        equation=equation,
        gaps=np.ascontiguousarray(tables.gaps[:, :, :count_u, :count_x]),
        inertia=inertia,
        residual=residual,
        inertia_residual=inertia_residual,
        largest=largest,
        steepest_x=2.0 / (domain.high - domain.low) * steep_x,
        steepest_u=2.0 / width * steep_u,
        travel=domain.travel,
        low=domain.low,
        high=domain.high,
    )

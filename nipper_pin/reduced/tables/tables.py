"""Tables of a domain: sampled until the series resolve the functions, and checked off the grid.

Negligible coefficients are left out, with bounds on the errors of the remaining series.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from ...arrays import FloatArray
from ...errors import ConvergenceError
from ...mechanism import Mechanism
from ...tolerances.mechanics import EPS
from ...tolerances.reduced import REFINEMENT_GAIN, TABLE_ERROR_SAFETY, TRIMMED_SHARE
from ..kernels.layout import Charts
from . import series2d
from .functions import Samples

CELL_RAD = 0.5
# Nodes of a cell along u, and in x to start with.
_COUNT_U, _COUNT_X = 16, 8
_MOST_CELLS = 64
_MOST_X = 40
_CHECKS = 96


# Configurations on a grid, shape (U, X, nv), from its travels and coordinates.
Grid = Callable[[FloatArray, FloatArray], FloatArray]
# The functions at points, from travels, coordinates and configurations near them, shape (N, nv).
At = Callable[[FloatArray, FloatArray, FloatArray], Samples]


@dataclass(frozen=True)
class Domain:
    """Travel u in [0, travel] and coordinate x in [low, high].

    Attributes:
        travel: Length of the domain [rad].
        low: Least coordinate.
        high: Largest coordinate.
    """

    travel: float
    low: float
    high: float

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
        series: Coefficients of the rows of ``Samples``, shape (rows, cells, Nu, Nx).
        functions: How many of them are those of the equation of motion.
    """

    u: FloatArray
    x: FloatArray
    q: FloatArray
    series: FloatArray
    functions: int


def resolved(grid: Grid, at: At, domain: Domain, weights: FloatArray, tolerance: float) -> Tables:
    """Refine cells and degrees until the tails of all functions are below the tolerance.

    Args:
        weights: Weight of an error of each of the first rows, as a rule those of the equation.
        tolerance: Largest weighted tail.
    """
    cells, count_x = max(1, math.ceil(domain.travel / CELL_RAD)), _COUNT_X
    sampled, tails, refine = 0, np.full(2, np.inf), np.zeros(2, dtype=bool)
    while cells <= _MOST_CELLS and count_x <= _MOST_X:
        tables = _sampled(grid, at, domain, cells, count_x)
        sampled += cells * _COUNT_U * count_x
        before, tails = tails, series2d.tails(tables.series[: len(weights)], weights)
        # Where the last refinement gained little, round-off of the samples is met.
        refine = (tails > tolerance) & ~(refine & (tails > REFINEMENT_GAIN * before))
        if not refine.any():
            # Half of the digits at least, where round-off keeps the others.
            if tails.max() > math.sqrt(tolerance):
                break
            return tables
        cells, count_x = (int(count) for count in (cells, count_x) * (1 + refine))
    message = (
        f"the motion is too rough here for its tables (unresolved: {tails[0]:.2g} along the "
        f"travel, {tails[1]:.2g} along the gap): a law of a drive bends, or a dead centre is near"
    )
    raise ConvergenceError(
        message, residual=float(tails.max()), tolerance=tolerance, iterations=sampled
    )


def misfit(
    at: At, domain: Domain, tables: Tables, series: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Bound the errors of series from their functions at random points off the grid.

    Args:
        series: Those of the tables, or lower orders of them.

    Returns:
        Bounds on the error of every row, and the least size of its function, shape (rows,) each.
    """
    # The points do not depend on the run: a model is built the same way every time.
    random = np.random.default_rng(20)
    u = random.uniform(0.0, domain.travel, _CHECKS)
    x = random.uniform(domain.low, domain.high, _CHECKS)
    # The edges of the domain are where series are worst, and x = 0 is where collisions are.
    u[:4], x[4:8] = (0.0, 0.0, domain.travel, domain.travel), (0.0, 0.0, 0.0, domain.high)
    row = np.minimum(np.searchsorted(tables.u, u), len(tables.u) - 1)
    column = np.minimum(np.searchsorted(tables.x, x), len(tables.x) - 1)
    true = at(u, x, tables.q[row, column]).rows
    _, cells, count_u, count_x = series.shape
    along = cells / domain.travel * u
    cell = np.minimum(along.astype(int), cells - 1)
    by_u = chebyshev.chebvander(2.0 * (along - cell) - 1.0, count_u - 1)
    by_x = chebyshev.chebvander(domain.places(x), count_x - 1)
    found = np.einsum("fnij,ni,nj->fn", series[:, cell], by_u, by_x)
    error, size = np.abs(found - true).max(axis=1), np.abs(true)
    return TABLE_ERROR_SAFETY * error + 4.0 * EPS * size.max(axis=1), size.min(axis=1)


def _sampled(grid: Grid, at: At, domain: Domain, cells: int, count_x: int) -> Tables:
    width = domain.travel / cells
    inner = 0.5 * width * (series2d.gauss_nodes(_COUNT_U) + 1.0)
    u = (width * np.arange(cells)[:, None] + inner).ravel()
    x = domain.low + 0.5 * (domain.high - domain.low) * (series2d.gauss_nodes(count_x) + 1.0)
    q = grid(u, x)
    found = at(np.repeat(u, count_x), np.tile(x, len(u)), q.reshape(len(u) * count_x, -1))
    values = found.rows.reshape(-1, cells, _COUNT_U, count_x)
    return Tables(u, x, q, series2d.fit(values), len(found.equation))


@dataclass(frozen=True, eq=False, kw_only=True)
class Chart:
    """Series of a domain as they are kept: one chart of a machine.

    Attributes:
        series: Coefficients of the rows of ``Samples``, shape (rows, cells, Nu, Nx).
        functions: How many of them are those of the equation of motion.
        bounds: Bounds on the errors of the rows, then their largest derivatives by x and by u, and
            their largest values, shape (4, rows).
        inertia_error: Bound on the relative error of the inertia.
        stop: Place of its stop among those of the mechanism.
        after: Number of the chart that follows where it ends.
        begin: Travel from the start of the turn to its begin [rad].
        meets: Derivative by u of the gap of the stop that takes over at the end, bound on its
            error, rate of x by that of its gap, and bound on the error of the end [rad]; zeros if
            it is the same stop.
    """

    domain: Domain
    series: FloatArray
    functions: int
    bounds: FloatArray
    inertia_error: float
    stop: int = 0
    after: int = 0
    begin: float = 0.0
    meets: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)


def chart_over(
    grid: Grid,
    at: At,
    domain: Domain,
    weights: FloatArray,
    tolerance: float,
    of_gaps: float = math.inf,
) -> Chart:
    """Sample a domain, and leave out the highest degrees that hardly matter.

    Args:
        weights: Weight of an error of each of the first rows, as a rule those of the equation.
        tolerance: Largest weighted tail; what is left out stays below a share of it.
        of_gaps: Relative accuracy that the gaps of other stops and their slopes keep.

    Raises:
        ConvergenceError: The functions are not smooth enough on this domain.
    """
    tables = resolved(grid, at, domain, weights, tolerance)
    size = np.abs(tables.series).sum(axis=(2, 3)).max(axis=1)
    kept = 1.0 / (of_gaps * np.where(size > 0.0, size, 1.0))
    # The orders of the others do for the inertia.
    kept[: len(weights)], kept[-1] = weights / (TRIMMED_SHARE * tolerance), 0.0
    count_u, count_x = series2d.needed(tables.series, kept, 1.0)
    series = tables.series[:, :, :count_u, :count_x]
    wrong, least = misfit(at, domain, tables, series)
    largest, steep_u, steep_x = series2d.largest(series)
    steep_u *= 2.0 * series.shape[1] / domain.travel
    steep_x *= 2.0 / (domain.high - domain.low)
    return Chart(
        domain=domain,
        series=series,
        functions=tables.functions,
        bounds=np.array([wrong, steep_x, steep_u, largest]),
        inertia_error=float(wrong[-1] / least[-1]),
    )


def stacked(mechanism: Mechanism, charts: list[Chart]) -> Charts:
    """All charts of a mechanism as arrays of one shape, padded by zeros."""
    lever, functions = np.array([stop.lever for stop in mechanism.stops]), charts[0].functions
    series = np.zeros((len(charts), *np.max([chart.series.shape for chart in charts], axis=0)))
    numbers, stops = [], []
    for number, chart in enumerate(charts):
        _, c, i, j = chart.series.shape
        series[number, :, :c, :i, :j] = chart.series
        # By round-off a place at the end may lie beyond it: there the functions are constant.
        series[number, :, c:, 0, :j] = chart.series[:, -1:].sum(axis=2)
        travel, low, high = chart.domain.travel, chart.domain.low, chart.domain.high
        numbers.append((travel, low, high, 2.0 / (high - low), c / travel, chart.begin,
                        *chart.meets, chart.inertia_error))  # fmt: skip
        others = [place for place in range(len(lever)) if place != chart.stop]
        stops.append((chart.stop, chart.after, *others))
    closed = np.concatenate([chart.domain.places(np.zeros(1)) for chart in charts])
    at_zero = chebyshev.chebvander(closed, series.shape[-1] - 1)
    along = np.einsum("cfnij,cj->cfni", series, at_zero)
    equation, gaps, _ = np.split(series, [functions, -1], axis=1)
    bounds = np.array([chart.bounds for chart in charts])
    ends = slice(functions + len(lever) - 1, functions + gaps.shape[1] // 3)
    return Charts(
        equation=np.ascontiguousarray(np.moveaxis(equation, 1, 3)),
        along=np.ascontiguousarray(np.swapaxes(along[:, :functions], 1, 2)),
        gaps=np.ascontiguousarray(gaps),
        inertia=np.ascontiguousarray(along[:, -1]),
        bounds=np.ascontiguousarray(np.swapaxes(bounds[:, :, :functions], 1, 2)),
        gap_bounds=np.ascontiguousarray(bounds[:, 0, functions:-1]),
        numbers=np.array(numbers),
        beyond=-along[:, ends],
        stops=np.array(stops, dtype=np.int64),
        lever=lever,
    )

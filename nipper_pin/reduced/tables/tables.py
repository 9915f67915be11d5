"""Tables of a domain: sampled until the series resolve the functions, and checked off the grid.

Negligible coefficients are left out, with bounds on the errors of the remaining series.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
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
_COUNT_U = 16
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
        count_x: Nodes in x to start with.
    """

    travel: float
    low: float
    high: float
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
        gaps: Coefficients of the gaps and their derivatives, shape (3 S, cells, Nu, Nx).
        inertia: Coefficients at x = 0, shape (cells, Nu).
    """

    u: FloatArray
    x: FloatArray
    q: FloatArray
    equation: FloatArray
    gaps: FloatArray
    inertia: FloatArray


def resolved(grid: Grid, at: At, domain: Domain, weights: FloatArray, tolerance: float) -> Tables:
    """Refine cells and degrees until the tails of all functions are below the tolerance.

    Args:
        weights: Weight of an error of each function, shape (functions,).
        tolerance: Largest weighted tail.
    """
    cells, count_x = max(1, math.ceil(domain.travel / CELL_RAD)), domain.count_x
    sampled = 0
    before = (np.inf, np.inf)
    refined = (False, False)
    while True:
        tables = _sampled(grid, at, domain, cells, count_x)
        sampled += cells * _COUNT_U * count_x
        by_u, by_x = series2d.tails(tables.equation, weights)
        floor_u = refined[0] and by_u > REFINEMENT_GAIN * before[0]
        floor_x = refined[1] and by_x > REFINEMENT_GAIN * before[1]
        refine = (by_u > tolerance and not floor_u, by_x > tolerance and not floor_x)
        if not any(refine):
            # Half of the digits at least, where round-off of the samples keeps the others.
            if max(by_u, by_x) > math.sqrt(tolerance):
                break
            return tables
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
    """Functions at random points of a domain, off the grid.

    Attributes:
        u: Travels, shape (N,).
        x: Coordinates, shape (N,).
        true: The functions there.
        inertia: Inertia at x = 0 for these travels, shape (N,).
    """

    domain: Domain
    u: FloatArray
    x: FloatArray
    true: Samples
    inertia: FloatArray

    def misfit(self, series: FloatArray, true: FloatArray) -> FloatArray:
        """Bound the errors of series from points off the grid.

        Args:
            series: Coefficients, shape (functions, cells, Nu, Nx).
            true: Values at the points, shape (functions, N).

        Returns:
            Bounds on the error of every function, shape (functions,).
        """
        scale = np.abs(true).max(axis=1, initial=0.0)
        error = np.abs(self.values(series) - true).max(axis=1)
        return np.asarray(TABLE_ERROR_SAFETY * error + 4.0 * EPS * scale)

    def values(self, series: FloatArray) -> FloatArray:
        """Values of series at the points, shape (functions, N)."""
        cells = series.shape[1]
        width = self.domain.travel / cells
        cell = np.minimum((self.u / width).astype(int), cells - 1)
        place = 2.0 * (self.u - cell * width) / width - 1.0
        found, x = np.empty((len(series), len(cell))), self.domain.places(self.x)
        for number in range(cells):
            here = cell == number
            of_cell = np.moveaxis(series[:, number], 0, -1)
            found[:, here] = chebyshev.chebval2d(place[here], x[here], of_cell)
        return found


def checks(at: At, domain: Domain, tables: Tables) -> Checks:
    """Evaluate the functions at random points off the grid of the tables."""
    # The points do not depend on the run: a model is built the same way every time.
    random = np.random.default_rng(20)
    u = random.uniform(0.0, domain.travel, _CHECKS)
    x = random.uniform(domain.low, domain.high, _CHECKS)
    # The edges of the domain are where series are worst, and x = 0 is where collisions are.
    u[:4], x[4:8] = (0.0, 0.0, domain.travel, domain.travel), (0.0, 0.0, 0.0, domain.high)
    row = np.minimum(np.searchsorted(tables.u, u), len(tables.u) - 1)
    column = np.minimum(np.searchsorted(tables.x, x), len(tables.x) - 1)
    true = at(u, x, tables.q[row, column])
    at_rest = at(u, np.zeros_like(u), tables.q[row, np.argmin(np.abs(tables.x))])
    return Checks(domain, u, x, true, at_rest.inertia)


def _sampled(grid: Grid, at: At, domain: Domain, cells: int, count_x: int) -> Tables:
    width = domain.travel / cells
    inner = 0.5 * width * (series2d.gauss_nodes(_COUNT_U) + 1.0)
    u = (width * np.arange(cells)[:, None] + inner).ravel()
    x = domain.coordinates(series2d.gauss_nodes(count_x))
    q = grid(u, x)
    flat = q.reshape(len(u) * count_x, -1)
    found = at(np.repeat(u, count_x), np.tile(x, len(u)), flat)
    shape = (-1, cells, _COUNT_U, count_x)
    inertia = series2d.fit(found.inertia.reshape(shape))[0]
    zero = chebyshev.chebvander(domain.places(np.zeros(1)), count_x - 1)[0]

    def fitted(values: FloatArray) -> FloatArray:
        return series2d.fit(values.reshape(len(values), *shape[1:]))

    return Tables(u, x, q, fitted(found.equation), fitted(found.gaps), np.asarray(inertia @ zero))


@dataclass(frozen=True, eq=False, kw_only=True)
class Chart:
    """Series of a domain as they are kept: one chart of a machine.

    Attributes:
        equation: Coefficients, shape (functions, cells, Nu, Nx).
        gaps: Those of the gaps as of ``Samples``, shape (3 S, cells, Nu, Nx).
        inertia: Those of the inertia at x = 0, shape (cells, Nu).
        bounds: Bounds on the errors of the functions, then their largest derivatives by x and by u,
            and their largest values, shape (4, functions).
        gap_bounds: Bounds on the errors of the gaps and their derivatives, shape (3 S,).
        inertia_error: Bound on the relative error of the inertia.
        stop: Place of its stop among those of the mechanism.
        after: Number of the chart that follows where it ends.
        begin: Travel from the start of the turn to its begin [rad].
        meets: Derivative by u of the gap of the stop that takes over at the end, bound on its
            error, rate of x by that of its gap, and bound on the error of the end [rad]; zeros if
            it is the same stop.
    """

    domain: Domain
    equation: FloatArray
    gaps: FloatArray
    inertia: FloatArray
    bounds: FloatArray
    gap_bounds: FloatArray
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
        weights: Weight of an error of each function, shape (functions,).
        tolerance: Largest weighted tail; what is left out stays below a share of it.
        of_gaps: Relative accuracy that the gaps of other stops and their slopes keep.

    Raises:
        ConvergenceError: The functions are not smooth enough on this domain.
    """
    tables = resolved(grid, at, domain, weights, tolerance)
    points = checks(at, domain, tables)
    orders = [series2d.needed(tables.equation, weights, TRIMMED_SHARE * tolerance)]
    orders += _orders_of_gaps(tables, of_gaps)
    count_u, count_x = map(max, zip(*orders, strict=True))
    equation = tables.equation[:, :, :count_u, :count_x]
    inertia = tables.inertia[:, :count_u]
    gaps = tables.gaps[:, :, :count_u, :count_x]
    residual = points.misfit(equation, points.true.equation)
    (found,) = points.values(inertia[None, :, :, None])
    relative = (np.abs(found - points.inertia) / np.abs(points.inertia)).max()
    width = domain.travel / equation.shape[1]
    largest, steep_u, steep_x = series2d.largest(equation)
    steep_u, steep_x = 2.0 / width * steep_u, 2.0 / (domain.high - domain.low) * steep_x
    return Chart(
        domain=domain,
        equation=equation,
        gaps=gaps,
        inertia=inertia,
        bounds=np.array([residual, steep_x, steep_u, largest]),
        gap_bounds=points.misfit(gaps, points.true.gaps),
        inertia_error=float(TABLE_ERROR_SAFETY * relative + 4.0 * EPS),
    )


def _orders_of_gaps(tables: Tables, share: float) -> Iterator[tuple[int, int]]:
    """Orders (Nu, Nx) that resolve the gaps and their slopes to a share of their sizes."""
    others = len(tables.gaps) // 3
    for series in (tables.gaps[:others], tables.gaps[others:]):
        size = np.abs(series).sum(axis=(2, 3)).max(axis=1, initial=0.0)
        weights = np.where(size > 0.0, 1.0 / np.where(size > 0.0, size, 1.0), 0.0)
        if len(series):
            yield series2d.needed(series, weights, share)


def stacked(mechanism: Mechanism, charts: list[Chart]) -> Charts:
    """All charts of a mechanism as arrays of one shape, padded by zeros."""
    lever = np.array([stop.lever for stop in mechanism.stops])
    shapes = np.array([chart.equation.shape[1:] for chart in charts])
    cells, count_u, count_x = (int(size) for size in shapes.max(axis=0))

    def padded(arrays: list[FloatArray]) -> FloatArray:
        found = np.zeros((len(arrays), len(arrays[0]), cells, count_u, count_x))
        for number, array in enumerate(arrays):
            f, c, i, j = array.shape
            found[number, :f, :c, :i, :j] = array
            # By round-off a place at the end may lie beyond it: there the functions are constant.
            found[number, :f, c:, 0, :j] = array[:, -1:].sum(axis=2)
        return found

    inertia = padded([chart.inertia[None, :, :, None] for chart in charts])[:, 0, :, :, 0]
    numbers, stops = [], []
    for chart in charts:
        travel, low, high = chart.domain.travel, chart.domain.low, chart.domain.high
        per_rad = chart.equation.shape[1] / travel
        numbers.append((travel, low, high, 2.0 / (high - low), per_rad, chart.begin,
                        *chart.meets, chart.inertia_error))  # fmt: skip
        others = [place for place in range(len(lever)) if place != chart.stop]
        stops.append((chart.stop, chart.after, *others))
    equation = padded([chart.equation for chart in charts])
    gaps = padded([chart.gaps for chart in charts])
    closed = np.concatenate([chart.domain.places(np.zeros(1)) for chart in charts])
    at_zero = chebyshev.chebvander(closed, count_x - 1)

    def along(functions: FloatArray, order: str) -> FloatArray:
        return np.asarray(np.einsum(f"cfnij,cj->{order}", functions, at_zero, order="C"))

    return Charts(
        equation=np.ascontiguousarray(np.moveaxis(equation, 1, 3)),
        along=along(equation, "cnfi"),
        gaps=gaps,
        inertia=np.ascontiguousarray(inertia),
        bounds=np.array([chart.bounds.T for chart in charts], order="C"),
        gap_bounds=np.array([chart.gap_bounds for chart in charts]),
        numbers=np.array(numbers),
        beyond=-along(gaps[:, len(lever) - 1 : gaps.shape[1] // 3], "cfni"),
        stops=np.array(stops, dtype=np.int64),
        lever=lever,
    )

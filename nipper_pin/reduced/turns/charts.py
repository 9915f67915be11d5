"""Charts of a turn: the functions around each stretch along which a stop can be closed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...errors import SimulationError
from ...hybrid.error_estimate.local_error import of_rates
from ...mechanism import Mechanism
from ...tolerances.reduced import CORNER_ROUND_OFF, GAP_SHARE
from ..kernels.layout import Tables as Series
from ..kernels.turn_layout import Charts
from ..model import MARGIN, factors
from ..tables.series2d import needed
from ..tables.tables import Domain, Tables, checks, misfit, resolved, trimmed
from .arcs import TURN, Arc, sampler_at, system_at
from .rows import on_rows

_PLACES = 9
_NODES_X = 8
# Travel over which the change of a rate is taken [rad].
_BESIDE = 1e-3
# Halvings of the gap of a chart that reaches a dead centre.
_HALVINGS = 4


@dataclass(frozen=True, eq=False)
class Chart:
    """Tables around one arc.

    Attributes:
        domain: Travels and gaps of the tables.
        kept: The series of the equation of motion, trimmed.
        slopes: Series of the derivatives of the other gaps, trimmed likewise.
        gap_residual: Bounds on the errors of the gaps, shape (S,).
        slope_residual: Bounds on the errors of the slopes, shape (2 S,).
        samples: Points that were sampled.
        on_rows: Largest gaps up to which springs are on the rows of their tables, by equal parts of
            the travel, shape (parts,).
        meets: Derivative by u of the gap of the stop that takes over at the end, bound on its
            error, rate of x by that of its gap, and bound on the error of the end [rad]; zeros if
            it is the same stop.
    """

    arc: Arc
    domain: Domain
    kept: Series
    slopes: FloatArray
    gap_residual: FloatArray
    slope_residual: FloatArray
    samples: int
    on_rows: FloatArray
    meets: tuple[float, float, float, float]


class Surroundings:
    """What is known of an arc before its tables: its functions along the closed stop.

    Args:
        mechanism: The mechanism.
        arc: The arc.
        start_angle: Cylinder angle at which turns start [rad].
    """

    def __init__(self, mechanism: Mechanism, arc: Arc, start_angle: float) -> None:
        """Sample a few places along the stop."""
        self.mechanism, self.arc = mechanism, arc
        self.system = system_at(mechanism, arc.begin, start_angle)
        self.sampler = sampler_at(self.system, arc.stop, arc.path[0], (arc.travels, arc.path))
        places = np.unique(np.linspace(0, len(arc.travels) - 1, _PLACES).astype(int))
        u = arc.travels[places]
        self.along = self.sampler.at(u, np.zeros_like(u), arc.path[places])

    def meets(self) -> tuple[float, float, float, float]:
        """As of :class:`Chart`."""
        arc = self.arc
        if arc.after.name == arc.stop.name:
            return 0.0, 0.0, 0.0, 0.0
        end = arc.travels[-1:]
        n, m = self.sampler.rates(end, arc.path[-1:])
        rounded = of_rates(
            self.system, frozenset({arc.stop.name}), float(end[0]), arc.path[-1], m[0]
        )
        rate = arc.after.rate(m[0])
        kind = next(j.kind for j in self.mechanism.joints if j.index == arc.after.index)
        extent = 1.0 if kind == "revolute" else self.mechanism.reach_m
        wrong = CORNER_ROUND_OFF * (TURN + extent / abs(rate))
        size = rounded.size(self.sampler.size + arc.after.index) + self._bend(rate) * wrong
        return rate, size, 1.0 / arc.after.rate(n[0]), wrong

    def _bend(self, rate: float) -> float:
        """Bound on the change of the rate of the gap ahead in a radian, near the end of the arc."""
        arc = self.arc
        before = arc.travels[-1:] - min(_BESIDE, 0.5 * arc.travels[-1])
        (row,) = self.sampler.along(before, np.zeros(1), arc.path[-1:])
        _, m = self.sampler.rates(before, row)
        change = rate - arc.after.rate(m[0])
        return float(abs(rate) + 2.0 * abs(change / (arc.travels[-1] - before[0])))

    @property
    def width(self) -> float:
        """Largest gap of the nearest other stop along the arc."""
        gaps = self.along.gaps.min(axis=0, initial=np.inf)
        return float(gaps.max()) if np.isfinite(gaps).all() else 0.0

    @property
    def room(self) -> float:
        """Largest gap of the arc's own stop at which the nearest other one may close."""
        gaps = self.along.gaps
        slopes = np.abs(self.along.slopes[: len(gaps)])
        rooms = np.where(slopes > 0.0, gaps / np.where(slopes > 0.0, slopes, 1.0), np.inf)
        room = float(rooms.min(axis=0, initial=np.inf).max())
        return room if math.isfinite(room) else 0.0

    def acceleration(self, w: float, place: int) -> tuple[float, FloatArray]:
        """X'' at a place on the stop with a rate w, and its terms, at a lively speed."""
        terms = factors(self.mechanism, len(self.along.equation), w) * self.along.equation[:, place]
        return float(terms.sum()), terms

    def weights(self, w: float) -> FloatArray:
        """Weights of the functions in x'' by the size of x'', at rates up to w."""
        weights = factors(self.mechanism, len(self.along.equation), w)
        size = float((np.abs(weights[:, None] * self.along.equation)).sum(axis=0).mean())
        return np.abs(weights) / (size if size > 0.0 else 1.0)


def chart_of(around: Surroundings, gap: float, w: float, tolerance: float) -> Chart:
    """Sample the tables of one arc.

    Args:
        around: The arc.
        gap: Largest x.
        w: Rates of x up to this are usual.
        tolerance: Relative accuracy of the tables.

    Raises:
        ConvergenceError: The functions are not smooth enough around it.
        SimulationError: A point cannot be reached.
    """
    for _ in range(_HALVINGS):
        try:
            return _sampled(around, gap, w, tolerance)
        except SimulationError:
            gap *= 0.5
    return _sampled(around, gap, w, tolerance)


def _sampled(around: Surroundings, gap: float, w: float, tolerance: float) -> Chart:
    arc, sampler = around.arc, around.sampler
    domain = Domain(float(arc.travels[-1]), -MARGIN * gap, gap, count_x=_NODES_X)
    weights = around.weights(w)
    tables, samples = resolved(sampler, domain, weights, tolerance)
    points = checks(sampler, domain, tables)
    kept = trimmed(points, domain, tables, weights, tolerance, _least(tables))
    count_u, count_x = kept.equation.shape[2:]
    slopes = np.ascontiguousarray(tables.slopes[:, :, :count_u, :count_x])
    return Chart(
        arc,
        domain,
        kept,
        slopes,
        misfit(points, domain, kept.gaps, points.true.gaps),
        misfit(points, domain, slopes, points.true.slopes),
        samples,
        on_rows(around.mechanism, domain, tables),
        around.meets(),
    )


def _least(tables: Tables) -> tuple[int, int]:
    """Orders that resolve the gaps and their slopes to round-off."""
    found = [(2, 2)]
    for series in (tables.gaps, tables.slopes):
        size = np.abs(series).sum(axis=(2, 3)).max(axis=1, initial=0.0)
        weights = np.where(size > 0.0, 1.0 / np.where(size > 0.0, size, 1.0), 0.0)
        if len(series):
            found.append(needed(series, weights, GAP_SHARE))
    by_u, by_x = zip(*found, strict=True)
    return max(by_u), max(by_x)


def stacked(mechanism: Mechanism, charts: list[Chart], after: list[int]) -> Charts:
    """All charts as arrays of one shape, padded by zeros.

    Args:
        after: Number of the chart that follows each.
    """
    names = [stop.name for stop in mechanism.stops]
    shapes = np.array([chart.kept.equation.shape[1:] for chart in charts])
    cells, count_u, count_x = (int(size) for size in shapes.max(axis=0))

    def padded(arrays: list[FloatArray]) -> FloatArray:
        found = np.zeros((len(arrays), len(arrays[0]), cells, count_u, count_x))
        for number, array in enumerate(arrays):
            f, c, i, j = array.shape
            found[number, :f, :c, :i, :j] = array
            # By round-off a place at the end may lie beyond it: there the functions are constant.
            found[number, :f, c:, 0, :j] = array[:, -1:].sum(axis=2)
        return found

    inertia = np.zeros((len(charts), cells, count_u))
    for number, chart in enumerate(charts):
        c, i = chart.kept.inertia.shape
        inertia[number, :c, :i] = chart.kept.inertia
        inertia[number, c:, 0] = chart.kept.inertia[-1].sum()
    travel = np.array([chart.domain.travel for chart in charts])
    stops = [names.index(chart.arc.stop.name) for chart in charts]
    meets = np.array([chart.meets for chart in charts])
    limits = [chart.on_rows for chart in charts]
    parts = max(len(rows) for rows in limits)
    return Charts(
        equation=padded([chart.kept.equation for chart in charts]),
        gaps=padded([chart.kept.gaps for chart in charts]),
        slopes=padded([chart.slopes for chart in charts]),
        inertia=inertia,
        residual=np.array([chart.kept.residual for chart in charts]),
        largest=np.array([chart.kept.largest for chart in charts]),
        steepest_x=np.array([chart.kept.steepest_x for chart in charts]),
        steepest_u=np.array([chart.kept.steepest_u for chart in charts]),
        inertia_residual=np.array([chart.kept.inertia_residual for chart in charts]),
        gap_residual=np.array([chart.gap_residual for chart in charts]),
        slope_residual=np.array([chart.slope_residual for chart in charts]),
        travel=travel,
        span=travel / shapes[:, 0] * cells,
        low=np.array([chart.domain.low for chart in charts]),
        high=np.array([chart.domain.high for chart in charts]),
        on_rows=np.array([np.pad(rows, (0, parts - len(rows)), "edge") if parts else rows
                          for rows in limits]),
        begin=np.array([chart.arc.begin for chart in charts]),
        stop=np.array(stops, dtype=np.int64),
        others=np.array([[k for k in range(len(names)) if k != stop] for stop in stops],
                        dtype=np.int64),
        after=np.array(after, dtype=np.int64),
        arrive=meets[:, 0].copy(),
        arrive_residual=meets[:, 1].copy(),
        throw=meets[:, 2].copy(),
        corner_error=meets[:, 3].copy(),
        lever=np.array([stop.lever for stop in mechanism.stops]),
    )  # fmt: skip

"""Charts of a turn: the functions around each stretch along which a stop can be closed."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property

import numpy as np

from ...arrays import FloatArray
from ...errors import SimulationError
from ...hybrid import State
from ...hybrid.error_estimate.local_error import of_rates
from ...mechanism import Mechanism
from ...tolerances.reduced import CORNER_ROUND_OFF, NO_ACCELERATION
from ..model import BY_SPRINGS, MARGIN, ROOM, factors
from ..tables.functions import Sampler
from ..tables.tables import Chart, Domain, chart_over
from .arcs import TURN, ContactArc, system_at

_PLACES = 9
# Least assumed share of a spring's preload in x''.
_LEAST_SHARE = 0.01
# Travel over which the change of a rate is taken [rad].
_BESIDE = 1e-3
# Halvings of the gap of a chart that reaches a dead centre.
_HALVINGS = 4


class ChartSampler:
    """What is known of an arc before its tables: its functions along the closed stop.

    Args:
        start_angle: Cylinder angle at which turns start [rad].
        after: Number of the arc that follows.
    """

    def __init__(
        self, mechanism: Mechanism, arc: ContactArc, start_angle: float, after: int
    ) -> None:
        """Sample a few places along the stop."""
        self.mechanism, self.arc, self.after = mechanism, arc, after
        self.system = system_at(mechanism, arc.begin, start_angle)
        self.sampler = Sampler(self.system, arc.stop, arc.path[0])
        places = np.unique(np.linspace(0, len(arc.travels) - 1, _PLACES).astype(int))
        self.places = arc.travels[places], np.zeros(len(places)), arc.path[places]
        self.along = self.sampler.at(*self.places)

    @cached_property
    def meets(self) -> tuple[float, float, float, float]:
        """As of :class:`Chart`."""
        arc, end, q = self.arc, float(self.arc.travels[-1]), self.arc.path[-1]
        if arc.after.name == arc.stop.name:
            return 0.0, 0.0, 0.0, 0.0
        (n,), (m,) = self.sampler.rates(np.array([end]), q[None])
        rounded = of_rates(
            self.system, State.at(self.system, end, q, m, frozenset({arc.stop.name}))
        )
        rate = arc.after.rate(m)
        kind = self.mechanism.joints[arc.after.index].kind
        extent = 1.0 if kind == "revolute" else self.mechanism.reach_m
        wrong = CORNER_ROUND_OFF * (TURN + extent / abs(rate))
        # Bound on the change of the rate in a radian, from that a little before the end.
        beside = min(_BESIDE, 0.5 * end)
        change = rate - arc.after.rate(self.sampler.closed(end - beside, q)[1])
        bend = abs(rate) + 2.0 * abs(change) / beside
        size = rounded.size(len(m) + arc.after.index) + bend * wrong
        return rate, size, 1.0 / arc.after.rate(n), wrong

    def placed(self, chart: Chart) -> Chart:
        """A chart around the arc, with its place in the turn."""
        return replace(
            chart,
            stop=self.mechanism.stops.index(self.arc.stop),
            after=self.after,
            begin=self.arc.begin,
            meets=self.meets,
        )

    @property
    def room(self) -> float:
        """Largest gap of the arc's own stop at which the nearest other one may close."""
        gaps = self.along.gaps.reshape(3, -1, len(self.places[0]))
        gaps, slopes, _ = np.abs(gaps[:, : len(self.mechanism.stops) - 1])
        rooms = np.where(slopes > 0.0, gaps / np.where(slopes > 0.0, slopes, 1.0), np.inf)
        room = float(rooms.min(axis=0, initial=np.inf).max())
        return room if math.isfinite(room) else 0.0

    def terms(self, w: float) -> FloatArray:
        """Terms of x'' at the begin of the arc with a rate w, at a lively speed."""
        weights = factors(self.mechanism, len(self.along.equation), w)
        return weights * self.along.equation[:, 0]

    def rebound(self, w: float) -> float:
        """Gap of a rebound at the begin with a rate w, and room; 0 where nothing presses."""
        a = float(self.terms(w).sum())
        return ROOM * 0.5 * w * w / -a if a < 0.0 else 0.0

    def weights(self, w: float) -> FloatArray:
        """Weights of the functions in x'' by the size of x'', at rates up to w."""
        functions = self.along.equation
        weights = shares(factors(self.mechanism, len(functions), w), functions)
        # A spring that is slack in the file may be preloaded in a case.
        for place in range(BY_SPRINGS, BY_SPRINGS + 2 * len(self.mechanism.springs), 2):
            unit = float(np.abs(functions[place]).mean())
            if unit > 0.0:
                weights[place] = max(weights[place], _LEAST_SHARE / unit)
        return weights

    def over(self, domain: Domain, w: float, tolerance: float, of_gaps: float = math.inf) -> Chart:
        """Sample the tables of a domain.

        Args:
            w: Rates of x up to this are usual.
            of_gaps: Relative accuracy of the gaps of other stops.
        """
        grid, at = self.sampler.grid, self.sampler.at
        return self.placed(chart_over(grid, at, domain, self.weights(w), tolerance, of_gaps))


def shares(weights: FloatArray, functions: FloatArray) -> FloatArray:
    """Weights of functions by the mean size of the sum of all, from their values at places."""
    size = float(np.abs(weights[:, None] * functions).sum(axis=0).mean())
    # Without acceleration the scale is arbitrary.
    return np.abs(weights) / (size if size > NO_ACCELERATION else 1.0)


def chart_of(
    around: ChartSampler, gap: float, w: float, tolerance: float, of_gaps: float,
    halvings: int = _HALVINGS,
) -> Chart:  # fmt: skip
    """Sample the tables of one arc, up to a gap or a part of it that can be reached."""
    domain = Domain(float(around.arc.travels[-1]), -MARGIN * gap, gap)
    try:
        return around.over(domain, w, tolerance, of_gaps)
    except SimulationError:
        if not halvings:
            raise
    return chart_of(around, 0.5 * gap, w, tolerance, of_gaps, halvings - 1)

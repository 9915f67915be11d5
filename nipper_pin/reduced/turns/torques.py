"""Torques of the drives around the stretches of a turn, as series of travel and gap.

T = T0 w^2 + T1 w x' + T2 x'^2 + Tg g / g0 + sum_k k (T_k p + T_ks) + Ta x'': the functions have the
places of those of the equation of motion, and Ta has that of the gap of another stop. They are
sampled on the charts of the turns, and only where torques are asked for.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from weakref import WeakKeyDictionary

import numpy as np

from ...arrays import FloatArray
from ...mechanism import Mechanism
from ..kernels.turn_layout import Charts
from ..tables.functions import Samples
from ..tables.tables import Domain, checks, resolved
from ..tables.trimmed import trimmed
from .charts import Chart, Surroundings, stacked
from .model import TurnModel, surroundings

# Nodes across the gap to start with.
_NODES_X = 8
_KNOWN: WeakKeyDictionary[Mechanism, dict[tuple[float, float], TorqueModel]] = WeakKeyDictionary()


@dataclass(frozen=True, kw_only=True)
class TorqueModel:
    """Torques of all drives of one mechanism.

    Attributes:
        drives: Names of the drives.
        charts: The functions: those of chart c and drive d have the place c drives + d.
    """

    drives: tuple[str, ...]
    charts: Charts = field(repr=False, compare=False)


@dataclass(frozen=True, eq=False)
class _DriveSampler:
    """The torque of one drive, sampled like an equation of motion.

    Attributes:
        around: The arc.
        drive: Place of the drive.
    """

    around: Surroundings
    drive: int

    def grid(self, u: FloatArray, x: FloatArray) -> FloatArray:
        """As of the sampler of the arc."""
        return self.around.sampler.grid(u, x)

    def at(self, u: FloatArray, x: FloatArray, guess: FloatArray) -> Samples:
        """The functions of the torque, in the place of those of the equation of motion."""
        found = self.around.sampler.torques(u, x, guess)[self.drive]
        none = np.empty((0, len(u)))
        return Samples(guess, found, none, none, np.ones(len(u)))


def torque_model(mechanism: Mechanism, turns: TurnModel, room: float = 1.0) -> TorqueModel:
    """Return the torques of a mechanism's drives on the charts of its turns, sampled once.

    Args:
        room: Factor on the gaps that its tables cover.

    Raises:
        ConvergenceError: The functions are not smooth enough on a chart.
        SimulationError: A point of the turn cannot be reached or is singular.
    """
    known = _KNOWN.setdefault(mechanism, {})
    key = turns.start_index, room
    if key not in known:
        known[key] = build_torques(mechanism, turns)
    return known[key]


def build_torques(
    mechanism: Mechanism, turns: TurnModel, *, tolerance: float = 1e-11
) -> TorqueModel:
    """Sample the torques; arguments and errors as of :func:`torque_model`.

    Args:
        tolerance: Accuracy of the tables, by the size of a torque.
    """
    around, _, _ = surroundings(mechanism, turns.start_index)
    charts = turns.charts
    found = []
    for number, item in enumerate(around):
        low, high = float(charts.low[number]), float(charts.high[number])
        domain = Domain(float(item.arc.travels[-1]), low, high, count_x=_NODES_X)
        for drive in range(len(mechanism.drives)):
            found.append(_chart(item, drive, domain, tolerance))
    return TorqueModel(
        drives=tuple(item.name for item in mechanism.drives),
        charts=stacked(mechanism, found, [0] * len(found)),
    )


def _chart(around: Surroundings, drive: int, domain: Domain, tolerance: float) -> Chart:
    """Tables of the torque of one drive around one arc."""
    sampler = _DriveSampler(around, drive)
    rate = float(np.sqrt(np.abs(around.acceleration(0.0, 0)[0]) * domain.high))
    weights = _weights(around, sampler, rate)
    tables, samples = resolved(sampler, domain, weights, tolerance)
    points = checks(sampler, domain, tables)
    kept = trimmed(points, domain, tables, weights, tolerance)
    functions = replace(
        kept,
        equation=np.ascontiguousarray(kept.equation[:-1]),
        gaps=np.ascontiguousarray(kept.equation[-1:]),
        residual=kept.residual[:-1],
        largest=kept.largest[:-1],
        steepest_x=kept.steepest_x[:-1],
        steepest_u=kept.steepest_u[:-1],
    )
    slopes = np.zeros((2, *kept.equation.shape[1:]))
    return Chart(around.arc, domain, functions, slopes, kept.residual[-1:], np.zeros(2), samples,
                 np.empty(0), (0.0, 0.0, 0.0, 0.0))  # fmt: skip


def _weights(around: Surroundings, sampler: _DriveSampler, rate: float) -> FloatArray:
    """Weights of the functions by the size of the torque at rates up to ``rate``."""
    places = np.linspace(0, len(around.arc.travels) - 1, around.along.equation.shape[1]).astype(int)
    places = np.unique(places)
    u, q = around.arc.travels[places], around.arc.path[places]
    functions = sampler.at(u, np.zeros_like(u), q).equation
    fastest = float(np.abs(around.acceleration(rate, 0)[1]).sum())
    weights = np.append(np.abs(around.factors(rate)), fastest)
    size = float(np.abs(weights[:, None] * functions).sum(axis=0).mean())
    return weights / (size if size > 0.0 else 1.0)

"""Largest torques of the drives in the turns of many cases, between events.

A collision changes the speed of held drives by an impulse, which is no torque. They cost about as
much as the turns themselves, so they are computed where they are asked for.

Torques of the drives around the stretches of a turn, as series of travel and gap.

T = T0 w^2 + T1 w x' + T2 x'^2 + Tg + sum_k k (T_k p + T_ks) + Ta x'': the functions have the
places of those of the equation of motion, and Ta has that of the gap of another stop. They are
sampled on the charts of the turns.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...made_once import made_once
from ...mechanism import Mechanism
from ...tolerances.reduced import TURN_TABLES
from ..kernels.layout import HIGH, LOW, Charts
from ..model import factors
from ..tables.tables import Domain, chart_over, stacked
from ..transition import kernel
from .cases import BESIDE, Run, room_for
from .charts import shares
from .model import TurnModel, surroundings
from .turn import turn_model, widening


@made_once
def torque_model(mechanism: Mechanism, start_index: float, gap_scale: float) -> Charts:
    """Return the torques of a mechanism's drives on the charts of its turns, sampled once.

    Those of chart c and drive d have the place c drives + d.

    Raises:
        ConvergenceError: The functions are not smooth enough on a chart.
        SimulationError: A point of the turn cannot be reached or is singular.
    """
    around, _ = surroundings(mechanism, start_index)
    charts = turn_model(mechanism, start_index, gap_scale).charts
    found = []
    for place, item in enumerate(around):
        low, high = charts.numbers[place, [LOW, HIGH]].tolist()
        domain = Domain(float(item.arc.travels[-1]), low, high)
        # The size of the torques at usual rates.
        rate = float(np.sqrt(np.abs(item.terms(0.0).sum()) * high))
        fastest = np.abs(item.terms(rate)).sum()
        usual = np.append(factors(mechanism, len(item.along.equation), rate), fastest)
        for drive in range(len(mechanism.drives)):
            at = partial(item.sampler.torque, drive)
            weights = shares(usual, at(*item.places).rows[: len(usual)])
            found.append(chart_over(item.sampler.grid, at, domain, weights, TURN_TABLES))
    # Of the function of x'' the bound on its error, and its largest value.
    by_a = np.array([chart.bounds[[0, -1], chart.functions] for chart in found])
    return stacked(mechanism, found)._replace(gap_bounds=by_a)


# Panels of a turn that there is room for, by its collisions and other events.
_PANELS = 2


def peak_torques(
    mechanism: Mechanism, start_index: float, run: Run, cases: FloatArray, last: int | None
) -> tuple[NDArray[np.int64], FloatArray]:
    """Status of each case, shape (n,), and largest torques.

    Returns:
        Largest magnitudes and bounds on their errors, shape (n, turns, 2, drives) [N m; N of a
        drive along a slide]: the last turn first, or alone; NaN without a turn.
    """
    _, grids = kernel()
    from ..kernels.turn_torques import run_torques

    n, drives = len(cases), len(mechanism.drives)
    status = np.zeros((n, 1), dtype=np.int64)
    largest = room_for(n, last, 2 * drives).reshape(n, -1, 2, drives)

    def follow(model: TurnModel, gap_scale: float, cases: FloatArray, told: NDArray[np.int64],
               found: FloatArray) -> None:  # fmt: skip
        torques = torque_model(mechanism, start_index, gap_scale)
        panels = _PANELS * (run.most + BESIDE)
        run_torques(
            grids, model.charts, torques, cases, run.settings, run.of(model), panels,
            run.events()[0], told[:, 0], found,
        )  # fmt: skip

    widening(mechanism, start_index, cases, status, largest, follow)
    return status[:, 0], largest

"""Which of many gaps, and of many forces, may fall through zero first on a panel.

A Chebyshev series is nowhere lower than its constant term less the sizes of all others. So an
acceleration has a least value, and a gap of which place and rate at the start are known has a least
time to close, which costs a hundredth of its root. Where one gap closes, no other one counts that
takes longer at least.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...chebyshev import nodes
from ...dynamics import System
from ...mechanism import Stop
from ...tolerances.hybrid import GAP_ROUND_OFF, SOONEST_SHARE
from ..motion.panel import Panel

# So few are looked at as they are, sooner than their bounds are found.
_FEW = 3


def by_soonest(system: System, panel: Panel, stops: Sequence[Stop]) -> list[tuple[float, Stop]]:
    """Stops in the order of the times at which their gaps may close on a panel at the soonest.

    Returns:
        Times [s] and stops; the start of the panel where nothing tells more.
    """
    if len(stops) <= _FEW or not panel.integrated:
        return [(panel.t, stop) for stop in stops]
    index, sense = [stop.index for stop in stops], np.array([stop.sense for stop in stops])
    gap = sense * (panel.q[0, index] - np.array([stop.at for stop in stops]))
    rate, least = sense * panel.v[0, index], _least(sense * panel.a[:, index])
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        root = np.sqrt(rate**2 - 2.0 * least * gap)
        # Either form of the first root where it loses no digits; no root is none that is real.
        away = np.where(least < 0.0, (rate + root) / -least, np.inf)
        after = np.where(rate > 0.0, away, 2.0 * gap / (root - rate))
    after[np.isnan(after)] = np.inf
    # What has hardly opened has a root of its own kind.
    after[gap <= GAP_ROUND_OFF * system.body.units[index]] = 0.0
    times = (panel.t + SOONEST_SHARE * after).tolist()
    order = np.argsort(times, kind="stable").tolist()
    return [(times[place], stops[place]) for place in order]


def may_vanish(forces: FloatArray) -> NDArray[np.bool_]:
    """Whether forces may fall through zero on a panel, shape (K,).

    Args:
        forces: Forces of the closed stops at its nodes, shape (N, K).
    """
    if forces.shape[1] <= _FEW:
        return np.ones(forces.shape[1], dtype=np.bool_)
    return np.asarray(_least(forces) <= (1.0 - SOONEST_SHARE) * np.abs(forces).max(axis=0))


def _least(values: FloatArray) -> FloatArray:
    """What no column of node values falls below between the nodes, from (N, K), shape (K,)."""
    constant, *others = nodes(len(values)).integrals[0] @ values
    return np.asarray(constant - np.abs(others).sum(axis=0))

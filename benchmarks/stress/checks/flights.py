"""Check of flights: the equations of motion hold between the nodes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.polynomial.chebyshev import chebpts1

from nipper_pin.arrays import FloatArray
from nipper_pin.hybrid import Solution
from nipper_pin.hybrid.motion.panel import Panel

from ...tolerances import EPS, LEFT_OUT, POSITION_TERMS
from ..mechanics.equations import Equations
from ..observations import beyond, polynomial, samples


def flights(solution: Solution) -> Iterator[str]:
    """Check the equations of motion between nodes, to the tolerance of the run."""
    equations, tolerance = Equations(solution), solution.case.resolution.tolerance
    for segment, panel, t in samples(solution):
        if not panel.integrated:
            continue
        # Times at equal distances are nodes where there are four, seven or thirteen of them.
        between = panel.t + panel.h * 0.5 * (1.0 + chebpts1(panel.order - 1))
        t = np.append(t, between[(t[0] < between) & (between < t[-1])])
        motion = solution.trajectory.evaluate(t)
        told = polynomial(panel.a)((t - panel.t) / panel.h)
        longest = max(item.h for item in segment.panels)
        off = _beside(equations, panel, segment.closed, longest, (t, motion.q, motion.v, told))
        loose = equations.loose(segment.closed)
        share = float((off * panel.h**2 / _moved(solution, panel))[:, loose].max(initial=0.0))
        most = LEFT_OUT * (2.0 * panel.order) ** 2 * tolerance + 1e4 * EPS
        yield from beyond(f"flight at {segment.t_start:.9g} s: equations between nodes [share]",
                          share, most)  # fmt: skip


def _beside(
    equations: Equations,
    panel: Panel,
    closed: frozenset[str],
    longest: float,
    states: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
) -> FloatArray:
    """Error of the stored accelerations in excess of round-off, shape (K, nv)."""
    t, q, v, told = states
    there = equations.accelerations(t, q, v, closed)
    unsure = equations.round_off(t, q, v, closed)
    off = np.abs(told - there)
    # What the closures determine is integrated, too, and drifts by what it is off; that may be
    # little for itself, and more for another coordinate that hardly moves.
    drift = panel.h * off
    drift[:, list(panel.split.independent)] = 0.0
    drifted = equations.accelerations(t, q, v + drift, closed)
    # The round-off of a state is that of the sums that it is.
    aside = equations.accelerations(t, q + POSITION_TERMS * EPS * equations.sizes(q), v, closed)
    # Noise of accelerations is integrated, too: on a panel, and on those before that led to it, it
    # makes rates of noise, which stiff springs and dampers turn into accelerations again.
    rates = 2.0 * longest * unsure
    fed = equations.accelerations(t, q + 0.5 * longest * rates, v + rates, closed)
    noise = unsure + np.abs(aside - there) + np.abs(fed - there)
    # That of the judge's own equations, and as much at every node of the interpolant, which exceeds
    # the largest of its values by Lebesgue's constant.
    allowed = (2.0 + 2.0 / np.pi * float(np.log(panel.order))) * noise
    return np.asarray(off - allowed - np.abs(drifted - there))


def _moved(solution: Solution, panel: Panel) -> FloatArray:
    """Largest change of each coordinate on a panel, shape (nv,), to which the tolerance refers."""
    size = np.abs(panel.h * panel.v[0]) + panel.h**2 * np.abs(panel.a).max(axis=0)
    return np.asarray(size + EPS * solution.system.body.reach_m)

"""What follows the rest of a transition: the jaw is pressed shut, and its force can be drawn."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...errors import NipperError
from ...hybrid import Solution
from ...mechanism import INDEX_PER_TURN
from ..run.sampling import sample_coordinates

# The force of a closed stop is as smooth as the drives: straight lines between so many of its
# values are off by less than a line of a plot is wide.
_POINTS = 9


def followed_on(solution: Solution) -> Solution:
    """A transition to rest and one index more, in which the stop is closed unless it opens before.

    Events stay those of the transition. Where the machine cannot be followed further, so does all
    else: the transition itself is not in doubt.
    """
    end = solution.events[-1].t + solution.shaft.period / INDEX_PER_TURN
    try:
        return solution.continued(end)
    except NipperError:
        return solution


def gap_line(solution: Solution) -> tuple[FloatArray, FloatArray]:
    """Times [s] and gaps of the transition stop [rad or m], each shape (K,)."""
    stop = solution.mechanism.stop(solution.mechanism.transition_stop)
    if not solution.segments:
        return np.zeros(1), np.zeros(1)
    t, q = sample_coordinates(solution, 0.0, solution.segments[-1].t_end)
    # Both limits at a collision have one abscissa, and a line needs only one of them.
    t, places = np.unique(t, return_index=True)
    return t, stop.gaps(q[places])


def force_line(solution: Solution) -> tuple[FloatArray, FloatArray]:
    """Times [s] and clamping forces [N; N m along a hinge without contact], each shape (K,).

    The force is zero while the jaw flies, and jumps where it comes to rest.
    """
    name, rest = solution.mechanism.transition_stop, solution.events[-1].t
    end = solution.segments[-1].t_end if solution.segments else 0.0
    if end <= rest:
        return np.array([0.0, rest]), np.zeros(2)
    t = np.linspace(rest, end, _POINTS)
    inner = solution.trajectory.reactions(t[:-1]).contacts[name]
    last = solution.trajectory.reactions(t[-1:], left=True).contacts[name]
    # The foot of the jump stands a hair before it, because times of a line have to increase.
    foot = rest * (1.0 - 1e-9)
    return np.array([0.0, foot, *t]), np.concatenate([[0.0, 0.0], inner, last])

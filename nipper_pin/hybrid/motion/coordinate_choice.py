"""Dependent and independent coordinates that suit a flight panel over its whole length.

The motion of a panel does not depend on the choice, but what closes the loops at any of its times
does: where the closures cease to determine the dependent coordinates, their rates there become
what round-off and tolerance make of them. That is no dead centre as long as others will do.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...dynamics import ConstraintSet, Partition, System, partition
from ...dynamics.small_systems import same_sign
from ...errors import SingularConfigurationError
from .panel import Panel

# A panel may end with a worse choice than it may begin with: with more of the largest good
# condition, and with one at hand that is this part of it. The next panel changes.
_SPOILT, _MUCH_BETTER = 2.0, 0.1
# Links that turn by less [rad] pass no two places where a choice fails.
_ONE_PLACE = 1.0


def serves(system: System, panel: Panel, start: FloatArray, end: FloatArray) -> bool:
    """True if the closures determine the dependent coordinates throughout a panel.

    A determinant that changes its sign has been zero. A block of condition c becomes singular only
    if links turn by some 1 / c.

    Args:
        start: Closure Jacobian at its start, shape (m, nv).
        end: The same at the end of the segment on it.
    """
    if not system.body.closure_rows:
        return True
    condition = system.condition(panel.split, end)
    if not condition < _SPOILT * system.good_condition:
        return False
    turns = system.turns(panel.q - panel.q[0])
    # The Euclidean norm bounds the largest element, and is found faster.
    if condition**2 * np.vdot(turns, turns) < 1.0:
        return True
    if turns.max() <= _ONE_PLACE:
        columns = panel.split.columns
        return same_sign(start.take(columns, 1), end.take(columns, 1))
    jacobians = np.concatenate([start[None], end[None], system.body.closures(panel.q)[1]])
    return _keeps_sign(jacobians, panel.split)


def suited_split(
    system: System,
    phase: ConstraintSet,
    panel: Panel,
    end: FloatArray,
    preferred: tuple[int, ...],
) -> Partition | None:
    """Dependent coordinates that serve throughout a panel on which its own do not.

    Args:
        end: Closure Jacobian at the end of the segment on it, shape (m, nv).
        preferred: Coordinates to keep independent where the closures allow it.

    Returns:
        The choice, its own if no other is much better where it is worst; None if another one is
        there, but not for the whole panel.
    """
    own = panel.split
    jacobians = np.concatenate([system.body.closures(panel.q)[1], end[None]])
    sizes = [system.condition(own, jacobian) for jacobian in jacobians]
    worst = jacobians[int(np.argmax(sizes))]
    try:
        weighed = worst * system.body.units
        other = partition(weighed, phase.given, preferred, system.good_condition)
    except SingularConfigurationError:
        # A dead centre, whatever the choice.
        return own if _keeps_sign(jacobians, own) else None
    if system.condition(other, worst) >= _MUCH_BETTER * max(sizes):
        return own if _keeps_sign(jacobians, own) else None
    good = max(system.condition(other, jacobian) for jacobian in jacobians) < system.good_condition
    return other if good and _keeps_sign(jacobians, other) else None


def _keeps_sign(jacobians: FloatArray, split: Partition) -> bool:
    """True if the determinant of the dependent block has one sign at all places."""
    signs = np.sign(np.linalg.det(jacobians[:, :, split.columns]))
    return bool((signs == signs[0]).all())

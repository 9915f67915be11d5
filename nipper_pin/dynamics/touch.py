"""The touch configuration, and the way from there to where a run begins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from ..arrays import FloatArray, product
from ..made_once import made_once
from ..tolerances.mechanics import GOOD_CONDITION, TRACKING_RESIDUAL
from .assembly import Partition, close_positions, close_velocities, inverted, partition
from .multibody import Multibody


@dataclass(frozen=True, eq=False)
class Touch:
    """The touch configuration, q = 0, with some coordinates given.

    Attributes:
        jacobian: Closure Jacobian G, shape (m, nv), not writeable.
        split: The given coordinates and those that follow from them.
        motion: Rates of all coordinates by those of the given ones, shape (nv, given).
    """

    jacobian: FloatArray
    split: Partition
    motion: FloatArray


@dataclass(frozen=True, eq=False)
class _Assembled:
    """Where the last path of a multibody system ended: runs at other speeds start there, too."""

    path: FloatArray
    given: tuple[int, ...]
    q: FloatArray
    jacobian: FloatArray
    split: Partition


_LAST: WeakKeyDictionary[Multibody, _Assembled] = WeakKeyDictionary()


@made_once
def touch(body: Multibody, given: tuple[int, ...]) -> Touch:
    """The touch configuration of a multibody system; all its runs start from there.

    Args:
        given: Places in q of the coordinates that are prescribed.

    Raises:
        SingularConfigurationError: The closures do not determine the others.
    """
    jacobian = body.closures(np.zeros((1, body.nv)))[1]
    jacobian.flags.writeable = False
    split = partition(jacobian[0] * body.units, given, [])
    units = np.eye(body.nv)[list(given)]
    return Touch(jacobian[0], split, close_velocities(units, jacobian, split).T)


def assemble(
    body: Multibody, path: FloatArray, given: Sequence[int], rates: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Assemble the mechanism at the end of a path of given coordinates that starts at q = 0.

    Args:
        path: Given coordinates along the path, shape (K, given); short steps, the first one near
            the touch configuration, so that the mechanism stays on its branch. None: q = 0.
        given: Places of those coordinates in q.
        rates: Their rates at the end, shape (given,).

    Returns:
        q, v of shape (nv,) and the closure Jacobian there, shape (m, nv).
    """
    if not len(path):
        start = touch(body, tuple(given))
        return np.zeros(body.nv), start.motion @ rates, start.jacobian
    end, columns = _LAST.get(body), list(given)
    if end is None or end.given != tuple(given) or not np.array_equal(end.path, path):
        end = _LAST[body] = _followed(body, path, columns)
    v = np.zeros((1, body.nv))
    v[0, columns] = rates
    return end.q.copy(), close_velocities(v, end.jacobian[None], end.split)[0], end.jacobian


def _followed(body: Multibody, path: FloatArray, columns: list[int]) -> _Assembled:
    """Follow a path of given coordinates; arguments as those of :func:`assemble`."""
    start = touch(body, tuple(columns))
    q = np.zeros((1, body.nv))
    jacobian, split, gaps = start.jacobian, start.split, np.zeros(body.closure_rows)
    before: FloatArray | None = None
    for target in path:
        slopes, inverse, known = _slopes(body, jacobian, columns, split)
        if known != split:
            before, split = None, known
        bent = slopes if before is None else 1.5 * slopes - 0.5 * before
        moved, before = target - q[0, columns], slopes
        # The step and, by the same matrices, what the last one has left open.
        q[0, split.columns] += product(bent, moved) - product(inverse, gaps)
        q[0, columns] = target
        (gaps,), (jacobian,) = body.closures(q)
        if np.vdot(gaps, gaps) > TRACKING_RESIDUAL * body.reach_m**2:
            # One step of Newton's method would leave more than its square.
            q, (jacobian,) = close_positions(body, q, split, TRACKING_RESIDUAL)
            gaps = np.zeros(body.closure_rows)
    q, (jacobian,) = close_positions(body, q, split)
    _, _, split = _slopes(body, jacobian, columns, split)
    jacobian.flags.writeable = False
    return _Assembled(path.copy(), tuple(columns), q[0], jacobian, split)


def _slopes(
    body: Multibody, jacobian: FloatArray, given: list[int], split: Partition
) -> tuple[FloatArray, FloatArray, Partition]:
    """Dependent coordinates by the given ones and by gaps; the split, another if it is bad."""
    columns = split.columns
    units = body.units.take(columns) if body.scaled else None
    condition, inverse = inverted(jacobian.take(columns, 1), units)
    if not condition <= GOOD_CONDITION * max(len(jacobian), 1):
        split = partition(jacobian * body.units, given, [])
        _, inverse = inverted(jacobian.take(split.columns, 1))
    return -product(inverse, jacobian.take(given, 1)), inverse, split

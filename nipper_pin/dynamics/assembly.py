"""Closing the loops: positions and velocities that satisfy the closures exactly.

A machine is assembled in the touch configuration, and along its drives from there to where a run
begins.

Small systems of linear equations are solved one by Eigen, several at once by numpy. For a matrix of
a few rows numpy's way to LAPACK takes three times as long as Eigen's factorisation,
which comes with Pinocchio; of many matrices numpy's way is gone once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np
from eigenpy import PartialPivLU
from numpy.typing import NDArray

from ..arrays import FloatArray, Jacobians, Vectors, product
from ..errors import ConvergenceError, SingularConfigurationError
from ..made_once import made_once
from ..tolerances.mechanics import (
    CLOSURE_RESIDUAL,
    DEAD_CENTRE_SHARE,
    GOOD_CONDITION,
    MAX_CONDITION,
    TRACKING_RESIDUAL,
)
from ..units import MM_PER_M
from .multibody import Multibody


def same_sign(one: FloatArray, other: FloatArray) -> bool:
    """True if the determinants of two square matrices have one sign, or are both zero."""
    if not one.size:
        return True
    first, second = PartialPivLU(one).determinant(), PartialPivLU(other).determinant()
    return bool((first > 0.0) == (second > 0.0) and (first < 0.0) == (second < 0.0))


_MAX_ITERATIONS = 25
# Round-off may stop the iteration a little above its tolerance: its floor is accepted.
_FLOOR = 16.0


@dataclass(frozen=True)
class Partition:
    """Split of the coordinates: dependent ones follow from the others through the closures.

    Generalised coordinate partitioning (Wehage and Haug, 1982).

    Attributes:
        dependent: As many coordinates as closure rows.
        independent: All the others, prescribed ones included.
    """

    dependent: tuple[int, ...]
    independent: tuple[int, ...]

    @cached_property
    def columns(self) -> NDArray[np.intp]:
        """The dependent coordinates as an index array."""
        return np.array(self.dependent, dtype=np.intp)

    @classmethod
    def of(cls, dependent: Sequence[int], size: int) -> Partition:
        """Return the partition of ``size`` coordinates with these dependent ones."""
        chosen = tuple(sorted(dependent))
        return cls(chosen, tuple(i for i in range(size) if i not in chosen))


def partition(
    jacobian: FloatArray,
    given: Sequence[int],
    preferred: Sequence[int],
    limit: float = MAX_CONDITION,
) -> Partition:
    """Choose dependent coordinates, each column of their block by pivoting on its size.

    Args:
        jacobian: Closure Jacobian G by coordinates in their units, G * units, shape (m, nv).
        given: Coordinates whose motion is prescribed; never dependent.
        preferred: Coordinates to keep independent, the most important first, as far as the
            closures allow it.
        limit: Condition number that this may cost.

    Raises:
        SingularConfigurationError: The closures do not determine the dependent coordinates.
    """
    rows, size = jacobian.shape
    candidates = [column for column in range(size) if column not in given]
    condition = np.inf
    for column in preferred:
        rest = [other for other in candidates if other != column]
        if column in candidates and len(rest) >= rows:
            found = condition_number(jacobian[:, rest])
            if found < limit:
                candidates, condition = rest, found
    if len(candidates) > rows:
        candidates = _pivot(jacobian, candidates)
        condition = np.inf
    if condition == np.inf and len(candidates) == rows:
        condition = condition_number(jacobian[:, candidates])
    if not condition < MAX_CONDITION:
        message = (
            f"the closures do not determine the mechanism here (condition {condition:.2g}): it "
            "stands in a dead centre; change the dimensions or the drive"
        )
        raise SingularConfigurationError(message, condition=condition, coordinates=candidates)
    return Partition.of(candidates, size)


def condition_number(matrix: FloatArray) -> float:
    """Condition number of a matrix without more rows than columns; infinite if it loses rank.

    Of a square matrix, the usual case, as :func:`inverted`; in the 2-norm otherwise.
    """
    if len(matrix) in (0, matrix.shape[1]):
        return inverted(matrix)[0]
    sizes = np.linalg.svd(matrix, compute_uv=False)
    return float(sizes[0] / sizes[-1]) if sizes.all() else np.inf


def weakest(jacobian: FloatArray, given: Sequence[int]) -> tuple[float, list[int]]:
    """Condition number of the closures, and the coordinates of the nearest dead centre.

    Args:
        jacobian: Closure Jacobian G by coordinates in their units, as for :func:`partition`.

    Returns:
        Condition number of G in the other coordinates, in the 2-norm; and those of them, the most
        important first, whose motion the closures determine least.
    """
    others = [column for column in range(jacobian.shape[1]) if column not in given]
    if not len(jacobian) or len(others) < len(jacobian):
        return 1.0, []
    _, sizes, motions = np.linalg.svd(jacobian[:, others])
    share = np.abs(motions[len(jacobian) - 1])
    chosen = [others[i] for i in np.argsort(-share) if share[i] >= DEAD_CENTRE_SHARE * share.max()]
    return float(sizes[0] / sizes[-1]) if sizes[-1] > 0.0 else np.inf, chosen


def inverted(matrix: FloatArray, units: FloatArray | None = None) -> tuple[float, FloatArray]:
    """Condition number and inverse of a square matrix; infinite if it is singular.

    The number is that in the Frobenius norm: at most the number of rows times that in the 2-norm.

    Args:
        matrix: Shape (m, m).
        units: What its columns count by in the condition number, shape (m,); None for ones.
    """
    if not matrix.size:
        return 1.0, matrix
    inverse: FloatArray = PartialPivLU(matrix).inverse()
    there, back = matrix, inverse
    if units is not None:
        there, back = matrix * units, inverse / units[:, None]
    condition = math.sqrt(np.vdot(there, there)) * math.sqrt(np.vdot(back, back))
    if not math.isfinite(condition):
        return np.inf, np.full_like(matrix, np.nan)
    return condition, inverse


def _pivot(jacobian: FloatArray, candidates: list[int]) -> list[int]:
    """Choose as many columns as rows, each the largest one orthogonal to those before."""
    residual = jacobian[:, candidates].copy()
    chosen: list[int] = []
    for _ in range(len(jacobian)):
        sizes = np.einsum("ij,ij->j", residual, residual)
        pivot = int(np.argmax(sizes))
        chosen.append(candidates[pivot])
        direction = residual[:, pivot] / np.sqrt(max(sizes[pivot], np.finfo(float).tiny))
        residual -= np.outer(direction, direction @ residual)
        # A column is chosen once, even where the remaining ones are round-off.
        candidates = [*candidates[:pivot], *candidates[pivot + 1 :]]
        residual = np.delete(residual, pivot, axis=1)
    return chosen


def close_positions(
    body: Multibody,
    q: FloatArray,
    split: Partition,
    share: float = CLOSURE_RESIDUAL,
    *,
    anew: bool = False,
) -> tuple[FloatArray, FloatArray]:
    """Solve g(q) = 0 for the dependent coordinates by Newton's method.

    Args:
        q: Guesses, shape (N, nv); the independent coordinates are kept to the last bit.
        share: Gap that may be left, by the reach of the mechanism.
        anew: Take a step even from guesses whose gaps are as small as that: near a dead centre they
            leave dependent coordinates open by far more, and differently from guess to guess.

    Returns:
        Closed configurations, shape (N, nv), and the closure Jacobian G there, shape (N, m, nv).

    Raises:
        ConvergenceError: The loops cannot be closed from these guesses.
        SingularConfigurationError: A dependent block is singular.
    """
    q = q.copy()
    dependent = split.columns
    tolerance = share * body.reach_m
    best = math.inf
    g, jacobian = body.closures(q)
    # Above it some gap is larger than any that is accepted, and which one does not matter.
    far = _FLOOR * tolerance * math.sqrt(g.size)
    if anew:
        q[:, dependent] -= _solve(jacobian.take(dependent, 2), g)
        g, jacobian = body.closures(q)
    for _ in range(_MAX_ITERATIONS):
        # The Euclidean norm bounds the largest gap, and is found faster.
        residual = math.sqrt(np.vdot(g, g))
        if residual <= tolerance:
            return q, jacobian
        if not residual > far:
            residual = float(np.maximum.reduce(np.abs(g), axis=None, initial=0.0))
            if residual <= tolerance or (residual <= _FLOOR * tolerance and residual >= best):
                return q, jacobian
        if not math.isfinite(residual):
            break
        best = min(best, residual)
        q[:, dependent] -= _solve(jacobian.take(dependent, 2), g)
        g, jacobian = body.closures(q)
    # Of many configurations the farthest one counts.
    best = min(best, float(np.abs(g).max()))
    message = (
        f"the loops do not close: {best * MM_PER_M:.3g} mm remain after {_MAX_ITERATIONS} Newton "
        "steps; the links cannot reach the position that is asked of them"
    )
    evidence = {"residual": best, "tolerance": tolerance, "iterations": _MAX_ITERATIONS}
    raise ConvergenceError(message, **evidence, row=int(np.argmax(np.abs(g).max(axis=0))))


def close_velocities(
    v: Vectors, jacobian: Jacobians, split: Partition, inverse: FloatArray | None = None
) -> Vectors:
    """Solve G v = 0 for the dependent velocities; the independent ones are kept.

    Args:
        inverse: What :func:`inverses` gives for them, where it is known already.
    """
    v = v.copy()
    dependent = split.columns
    v[:, dependent] = 0.0
    if inverse is None:
        inverse = inverses(jacobian, split)
    v[:, dependent] = -products(inverse, products(jacobian, v))
    return v


def inverses(jacobian: Jacobians, split: Partition) -> FloatArray:
    """Inverses of the dependent blocks of the closures, shape (N, m, m).

    Raises:
        SingularConfigurationError: A block is singular.
    """
    blocks = jacobian.take(split.columns, 2)
    if len(blocks) == 1 and blocks.size:
        return _finite(PartialPivLU(blocks[0]).inverse()[None])
    try:
        return np.asarray(np.linalg.inv(blocks), dtype=np.float64)
    except np.linalg.LinAlgError as error:
        raise _singular() from error


def products(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    """Products of N matrices (N, r, c) and N vectors (N, c), shape (N, r)."""
    found: FloatArray = np.matmul(matrices, vectors[:, :, None])[:, :, 0]
    return found


def _solve(matrices: FloatArray, right: FloatArray) -> FloatArray:
    """Solve N small systems, shapes (N, m, m) and (N, m); the right sides are finite."""
    if len(matrices) == 1 and matrices.size:
        return _finite(PartialPivLU(matrices[0]).solve(right[0]).reshape(right.shape))
    try:
        return np.asarray(np.linalg.solve(matrices, right[:, :, None])[:, :, 0], dtype=np.float64)
    except np.linalg.LinAlgError as error:
        raise _singular() from error


def _finite(found: FloatArray) -> FloatArray:
    """Refuse what a division by a pivot of zero has left: Eigen does not report it."""
    if not math.isfinite(np.vdot(found, found)):
        raise _singular()
    return found


def _singular() -> SingularConfigurationError:
    message = (
        "the closures are singular here: the mechanism stands exactly in a dead centre; "
        "change the dimensions or the drive"
    )
    return SingularConfigurationError(message, condition=np.inf)


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

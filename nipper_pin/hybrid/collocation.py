"""Chebyshev collocation on one panel of time.

A motion on a panel [t, t + h] is held as its accelerations at the Chebyshev-Lobatto nodes. Their
interpolant, integrated twice, gives velocity and position as polynomials that satisfy the initial
values exactly, so a gap that starts at zero keeps full relative precision near the start.

Source: C. W. Clenshaw and H. J. Norton, The Computer Journal 6 (1963) 88 (Picard iteration in
Chebyshev series); L. N. Trefethen, Approximation Theory and Approximation Practice, 2013.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import chebyshev

from ..arrays import FloatArray

_SAMPLES_PER_NODE = 4


@dataclass(frozen=True)
class Nodes:
    """Nodes and operators of one order on the unit interval sigma in [0, 1].

    Attributes:
        sigma: Nodes, shape (N,), from 0 to 1.
        integrals: Node values to the Chebyshev coefficients of the interpolant (first), of its
            integral from 0 (second) and of its double integral (third), shapes (N + k, N).
        once: Node values to integrals from 0 at the nodes, shape (N, N).
        twice: The same integrated twice, shape (N, N).
        samples: Fine grid from 0 to 1, shape (S,).
        sample_value: Node values to values on the fine grid, shape (S, N).
        sample_twice: Node values to double integrals on the fine grid, divided by sigma to the
            power 0, 1 and 2 (limits at sigma = 0), shapes (S, N).
    """

    sigma: FloatArray
    integrals: tuple[FloatArray, FloatArray, FloatArray]
    once: FloatArray
    twice: FloatArray
    samples: FloatArray
    sample_value: FloatArray
    sample_twice: tuple[FloatArray, FloatArray, FloatArray]


@cache
def nodes(order: int) -> Nodes:
    """Return the nodes and operators with this many nodes."""
    x = -np.cos(np.pi * np.arange(order) / (order - 1))
    sigma = 0.5 * (x + 1.0)
    coefficients = np.linalg.inv(chebyshev.chebvander(x, order - 1))
    # lbnd = -1 makes every integral vanish at sigma = 0; 1/2 is dx -> dsigma.
    integrals = (
        np.asarray(coefficients, dtype=np.float64),
        chebyshev.chebint(coefficients, m=1, lbnd=-1, scl=0.5),
        chebyshev.chebint(coefficients, m=2, lbnd=-1, scl=0.5),
    )
    count = _SAMPLES_PER_NODE * order
    samples = 0.5 * (1.0 - np.cos(np.pi * np.arange(count + 1) / count))
    value = np.asarray(_basis(samples, order) @ integrals[0])
    # The first sample is the first node: its value is met to the last bit.
    value[0] = np.eye(order)[0]
    twice = _basis(samples, order + 2) @ integrals[2]
    inner = samples[1:, None]
    # The double integral grows like sigma^2 / 2 from its start.
    by_one = np.vstack([np.zeros(order), twice[1:] / inner])
    by_two = np.vstack([0.5 * value[0], twice[1:] / inner**2])
    return Nodes(
        sigma=sigma,
        integrals=integrals,
        once=_basis(sigma, order + 1) @ integrals[1],
        twice=_basis(sigma, order + 2) @ integrals[2],
        samples=samples,
        sample_value=value,
        sample_twice=(twice, by_one, by_two),
    )


def _basis(sigma: FloatArray, count: int) -> FloatArray:
    """Chebyshev polynomials of degree 0 to count - 1 at sigma, shape (len(sigma), count)."""
    angle = np.arccos(np.clip(2.0 * sigma - 1.0, -1.0, 1.0))
    return np.asarray(np.cos(angle[:, None] * np.arange(count)))


def evaluate(values: FloatArray, sigma: FloatArray, integrations: int) -> FloatArray:
    """Interpolate node values, or their integral from 0, at sigma.

    Args:
        values: Node values, shape (N, ...).
        sigma: Places in [0, 1], shape (K,).
        integrations: 0 for the interpolant, 1 for its integral by sigma, 2 for the double one.

    Returns:
        Values at sigma, shape (K, ...).
    """
    operator = nodes(len(values)).integrals[integrations]
    return np.asarray(_basis(sigma, len(operator)) @ (operator @ values))


def evaluate_motion(values: FloatArray, sigma: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Double and single integral of node values from 0 to sigma; as :func:`evaluate`, at once."""
    _, once, twice = nodes(len(values)).integrals
    basis = _basis(sigma, len(twice))
    return np.asarray(basis @ (twice @ values)), np.asarray(basis[:, :-1] @ (once @ values))


def prolonged(values: FloatArray, count: int) -> FloatArray:
    """Interpolate node values to another number of nodes; one value stands for a constant.

    Args:
        values: Node values, shape (N, columns).
        count: Number of nodes wanted.

    Returns:
        Node values, shape (count, columns), in an array of their own.
    """
    if len(values) == count:
        return values.copy()
    if len(values) == 1:
        return np.repeat(values, count, axis=0)
    fine = np.asarray(_prolongation(len(values), count) @ values)
    if (count - 1) % (len(values) - 1) == 0:
        # Nodes of nested grids keep their values to the last bit.
        fine[:: (count - 1) // (len(values) - 1)] = values
    return fine


@cache
def _prolongation(coarse: int, fine: int) -> FloatArray:
    return np.asarray(_basis(nodes(fine).sigma, coarse) @ nodes(coarse).integrals[0])


class Arc:
    """One coordinate on a panel as polynomials of sigma, for scalar evaluation in root searches.

    Args:
        values: Node values of the second derivative by sigma, shape (N,).
        start: Value at sigma = 0.
        slope: Derivative by sigma there.
    """

    def __init__(self, values: FloatArray, start: float, slope: float) -> None:
        """Integrate the series."""
        _, once, twice = nodes(len(values)).integrals
        self._start, self._slope = start, slope
        self._once: list[float] = (once @ values).tolist()
        self._twice: list[float] = (twice @ values).tolist()

    def value(self, sigma: float) -> float:
        """Value at sigma."""
        return self._start + sigma * self._slope + _clenshaw(self._twice, sigma)

    def rate(self, sigma: float) -> float:
        """First derivative by sigma."""
        return self._slope + _clenshaw(self._once, sigma)


def _clenshaw(coefficients: list[float], sigma: float) -> float:
    x2 = 4.0 * sigma - 2.0
    high = low = 0.0
    for coefficient in coefficients[:0:-1]:
        high, low = coefficient + x2 * high - low, high
    return coefficients[0] + 0.5 * x2 * high - low


def tail(values: FloatArray) -> FloatArray:
    """Size of the last two Chebyshev coefficients of every column of node values.

    Args:
        values: Node values, shape (N, columns).

    Returns:
        |c[N-1]| + |c[N-2]|, shape (columns,): what a finer grid would still add, at least.
    """
    return np.asarray(np.abs(nodes(len(values)).integrals[0][-2:] @ values).sum(axis=0))

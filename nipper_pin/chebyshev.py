"""Chebyshev collocation on one panel of time.

A motion on a panel [t, t + h] is held as its accelerations at the Chebyshev-Lobatto nodes. Their
interpolant, integrated twice, gives velocity and position as polynomials that satisfy the initial
values exactly, so a gap that starts at zero keeps full relative precision near the start.

Source: C. W. Clenshaw and H. J. Norton, The Computer Journal 6 (1963) 88 (Picard iteration in
Chebyshev series); L. N. Trefethen, Approximation Theory and Approximation Practice, 2013.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from .arrays import FloatArray, product

_SAMPLES_PER_NODE = 4
# Nodes from which on the last three coefficients show how they decay.
_DECAY = 4
_TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class Nodes:
    """Nodes and operators of one order on the unit interval sigma in [0, 1].

    Attributes:
        sigma: Nodes, shape (N,), from 0 to 1.
        integrals: Node values to the Chebyshev coefficients of the interpolant (first), of its
            integral from 0 (second) and of its double integral (third), shapes (N + k, N).
        once: Node values to integrals from 0 at the nodes, shape (N, N).
        twice: The same integrated twice, shape (N, N).
        motion: ``twice`` and ``once``, shape (2, N, N).
        degrees: 0, 1, ..., N + 1.
        both: Node values to the coefficients of the double integral (first N columns) and of the
            single one (last N), shape (N + 2, 2 N).
        deflated: Node values to the coefficients of the double integral divided by sigma to the
            power 0, 1 and 2, shapes (N + 2 - k, N).
        between: Places halfway in angle between the nodes, shape (N - 1,).
        samples: Fine grid from 0 to 1, shape (S,).
        sample_value: Node values to values on the fine grid, shape (S, N).
        sample_twice: Node values to double integrals on the fine grid, divided by sigma to the
            power 0, 1 and 2 (limits at sigma = 0), shapes (S, N).
    """

    sigma: FloatArray
    integrals: tuple[FloatArray, FloatArray, FloatArray]
    once: FloatArray
    twice: FloatArray
    motion: FloatArray
    degrees: FloatArray
    both: FloatArray
    deflated: tuple[FloatArray, FloatArray, FloatArray]
    between: FloatArray
    samples: FloatArray
    sample_value: FloatArray
    sample_twice: tuple[FloatArray, FloatArray, FloatArray]


@cache
def nodes(order: int) -> Nodes:
    """Return the nodes and operators with this many nodes."""
    from numpy.polynomial import chebyshev

    sigma = _lobatto(order)
    coefficients = _transform(order)
    # lbnd = -1 makes every integral vanish at sigma = 0; 1/2 is dx -> dsigma.
    integrals: tuple[FloatArray, FloatArray, FloatArray] = (
        coefficients,
        np.asarray(chebyshev.chebint(coefficients, m=1, lbnd=-1, scl=0.5), dtype=np.float64),
        np.asarray(chebyshev.chebint(coefficients, m=2, lbnd=-1, scl=0.5), dtype=np.float64),
    )
    once = _basis(sigma, order + 1) @ integrals[1]
    twice = _basis(sigma, order + 2) @ integrals[2]
    # Integrals from 0 to 0, to the last bit: a gap that starts at zero is zero there.
    once[0] = twice[0] = 0.0
    both = np.zeros((order + 2, 2 * order))
    both[:, :order] = integrals[2]
    both[:-1, order:] = integrals[1]
    count = _SAMPLES_PER_NODE * order
    samples = 0.5 * (1.0 - np.cos(np.pi * np.arange(count + 1) / count))
    value = np.asarray(_basis(samples, order) @ integrals[0])
    # The first sample is the first node: its value is met to the last bit.
    value[0] = np.eye(order)[0]
    moved = _basis(samples, order + 2) @ integrals[2]
    moved[0] = 0.0
    return Nodes(
        sigma=sigma,
        integrals=integrals,
        once=once,
        twice=twice,
        motion=np.stack([twice, once]),
        degrees=np.arange(order + 2.0),
        both=both,
        deflated=(
            integrals[2],
            _transform(order + 1) @ _divided(integrals[2], _lobatto(order + 1), 1),
            _transform(order) @ _divided(integrals[2], sigma, 2),
        ),
        between=0.5 * (1.0 - np.cos(np.pi * (np.arange(order - 1) + 0.5) / (order - 1))),
        samples=samples,
        sample_value=value,
        sample_twice=(
            moved,
            _divided(integrals[2], samples, 1),
            _divided(integrals[2], samples, 2),
        ),
    )


def _lobatto(order: int) -> FloatArray:
    """Chebyshev-Lobatto nodes on [0, 1], shape (order,)."""
    return np.asarray(0.5 * (1.0 - np.cos(np.pi * np.arange(order) / (order - 1))))


def _transform(order: int) -> FloatArray:
    """Node values to Chebyshev coefficients, shape (order, order)."""
    return np.asarray(np.linalg.inv(_basis(_lobatto(order), order)), dtype=np.float64)


def _divided(double: FloatArray, sigma: FloatArray, power: int) -> FloatArray:
    """Double integrals at sigma, from 0 on, divided by sigma to a power, shape (len(sigma), N)."""
    values = _basis(sigma, len(double)) @ double
    values[1:] /= sigma[1:, None] ** power
    # The double integral grows like a(0) sigma^2 / 2 from its start.
    values[0] = 0.0
    values[0, 0] = 0.5 if power == 2 else 0.0
    return np.asarray(values)


def _basis(sigma: FloatArray, count: int) -> FloatArray:
    """Chebyshev polynomials of degree 0 to count - 1 at sigma, shape (len(sigma), count)."""
    angle = np.arccos(np.maximum(np.minimum(2.0 * sigma - 1.0, 1.0), -1.0))
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
    order = len(values)
    weights = _basis(sigma, order + 2) @ nodes(order).both
    return np.asarray(weights[:, :order] @ values), np.asarray(weights[:, order:] @ values)


def motion_weights(order: int, sigma: float) -> FloatArray:
    """Weights of node values in their double and their single integral to one place sigma.

    Args:
        order: Number of nodes.
        sigma: Place in [0, 1].

    Returns:
        Shape (2, order).
    """
    grid = nodes(order)
    return product(np.cos(_angle(sigma) * grid.degrees), grid.both).reshape(2, order)


def value_weights(order: int, sigma: float) -> FloatArray:
    """Weights of node values in their interpolant at one place sigma, shape (order,)."""
    grid = nodes(order)
    return product(np.cos(_angle(sigma) * grid.degrees[:order]), grid.integrals[0])


def _angle(sigma: float) -> float:
    """Angle whose cosine is the place of sigma between -1 and 1."""
    return math.acos(max(min(2.0 * sigma - 1.0, 1.0), -1.0))


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
        return values.repeat(count, 0)
    fine = product(_prolongation(len(values), count), values)
    if (count - 1) % (len(values) - 1) == 0:
        # Nodes of nested grids keep their values to the last bit.
        fine[:: (count - 1) // (len(values) - 1)] = values
    return fine


@cache
def _prolongation(coarse: int, fine: int) -> FloatArray:
    return np.asarray(_basis(nodes(fine).sigma, coarse) @ nodes(coarse).integrals[0])


class Series:
    """A Chebyshev series on [0, 1] for scalar evaluation in root searches.

    Args:
        coefficients: Coefficients, the constant one first, shape (N,).
    """

    def __init__(self, coefficients: FloatArray) -> None:
        """Keep the coefficients as plain numbers, which a loop of Python adds up fastest."""
        self.coefficients: list[float] = coefficients.tolist()

    @property
    def positive(self) -> bool:
        """True if the series is known to be positive: no Chebyshev polynomial exceeds one."""
        return self.coefficients[0] > sum(map(abs, self.coefficients[1:]))

    @property
    def falls(self) -> bool:
        """True if the series falls throughout: a polynomial of degree k has a slope below k^2."""
        rest = enumerate(self.coefficients[2:], start=2)
        return -self.coefficients[1] > sum(k * k * abs(value) for k, value in rest)

    @property
    def ends(self) -> tuple[float, float]:
        """Values at 0 and at 1, where Chebyshev polynomials are 1 or -1."""
        even, odd = sum(self.coefficients[::2]), sum(self.coefficients[1::2])
        return even - odd, even + odd

    def falls_once(self, left: float, right: float) -> tuple[float, float, float] | None:
        """The bracket and the zero of its chord if the series has one zero there, a fall."""
        if not self.falls:
            return None
        first, last = self.value(left), self.value(right)
        if not first > 0.0 >= last:
            return None
        return left, right, left + (right - left) * first / (first - last)

    def value(self, sigma: float) -> float:
        """Value at sigma."""
        return self.value_and_slope(sigma)[0]

    def value_and_slope(self, sigma: float) -> tuple[float, float]:
        """Value and first derivative at sigma, by Clenshaw's recurrence and its derivative."""
        x2 = 4.0 * sigma - 2.0
        high = low = slope_high = slope_low = 0.0
        for coefficient in self.coefficients[:0:-1]:
            slope_high, slope_low = 2.0 * high + x2 * slope_high - slope_low, slope_high
            high, low = coefficient + x2 * high - low, high
        value = self.coefficients[0] + 0.5 * x2 * high - low
        return value, 2.0 * (high + 0.5 * x2 * slope_high - slope_low)


def interpolant(values: FloatArray) -> Series:
    """Return the polynomial through node values, shape (N,), as a series."""
    return Series(product(nodes(len(values)).integrals[0], values))


def tail(values: FloatArray) -> FloatArray:
    """Size of the last two Chebyshev coefficients of every column of node values.

    Args:
        values: Node values, shape (N, columns).

    Returns:
        |c[N-1]| + |c[N-2]|, shape (columns,): what a finer grid would still add, at least.
    """
    last, last_but_one = np.abs(product(nodes(len(values)).integrals[0][-2:], values))
    return np.asarray(last + last_but_one)


def decayed(values: FloatArray) -> FloatArray:
    """Size of what follows the Chebyshev coefficients of node values, if they go on to decay.

    The last but one is made smaller by as much as it is smaller than the one before it: it takes
    part because the last one may vanish by chance, or by symmetry.

    Args:
        values: Node values, shape (N, columns).

    Returns:
        |c[N-1]| + |c[N-2]| min(1, |c[N-2] / c[N-3]|), shape (columns,); of so few nodes that
        c[N-3] is the constant, which tells nothing of the decay, as :func:`tail`.
    """
    if len(values) < _DECAY:
        return tail(values)
    final = np.abs(product(nodes(len(values)).integrals[0][-3:], values))
    before, second, last = final[0], final[1], final[2]
    return np.asarray(last + second * second / (np.maximum(before, second) + _TINY))

"""Lazy truncated power series in time, for any mpmath context (``mpmath.mp`` or ``mpmath.fp``).

A series x(t0 + tau) = sum_k x_k tau^k stores the coefficients known so far and a rule for the next
one. A rule may look at lower coefficients of any series, also of the one that is being built, so
the solution of an ordinary differential equation is an ordinary series whose rule is the equation.
Time is real: the conjugate of a complex series has the conjugate coefficients.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Any

from scipy.optimize import brentq

_EPS = 2.0**-52
Number = Any
"""mpf, mpc, float or complex: whatever the context works with."""


class Series:
    """Power series with lazily computed coefficients.

    Args:
        ctx: mpmath context that owns the numbers.
        known: coefficients that are given, lowest first.
        rule: k -> coefficient k, called once for each k beyond the given ones. Without a rule the
            series is a polynomial.
    """

    __slots__ = ("_rule", "coefficients", "ctx")

    def __init__(
        self,
        ctx: Any,
        known: Iterable[Number] = (),
        rule: Callable[[int], Number] | None = None,
    ) -> None:
        self.ctx = ctx
        self.coefficients = list(known)
        self._rule = rule if rule is not None else (lambda _k: ctx.zero)

    def __getitem__(self, k: int) -> Number:
        """Coefficient of tau^k."""
        c = self.coefficients
        while len(c) <= k:
            c.append(self._rule(len(c)))
        return c[k]

    def upto(self, order: int) -> list[Number]:
        """Coefficients 0..order."""
        self[order]
        return self.coefficients[: order + 1]

    def _like(self, rule: Callable[[int], Number]) -> Series:
        return Series(self.ctx, (), rule)

    def __add__(self, other: Series | Number) -> Series:
        if isinstance(other, Series):
            return self._like(lambda k: self[k] + other[k])
        return self._like(lambda k: self[k] + other if k == 0 else self[k])

    __radd__ = __add__

    def __neg__(self) -> Series:
        return self._like(lambda k: -self[k])

    def __sub__(self, other: Series | Number) -> Series:
        if isinstance(other, Series):
            return self._like(lambda k: self[k] - other[k])
        return self._like(lambda k: self[k] - other if k == 0 else self[k])

    def __rsub__(self, other: Number) -> Series:
        return (-self).__add__(other)

    def __mul__(self, other: Series | Number) -> Series:
        if not isinstance(other, Series):
            scale = other
            return self._like(lambda k: self[k] * scale)

        def rule(k: int) -> Number:
            return self.ctx.fdot(self.upto(k), other.upto(k)[::-1])

        return self._like(rule)

    __rmul__ = __mul__

    def __truediv__(self, other: Series) -> Series:
        quotient = Series(self.ctx)

        def rule(k: int) -> Number:
            if k == 0:
                return self[0] / other[0]
            known = self.ctx.fdot(quotient.coefficients[:k], other.upto(k)[:0:-1])
            return (self[k] - known) / other[0]

        quotient._rule = rule
        return quotient

    def power(self, exponent: Number, start: Number) -> Series:
        """The branch of x^p that has the value ``start`` at tau = 0.

        From x y' = p x' y: k x_0 y_k = sum_{j=1..k} (p j - (k - j)) x_j y_{k-j}.
        """
        y = Series(self.ctx)

        def rule(k: int) -> Number:
            if k == 0:
                return start
            x = self.upto(k)
            weighted = [(exponent * j - (k - j)) * x[j] for j in range(1, k + 1)]
            return self.ctx.fdot(weighted, y.coefficients[k - 1 :: -1]) / (k * x[0])

        y._rule = rule
        return y

    def sqrt(self) -> Series:
        """Principal square root."""
        return self.power(self.ctx.mpf("0.5"), self.ctx.sqrt(self[0]))

    def turn(self, start: Number) -> Series:
        """exp(i x) for a real series x, with ``start`` = exp(i x_0): y' = i x' y."""
        y = Series(self.ctx)

        def rule(k: int) -> Number:
            if k == 0:
                return start
            x = self.upto(k)
            slope = [j * x[j] for j in range(1, k + 1)]
            return self.ctx.mpc(0, 1) * self.ctx.fdot(slope, y.coefficients[k - 1 :: -1]) / k

        y._rule = rule
        return y

    def derivative(self) -> Series:
        """Derivative with respect to time."""
        return self._like(lambda k: (k + 1) * self[k + 1])

    def conj(self) -> Series:
        """Complex conjugate for real time."""
        return self._like(lambda k: self[k].conjugate())

    @property
    def real(self) -> Series:
        """Real part for real time."""
        return self._like(lambda k: self[k].real)

    @property
    def imag(self) -> Series:
        """Imaginary part for real time."""
        return self._like(lambda k: self[k].imag)

    def __call__(self, tau: Number, order: int) -> Number:
        """Value of the polynomial of the given order at tau (Horner)."""
        return horner(self.upto(order), tau)


def dot(a: Series, b: Series) -> Series:
    """Scalar product of two plane vectors held as complex series: Re(conj(a) b)."""
    return a.real * b.real + a.imag * b.imag


def cross(a: Series, b: Series) -> Series:
    """Cross product of two plane vectors, counter-clockwise positive: Im(conj(a) b)."""
    return a.real * b.imag - a.imag * b.real


def horner(coefficients: list[Number], x: Number) -> Number:
    """Value of a polynomial, lowest coefficient first."""
    total = coefficients[-1]
    for c in coefficients[-2::-1]:
        total = total * x + c
    return total


def slope(coefficients: list[Number]) -> list[Number]:
    """Coefficients of the derivative of a polynomial."""
    return [k * c for k, c in enumerate(coefficients)][1:]


def safe_step(coefficients: list[Number], tolerance: Number, ctx: Any) -> Number:
    """Length on which the last terms of a polynomial stay below a tolerance.

    Both of the last two terms must be below ``tolerance`` at the end of the step; the terms of a
    convergent series decay geometrically, so the neglected tail is a small multiple of that.
    """
    steps = []
    for k in (len(coefficients) - 1, len(coefficients) - 2):
        c = abs(coefficients[k])
        if c > 0:
            steps.append((tolerance / c) ** (ctx.one / k))
    return min(steps) if steps else ctx.inf


def first_root(
    coefficients: list[Number], end: Number, ctx: Any, falling: bool = True, samples: int = 64
) -> Number | None:
    """First zero of a polynomial on (0, end] where it falls (or changes sign, falling=False).

    Brackets come from sampling in double precision with the variable scaled to [0, 1]; Newton
    in the context's own precision polishes the root, with no loss of relative precision in it.
    """
    scale = ctx.one
    scaled = []
    for c in coefficients:
        scaled.append(c * scale)
        scale *= end
    size = max(abs(c) for c in scaled)
    if size == 0:
        return None
    scaled = [c / size for c in scaled]
    rough = [float(c) for c in scaled]
    places = _with_turns(slope(rough), [i / samples for i in range(samples + 1)])
    left = horner(rough, 0.0)
    for before, place in pairwise(places):
        right = horner(rough, place)
        down, up = left > 0 >= right, left < 0 <= right
        if down or (up and not falling):
            x = ctx.mpf(_root(rough, before, place))
            d = slope(scaled)
            for _ in range(4):
                x -= horner(scaled, x) / horner(d, x)
            return x * end
        left = right
    return None


def _with_turns(d: list[float], places: list[float]) -> list[float]:
    """Places with those between them where a slope changes sign: a dip may be that narrow."""
    turns = [
        _root(d, low, high)
        for low, high in pairwise(places)
        if horner(d, low) * horner(d, high) < 0
    ]
    return sorted(places + turns)


def _root(coefficients: list[float], low: float, high: float) -> float:
    """Where a polynomial changes its sign, as near as doubles come."""
    found = brentq(lambda x: horner(coefficients, x), low, high, xtol=1e-300, rtol=4.0 * _EPS)
    return float(found)

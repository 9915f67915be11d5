"""Gauss collocation of q'' = a(t, q, q') over one step, order 2 s at its end.

Source: E. Hairer, S. Norsett, G. Wanner, Solving Ordinary Differential Equations I, section II.7.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

Array = np.ndarray
Accelerations = Callable[[Array, Array, Array], Array]
_ITERATIONS, _STALLED = 40, 4
# Share of the accelerations that round-off of stiff forces may leave open.
_SETTLED = 1e-9
# Iterations after which stiffness counts as what makes them slow.
_PLAIN = 8
# Share of a coordinate, and of a rate, by which accelerations are differentiated.
_SHIFT = 1e-6


class Rule(NamedTuple):
    """Nodes on 0 to 1, integrals to the nodes and to the end, and the transform to Legendre."""

    nodes: Array
    once: Array
    twice: Array
    weights: Array
    moments: Array
    transform: Array


@cache
def rule(stages: int) -> Rule:
    """The Gauss rule with so many stages."""
    x, w = legendre.leggauss(stages)
    nodes, weights = 0.5 * (x + 1.0), 0.5 * w
    orders = np.arange(stages)
    values = legendre.legvander(x, stages - 1)
    transform = (2 * orders[:, None] + 1) * values.T * weights
    once = _integrals(stages, x) @ transform
    return Rule(nodes, once, once @ once, weights, weights * (1.0 - nodes), transform)


def _integrals(stages: int, x: Array) -> Array:
    """Integrals from 0 to the places x (on -1 to 1) of the Legendre polynomials."""
    integrals = [legendre.legint(one, lbnd=-1) for one in np.eye(stages)]
    return np.array([0.5 * legendre.legval(x, item) for item in integrals]).T


class Step(NamedTuple):
    """A step from t0 of length h: states at the nodes and at the end, and what is unresolved."""

    t0: float
    h: float
    q: Array
    v: Array
    a: Array
    q_end: Array
    v_end: Array
    tail: float


class Mixing:
    """Anderson's acceleration of a fixed-point iteration x = g(x), which stiff springs slow down.

    Source: H. F. Walker, P. Ni, SIAM J. Numer. Anal. 49 (2011) 1715.
    """

    def __init__(self, unit: Array, depth: int = 6) -> None:
        self.unit, self.depth = unit, depth
        self.places: list[Array] = []
        self.misses: list[Array] = []

    def next(self, x: Array, g: Array) -> Array:
        """The next place to try, from a place and the function there."""
        self.places.append((x / self.unit).ravel())
        self.misses.append(((g - x) / self.unit).ravel())
        del self.places[: -self.depth], self.misses[: -self.depth]
        if len(self.places) == 1:
            return g
        dX, dF = np.diff(np.array(self.places), axis=0).T, np.diff(np.array(self.misses), axis=0).T
        share = np.linalg.lstsq(dF, self.misses[-1], rcond=1e-12)[0]
        mixed = self.places[-1] + self.misses[-1] - (dX + dF) @ share
        return np.asarray(mixed.reshape(x.shape) * self.unit)


class Newton:
    """Simplified Newton steps for accelerations that depend on a few coordinates stiffly.

    The nodes of a step solve a = f(q0 + h c v0 + h^2 A^2 a, v0 + h A a); derivatives of f by these
    coordinates are those at one of the nodes, the others are left out.
    """

    def __init__(
        self, f: Accelerations, t: float, q: Array, v: Array, h: float, r: Rule, unit: Array,
        stiff: Array,
    ) -> None:  # fmt: skip
        self.stiff, self.h, self.r = stiff, h, r
        few, stages = len(stiff), len(r.nodes)
        fastest = max(float(np.abs(v / unit).max()), 1.0 / h)
        states = np.repeat(np.array([[q, v]]), 2 * few + 1, axis=0)
        rows = np.arange(1, few + 1)
        states[rows, 0, stiff] += _SHIFT * unit[stiff]
        states[few + rows, 1, stiff] += _SHIFT * fastest * unit[stiff]
        found = f(np.full(len(states), t), states[:, 0], states[:, 1])
        changes = (found[1:] - found[0]) / _SHIFT
        self.by_q = (changes[:few] / unit[stiff, None]).T
        self.by_v = (changes[few:] / (fastest * unit[stiff, None])).T
        matrix = np.eye(stages * few) - h * h * np.kron(r.twice, self.by_q[stiff])
        self.inverse = np.linalg.inv(matrix - h * np.kron(r.once, self.by_v[stiff]))

    def correction(self, missing: Array) -> Array:
        """Change of the accelerations at the nodes that what is missing of them asks for."""
        own = self.inverse @ missing[:, self.stiff].ravel()
        own = own.reshape(len(missing), -1)
        h, r = self.h, self.r
        return np.asarray(
            missing + h * h * (r.twice @ own) @ self.by_q.T + h * (r.once @ own) @ self.by_v.T
        )


def step(
    f: Accelerations, t0: float, h: float, q0: Array, v0: Array, guess: Array, unit: Array,
    stages: int, floor: float, stiff: Array,
) -> Step | None:  # fmt: skip
    """One step; None if the iteration does not settle.

    Accelerations are guessed at the start or at the nodes. ``unit`` is the size of one in each
    coordinate, and an acceleration of ``floor`` of them counts as none beside what the machine
    does; on ``stiff`` coordinates accelerations may depend stiffly.
    """
    r = rule(stages)
    t = t0 + h * r.nodes
    a = np.broadcast_to(guess, (stages, len(q0))).copy()
    mixing, best, stalled = Mixing(unit), np.inf, 0
    settled, scale, newton = a, floor, None
    for number in range(_ITERATIONS):
        q = q0 + h * r.nodes[:, None] * v0 + h * h * (r.twice @ a)
        v = v0 + h * (r.once @ a)
        found = f(t, q, v)
        change = float((np.abs(found - a) / unit).max())
        size = float((np.abs(found) / unit).max()) + floor
        if not np.isfinite(change) or change > 1e6 * size:
            return None
        # It settles on round-off, which a stiff drive train makes larger.
        stalled = stalled + 1 if change > 0.5 * best else 0
        if change < best:
            best, settled, scale = change, found, size
        settles = 1e-12 if newton is None else _SETTLED
        if change <= 1e-15 * size or (stalled >= _STALLED and best < settles * size):
            break
        if number == _PLAIN and len(stiff):
            middle = stages // 2
            newton = Newton(f, t[middle], q[middle], v[middle], h, r, unit, stiff)
            mixing = Mixing(unit)
        a = mixing.next(a, found if newton is None else a + newton.correction(found - a))
    # Beside the size that it had there: an iteration that runs away grows beyond any change.
    size = scale
    if best > _SETTLED * size:
        return None
    a = settled
    q_end = q0 + h * v0 + h * h * (r.moments @ a)
    v_end = v0 + h * (r.weights @ a)
    q = q0 + h * r.nodes[:, None] * v0 + h * h * (r.twice @ a)
    v = v0 + h * (r.once @ a)
    tail = float((np.abs(r.transform[-2:] @ a) / unit).max()) / size
    return Step(t0, h, q, v, a, q_end, v_end, tail)


def values_between(nodes: Array, sigma: Array) -> Array:
    """The polynomial through values at the nodes (s, ...) at places 0 to 1."""
    coefficients = rule(len(nodes)).transform @ nodes
    return legendre.legvander(2.0 * sigma - 1.0, len(nodes) - 1) @ coefficients


def integrated(nodes: Array, sigma: Array) -> tuple[Array, Array]:
    """Single and double integral from 0 to the places 0 to 1, as factors of sigma, sigma^2.

    Divided by sigma and sigma squared they keep their relative precision near the start.
    """
    r = rule(len(nodes))
    # Over 0 to sigma by the same rule, exact for these polynomials.
    places = sigma[:, None] * r.nodes
    inner = values_between(nodes, places.ravel()).reshape(places.shape)
    return inner @ r.weights, inner @ r.moments

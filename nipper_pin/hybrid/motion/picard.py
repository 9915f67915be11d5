"""Panels of phases with freedom: Picard iteration on nested collocation grids."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from ...arrays import FloatArray, largest, product
from ...chebyshev import decayed, nodes, prolonged
from ...dynamics import ConstraintSet, Partition, System
from ...errors import SimulationError
from ...tolerances.hybrid import (
    COORDINATE_ROUND_OFF,
    ITERATION_FLOOR,
    NOTICED_ROUND_OFF,
    ROUND_OFF_SAFETY,
    SMALLEST,
)
from ..case import Resolution
from .noise_floor import of_closures, roughness
from .panel import Attempt, Begin, Panel, forces_at, judged, shorter

# The error of sweep k behaves like (L h)^k / k!, so the first sweeps may gain little; later ones
# that gain less than this show a panel too long for the iteration.
_FREE_SWEEPS = 4
# But none of them a change by this multiple of the motion, whose square and cube would follow.
_DIVERGED = 1e9
_WORST_CONTRACTION = 0.5
# Sweeps over the finest of nested grids after which the last coefficients are known: what follows
# them, if it is so many times too large, no other sweep makes small enough.
_TELLING_SWEEPS, _TOO_ROUGH = 2, 2.0
# Coefficients that decay by less from grid to grid are round-off.
_DECAYS = 0.1
# Contraction of the sweeps on a panel that is short beside all that happens on it: the few nodes of
# a coarse grid are to be trusted.
_SHORT = 1e-2
# Sweeps start on coarse grids, nested in the finest one, and move on when they have gained what
# such a grid can hold; a short flight never needs the finest one.
_COARSE_STRIDES = (4, 2)
_COARSE_SWEEPS = 2
_MAX_SWEEPS = 24
_EASY_SWEEPS = 14
# What a coarse grid foretells of the finest one is an estimate, and has to be so much too large.
_FORESEEN_ROUGH = 8.0
# Growth of panels as long as they do not need the finest grid.
_LONGER = 2.0
# Motion on one panel [rad or m] beyond which inertia could no longer be neglected beside that of a
# held shaft.
_RUN_AWAY = 1e9


def _next(moved: FloatArray, guess: FloatArray) -> float:
    """Estimate of the change by a third sweep from those by two, (N - 1, nv): the largest one.

    The first change is that of the guess: a large one, of a coordinate that is then right at once,
    would hide another one that hardly moves towards its solution.
    """
    latest, first = largest(moved), largest(guess)
    return float((latest * latest / (first + SMALLEST)).max())


class PicardIteration:
    """Picard iteration of one panel of the length h [s].

    Attributes:
        finest: Number of nodes of the finest grid.
        tolerance: Relative change of the positions that ends the iteration.
        count: Number of sweeps.
    """

    def __init__(
        self, system: System, phase: ConstraintSet, begin: Begin, h: float, resolution: Resolution
    ) -> None:
        """Compute what no sweep changes."""
        self._system, self._phase, self._h = system, phase, h
        self.finest = finest = resolution.flight_nodes
        self.tolerance = resolution.tolerance if resolution.adaptive else ITERATION_FLOOR
        # Whether the iteration starts on coarser grids.
        self._nested = resolution.adaptive and (finest - 1) % _COARSE_STRIDES[0] == 0
        t, q, v, _, _ = begin
        elapsed = h * nodes(finest).sigma
        motion = system.shaft.driven(t + elapsed, t + 0.5 * h)
        self._forcing = system.forcing(motion, phase)
        # Motion without acceleration; that of held drives is known.
        self._lines = np.empty((2, finest, len(q)))
        self._lines[0] = q + elapsed[:, None] * v
        self._lines[1] = v
        if system.held:
            self._lines[0][:, system.driven_columns] = motion[0]
            self._lines[1][:, system.driven_columns] = motion[1]
        # Way on the panel beside which changes of positions count, shape (nv,).
        self._way = np.abs(h * v) + SMALLEST
        # Relative change of positions by change of acceleration, shape (nv,); the same for every
        # node: arrays of one shape are multiplied three times as fast as a row is repeated.
        self._weight = np.empty(0)
        self._weights = np.empty((finest, len(q)))
        self._free = system.free[None].repeat(finest, 0)
        # Relative changes of positions in the latest sweep, shape (N - 1, nv).
        self._moved = np.empty((0, len(q)))
        self._start = t, q, v
        self._smooth = system.elements is None
        self._still = ROUND_OFF_SAFETY * COORDINATE_ROUND_OFF * system.shaft.rate**2
        self._allowed = False
        self._change = np.inf
        self._contraction = 1.0
        # What turns integrals over the unit interval into positions and velocities.
        self._scales = np.array([h * h, h])[:, None, None]
        self.count, self._too_rough = 0, False

    def swept(self, a: FloatArray) -> tuple[FloatArray, float] | tuple[None, float]:
        """Sweep over one grid after the other, from the first node, until one resolves the motion.

        Returns:
            Accelerations at the nodes and what they leave over; or None and the ratio of the length
            of the next attempt.
        """
        tolerance, finest = self.tolerance, self.finest
        for stride in _COARSE_STRIDES if self._nested else ():
            a = prolonged(a, (finest - 1) // stride + 1)
            if self._converges(a, stride, _COARSE_SWEEPS) or (
                self._nearly(a) and self._converges(a, stride, 1)
            ):
                left_over = self.left_over(a)
                if left_over <= tolerance:
                    return a, left_over
            elif stride == _COARSE_STRIDES[-1]:
                foreseen = self._foreseen(a)
                if foreseen > _FORESEEN_ROUGH * tolerance:
                    return None, shorter(foreseen / tolerance, finest)
        a = prolonged(a, finest)
        if not self._converges(a, 1, _MAX_SWEEPS):
            if self._too_rough:
                return None, shorter(self.left_over(a) / tolerance, finest)
            settled = self.allows_round_off() and np.abs(self._moved).max(initial=0.0) <= tolerance
            if not settled:
                return None, 0.5
        return a, self.left_over(a)

    def _converges(self, a: FloatArray, stride: int, most: int) -> bool:
        """Sweep over a grid, in place, until another sweep would change nothing that matters.

        The stride leads from node to node on the finest grid; the first acceleration is exact.
        """
        count, h, system, tolerance = len(a), self._h, self._system, self.tolerance
        # Nothing changes at the first node.
        operator = (nodes(count).motion[:, 1:] * self._scales).reshape(-1, count)
        lines, forcing = self._lines[:, stride::stride].copy(), self._forcing[stride::stride].copy()
        moved = unknown = a[1:]
        shape, free, weights = lines.shape, self._free[:count], self._weights[1:count]
        for sweep in range(1, most + 1):
            # Unpacked, an array would be iterated until an IndexError that nobody sees.
            states = product(operator, a * free).reshape(shape) + lines
            v = states[1]
            new = system.respond(forcing, states[0], v, self._phase)
            if not self._weight.size:
                self._way += h**2 * largest(new)
                self._weigh()
                if max(self._weight.tolist()) * self._still > tolerance:
                    # A link stands nearly still: all that it has may be round-off of the others.
                    self._allow(of_closures(system, v[0], new[0]))
            guess, moved = moved, (new - unknown) * weights
            self._moved = moved
            # The Euclidean norm bounds the largest element, and is found faster.
            previous, change = self._change, math.sqrt(np.vdot(moved, moved))
            self._change = change
            if not change < _DIVERGED:
                return False
            unknown[:] = new
            self.count += 1
            # The first sweep of a grid shows what the one before did not hold.
            known = self._contraction if sweep == 1 else 0.0
            self._contraction = min(max(change / max(previous, SMALLEST), known), 1.0)
            # The next sweep would change by this times the contraction, so it is not needed.
            if change * self._contraction <= tolerance and (
                sweep == 1 or self.count > 2 or _next(moved, guess) <= tolerance
            ):
                return True
            if stride == 1 and sweep == _TELLING_SWEEPS and self._is_too_rough(a):
                self._too_rough = True
                return False
            if sweep > _FREE_SWEEPS and change > _WORST_CONTRACTION * previous:
                return change <= ITERATION_FLOOR
        return False

    def _weigh(self) -> None:
        # What is prescribed does not move: its accelerations are round-off of the armature.
        self._weight = self._weights[:] = self._h**2 * self._phase.moving / self._way

    def left_over(self, a: FloatArray) -> float:
        """Relative change of positions by what follows the last coefficients of accelerations.

        Two integrations divide the coefficient of degree k by about (2 k)^2.
        """
        # Of a few finite numbers the largest is found faster without numpy.
        most: float = max((decayed(a) * self._weight).tolist())
        return most / (2.0 * len(a)) ** 2

    def _nearly(self, a: FloatArray) -> bool:
        """True if one more sweep ends the iteration on a grid that resolves the motion."""
        if self._contraction > _SHORT or not self._smooth:
            return False
        next_but_one = self._change * self._contraction**2
        return next_but_one <= self.tolerance and self.left_over(a) <= self.tolerance

    def _foreseen(self, a: FloatArray) -> float:
        """What :meth:`left_over` will be on the next grid, if coefficients go on to decay.

        From grid to grid the degree doubles. Zero where they do not decay, as those of round-off,
        and where tables or struts may bend the motion between two nodes.
        """
        if not self._smooth:
            return 0.0
        here, before = self.left_over(a), self.left_over(a[::2])
        return here * (here / before) ** 2 if here < _DECAYS * before else 0.0

    def _is_too_rough(self, a: FloatArray) -> bool:
        """True if what follows the last coefficients is too large, even beside round-off."""
        least = _TOO_ROUGH * self.tolerance
        if not self._nested or self.left_over(a) <= least:
            return False
        beside = self._weight * (self._way / (self._way + self._allowance(self._roughness)))
        return float(np.maximum.reduce(decayed(a) * beside)) > least * (2.0 * len(a)) ** 2

    @cached_property
    def _roughness(self) -> FloatArray:
        """Round-off of accelerations at the start of the panel, shape (nv,)."""
        return roughness(self._system, self._phase, *self._start)

    def allows_round_off(self) -> bool:
        """Weigh anew, so that round-off of accelerations is allowed; True if that matters."""
        if self._allowed or not self._weight.size:
            return False
        self._allowed = True
        return self._allow(self._roughness)

    def _allow(self, rough: FloatArray) -> bool:
        """Weigh changes beside round-off of accelerations, too; True if that matters anywhere."""
        allowance = self._allowance(rough)
        matters = bool((self._phase.moving * (allowance > NOTICED_ROUND_OFF * self._way)).any())
        self._moved = self._moved * (self._way / (self._way + allowance))
        self._way += allowance
        self._weigh()
        return matters

    def _allowance(self, rough: FloatArray) -> FloatArray:
        """Ways beside which round-off of accelerations is within the tolerance, shape (nv,)."""
        return np.asarray(ROUND_OFF_SAFETY * self._h**2 * rough / self.tolerance)

    def motion(self, a: FloatArray) -> FloatArray:
        """Positions and velocities at the nodes, shape (2, N, nv), of accelerations there."""
        count = len(a)
        operator = nodes(count).motion.reshape(-1, count)
        moved = product(operator, a * self._free[:count]).reshape(2, *a.shape)
        stride = (self._lines.shape[1] - 1) // (count - 1)
        return np.asarray(moved * self._scales + self._lines[:, ::stride])


def flight_panel(
    system: System,
    phase: ConstraintSet,
    split: Partition,
    begin: Begin,
    h: float,
    resolution: Resolution,
) -> Attempt:
    """Motion of a phase with freedom for a time h [s]; its first node has the given acceleration.

    Raises:
        SimulationError: A link has run away, as one does that a turning shaft throws outwards.
    """
    if h * h * np.vdot(begin.v, begin.v) > _RUN_AWAY**2:
        raise _run_away(system, h * begin.v)
    sweeps = PicardIteration(system, phase, begin, h, resolution)
    none = np.empty((0, len(phase.stops)))
    a, left_over = sweeps.swept(begin.a[None])
    if a is None:
        return Attempt(None, none, left_over)
    moved = sweeps.motion(a)
    q_nodes, v_nodes = moved[0], moved[1]
    panel = Panel(begin.t, h, q_nodes, v_nodes, a, split, integrated=True)
    forces = forces_at(system, phase, panel, panel.times)[3].la_N if phase.stops else none
    if not resolution.adaptive:
        return Attempt(panel, forces, 1.0)
    hard, tolerance = sweeps.count > _EASY_SWEEPS, sweeps.tolerance
    if left_over > tolerance and sweeps.allows_round_off():
        left_over = sweeps.left_over(a)
        if left_over <= tolerance:
            # No shorter panel would resolve it either.
            return Attempt(panel, forces, 1.0 if hard else _LONGER)
    if len(a) < sweeps.finest and not hard:
        # A coarse grid was enough, and a panel that only just suits it would stay short for ever.
        return Attempt(panel, forces, _LONGER)
    attempt = judged(panel, forces, left_over / tolerance, len(a))
    return attempt._replace(factor=min(attempt.factor, 1.0)) if hard else attempt


def _run_away(system: System, moved: FloatArray) -> SimulationError:
    """The error of a coordinate that moves too far on one panel."""
    fastest = int(np.argmax(np.abs(moved)))
    name = system.mechanism.joints[fastest].name
    message = (
        f"joint {name} runs away: it moves by {abs(moved[fastest]):.2g} (rad or m) in one step "
        "and nothing holds it; give it a stop or a spring, or simulate a shorter time"
    )
    return SimulationError(message, joint=name, moved=float(moved[fastest]))

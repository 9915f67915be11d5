"""Variational equation: deviations at the end of a panel, linear in those at its start.

The free independent coordinates y of a panel tell the others, q(y) and v(y, y'). Neighbouring
motions differ in them by dy, with

    ddy = A(t) dy + B(t) dy',    A = da/dy at y' held,  B = da/dy',

A and B being differences of accelerations at the nodes. The collocation that integrates the panel
solves this linear equation, too: for the accelerations of dy at the nodes, a small linear system of
each part of the machine.

Parts that do not touch one another answer each for itself: a motion beside another one in every
part at once tells of all of them what one beside it in a single part tells of that.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray, Vectors
from ...chebyshev import evaluate_motion, nodes
from ...dynamics import ConstraintSet, Partition, System, close_velocities
from ...mechanism import Stop
from ...tolerances.hybrid import DIFFERENCE_STEP, SMALLEST
from ..motion.panel import Panel


def free_coordinates(phase: ConstraintSet, split: Partition) -> list[int]:
    """Independent coordinates that forces move: one for each freedom of a phase."""
    return [k for k in split.independent if phase.moving[k]]


@dataclass(frozen=True, eq=False)
class Freedoms:
    """Coordinates that are moved each for itself, those of different parts at once.

    Attributes:
        units: What each coordinate is measured in, shape (nv,) [rad or m].
        columns: The coordinates, F of them.
        part: Place of the part of each in ``members``.
        members: Coordinates of every part.
    """

    units: FloatArray
    columns: tuple[int, ...]
    part: tuple[int, ...]
    members: tuple[NDArray[np.intp], ...]

    @classmethod
    def of(cls, system: System, columns: Sequence[int]) -> Freedoms:
        """Coordinates of any parts, no held shaft among them."""
        numbers = system.parts[list(columns)].tolist()
        # The number of a part is one of its coordinates.
        found = list(dict.fromkeys(numbers)) or [0]
        members = [system.members(number) for number in found]
        part = tuple(found.index(number) for number in numbers)
        return cls(system.body.units, tuple(columns), part, tuple(members))

    @classmethod
    def of_one(cls, system: System, columns: Sequence[int], members: NDArray[np.intp]) -> Freedoms:
        """Coordinates of one part, whose members are, held shafts that move it among them."""
        return cls(system.body.units, tuple(columns), (0,) * len(columns), (members,))

    @classmethod
    def struck(cls, system: System, split: Partition, stops: Sequence[Stop]) -> Freedoms:
        """Independent coordinates of the part of stops, of which there is one at least."""
        members = system.members(stops[0].index)
        return cls.of_one(system, [k for k in split.independent if k in members], members)

    @cached_property
    def direction(self) -> tuple[int, ...]:
        """Which one of its part each coordinate is: those of one number are moved at once."""
        return tuple(self.part[:place].count(part) for place, part in enumerate(self.part))

    @cached_property
    def directions(self) -> FloatArray:
        """The coordinates that are moved at once, by ones, shape (C, nv)."""
        found = np.zeros((max(self.direction, default=-1) + 1, len(self.units)))
        found[list(self.direction), list(self.columns)] = 1.0
        return found

    @cached_property
    def own(self) -> NDArray[np.bool_]:
        """True where a coordinate is of the part of a freedom, shape (nv, F)."""
        found = np.zeros((len(self.units), len(self.members)), dtype=np.bool_)
        for place, members in enumerate(self.members):
            found[members, place] = True
        return found[:, list(self.part)]

    def alike(self) -> Iterator[NDArray[np.intp]]:
        """Places of the freedoms of parts with as many as one another, shape (P, f)."""
        places: list[list[int]] = [[] for _ in self.members]
        for place, part in enumerate(self.part):
            places[part].append(place)
        for count in sorted({len(own) for own in places} - {0}):
            yield np.array([own for own in places if len(own) == count])

    def steps(self, tangents: FloatArray) -> FloatArray:
        """Steps of difference quotients, (C, parts), by derivatives along each, (C, N, nv)."""
        sizes = self.largest(np.abs(tangents / self.units).max(axis=1, initial=0.0))
        most = np.maximum(sizes, self.largest(self.directions / self.units))
        # Parts of fewer freedoms than others do not move in the last directions.
        return np.asarray(DIFFERENCE_STEP / np.where(most > 0.0, most, 1.0))

    def fastest(self, v: Vectors) -> FloatArray:
        """Largest rate of each part in units of its coordinate [1/s], never zero, (parts,)."""
        return np.maximum(self.largest(np.abs(v / self.units).max(axis=0)), SMALLEST)

    def largest(self, values: FloatArray) -> FloatArray:
        """Largest value in each part, shape (..., parts), of one for each coordinate, (..., nv)."""
        ends = np.cumsum([0, *(len(own) for own in self.members[:-1])])
        found: FloatArray = np.maximum.reduceat(
            values[..., np.concatenate(self.members)], ends, axis=-1
        )
        return found

    def spread(self, values: FloatArray) -> FloatArray:
        """Values of parts at each of their coordinates, shape (C, 1, nv), from (C, parts)."""
        found = np.zeros((len(values), 1, len(self.units)))
        for place, members in enumerate(self.members):
            found[:, 0, members] = values[:, place, None]
        return found


def lifts(jacobian: FloatArray, split: Partition, directions: FloatArray) -> FloatArray:
    """Derivatives of all coordinates along independent ones at N states, (C, N, nv), by (C, nv)."""
    units = directions[:, None].repeat(len(jacobian), axis=1)
    repeated = np.tile(jacobian, (len(directions), 1, 1))
    flat = units.reshape(-1, directions.shape[1])
    return close_velocities(flat, repeated, split).reshape(units.shape)


def tangents(
    system: System, q: Vectors, v: Vectors, split: Partition, along: Freedoms
) -> tuple[FloatArray, FloatArray]:
    """Derivatives of all coordinates and rates along freedoms in C directions, at N states.

    Returns:
        dq/dy = dv/dy' and dv/dy at independent rates held, shapes (C, N, nv).
    """
    units = lifts(system.body.closures(q)[1], split, along.directions)
    step = along.spread(along.steps(units))
    moved = (q + step * units).reshape(-1, q.shape[1])
    rates = np.tile(v, (len(units), 1))
    followed = close_velocities(rates, system.body.closures(moved)[1], split)
    # No coordinate of a part without freedom moves.
    return units, (followed - rates).reshape(units.shape) / np.where(step > 0.0, step, 1.0)


def flight_map(
    system: System, phase: ConstraintSet, panel: Panel, length: float
) -> tuple[FloatArray, FloatArray]:
    """Carries deviations of a state over the first part of a flight panel, of a length [s].

    Returns:
        Deviations (dq, dv) at the end by those at the start, shape (2 nv, 2 nv); and by dy and dy'
        at the end, shape (2 nv, 2 f), in the order of the free coordinates. Neither has anything
        where one part of the machine would move another one.
    """
    along = Freedoms.of(system, free_coordinates(phase, panel.split))
    end = panel.interpolate(np.array([panel.t + length]))
    q, v = (np.vstack(pair) for pair in zip((panel.q, panel.v), end, strict=True))
    units, turned = tangents(system, q, v, panel.split, along)
    slopes = _slopes(system, phase, panel, along, units[:, :-1], turned[:, :-1])
    found = _propagated(slopes, panel, length, along)
    f, nv, each = len(along.columns), system.body.nv, list(along.direction)
    unit, turn = (np.where(along.own, part[each, -1].T, 0.0) for part in (units, turned))
    lifted = np.block([[unit, np.zeros((nv, f))], [turn, unit]])
    whole = np.zeros((2 * nv, 2 * nv))
    whole[:, [*along.columns, *(nv + k for k in along.columns)]] = lifted @ found
    return whole, lifted


def _slopes(
    system: System,
    phase: ConstraintSet,
    panel: Panel,
    along: Freedoms,
    units: FloatArray,
    turned: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """A and B at the nodes of a panel, of all coordinates: shapes (N, nv, C) [1/s^2, 1/s].

    ``units`` and ``turned`` are what :func:`tangents` gives there.
    """
    count, nv, nodes_of = len(units), system.body.nv, panel.order
    x = along.steps(units)
    aside, faster = along.spread(x), along.spread(x * along.fastest(panel.v))
    still = np.zeros((1, nodes_of, nv))
    q = panel.q + np.concatenate([still, aside * units, 0.0 * units])
    v = panel.v + np.concatenate([still, aside * turned, faster * units])
    # One call for all; the forces of the drives are those of the nodes.
    motion = system.shaft.driven(panel.times, panel.middle)
    forcing = np.tile(system.forcing(motion, phase), (2 * count + 1, 1))
    a = system.respond(forcing, q.reshape(-1, nv), v.reshape(-1, nv), phase)
    a = a.reshape(2 * count + 1, nodes_of, nv)
    steps = np.concatenate([aside, faster])
    # No coordinate of a part without freedom moves.
    slopes = np.moveaxis((a[1:] - a[0]) / np.where(steps > 0.0, steps, 1.0), 0, 2)
    return slopes[:, :, :count], slopes[:, :, count:]


def _propagated(
    slopes: tuple[FloatArray, FloatArray], panel: Panel, length: float, along: Freedoms
) -> FloatArray:
    """Deviations dy, dy' after a length [s] by those at the start of a panel, (2 f, 2 f)."""
    count, columns = len(along.columns), np.array(along.columns, dtype=np.intp)
    whole = np.zeros((2 * count, 2 * count))
    for places in along.alike():
        number, f = places.shape
        by_place, by_rate = (np.moveaxis(item[:, columns[places], :f], 1, 0) for item in slopes)
        flat = np.moveaxis(_variations(by_place, by_rate, panel.h), 1, 0).reshape(panel.order, -1)
        integrals = evaluate_motion(flat, np.array([length / panel.h]))
        twice, once = (integral.reshape(number, f, 2 * f) for integral in integrals)
        one = np.eye(f)
        found = np.block([[one, length * one], [np.zeros((f, f)), one]])
        found = found + np.concatenate([panel.h**2 * twice, panel.h * once], axis=1)
        rows = np.concatenate([places, count + places], axis=1)
        whole[rows[:, :, None], rows[:, None]] = found
    return whole


def _variations(places: FloatArray, rates: FloatArray, h: float) -> FloatArray:
    """Accelerations of dy at the nodes for unit dy and dy' at the start, (P, N, f, 2 f).

    They follow from A [1/s^2] and B [1/s] of P parts with f free coordinates each, (P, N, f, f).
    """
    number, count, f = places.shape[:3]
    grid = nodes(count)
    matrix = np.eye(count * f).reshape(count, f, count, f)
    matrix = matrix - h**2 * np.einsum("pjik,jl->pjilk", places, grid.twice)
    matrix -= h * np.einsum("pjik,jl->pjilk", rates, grid.once)
    later = h * grid.sigma[:, None, None] * places + rates
    right = np.concatenate([places, later], axis=3).reshape(number, count * f, -1)
    found = np.linalg.solve(matrix.reshape(number, count * f, -1), right)
    return np.asarray(found.reshape(number, count, f, 2 * f))

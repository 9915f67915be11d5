"""Saltation matrix: deviations after impulses, linear in those before them.

A neighbouring motion strikes later by dt, at another place and with other rates. At its own time it
deviates by (dq + v- dt, dv + a- dt); the impact law carries that over to the rates after, and back
at the time of the collision it deviates by that less (v+, a+) dt.

Source: N. J. Kong, J. J. Payne, J. Zhu, A. M. Johnson, Saltation Matrices: The Essential Tool for
Linearizing Hybrid Dynamical Systems, arXiv 2306.06862.

Stops that are struck in one event a neighbouring motion strikes at times of their own: by dt after
the first one, until when it goes on without the change of velocity u that this stop makes, with the
accelerations from before. At the time of the first one it deviates by -u dt, and what u moves has
struck with other rates. Parts that do not touch are followed apart (:class:`.Part`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray, Vector
from ...dynamics import Partition, System
from ...dynamics.impact_laws import solve_impact
from ...mechanism import Stop
from ...tolerances.hybrid import DIFFERENCE_STEP, NEGLIGIBLE_DEVIATION
from ..history import Event, Segment
from .variational import Freedoms, lifts, tangents
from .zonotope import Part, Zonotope


def impact_map(
    system: System,
    q: Vector,
    v: FloatArray,
    struck: Sequence[Stop],
    restitution: Sequence[float],
    slopes: Sequence[float] | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Derivative of the impact law at stops that receive an impulse.

    Args:
        v: Velocity before, shape (nv,).
        struck: The stops, all of one part of the machine.
        restitution: e_N of each; zero takes their rates away.
        slopes: -d(rate after)/d(rate before) of each, where a law makes e_N depend on the rate;
            None if all are constant.

    Returns:
        Deviations (dq, dv) after by those before, both at the time at which the neighbouring motion
        strikes, shape (2 nv, 2 nv); and those of the impulses, shape (struck, 2 nv). By those of
        other parts there are none.
    """
    nv = system.body.nv
    _, jacobian = system.body.closures(q[None])
    columns = tuple(stop.index for stop in struck)
    split = system.split(jacobian[0], system.held_coordinates, columns)
    along = Freedoms.struck(system, split, struck)
    y = list(along.columns)
    units, turned = (part[:, 0] for part in tangents(system, q[None], v[None], split, along))
    steps = along.steps(units[:, None])
    aside = np.vstack([q, q + steps * units])
    laws = _laws(system, aside, split, struck, restitution)
    neighbours = np.vstack([v, v + steps * turned])[:, :, None]
    after, law = (laws @ neighbours)[:, :, 0], laws[0]
    if slopes is not None:
        # Of the change with the rates, which the coefficients of these impacts leave out.
        steeper = _laws(system, q[None], split, struck, slopes)[0]
        after = after + (neighbours - neighbours[0])[:, :, 0] @ (steeper - law).T
        law = steeper
    found = np.zeros((2 * nv + len(struck), 2 * nv))
    found[:nv, y] = units.T
    found[nv:, y] = ((after[1:] - after[0]) / steps).T
    found[nv:, [nv + k for k in y]] = law @ units.T
    return found[: 2 * nv], found[2 * nv :]


def pushed_by(system: System, q: Vector, stop: Stop, impulse: float) -> FloatArray:
    """Change of velocity by the impulse of one stop alone [N s or N m s], shape (nv,)."""
    _, jacobian = system.body.closures(q[None])
    split = system.split(jacobian[0], system.held_coordinates, (stop.index,))
    mass, units = _free_mass(system, q[None], jacobian, split, [stop])
    pushed = stop.sense * impulse * units[0, stop.index]
    return np.asarray(units[0] @ np.linalg.solve(mass[0], pushed))


def _laws(
    system: System,
    q: FloatArray,
    split: Partition,
    struck: Sequence[Stop],
    restitution: Sequence[float],
) -> FloatArray:
    """Velocities after, then impulses of the stops, by velocities before: (N, nv + struck, nv)."""
    nv = system.body.nv
    mass, units = _free_mass(system, q, system.body.closures(q)[1], split, struck)
    gaps = np.zeros((len(struck), nv))
    gaps[range(len(struck)), [stop.index for stop in struck]] = [stop.sense for stop in struck]
    rows = gaps @ units
    response = np.linalg.solve(mass, np.swapaxes(rows, 1, 2))
    wanted = -(1.0 + np.array(restitution))[:, None] * gaps
    impulses = np.linalg.solve(rows @ response, np.broadcast_to(wanted, (len(q), *wanted.shape)))
    return np.concatenate([np.eye(nv) + units @ response @ impulses, impulses], axis=1)


def _free_mass(
    system: System,
    q: FloatArray,
    jacobian: FloatArray,
    split: Partition,
    struck: Sequence[Stop],
) -> tuple[FloatArray, FloatArray]:
    """Mass matrices of what impulses at stops move, (N, K, K), and what it lifts to, (N, nv, K)."""
    reached = Freedoms.struck(system, split, struck).columns
    free = [k for k in reached if k not in system.held_coordinates]
    units = np.moveaxis(lifts(jacobian, split, np.eye(system.body.nv)[free]), 0, 2)
    mass = system.body.mass_matrices(q)
    if not system.held:
        mass += np.diag(system.drive_armature)
    return np.swapaxes(units, 1, 2) @ mass @ units, units


# Strikes of one impact that are followed at its neighbours; more are a series without an end.
_MOST_STRIKES = 1000


def sequence_map(
    system: System,
    q: Vector,
    v: FloatArray,
    contacts: Sequence[Stop],
    pushed: Sequence[Stop],
) -> tuple[FloatArray, FloatArray]:
    """As :func:`impact_map`, of strikes that follow one another, by differences of the whole.

    Contacts are all of one part of the machine; impulses are those of the ``pushed`` ones.

    Raises:
        SingularConfigurationError: The closures do not determine the dependent coordinates.
        ImpactError: A neighbour has no impulses, or too many strikes.
    """

    def outcome(q: FloatArray, v: FloatArray) -> FloatArray:
        jacobian = system.body.closures(q[None])[1][0]
        impact = solve_impact(system, q, v, jacobian, contacts, most=_MOST_STRIKES)
        return np.array([*impact.v_after, *(impact.P_N[stop.name] for stop in pushed)])

    nv = system.body.nv
    _, jacobian = system.body.closures(q[None])
    columns = tuple(stop.index for stop in contacts)
    split = system.split(jacobian[0], system.held_coordinates, columns)
    along = Freedoms.struck(system, split, contacts)
    units, turned = (part[:, 0] for part in tangents(system, q[None], v[None], split, along))
    after, found = outcome(q, v), np.zeros((2 * nv + len(pushed), 2 * nv))
    step = DIFFERENCE_STEP * float(np.abs(v[along.members[0]]).max())
    for k, unit, turn in zip(along.columns, units, turned, strict=True):
        size = max(float(np.abs(unit).max()), 1.0)
        aside, quick = DIFFERENCE_STEP / size, step / size
        found[:nv, k] = unit
        found[nv:, k] = (outcome(q + aside * unit, v + aside * turn) - after) / aside
        found[nv:, nv + k] = (outcome(q, v + quick * unit) - after) / quick
    return found[: 2 * nv], found[2 * nv :]


class StrikeError(NamedTuple):
    """Estimated errors of one stop that an event strikes.

    Attributes:
        time: Of the time at which it is struck [s].
        relative: Of its rates and its impulse [-].
        since: Of the time since the event before, of the first stops of its part [s].
    """

    time: float
    relative: float
    since: float


class Beside(NamedTuple):
    """A stop that is struck in the event of another one.

    Attributes:
        late: By how much later than the first one each source has it struck [s], shape (K,).
        moved: What its impulse adds to the velocities of the part, shape (n,).
        along: True where it does, shape (n,).
        time: Error of the time at which it is struck [s].
        relative: Relative error of its rates [-].
    """

    name: str
    late: FloatArray
    moved: FloatArray
    along: FloatArray
    time: float
    relative: float


def still_apart(
    system: System, part: Part, event: Event, segment: Segment | None, found: Zonotope
) -> Zonotope:
    """Add what the gaps of stops that are struck together were to the deviations before an event.

    Within round-off of one time they are closed at that of the earliest. The event is one of all
    parts, the deviations are of one; a run that begins with it has no segment before.
    """
    struck = event.struck(system.mechanism)
    if len(struck) == 1 or segment is None or segment.t_end <= segment.t_start:
        return found
    q, _ = segment.panels[-1].interpolate_at(event.t)
    gaps = np.zeros(len(q))
    for stop in struck:
        gaps[stop.index] = stop.gap(q)
    gaps = gaps[part.coordinates]
    return found.joined(Zonotope.independent(gaps, np.zeros_like(gaps)))


def beside(
    system: System, part: Part, event: Event, a: FloatArray, before: Zonotope
) -> tuple[Zonotope, list[Beside]]:
    """Deviations where stops are struck in the event of another one.

    ``a`` are accelerations of the part before it, (n,), ``before`` are deviations at the times at
    which the first stop is struck.

    Returns:
        The deviations, of each part when it is struck itself, and the stops.
    """
    states = before.states.copy()
    stops: list[Beside] = []
    for stop in event.struck(system.mechanism)[1:]:
        rate, place = float(event.v_before[stop.index]), part.place(stop.index)
        late = -before.states[place] / rate
        moved = pushed_by(system, event.q, stop, event.P_N[stop.name])[part.coordinates]
        size = np.abs(moved)
        along = size > NEGLIGIBLE_DEVIATION * size.max()
        states[part.size :][along] += np.outer(a[along], late)
        time = float(np.abs(before.late + late).sum())
        relative = float(np.abs(states[part.size + place]).sum()) / abs(rate)
        stops.append(Beside(stop.name, late, moved, along, time, relative))
    return replace(before, states=states), stops


def after_all(
    system: System, part: Part, event: Event, stops: list[Beside], after: Zonotope
) -> Zonotope:
    """Deviations after an event, back at the times at which its first stop is struck.

    Those that come in are those of each part when it is struck itself.
    """
    if not stops:
        return after
    phase, motion = system.constraint_set(event.closed_after), system.shaft.driven_at(event.t)
    a = system.accelerations(motion, event.q[None], event.v_after[None], phase)
    a, states, n = a[0, part.coordinates], after.states.copy(), part.size
    for stop in stops:
        states[:n] -= np.outer(stop.moved, stop.late)
        states[n:][stop.along] -= np.outer(a[stop.along], stop.late)
    return replace(after, states=states)


def stated(
    first: StrikeError, stops: list[Beside], event: Event, impulses: Mapping[str, float]
) -> dict[str, StrikeError]:
    """Errors of each stop that an event strikes, by name; nothing if it strikes one alone."""
    found = {event.stops[0]: first} if stops else {}
    for stop in stops:
        size = abs(event.P_N[stop.name])
        relative = stop.relative + (impulses[stop.name] / size if size > 0.0 else 0.0)
        found[stop.name] = StrikeError(stop.time, min(relative, 1.0), first.since)
    return found

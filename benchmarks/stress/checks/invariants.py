"""Checks of any solution, without a reference.

Each check yields violations: what was found and the most that is allowed. Limits are round-off
times the size of the terms where equations are met exactly, and the tolerance of the run where
they are met as well as it was resolved.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.hybrid import EventKind, Outcome, Solution

from ...tolerances import (
    BALANCED,
    CLOSURE_RATE,
    ENERGY_KEPT,
    EPS,
    JUMP,
    PENETRATION,
    PULL_SHARE,
    SLOPE_SHARE,
)
from ..mechanics.equations import Equations
from ..observations import EVENTS, Shown, beyond, polynomial, samples, shown, some
from .elements import elements
from .flights import flights
from .impacts import impulses
from .model import built
from .rebounds import rebounds


@dataclass(frozen=True)
class Violation:
    """One violated invariant: where, what was found and what is allowed."""

    kind: str
    detail: str


def violations(solution: Solution) -> list[Violation]:
    """Check one solution; of many segments and events evenly chosen ones are looked at."""
    impossible = [Violation("motion", text) for text in _over_determined(solution)]
    if impossible:
        # The equations of such a segment have no solution that others could be compared with.
        return impossible
    return [Violation(kind, text) for kind, check in CHECKS.items() for text in check(solution)]


def _over_determined(solution: Solution) -> Iterator[str]:
    """Drives and closed stops prescribe no more than the closures leave free."""
    equations = Equations(solution)
    for segment in solution.segments:
        freedom = equations.freedom(segment.closed)
        if freedom < 0:
            names = ", ".join(sorted(segment.closed))
            yield f"segment at {segment.t_start:.9g} s: {names} closed, a freedom of {freedom}"


def _times(solution: Solution) -> Iterator[str]:
    """Events and segments in order of time, without gaps, within the window."""
    end = solution.segments[-1].t_end if solution.segments else 0.0
    clock = 16.0 * EPS * end
    for old, new in zip(solution.segments, solution.segments[1:], strict=False):
        yield from beyond("gap between segments [s]", abs(new.t_start - old.t_end), clock)
    for segment in solution.segments:
        yield from beyond(f"segment at {segment.t_start:.9g} s runs backwards [s]",
                           segment.t_start - segment.t_end, 0.0)  # fmt: skip
    for number, event in enumerate(solution.events, start=1):
        if event.number != number:
            yield f"event {number} has number {event.number}"
        if event.kind is not EventKind.REST:
            yield from beyond(f"event {number} beyond the end [s]", event.t - end, clock)
    for before, after in zip(solution.events, solution.events[1:], strict=False):
        yield from beyond(f"event {after.number} before its predecessor [s]",
                           before.t - after.t, clock)  # fmt: skip


def _outcome(solution: Solution) -> Iterator[str]:
    """Check the outcome against the events."""
    case, events = solution.case, solution.events
    collisions = sum(event.kind is EventKind.COLLISION for event in events)
    end = solution.segments[-1].t_end if solution.segments else 0.0
    last = events[-1] if events else None
    name = solution.mechanism.transition_stop
    if solution.outcome is Outcome.AT_REST:
        if last is None or last.kind is not EventKind.REST or name not in last.stops:
            yield "at rest, but the last event is no rest of the transition stop"
    elif solution.outcome is Outcome.TOO_MANY_COLLISIONS:
        yield from beyond("collisions wanted", case.max_collisions, collisions)
    elif solution.outcome is not Outcome.NO_REST:
        window = case.cycles * solution.shaft.period
        yield from beyond("end away from that of the window [s]", abs(end - window),
                           16.0 * EPS * window)  # fmt: skip
    for event in events:
        if event.kind is EventKind.REST and case.rest_rate is None:
            hard = [n for n in event.stops if solution.mechanism.stop(n).restitution == 1.0]
            if hard and solution.mechanism.stop(hard[0]).rate(event.v_before):
                yield f"event {event.number}: {hard} came to rest with restitution 1"


def _phases(solution: Solution) -> Iterator[str]:
    """Check the sequence of closed stops against the events."""
    mechanism = solution.mechanism
    closed = mechanism.phase(mechanism.initial_phase).closed
    chain = [closed]
    for event in solution.events:
        where = f"event {event.number} ({event.kind.value})"
        if event.closed_before != closed:
            yield f"{where}: closed {sorted(event.closed_before)}, before {sorted(closed)}"
        before, closed = closed, event.closed_after
        chain.append(closed)
        if event.kind is EventKind.RELEASE:
            if not set(event.stops) <= before - closed or closed - before:
                yield f"{where}: {sorted(before)} to {sorted(closed)}"
        elif event.kind is EventKind.REST:
            if not set(event.stops) <= closed:
                yield f"{where}: {event.stops} not among {sorted(closed)}"
        elif not closed <= before | set(event.P_N):
            yield f"{where}: {sorted(closed)} closed without a contact"
        # Several stops may meet one after the other in one instant, and the last event counts.
        following = solution.events[event.number : event.number + 1]
        cut_off = solution.outcome is Outcome.TOO_MANY_COLLISIONS and not following
        goes_on = cut_off or any(item.t == event.t for item in following)
        for stop in mechanism.stops:
            gap, rate = stop.gap(event.q), stop.rate(event.v_after)
            if stop.name in closed and (gap != 0.0 or rate != 0.0):
                yield f"{where}: closed stop {stop.name} at {gap:.3g} with rate {rate:.3g}"
            if stop.name not in closed and gap == 0.0 and rate < 0.0 and not goes_on:
                yield f"{where}: open stop {stop.name} enters its contact with {rate:.3g}"
    place = 0
    for segment in solution.segments:
        while place < len(chain) and chain[place] != segment.closed:
            place += 1
        if place == len(chain):
            yield f"segment at {segment.t_start:.9g} s: {sorted(segment.closed)} out of turn"
            return


def _motion(solution: Solution) -> Iterator[str]:
    """Closures, gaps and forces between events; the product of gap and force is zero."""
    system, equations = solution.system, Equations(solution)
    tolerance = solution.case.resolution.tolerance
    for segment, panel, t in samples(solution):
        where = f"segment at {segment.t_start:.9g} s"
        seen = shown(solution, segment.closed, t)
        q, v, a = seen.q, seen.v, seen.a
        parts = (q, v, a, seen.closures, seen.drives, *seen.stops.values())
        if not all(np.isfinite(item).all() for item in parts):
            yield f"{where}: not finite"
            continue
        g, G = equations.closures(q)
        yield from beyond(f"{where}: closure gap [m]", _most(g), 300.0 * EPS * system.body.reach_m)
        size = np.einsum("nij,nj->ni", np.abs(G), np.abs(v))
        rate = np.einsum("nij,nj->ni", G, v)
        yield from beyond(f"{where}: closure rate [m/s]", _most(rate), CLOSURE_RATE * _most(size))
        for stop in solution.mechanism.stops:
            gap = stop.gaps(q)
            if stop.name in segment.closed:
                if gap.any():
                    yield f"{where}: closed stop {stop.name} is open"
                continue
            ends = np.abs(stop.gaps(panel.q)).max()
            # Of a flight of height H a gap is right to the tolerance times H.
            clock = 16.0 * EPS * segment.t_end * float(np.abs(v[:, stop.index]).max())
            yield from beyond(f"{where}: stop {stop.name} penetrates [rad or m]",
                               -float(gap.min()),
                               2.0 * tolerance * ends + clock + PENETRATION)  # fmt: skip
        yield from _forces(solution, where, equations, seen, G)
        # A panel of one unit in the last place of time has no slope.
        if segment.kinematic and panel.h > 1e-9 * solution.shaft.period:
            # Nodes are solved one by one: velocities do not depend on accelerations.
            course = polynomial(panel.v)
            rising = course.derivative(course.xi) / panel.h
            size = np.abs(panel.a).max() + np.abs(panel.v).max() / panel.h
            # Of a machine at rest only what round-off of its coordinates would make of it.
            size += 1e5 * EPS * (1.0 + np.abs(panel.q).max()) / panel.h**2
            # And what holds its weight and its springs has the round-off of what these would do.
            start = panel.q[:1]
            still = np.zeros_like(start)
            pulls = np.abs(equations.forces.of_elements(start[0], still[0])[0])
            pulls = pulls + np.abs(system.body.inverse_dynamics(start, still, still))
            if not system.held:
                # So have drive trains that wind up against closed stops.
                motion = system.shaft.driven(panel.times[-1:])
                torques = system.train_torques(motion, start, still)
                pulls[:, system.driven_columns] += np.abs(torques)
            size += 1e7 * EPS * _most(pulls / np.diag(system.body.mass_matrix(start[0])))
            yield from beyond(f"{where}: rate of the velocity is not the acceleration [share]",
                               _most(rising - panel.a) / float(size + 1e-300),
                               SLOPE_SHARE + 10.0 * tolerance**0.5)  # fmt: skip


def _forces(
    solution: Solution, where: str, equations: Equations, seen: Shown, G: FloatArray
) -> Iterator[str]:
    """M a + h = tau + G' la_g + W' la_N in every coordinate, and closed stops push."""
    system, tolerance = solution.system, solution.case.resolution.tolerance
    q, v, a = seen.q, seen.v, seen.a
    inverse = equations.tree.inverse_dynamics(q, v, a)
    spring, _ = equations.forces.of_elements(q, v)
    left = inverse - spring - np.einsum("nij,ni->nj", G, seen.closures)
    size = np.abs(inverse) + np.abs(spring)
    # In free fall inertia and weight are the only forces and cancel.
    size += np.abs(equations.tree.inverse_dynamics(q, v, np.zeros_like(a)))
    size += np.einsum("nij,ni->nj", np.abs(G), np.abs(seen.closures)) + 1e-300
    stops = [solution.mechanism.stop(name) for name in seen.stops]
    for stop in stops:
        left[:, stop.index] -= stop.sense * seen.stops[stop.name]
    left[:, system.driven] -= seen.drives
    wound = 0.0
    if not system.held:
        left[:, system.driven] += system.inertia * a[:, system.driven]
        # The torque of a drive train is a difference of angles, and has their round-off.
        angles = np.abs(q[:, system.driven]).max(initial=0.0)
        wound = 64.0 * EPS * float(equations.forces.stiffness.max(initial=0.0) * angles)
        size += wound
    # Moments of forces next to their joint, and of what turns evenly, are differences of products.
    reach = max(system.body.reach_m, 1.0)
    acting = float(equations.tree.masses.sum()) * equations.tree.gravity
    acting += equations.forces.tension(q, v) * len(solution.mechanism.struts)
    # The length of a strut is a difference of places.
    acting += system.body.reach_m * sum(item.stiffness for item in solution.mechanism.struts)
    acting += 2.0 * _most(equations.tree.kinetic_energy(q, v)) / min(system.body.reach_m, 1.0)
    size += 4.0 * EPS / BALANCED * acting * reach
    share = np.abs(left).max(axis=1) / size.max(axis=1)
    yield from beyond(f"{where}: equations of motion [share]", float(share.max()), BALANCED)
    if stops:
        # The pull of a strut is one of a difference of lengths, and has their round-off.
        reach = system.body.reach_m
        stiffness = sum(strut.stiffness for strut in solution.mechanism.struts)
        pushed = np.stack([seen.stops[stop.name] for stop in stops], axis=1)
        pushed = pushed + 64.0 * EPS * stiffness * reach * max(reach, 1.0)
        # So is what a drive train presses together, of a difference of angles.
        pushed += wound
        pull = -(pushed / size[:, [stop.index for stop in stops]].max(axis=0)).min()
        # Forces are second derivatives: they are resolved less far than positions.
        most = 10.0 * tolerance**0.5 + PULL_SHARE
        yield from beyond(f"{where}: a closed stop pulls [share]", float(pull), most)


def _continuity(solution: Solution) -> Iterator[str]:
    """No link jumps from one panel to the next."""
    tolerance, equations = solution.case.resolution.tolerance, Equations(solution)
    parts = [(s, *piece) for s in solution.segments[:EVENTS] for piece in s.pieces()]
    for place in some(max(len(parts) - 1, 0), EVENTS):
        (old, before, begin, end), (new, after, then, _) = parts[place : place + 2]
        just_before = np.nextafter(end, begin)
        there = solution.trajectory.evaluate(np.array([just_before, then]))
        moved = np.abs(before.q).max() + np.abs(after.q).max()
        # Either side meets the closures to round-off; near a dead centre these leave it more.
        open_by = sum(
            float(equations.opened(q, s.closed).max())
            for q, s in zip(there.q, (old, new), strict=True)
        )
        open_by += (end - just_before) * _most(there.v)
        yield from beyond(f"jump at {end:.9g} s [rad or m]", _most(there.q[1] - there.q[0]),
                           10.0 * tolerance * float(moved) + open_by + JUMP)  # fmt: skip


def _energy(solution: Solution) -> Iterator[str]:
    """Check the energy balance: work of drives and gravity is stored or lost."""
    energy = solution.energy
    terms = (
        energy.drive_work, energy.drive_impulse_work, energy.gravity_work, energy.spring_change,
        energy.kinetic_change, energy.impact_losses, energy.dissipated,
    )  # fmt: skip
    scale = sum(map(abs, terms)) + energy.kinetic_peak
    system, equations, condition = solution.system, Equations(solution), 1.0
    heights = []
    # The energy of a table counts from its first row, so it may be negative.
    stored = 0.0
    # Near a dead centre panels are short. Copies of a turn share theirs.
    known = {s.source: s for s in solution.segments}
    shortest = [(s, min(s.panels, key=lambda p: p.h)) for s in known.values()]
    for segment, panel in (*shortest, *((s, p) for s, p, _ in samples(solution))):
        springs = system.spring_energy(panel.q)
        scale, stored = max(scale, float(springs.max())), max(stored, _most(springs))
        heights.append(system.body.gravity_energy(panel.q))
        some_of = panel.q[:: max(len(panel.q) // 4, 1)]
        condition = max(condition, float(equations.condition(some_of, segment.closed).max()))
    # Energy that is exchanged repeatedly adds round-off, too.
    scale += float(np.ptp(np.concatenate(heights))) if heights else 0.0
    # Forces lose the digits that the impact matrix loses.
    lost = min(32.0 * EPS * condition, 1e-5)
    # Every panel may leave an error of the order of the tolerance in positions, and in rates one
    # that is larger by twice the number of its nodes.
    panels = sum(4.0 * panel.order for segment in solution.segments for panel in segment.panels)
    unresolved = (100.0 + panels) * solution.case.resolution.tolerance
    most = (ENERGY_KEPT + lost + unresolved) * scale + 64.0 * EPS * stored
    # A strut's deflection is a difference of places, and has their round-off: so have the energy of
    # springs that hold some, and that of those which hold none.
    stiffness = sum(strut.stiffness for strut in system.mechanism.struts)
    blurred = EPS * system.body.reach_m
    most += 1e4 * stiffness * blurred**2 + 4.0 * blurred * (2.0 * stiffness * stored) ** 0.5
    yield from beyond("energy that is left over [J]", abs(energy.residual), most)


def _tables(solution: Solution) -> Iterator[str]:
    """Check that rebounds, phases and stated errors can be computed and have possible values."""
    yield from rebounds(solution)
    for hit in solution.collisions[:EVENTS]:
        amplitude, time = hit.rebound_amplitude, hit.rebound_time
        for name, value in (("amplitude", amplitude), ("time", time)):
            if value is not None and not 0.0 <= value < np.inf:
                yield f"collision {hit.number}: rebound {name} {value!r}"
    for phase in solution.phases:
        yield from beyond("phase runs backwards [s]", phase.t_start - phase.t_end, 0.0)
    for number, error in enumerate(solution.errors, start=1):
        if not (0.0 <= error.time < np.inf and 0.0 <= error.impulse < np.inf):
            yield f"event {number}: stated errors {error}"
            return


CHECKS: dict[str, Callable[[Solution], Iterator[str]]] = {
    "model": built,
    "time order": _times,
    "outcome": _outcome,
    "phase logic": _phases,
    "impulse": impulses,
    "motion": _motion,
    "flights": flights,
    "springs and dampers": elements,
    "continuity": _continuity,
    "energy": _energy,
    "tables": _tables,
}
"""The invariants by name."""


def _most(values: FloatArray) -> float:
    return float(np.abs(values).max(initial=0.0))

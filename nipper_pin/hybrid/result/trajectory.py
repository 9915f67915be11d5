"""Dense motion and forces of a solution, at any time, by left or right limit."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np

from ...arrays import FloatArray, Vectors
from ...dynamics import System
from ...errors import InputError
from ...given import refuse
from ...mechanism import Mechanism
from ...mechanism.parallel import force_shares
from ..history import Event, Segment
from ..motion.panel import Panel, forces_at, state_at


@dataclass(frozen=True, eq=False)
class Motion:
    """States at K times.

    Attributes:
        t: Times [s], shape (K,).
        cylinder_angle: psi [rad], shape (K,).
        q: Configurations [rad or m], shape (K, nv).
        v: Velocities, shape (K, nv).
        names: Names of the joints, in the order of the coordinates.
    """

    t: FloatArray
    cylinder_angle: FloatArray
    q: FloatArray
    v: FloatArray
    names: tuple[str, ...]

    @property
    def joints(self) -> dict[str, FloatArray]:
        """By joint: its coordinate [rad or m], shape (K,)."""
        return dict(zip(self.names, self.q.T, strict=True))

    @property
    def rates(self) -> dict[str, FloatArray]:
        """By joint: its rate [rad/s or m/s], shape (K,)."""
        return dict(zip(self.names, self.v.T, strict=True))


@dataclass(frozen=True, eq=False)
class Reactions:
    """Forces at K times; every force is the one on the child link or on the side of frame a.

    Those of joints and cut joints are found when they are first asked for.

    Attributes:
        t: Times [s], shape (K,).
        a: Accelerations, shape (K, nv).
        drives: By drive: torque on the driven joint [N m], shape (K,).
        stops: By stop: force along its gap, positive when it pushes [N m or N], zero while open,
            shape (K,).
        contacts: By stop: normal force at its contact point [N]; along the joint of a stop without
            one [N or N m], shape (K,).
    """

    t: FloatArray
    a: FloatArray
    drives: dict[str, FloatArray]
    stops: dict[str, FloatArray]
    contacts: dict[str, FloatArray]
    _wrenches: Callable[[], tuple[dict[str, FloatArray], dict[str, FloatArray]]] = field(
        repr=False, compare=False
    )

    @property
    def joints(self) -> dict[str, FloatArray]:
        """By tree joint what the parent link exerts on the child, shape (K, 3).

        Force x, force z [N] and moment counter-clockwise about the joint [N m], world axes. Along a
        joint's own coordinate this contains springs, dampers and drives that act there, and stops
        without a contact point. Lips of stops with one, and springs and dampers between two points,
        act past the joints.
        """
        return self._found[0]

    @property
    def closures(self) -> dict[str, FloatArray]:
        """By cut joint: force x, force z [N] on the link of frame a, shape (K, 2)."""
        return self._found[1]

    @cached_property
    def _found(self) -> tuple[dict[str, FloatArray], dict[str, FloatArray]]:
        return self._wrenches()

    def __getstate__(self) -> dict[str, Any]:
        """All forces; Pinocchio's objects, which find them, cannot be pickled."""
        found = self._found
        return {**self.__dict__, "_wrenches": partial(tuple, found)}


@dataclass(frozen=True, eq=False)
class Impulses:
    """Impulses of an event; sides and axes as of ``Reactions``.

    Attributes:
        joints: By tree joint: impulse x, impulse z [N s] and its moment counter-clockwise about the
            joint [N m s], shape (3,). Along a joint's own coordinate this contains those of its
            drive and of stops without a contact point.
        closures: By cut joint: impulse x, impulse z [N s] on the link of frame a, shape (2,).
        contacts: By stop: normal impulse at its contact point [N s]; along the joint of a stop
            without one [N s or N m s].
    """

    joints: dict[str, FloatArray]
    closures: dict[str, FloatArray]
    contacts: dict[str, float]


class Trajectory:
    """Evaluates the segments of a solution; prescribed motion and closures are met to round-off.

    Args:
        system: The system that the segments were computed with.
        segments: Segments in order of time, without gaps.
    """

    def __init__(self, system: System, segments: Sequence[Segment]) -> None:
        """Store the segments."""
        self.system = system
        self.segments = tuple(segments)
        self._starts = np.array([segment.t_start for segment in self.segments])

    @property
    def span(self) -> tuple[float, float]:
        """First and last time [s]; both zero in a run without motion."""
        if not self.segments:
            return 0.0, 0.0
        return self.segments[0].t_start, self.segments[-1].t_end

    def evaluate(self, t: FloatArray | float, *, left: bool = False) -> Motion:
        """States at times t.

        Args:
            t: Times [s], shape (K,) or a number.
            left: At an event, the limit from before instead of the one from after.

        Raises:
            InputError: A time lies outside the solution.
        """
        times = _times(t)
        q = np.empty((len(times), self.system.body.nv))
        v = np.empty_like(q)
        for segment, panel, chosen in self._groups(times, left):
            phase = self.system.constraint_set(segment.closed)
            exact, _ = state_at(self.system, phase, panel, times[chosen])
            q[chosen], v[chosen] = exact.q, exact.v
        names = tuple(joint.name for joint in self.system.mechanism.joints)
        return Motion(times, self.system.shaft.angle(times), q, v, names)

    def reactions(self, t: FloatArray | float, *, left: bool = False) -> Reactions:
        """Forces at all joints, cut joints, drives and stops; arguments as of ``evaluate``."""
        mechanism, body = self.system.mechanism, self.system.body
        times = _times(t)
        count = len(times)
        torques = np.empty((count, len(mechanism.drives)))
        stops = np.zeros((count, len(mechanism.stops)))
        la_g = np.empty((count, body.closure_rows))
        q, v, a = np.empty((3, count, body.nv))
        places = {stop.name: i for i, stop in enumerate(mechanism.stops)}
        for segment, panel, chosen in self._groups(times, left):
            phase = self.system.constraint_set(segment.closed)
            found = forces_at(self.system, phase, panel, times[chosen])
            (q[chosen], v[chosen], a[chosen]), forces = found[:3], found[3]
            la_g[chosen] = forces.la_g
            torques[chosen] = forces.drive
            for column, stop in enumerate(phase.shut):
                for name, share in force_shares(mechanism.stops, stop.name).items():
                    stops[chosen, places[name]] = share * forces.la_N[:, column]
        return Reactions(
            t=times,
            a=a,
            drives={drive.name: torques[:, i] for i, drive in enumerate(mechanism.drives)},
            stops={stop.name: stops[:, i] for i, stop in enumerate(mechanism.stops)},
            contacts={
                stop.name: stops[:, i] / stop.lever for i, stop in enumerate(mechanism.stops)
            },
            _wrenches=partial(self._wrenches, q, v, a, la_g, stops),
        )

    def _wrenches(
        self, q: Vectors, v: Vectors, a: Vectors, la_g: FloatArray, stops: FloatArray
    ) -> tuple[dict[str, FloatArray], dict[str, FloatArray]]:
        """Forces of the joints and of the cut joints, each by name.

        Closure forces have the shape (K, m) [N], those of the stops along their gaps (K, stops).
        """
        mechanism, body = self.system.mechanism, self.system.body
        lips, levers = _with_point(mechanism)
        pulls, pushes = self.system.point_forces(q, v), stops[:, lips] / levers
        wrenches = np.empty((len(pulls), len(mechanism.joints), 3))
        cuts = np.empty((len(pulls), len(mechanism.closures), 2))
        for row, state in enumerate(zip(q, v, a, la_g, pulls, pushes, strict=True)):
            wrenches[row], cuts[row] = body.joint_wrenches(*state)
        return (
            {joint.name: wrenches[:, i] for i, joint in enumerate(mechanism.joints)},
            {closure.name: cuts[:, i] for i, closure in enumerate(mechanism.closures)},
        )

    def impulses(self, event: Event) -> Impulses:
        """Impulses at all joints, cut joints and contacts of an event; zero where none strikes.

        Args:
            event: One of the events of the run.
        """
        mechanism = self.system.mechanism
        lips, levers = _with_point(mechanism)
        sizes = np.array([event.P_N.get(stop.name, 0.0) for stop in mechanism.stops])
        # What pulls between two points is finite, and gives no impulse.
        pulls, still = np.zeros((len(mechanism.struts), 2)), np.zeros_like(event.delta)
        wrenches, cuts = self.system.body.joint_wrenches(
            event.q, still, event.delta, event.P_g, pulls, sizes[lips] / levers, weight=False
        )
        return Impulses(
            joints={joint.name: wrenches[i] for i, joint in enumerate(mechanism.joints)},
            closures={closure.name: cuts[i] for i, closure in enumerate(mechanism.closures)},
            contacts={
                stop.name: float(size) / stop.lever
                for stop, size in zip(mechanism.stops, sizes, strict=True)
            },
        )

    def _groups(self, times: FloatArray, left: bool) -> Iterator[tuple[Segment, Panel, list[int]]]:
        """Times grouped by the panel that holds them."""
        first, last = self.span
        # A time that was computed in another way than the span may lie, by round-off, outside.
        slack = 4.0 * np.finfo(float).eps * max(abs(first), abs(last))
        inside = (first - slack <= times) & (times <= last + slack)
        outside = times[~inside] if self.segments else times
        if outside.size:
            message = (
                f"time {outside[0]:.9g} s lies outside the solution, which spans "
                f"{first:.9g} s to {last:.9g} s"
            )
            raise InputError(message, time=float(outside[0]), span=self.span)
        places = np.searchsorted(self._starts, times, side="left" if left else "right") - 1
        groups: dict[tuple[int, int], list[int]] = {}
        for row, place in enumerate(np.maximum(places, 0)):
            panels, t = self.segments[place].panels, float(times[row])
            panel = max(bisect_right(panels, t, key=lambda panel: panel.t) - 1, 0)
            groups.setdefault((int(place), panel), []).append(row)
        for (place, panel), rows in groups.items():
            yield self.segments[place], self.segments[place].panels[panel], rows


def _with_point(mechanism: Mechanism) -> tuple[list[int], FloatArray]:
    """Places of the stops that have a contact point, and their levers [m or 1]."""
    places = [i for i, stop in enumerate(mechanism.stops) if stop.contact is not None]
    return places, np.array([mechanism.stops[i].lever for i in places])


def closure_residuals(system: System, segments: Sequence[Segment]) -> tuple[float, float]:
    """Largest closure gap [m] and closure rate [m/s] of the motion as it was computed.

    The nodes of the panels are looked at as they are; a motion that was integrated meets the
    closures only as well as its integration.
    """
    gap = rate = 0.0
    # Copies of a turn have the closures of what they are copies of.
    for segment in {segment.source: segment for segment in reversed(segments)}.values():
        for panel in segment.panels:
            g, jacobian = system.body.closures(panel.q)
            gap = max(gap, float(np.abs(g).max(initial=0.0)))
            g_dot = np.einsum("nij,nj->ni", jacobian, panel.v)
            rate = max(rate, float(np.abs(g_dot).max(initial=0.0)))
    return gap, rate


def _times(t: FloatArray | float) -> FloatArray:
    """Times that were asked for, shape (K,); whether they lie inside is seen later."""
    found = np.atleast_1d(np.asarray(t))
    if found.dtype.kind not in "iuf":
        refuse("t", t, "times in seconds")
    return found.astype(np.float64)

"""The constraints of one phase: which stops are closed, and what that leaves free to move.

Linear forces, shafts and parts of a mechanism are laid out by coordinate once, for all its phases.
An impact at one part leaves the others alone. Two coordinates belong to one part if a link, a
closure, a coupling or a strut moves with both. What is driven by a held shaft moves whatever the
others do, and connects nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..errors import ModelError
from ..made_once import made_once
from ..mechanism import Mechanism, Stop, supports
from .multibody import INFINITE_INERTIA


@dataclass(frozen=True, eq=False)
class Coefficients:
    """Coefficients independent of speed and time, shapes (drives,) or (nv,).

    Attributes:
        driven: Places of the driven coordinates.
        columns: The same to index with: a slice where one holds them, which numpy takes faster.
        inertia: I of each driven shaft [kg m^2 or kg].
        train_stiffness: k = I w^2 of each elastic drive train.
        train_damping: c = 2 zeta w I of each.
        armature: Inertia added to the driven coordinates: infinite for held ones, I otherwise.
        free: 1 for coordinates that accelerations move, 0 for those that a law holds.
        stiffness: Sum of the springs at each coordinate.
        preload: Their force at q = 0, -k p.
        damping: Sum of the dampers at each coordinate.
        turning: Angle by which links turn for each unit of a coordinate; slides by the reach.
    """

    driven: NDArray[np.intp]
    columns: slice | NDArray[np.intp]
    inertia: FloatArray
    train_stiffness: FloatArray
    train_damping: FloatArray
    armature: FloatArray
    free: FloatArray
    stiffness: FloatArray
    preload: FloatArray
    damping: FloatArray
    turning: FloatArray


@made_once
def coefficients(mechanism: Mechanism, held: bool) -> Coefficients:
    """Coefficients of a mechanism, the same for all its runs.

    Args:
        held: True if the driven shafts are held, False if they have their inertia.

    Raises:
        ModelError: A shaft that is not held lacks its numbers: it can only be held.
    """
    missing = [f"drives.{item.name}.{key}" for item in mechanism.drives for key in item.missing]
    if missing and not held:
        allowed = "an inertial drive needs a number; the others that are missing: "
        raise ModelError(
            file=f"{mechanism.name}.toml",
            key=missing[0],
            value=None,
            allowed=allowed + (", ".join(missing[1:]) or "none"),
        )
    nv = len(mechanism.joints)
    driven = np.array([item.index for item in mechanism.drives], dtype=np.intp)
    inertia = np.array([item.reflected_inertia for item in mechanism.drives])
    omega = 2.0 * np.pi * np.array([item.shaft_frequency_hz for item in mechanism.drives])
    ratio = np.array([item.shaft_damping_ratio for item in mechanism.drives])
    armature, free = np.zeros(nv), np.ones(nv)
    armature[driven] = INFINITE_INERTIA if held else inertia
    if held:
        free[driven] = 0.0
    stiffness, preload, damping = np.zeros((3, nv))
    for spring in mechanism.springs:
        stiffness[spring.index] += spring.stiffness
        preload[spring.index] -= spring.stiffness * spring.preload
    for damper in mechanism.dampers:
        damping[damper.index] += damper.damping
    return Coefficients(
        driven=driven,
        columns=column_index(driven),
        inertia=inertia,
        train_stiffness=inertia * omega**2,
        train_damping=2.0 * ratio * omega * inertia,
        armature=armature,
        free=free,
        stiffness=stiffness,
        preload=preload,
        damping=damping,
        turning=np.array(
            [
                1.0 if joint.kind == "revolute" else 1.0 / mechanism.reach_m
                for joint in mechanism.joints
            ]
        ),
    )


def column_index(places: NDArray[np.intp]) -> slice | NDArray[np.intp]:
    """Return equally spaced, increasing indices as a slice, and other ones unchanged."""
    steps = set(np.diff(places).tolist()) or {1}
    step = min(steps)
    if not places.size or len(steps) > 1 or step < 1:
        return places
    return slice(int(places[0]), int(places[-1]) + 1, step)


# The stiffness is repeated for the largest number of nodes of a panel: products of arrays of one
# shape take a third of the time of broadcasting.
_ROWS = 64


@dataclass(frozen=True, eq=False)
class ConstraintSet:
    """The constraints of one phase (contact mode) beside the closures.

    Attributes:
        shut: The closed stops, of those that close together their leader.
        stops: Their coordinates.
        columns: The same as an index, a slice where that is possible.
        places: Where they hold these coordinates, shape (closed,) [rad or m].
        senses: Direction in which each pushes, 1 or -1, shape (closed,).
        open: The other stops, likewise.
        given: Held drives and closed stops: never dependent through the closures.
        yielding: Driven coordinates that forces move; independent as far as closures allow it.
        armature: Inertia added to each joint in flight, shape (nv,).
        stiffness: Of springs and elastic drive trains at coordinates that move, shape (nv,).
        repeated: The same for each node of a panel, shape (64, nv).
        damping: Of dampers and drive trains, shape (nv,); None where there is none.
        freedom: Degrees of freedom that are left.
        moving: 1 for coordinates that forces move, 0 for those that are prescribed, shape (nv,).
    """

    closed: frozenset[str]
    shut: tuple[Stop, ...]
    stops: tuple[int, ...]
    columns: slice | NDArray[np.intp]
    places: FloatArray
    senses: FloatArray
    open: tuple[Stop, ...]
    given: tuple[int, ...]
    yielding: tuple[int, ...]
    armature: FloatArray
    stiffness: FloatArray
    repeated: FloatArray
    damping: FloatArray | None
    freedom: int
    moving: FloatArray


# Constraint sets depend on neither speed nor time, so all runs of a mechanism share them.
@made_once
def constraint_set(mechanism: Mechanism, closed: frozenset[str], held: bool) -> ConstraintSet:
    """Return the constraints of the phase with these closed stops.

    Args:
        held: True if the driven shafts are held, False if they have their inertia.
    """
    leaders = [stop for stop in mechanism.stops if not stop.leader]
    shut = tuple(stop for stop in leaders if stop.name in closed)
    stops = tuple(stop.index for stop in shut)
    drives = tuple(drive.index for drive in mechanism.drives)
    # Elastic drive trains prescribe nothing: with all stops closed their coordinates may depend on
    # one another.
    given, yielding = ((*drives, *stops), ()) if held else (stops, drives)
    numbers = coefficients(mechanism, held)
    armature, stiffness = numbers.armature.copy(), numbers.stiffness.copy()
    moving, damping = numbers.free.copy(), numbers.damping.copy()
    if not held:
        stiffness[numbers.driven] += numbers.train_stiffness
        damping[numbers.driven] += numbers.train_damping
    held_stops = list(stops)
    armature[held_stops] = INFINITE_INERTIA
    moving[held_stops] = 0.0
    stiffness *= moving
    damping *= moving
    return ConstraintSet(
        closed=closed,
        shut=shut,
        stops=stops,
        columns=column_index(np.array(stops, dtype=np.intp)),
        places=np.array([stop.at for stop in shut]),
        senses=np.array([stop.sense for stop in shut]),
        open=tuple(stop for stop in leaders if stop.name not in closed),
        given=given,
        yielding=yielding,
        armature=armature,
        stiffness=stiffness,
        repeated=np.tile(stiffness, (_ROWS, 1)),
        damping=damping if damping.any() else None,
        freedom=mechanism.degrees_of_freedom - len(given),
        moving=moving,
    )


class Parts(NamedTuple):
    """The parts of a machine.

    Attributes:
        number: Number of the part of each coordinate, shape (nv,); held shafts have their own.
        members: Coordinates of each part, those of held shafts that move it among them, by number.
        stops: Names of the stops in the part of each stop, itself among them, by its name.
        whole: True if all stops are in one part, as in most machines.
    """

    number: NDArray[np.intp]
    members: Mapping[int, NDArray[np.intp]]
    stops: Mapping[str, frozenset[str]]
    whole: bool


@made_once
def parts(mechanism: Mechanism, held: bool) -> Parts:
    """Find the parts of a machine.

    Args:
        held: True if the driven shafts are held, False if they have their inertia.
    """
    number, members = _parts(mechanism, held)
    groups: dict[int, set[str]] = {}
    for stop in mechanism.stops:
        groups.setdefault(number[stop.index], set()).add(stop.name)
    names = {place: frozenset(group) for place, group in groups.items()}
    stops = {stop.name: names[number[stop.index]] for stop in mechanism.stops}
    return Parts(np.array(number, dtype=np.intp), members, stops, len(groups) < 2)


def _parts(mechanism: Mechanism, held: bool) -> tuple[list[int], dict[int, NDArray[np.intp]]]:
    model, driven = mechanism.model, {drive.index for drive in mechanism.drives if held}
    part = list(range(int(model.nv)))
    moved: list[tuple[int, int]] = []

    def movers(joint: int) -> list[int]:
        return [int(model.joints[j].idx_v) for j in supports(model, joint)]

    def join(columns: Iterable[int]) -> None:
        together = set(columns)
        own = together - driven
        moved.extend((min(own), shaft) for shaft in together & driven if own)
        joined = {part[column] for column in own}
        for column, number in enumerate(part):
            if number in joined:
                part[column] = min(joined)

    for joint in range(1, model.njoints):
        join(movers(joint))
    for coupling in mechanism.couplings:
        join((coupling.index, coupling.of))
    pairs = [(item.frame_a, item.frame_b) for item in mechanism.closures]
    pairs += [(item.frame_a, item.frame_b) for item in mechanism.struts]
    for pair in pairs:
        ends = (model.getFrameId(name, pin.FrameType.BODY) for name in pair)
        join(column for end in ends for column in movers(model.frames[end].parentJoint))
    members: dict[int, set[int]] = {}
    for column, shaft in [*enumerate(range(len(part))), *moved]:
        members.setdefault(part[column], set()).add(shaft)
    return part, {item: np.array(sorted(own), dtype=np.intp) for item, own in members.items()}

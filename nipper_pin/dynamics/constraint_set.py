"""The constraints of one phase: which stops are closed, and what that leaves free to move."""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..mechanism import Mechanism, Stop
from .coefficients import coefficients, column_index
from .multibody import INFINITE_INERTIA

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
_KNOWN: WeakKeyDictionary[Mechanism, dict[tuple[bool, frozenset[str]], ConstraintSet]]
_KNOWN = WeakKeyDictionary()


def constraint_set(mechanism: Mechanism, closed: frozenset[str], *, held: bool) -> ConstraintSet:
    """Return the constraints of the phase with these closed stops.

    Args:
        held: True if the driven shafts are held, False if they have their inertia.
    """
    known = _KNOWN.setdefault(mechanism, {})
    if (held, closed) not in known:
        known[held, closed] = _constraint_set(mechanism, closed, held=held)
    return known[held, closed]


def _constraint_set(mechanism: Mechanism, closed: frozenset[str], *, held: bool) -> ConstraintSet:
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

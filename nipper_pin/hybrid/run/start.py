"""The state that a run starts from."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, tau

import numpy as np

from ...dynamics import System, assemble
from ...dynamics.assembly import touch
from ...errors import ConvergenceError, InputError, SimulationError, SingularConfigurationError
from ...mechanism import Start, Stop
from ...tolerances.hybrid import GAP_ROUND_OFF
from ...units import coordinate_text
from ..case import Case, Window
from ..segment import State
from .phase_manager import located

# Steps of the assembly: for a turn of the cylinder, and at least if stops or starts move, too.
_STEPS_A_TURN, _STEPS_OF_STOPS = 18, 12


def start_of(system: System, case: Case) -> State:
    """State in which a run begins: in the touch configuration, or at the start index.

    Raises:
        InputError: The machine is not in its initial phase there.
        SimulationError: Its loops do not close there.
    """
    touching = case.window is Window.TRANSITION
    try:
        # A transition starts in the touch configuration, whose coordinates are zero.
        starts = () if touching else system.mechanism.starts
        return initial_state(system, case.start_index, starts)
    except (ConvergenceError, SingularConfigurationError) as error:
        found = located(error, system)
        raise (found if touching else _beginning(found, system)) from error


def _beginning(error: SimulationError, system: System) -> SimulationError:
    """The error of a start at an index, with what has to be so there, and what may be changed."""
    mechanism = system.mechanism
    phase = mechanism.phase(mechanism.initial_phase)
    closed = ", ".join(sorted(phase.closed)) or "no stop"
    name = f"{phase.number} {phase.name}".rstrip()
    message = f"{error.message}; turns start in phase {name} ({closed} closed)"
    starts = [item.joint for item in mechanism.starts]
    if starts:
        message += f", {', '.join(starts)} where [initial] says"
    ways = []
    if mechanism.drives:
        ways += ["start_index has to lie in it", "initial_phase has to be another one"]
    if isinstance(error, ConvergenceError):
        shut = [stop.index for stop in mechanism.stops if stop.name in phase.closed]
        given = [*system.shaft.indices, *shut, *(item.index for item in mechanism.starts)]
        free = set(touch(system.body, tuple(given)).split.independent) - set(given)
        kept = [joint.name for joint in mechanism.joints if joint.index in free]
        if kept:
            message += f", {', '.join(kept)} at 0, as nothing says where"
        if kept or starts:
            ways.append(f"[initial] has to give {'other' if starts else 'some'} coordinates")
    if ways:
        message += f": {', or '.join(ways)}"
    return type(error)(message, **error.evidence)


def initial_state(system: System, start_index: float, starts: Sequence[Start] = ()) -> State:
    """The initial phase at time zero, assembled along the drives from the touch position.

    Coordinates that neither drives nor closed stops nor starts prescribe and that the closures
    leave free stay zero, as in the touch position, and have no rate.

    Args:
        start_index: Index that belongs to the start angle of the shaft, for the message.
        starts: Coordinates and rates that are given for the start.

    Raises:
        InputError: An open stop would be beyond its contact there, or starts are too many.
    """
    mechanism, shaft = system.mechanism, system.shaft
    closed = mechanism.phase(mechanism.initial_phase).closed
    shut = [stop for stop in mechanism.stops if stop.name in closed]
    travel = shaft.start_angle_rad - mechanism.cylinder.angle_at_touch_rad
    # In the touch configuration all coordinates are zero: there is nothing to assemble.
    places = [(stop.index, stop.at) for stop in shut] + [(item.index, item.at) for item in starts]
    moved = any(at for _, at in places)
    away = travel != 0.0 or moved
    steps = max(ceil(_STEPS_A_TURN * abs(travel) / tau), _STEPS_OF_STOPS if moved else 1)
    end = shaft.start_angle_rad
    turned = np.linspace(end - travel, end, steps + 1) if away else np.array([end])
    angles, rates, accelerations = shaft.driven_along(turned) if away else shaft.driven_at(0.0)
    driven = shaft.indices
    given = [*driven, *[index for index, _ in places]]
    _check_starts(system, starts, shut, given)
    path = np.zeros((len(turned) - 1, len(given)))
    path[:, : len(driven)] = angles[1:]
    for column, (_, at) in enumerate(places, start=len(driven)):
        if at:
            path[:, column] = np.linspace(0.0, at, len(turned))[1:]
    end_rates = np.zeros(len(given))
    end_rates[: len(driven)] = rates[-1]
    end_rates[len(given) - len(starts) :] = [item.rate for item in starts]
    q, v, jacobian = assemble(system.body, path, given, end_rates)
    for stop in mechanism.stops:
        gap = stop.gap(q)
        if abs(gap) <= GAP_ROUND_OFF * system.body.unit_of[stop.index]:
            q[stop.index] = stop.at
        elif stop.name not in closed and gap < 0.0:
            beyond = coordinate_text(-gap, mechanism.joints[stop.index].kind)
            message = (
                f"stop {stop.name!r} would be {beyond} beyond its contact at the "
                f"start, index {start_index:g}; start_index has to lie in phase "
                f"{mechanism.initial_phase}"
            )
            if starts:
                message += ", or [initial] has to give other coordinates"
            raise InputError(message, stop=stop.name, gap=gap)
    motion = (angles[-1:], rates[-1:], accelerations[-1:])
    return State(0.0, q, v, jacobian, motion, closed)


def _check_starts(
    system: System, starts: Sequence[Start], shut: Sequence[Stop], given: Sequence[int]
) -> None:
    """Refuse starts of what stands on a stop, and more than the closures leave free."""
    phase = system.mechanism.initial_phase
    for item in starts:
        for stop in shut:
            if item.index == stop.index:
                message = (
                    f"initial.{item.joint} gives a start to a joint that stands on stop "
                    f"{stop.name!r} in phase {phase}, in which turns start: leave it out, or let "
                    "initial_phase be one in which this stop is open"
                )
                raise InputError(message, joint=item.joint, stop=stop.name)
    free = system.body.nv - system.body.closure_rows
    if starts and len(given) > free:
        names = ", ".join(item.joint for item in starts)
        message = (
            f"[initial] gives {names}: with the drives and the closed stops of phase {phase} these "
            f"are {len(given)} coordinates, and the closures leave {free} free; leave "
            f"{len(given) - free} of them out"
        )
        raise InputError(message, given=len(given), free=free)

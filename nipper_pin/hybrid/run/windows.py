"""The two windows of a run: one transition, or whole turns; those that must repeat are copied.

A run starts in the touch configuration, or at an index in its initial phase.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import ceil, tau

import numpy as np

from ...arrays import FloatArray
from ...dynamics import System, assemble
from ...dynamics.assembly import touch
from ...errors import ConvergenceError, InputError, SimulationError, SingularConfigurationError
from ...mechanism import Mechanism, Start, Stop
from ...tolerances.hybrid import GAP_ROUND_OFF, SAME_POSITION, SAME_RATE, SHORTEST_PANEL
from ...units import coordinate_text, rate_text
from ..case import Case, Window
from ..history import Event, EventKind, Outcome, Segment, State
from .phase_manager import PhaseManager, located


def comes_back(system: System) -> bool:
    """True if the drives come back with the cylinder, but for whole turns of a crank."""
    positions = np.zeros((2, system.body.nv))
    positions[:, system.driven] = system.shaft.driven(np.array([0.0, system.shaft.period]))[0]
    return winding(system.mechanism, positions[0], positions[1]) is not None


def winding(
    mechanism: Mechanism, start: FloatArray, end: FloatArray, within: float = SAME_POSITION
) -> FloatArray | None:
    """By how much hinges have wound on from a start to an end, (nv,), if links stand as before.

    Links stand the same after whole turns of a hinge; springs and stops at the hinge do not.

    Args:
        within: What positions of one assembly may differ by, in units of coordinates.

    Returns:
        Multiples of 2 pi, zero for all other coordinates, shape (nv,) [rad]; None if the links
        stand elsewhere.
    """
    bound = {spring.index for spring in mechanism.springs}
    bound |= {table.index for table in mechanism.tabulated_springs}
    bound |= {force.index for force in mechanism.forces}
    bound |= {stop.index for stop in mechanism.stops}
    winds = np.zeros(len(start))
    for joint in mechanism.joints:
        winds[joint.index] = joint.kind == "revolute" and joint.index not in bound
    wound = 2.0 * np.pi * winds * np.rint((end - start) / (2.0 * np.pi))
    apart = np.abs(end - start - wound) / mechanism.units
    return wound if apart.max(initial=0.0) <= within else None


def repeats(
    system: System,
    previous: Sequence[Segment],
    current: Sequence[Segment],
    start: State,
    end: State,
) -> FloatArray | None:
    """By how much hinges wind on in this turn, if the one after must equal it, as :func:`winding`.

    With held drives a phase without freedom is determined by the cylinder angle and the assembly of
    the links, so two turns that share such a phase at the same angle are equal from there on. An
    event at the very border of two turns may, by round-off, belong to either, and a flight may
    bring the links to another assembly: this turn has to end as it began.
    """
    if not system.held or not comes_back(system):
        return None
    period = system.shaft.period
    units = system.body.units
    changed = float((np.abs(end.v - start.v) / units).max())
    panels = [panel for part in current for panel in part.panels]
    fastest = max(float((np.abs(panel.v) / units).max()) for panel in panels)
    if start.closed != end.closed or changed > SAME_RATE * fastest:
        return None
    # The links may have come to their other assembly, where rates may be the same.
    wound = winding(system.mechanism, start.q, end.q)
    first, last = current[0], current[-1]
    if first.kinematic and last.kinematic and first.closed == last.closed:
        return wound
    shared = any(
        old.kinematic
        and new.kinematic
        and old.closed == new.closed
        and old.t_start + period < new.t_end
        and new.t_start < old.t_end + period
        for old in previous
        for new in current
    )
    return wound if shared else None


def transition(manager: PhaseManager) -> Outcome:
    """From the touch configuration, where the transition stop collides, to its rest."""
    name = _closing_stop(manager)
    manager.collide({name} | manager.closing())
    while True:
        rest = _rest_of(manager, name)
        if rest is not None and _followed(manager, name, rest.t):
            return Outcome.AT_REST
        if manager.collisions >= manager.case.max_collisions:
            return Outcome.TOO_MANY_COLLISIONS
        if not manager.step(manager.system.shaft.period):
            return Outcome.NO_REST


def _rest_of(manager: PhaseManager, name: str) -> Event | None:
    """The rest of a stop, if the latest events hold it."""
    for event in reversed(manager.events):
        if event.kind is not EventKind.REST:
            break
        if name in event.stops:
            return event
    return None


def _followed(manager: PhaseManager, name: str, t_rest: float) -> bool:
    """Follow parts that do not touch a stop until its rest [s]; False if they strike too often."""
    if manager.system.whole:
        return True
    together = manager.system.coupled([name])
    stops = {stop.name for stop in manager.mechanism.stops}
    if stops <= together | manager.state.closed:
        return True
    while manager.step(t_rest):
        if manager.collisions >= manager.case.max_collisions:
            return False
    # What comes to rest later is no part of the transition.
    while name not in manager.events[-1].stops:
        manager.events.pop()
    return True


def _closing_stop(manager: PhaseManager) -> str:
    """Name of the transition stop, which closes in the touch configuration.

    Raises:
        InputError: The machine has no such stop, or it does not close there.
    """
    mechanism, state = manager.mechanism, manager.state
    name = mechanism.transition_stop
    if not name:
        message = (
            f"{mechanism.name} has no stop, so there is no transition: simulate whole "
            "turns (window cycle), or give it a stop"
        )
        raise InputError(message, model=mechanism.name)
    stop = mechanism.stop(name)
    gap, rate = stop.gap(state.q), stop.rate(state.v)
    kind = mechanism.joints[stop.index].kind
    if gap != 0.0:
        message = (
            f"stop {name!r} stands open by {coordinate_text(gap, kind)} in the touch "
            "configuration, where a transition starts: simulate whole turns (window cycle), or "
            "make transition_stop one that is closed there"
        )
        raise InputError(message, stop=name, gap=gap)
    if rate >= 0.0:
        if mechanism.drives:
            how = "check cylinder.angle_at_touch_deg and cylinder.direction"
        else:
            how = "without a drive nothing moves there"
        message = (
            f"stop {name!r} is not closing in the touch configuration, where a transition starts "
            f"(rate {rate_text(rate, kind)}): {how}; or simulate whole turns (window cycle)"
        )
        raise InputError(message, stop=name, rate=rate)
    return name


def turns(
    manager: PhaseManager, progress: Callable[[int, int], None] | None
) -> tuple[Outcome, int | None]:
    """Whole turns, until one is known to repeat.

    Returns:
        How it ended, and the turn that the following ones are copies of, None without copies.
    """
    case, period = manager.case, manager.system.shaft.period
    previous: list[Segment] = []
    # What is over within the shortest time that is resolved, is over at the end.
    manager.end = (case.cycles + SHORTEST_PANEL) * period
    manager.touch()
    for turn in range(1, case.cycles + 1):
        first_segment, first_event = len(manager.segments), len(manager.events)
        start, before = manager.state, manager.collisions
        while manager.step(turn * period):
            if manager.collisions - before >= case.max_collisions:
                return Outcome.TOO_MANY_COLLISIONS, None
        if progress is not None:
            progress(turn, case.cycles)
        current = manager.segments[first_segment:]
        wound = None
        # Of the last copy a rest in the turn that follows would lie beyond the window.
        over = any(event.t > turn * period for event in manager.events[first_event:])
        if case.reuse_cycles and turn < case.cycles and not over:
            wound = repeats(manager.system, previous, current, start, manager.state)
        if wound is not None:
            manager.copy(current, manager.events[first_event:], case.cycles - turn, wound)
            if progress is not None:
                progress(case.cycles, case.cycles)
            return _at_the_end(manager), turn
        previous = current
    return _at_the_end(manager), None


def _at_the_end(manager: PhaseManager) -> Outcome:
    return Outcome.COMPLETED if not manager.state.series else Outcome.STILL_BOUNCING


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
    places = [(stop.index, stop.at, 0.0) for stop in shut]
    places += [(item.index, item.at, item.rate) for item in starts]
    moved = any(at for _, at, _ in places)
    away = travel != 0.0 or moved
    steps = max(ceil(_STEPS_A_TURN * abs(travel) / tau), _STEPS_OF_STOPS if moved else 1)
    end = shaft.start_angle_rad
    turned = np.linspace(end - travel, end, steps + 1) if away else np.array([end])
    angles, rates, accelerations = shaft.driven_along(turned) if away else shaft.driven_at(0.0)
    given = [*shaft.indices, *(index for index, _, _ in places)]
    _check_starts(system, starts, shut, given)
    path = np.empty((0, len(given)))
    if away:
        ways = [np.linspace(0.0, at, len(turned))[1:] for _, at, _ in places]
        path = np.column_stack([angles[1:], *ways])
    end_rates = np.array([*rates[-1], *(rate for _, _, rate in places)])
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

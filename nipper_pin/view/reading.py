"""Units of coordinates, digits of numbers and the turns shown, in tables and figures."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..hybrid.case import Window
from ..hybrid.event import Event, EventKind
from ..hybrid.result.quantities import force_unit
from ..hybrid.result.solution import Solution
from ..hybrid.result.tables import Collision, PhaseInterval, Transition
from ..mechanism import Mechanism, Stop, Strut
from ..terms import digits, shown_in
from ..units import MM_PER_M

TURNS_SHOWN = 2


@dataclass(frozen=True)
class Units:
    """Units of one coordinate; a factor turns the SI value into the unit beside it.

    Attributes:
        noun: What the coordinate is.
        coordinate: Unit of the coordinate.
        coordinate_factor: [unit/rad] or [unit/m].
        amplitude: Unit of rebound amplitudes.
        amplitude_factor: [unit/rad] or [unit/m].
        rate: Unit of the rate.
        rate_factor: [unit/(rad/s)] or [unit/(m/s)].
    """

    noun: str
    coordinate: str
    coordinate_factor: float
    amplitude: str
    amplitude_factor: float
    rate: str
    rate_factor: float


def _units(noun: str, unit: str) -> Units:
    """Units of a coordinate in rad or m."""
    coordinate, small, rate = (
        shown_in(unit),
        shown_in(unit, small=True),
        shown_in(f"{unit}/s"),
    )
    return Units(noun, *coordinate, *small, *rate)


_BY_KIND = {"revolute": _units("angle", "rad"), "prismatic": _units("stroke", "m")}


def units_of(mechanism: Mechanism, index: int) -> Units:
    """Units of the coordinate at a place in q."""
    return _BY_KIND[next(j.kind for j in mechanism.joints if j.index == index)]


def spring_text(mechanism: Mechanism) -> str:
    """Stiffness, preload deflection and preload force of every spring, or what its table spans."""
    parts = []
    for spring in mechanism.springs:
        force = digits(spring.stiffness * spring.preload)
        if units_of(mechanism, spring.index).noun == "angle":
            stiffness = f"{spring.stiffness:g} N m/rad"
            preload = f"{math.degrees(spring.preload):g} deg ({force} N m)"
        else:
            stiffness = f"{spring.stiffness / MM_PER_M:g} N/mm"
            preload = f"{spring.preload * MM_PER_M:g} mm ({force} N)"
        parts.append(f"{spring.name} {stiffness}, preload {preload}")
    for table in mechanism.tabulated_springs:
        units, rows = units_of(mechanism, table.index), table.characteristic
        low, high = (f"{units.coordinate_factor * end:g}" for end in rows.ends)
        forces = f"{rows.force[0]:g} to {rows.force[-1]:g}"
        unit = "N m" if units.noun == "angle" else "N"
        parts.append(f"{table.name} table from {low} to {high} {units.coordinate}, {forces} {unit}")
    for strut in _struts(mechanism, "spring"):
        parts.append(
            f"{strut.name} {strut.stiffness / MM_PER_M:g} N/mm from {strut.frame_a} to "
            f"{strut.frame_b}, free length {MM_PER_M * strut.free_length:g} mm"
        )
    return "; ".join(parts) or "none"


def damper_text(mechanism: Mechanism) -> str:
    """Damping of every damper; empty without one."""
    parts = []
    for damper in mechanism.dampers:
        turns = units_of(mechanism, damper.index).noun == "angle"
        parts.append(f"{damper.name} {damper.damping:g} {'N m s/rad' if turns else 'N s/m'}")
    for strut in _struts(mechanism, "damper"):
        ends = f"from {strut.frame_a} to {strut.frame_b}"
        parts.append(f"{strut.name} {strut.damping:g} N s/m {ends}")
    return "; ".join(parts)


def force_text(mechanism: Mechanism) -> str:
    """Law and joint of every force element; empty without one."""
    names = {joint.index: joint.name for joint in mechanism.joints}
    return "; ".join(
        f"{force.name} ({force.kind}) on {names[force.index]}" for force in mechanism.forces
    )


def _struts(mechanism: Mechanism, kind: str) -> list[Strut]:
    return [strut for strut in mechanism.struts if strut.kind == kind]


def stop_place(mechanism: Mechanism, stop: Stop) -> str:
    """Joint of a stop, and which of its limits it is."""
    joint = next(item for item in mechanism.joints if item.index == stop.index)
    units = _BY_KIND[joint.kind]
    side = "lower" if stop.sense > 0.0 else "upper"
    return (
        f"{side} limit of {joint.name} at {units.coordinate_factor * stop.at:g} {units.coordinate}"
    )


def gap_noun(mechanism: Mechanism, stop: Stop) -> str:
    """Name of the gap of a stop: the joint's coordinate, or a distance from the stop."""
    return units_of(mechanism, stop.index).noun if stop.plain else "gap"


def restitution_text(stops: tuple[Stop, ...]) -> str:
    """Restitution of every stop; of vanishing rates where it depends on them."""
    return ", ".join(
        f"{stop.name} {stop.restitution:g}" + (" at rate 0, by a law" if stop.law else "")
        for stop in stops
    )


def case_text(solution: Solution) -> str:
    """Speed, window and drive of a run."""
    case = solution.case
    window = case.window.value
    if case.window is Window.CYCLE:
        turns = "1 turn" if case.cycles == 1 else f"{case.cycles} turns"
        window += f" ({turns} from index {case.start_index:g})"
    return f"{case.speed_rpm:g} r/min, window {window}, {case.drive.value} drive"


def shown_before(solution: Solution) -> float:
    """Time before which things are shown [s]: no limit, or the first turns of many."""
    if solution.case.window is Window.CYCLE and solution.case.cycles > TURNS_SHOWN:
        return TURNS_SHOWN * solution.shaft.period
    return math.inf


def shown_until(solution: Solution) -> float:
    """End of the motion that is shown [s]; a run that ends as it starts has no motion."""
    end = solution.segments[-1].t_end if solution.segments else 0.0
    return min(end, shown_before(solution))


def shown_collisions(solution: Solution) -> list[Collision]:
    """Collisions of the turns shown."""
    return [item for item in solution.collisions if item.t < shown_before(solution)]


def shown_phases(solution: Solution) -> list[PhaseInterval]:
    """Phase intervals that begin in the turns shown."""
    return [item for item in solution.phases if item.t_start < shown_before(solution)]


def shown_transitions(solution: Solution) -> list[Transition]:
    """Completed transitions that begin in the turns shown."""
    return [item for item in solution.transitions if item.t_start < shown_before(solution)]


def shown_events(solution: Solution, kind: EventKind) -> list[Event]:
    """Events of one kind in the turns shown."""
    before = shown_before(solution)
    return [item for item in solution.events if item.kind is kind and item.t < before]


def index_at(solution: Solution, t: float) -> float:
    """Index on the comber's scale at a time [s]."""
    return solution.mechanism.cylinder.index_from_angle(float(solution.shaft.angle(t)))


def phase_name(mechanism: Mechanism, closed: frozenset[str]) -> str:
    """Number and name of the phase with these closed stops."""
    phase = mechanism.phase_of(closed)
    if phase is None:
        return "without number"
    return f"{phase.number} {phase.name}".strip()


def force_name(mechanism: Mechanism, stop: str) -> str:
    """Name and unit of the force of a closed stop."""
    noun = "clamping force" if stop == mechanism.transition_stop else "stop force"
    return f"{noun} [{force_unit(mechanism, mechanism.stop(stop))}]"

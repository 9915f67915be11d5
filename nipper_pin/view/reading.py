"""Quantities, springs, stops and settings of a machine as people read them; the turns shown."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TypeVar

from ..hybrid import Collision, Event, EventKind, PhaseInterval, Solution, Transition, Window
from ..hybrid.result.quantities import coordinate_unit, force_unit
from ..mechanism import Mechanism, Stop, Strut
from ..terms import Shown, digits, named, shown_in
from ..units import MM_PER_M

# As fine as what can be made.
AT_CONTACT = Shown(words="gap at the contact", unit="mm", factor=MM_PER_M, decimals=4)
"""Of a gap at a contact point [m]."""
TURNS_SHOWN = 2
Item = TypeVar("Item", Collision, Event, PhaseInterval, Transition)


def shown(mechanism: Mechanism, name: str) -> Shown:
    """How people read a quantity of the transition stop or of a turn, or a parameter.

    Args:
        name: Its name in files, as :func:`~nipper_pin.terms.named` takes it, or a shortcut.
    """
    units = [
        coordinate_unit(mechanism, stop.index)
        for stop in mechanism.stops
        if stop.name == mechanism.transition_stop
    ]
    return named(mechanism.shortcuts.get(name, name), *units)


def coordinate_shown(mechanism: Mechanism, index: int, *, small: bool = False) -> Shown:
    """How people read a coordinate, by its place in q; those of rebounds are small."""
    file_unit = coordinate_unit(mechanism, index)
    unit, factor = shown_in(file_unit, small=small)
    return Shown(words="stroke" if file_unit == "m" else "angle", unit=unit, factor=factor)


def stiffness_shown(mechanism: Mechanism, index: int) -> Shown:
    """How people read the rate of a spring, by the place of its joint in q."""
    turns = coordinate_unit(mechanism, index) == "rad"
    unit, factor = shown_in("N m/rad" if turns else "N/m")
    return Shown(words="stiffness", unit=unit, factor=factor)


def contact_shown(stop: Stop) -> Shown | None:
    """How people read the gap at the contact point of a stop; None of a stop along its joint."""
    return None if stop.contact is None else replace(AT_CONTACT, factor=MM_PER_M * stop.lever)


def lips_shown(mechanism: Mechanism, stop: Stop) -> Shown | None:
    """How people read that gap beside the angle of a hinge; None of a slide, whose gap is one."""
    return contact_shown(stop) if coordinate_unit(mechanism, stop.index) == "rad" else None


def lips_phrase(mechanism: Mechanism, stop: Stop, gap: float | None) -> str:
    """What follows an angle: the gap at the contact point; nothing without one."""
    lips = lips_shown(mechanism, stop)
    return "" if lips is None or gap is None else f" ({lips.phrase(gap)} at the contact)"


def rate_shown(mechanism: Mechanism, index: int) -> Shown:
    """How people read the rate of a coordinate, by its place in q."""
    unit, factor = shown_in(f"{coordinate_unit(mechanism, index)}/s")
    return Shown(words="rate", unit=unit, factor=factor)


def spring_text(mechanism: Mechanism) -> str:
    """Stiffness, preload deflection and preload force of every spring, or what its table spans."""
    parts = []
    for spring in mechanism.springs:
        rate = stiffness_shown(mechanism, spring.index)
        preload = coordinate_shown(mechanism, spring.index)
        unit = "N" if preload.unit == "mm" else "N m"
        parts.append(
            f"{spring.name} {rate.value(spring.stiffness):g} {rate.unit}, "
            f"preload {preload.value(spring.preload):g} {preload.unit} "
            f"({digits(spring.stiffness * spring.preload)} {unit})"
        )
    for table in mechanism.tabulated_springs:
        span, rows = coordinate_shown(mechanism, table.index), table.characteristic
        low, high = (f"{span.value(end):g}" for end in rows.ends)
        forces = f"{rows.force[0]:g} to {rows.force[-1]:g}"
        unit = "N m" if coordinate_unit(mechanism, table.index) == "rad" else "N"
        parts.append(f"{table.name} table from {low} to {high} {span.unit}, {forces} {unit}")
    per_length, per = shown_in("N/m")
    unit, length = shown_in("m")
    for strut in _struts(mechanism, "spring"):
        parts.append(
            f"{strut.name} {per * strut.stiffness:g} {per_length} from {strut.frame_a} to "
            f"{strut.frame_b}, free length {length * strut.free_length:g} {unit}"
        )
    return "; ".join(parts) or "none"


def element_lines(mechanism: Mechanism) -> Iterator[str]:
    """Springs, and dampers and force elements if there are any, a line of each kind."""
    yield f"springs: {spring_text(mechanism)}"
    if dampers := _damper_text(mechanism):
        yield f"dampers: {dampers}"
    if mechanism.forces:
        forces = (f"{force.name} ({force.kind}) on {mechanism.joints[force.index].name}"
                  for force in mechanism.forces)  # fmt: skip
        yield f"forces: {'; '.join(forces)}"


def _damper_text(mechanism: Mechanism) -> str:
    """Damping of every damper; empty without one."""
    parts = []
    for damper in mechanism.dampers:
        turns = coordinate_unit(mechanism, damper.index) == "rad"
        parts.append(f"{damper.name} {damper.damping:g} {'N m s/rad' if turns else 'N s/m'}")
    for strut in _struts(mechanism, "damper"):
        ends = f"from {strut.frame_a} to {strut.frame_b}"
        parts.append(f"{strut.name} {strut.damping:g} N s/m {ends}")
    return "; ".join(parts)


def _struts(mechanism: Mechanism, kind: str) -> list[Strut]:
    return [strut for strut in mechanism.struts if strut.kind == kind]


def stop_place(mechanism: Mechanism, stop: Stop) -> str:
    """Joint of a stop, and which of its limits it is."""
    joint = mechanism.joints[stop.index]
    limit = coordinate_shown(mechanism, stop.index)
    side = "lower" if stop.sense > 0.0 else "upper"
    return f"{side} limit of {joint.name} at {limit.value(stop.at):g} {limit.unit}"


def gap_noun(mechanism: Mechanism, stop: Stop) -> str:
    """Name of the gap of a stop: the joint's coordinate, or a distance from the stop."""
    return coordinate_shown(mechanism, stop.index).words if stop.plain else "gap"


def restitution_text(stops: tuple[Stop, ...]) -> str:
    """Restitution of every stop; of vanishing rates where it depends on them."""
    return ", ".join(
        f"{stop.name} {stop.restitution:g}" + (" at rate 0, by a law" if stop.law else "")
        for stop in stops
    )


def law_text(mechanism: Mechanism) -> str:
    """The law of stops that are struck together; empty if it is the usual one."""
    if mechanism.simultaneous == "newton":
        return ""
    return (
        f'stops struck together: simultaneous = "{mechanism.simultaneous}", impulses pass from '
        "contact to contact"
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


def in_sight(solution: Solution, items: Sequence[Item]) -> list[Item]:
    """What happens, or begins, in the turns shown."""
    before = shown_before(solution)
    times = (item.t if isinstance(item, Collision | Event) else item.t_start for item in items)
    return [item for item, t in zip(items, times, strict=True) if t < before]


def shown_events(solution: Solution, kind: EventKind) -> list[Event]:
    """Events of one kind in the turns shown."""
    return [item for item in in_sight(solution, solution.events) if item.kind is kind]


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

"""Report on a model: structure, conditioning over a cycle, clearances and timing."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from ..dynamics import impact_condition
from ..errors import NipperError
from ..hybrid import START_INDEX, Case, EventKind, Solution, Window, simulate
from ..hybrid.result.quantities import force_unit
from ..mechanism import Mechanism, need_mechanism
from .interference import Clearance, clearances
from .masses import LinkMass, link_masses
from .urdf_advice import UrdfAdvice, urdf_advice

_SAMPLES = 240


@dataclass(frozen=True)
class Extreme:
    """An extreme value over a cycle.

    Attributes:
        index: Index at which it occurs.
    """

    value: float
    index: float


@dataclass(frozen=True)
class ModelReport:
    """Findings about a model at one speed.

    Attributes:
        speed_rpm: Speed of the cycle that was walked [r/min].
        start_index: Index at which it starts.
        condition: Largest condition number of the closures over the cycle, the columns of the
            driven joints left out [-]; infinite in a dead centre.
        impact_condition: Largest condition number of the impact matrix of the closures and the
            stops that are closed [-]; accelerations and forces lose as many digits.
        clearances: Smallest distances between links that should not touch.
        closing_index: Index of the first collision of the transition stop; None without one.
        opening_index: Index at which that stop opens again; None if it does not.
        releases: Indices at which a closed stop opens because its force falls to zero.
        stop_force: Smallest force of every stop while it is closed [N], or moment [N m] of one at a
            hinge without a contact point, and where.
        outcome: How the cycle ended.
        struck: Stops that something collides with in the cycle.
        no_transition: Why a transition cannot be simulated from the touch configuration; empty if
            it can.
        urdf: What the URDF holds and the simulation does not.
    """

    mechanism: Mechanism
    speed_rpm: float
    start_index: float
    condition: Extreme
    impact_condition: Extreme
    clearances: tuple[Clearance, ...]
    closing_index: float | None
    opening_index: float | None
    releases: tuple[tuple[str, float], ...]
    stop_force: dict[str, Extreme]
    outcome: str
    struck: frozenset[str]
    no_transition: str
    urdf: UrdfAdvice = field(default_factory=UrdfAdvice)

    @property
    def masses(self) -> tuple[LinkMass, ...]:
        """Masses of the moving links, in the order of their joints."""
        return link_masses(self.mechanism)

    @property
    def interferences(self) -> tuple[Clearance, ...]:
        """Pairs of links that overlap somewhere in the cycle."""
        return tuple(item for item in self.clearances if item.interferes)

    def record(self) -> dict[str, Any]:
        """Return the report as plain data."""
        mechanism = self.mechanism
        return {
            "model": mechanism.name,
            "title": mechanism.title,
            "speed_rpm": self.speed_rpm,
            "start_index": self.start_index,
            "side_view": mechanism.side_view,
            "closing": mechanism.closing,
            "curves": mechanism.curves,
            "links": list(mechanism.links),
            "masses_kg": {item.link: item.mass_kg for item in self.masses},
            "joints": [asdict(joint) for joint in mechanism.joints],
            "closures": [asdict(closure) for closure in mechanism.closures],
            "couplings": [asdict(coupling) for coupling in mechanism.couplings],
            "mobility": mechanism.degrees_of_freedom,
            "driven": len(mechanism.drives),
            "stops": {
                stop.name: {
                    "joint": next(j.name for j in mechanism.joints if j.index == stop.index),
                    "side": "lower" if stop.sense > 0.0 else "upper",
                    "at": stop.at,
                    "restitution": stop.restitution,
                }
                for stop in mechanism.stops
            },
            "contacts": {
                stop.name: {
                    "point_m": stop.contact.point.tolist(),
                    "normal": stop.contact.normal.tolist(),
                    "lever_m": stop.contact.lever_m,
                    "closing_coordinate": stop.contact.closing_coordinate,
                }
                for stop in mechanism.stops
                if stop.contact is not None
            },
            "condition": asdict(self.condition),
            "impact_condition": asdict(self.impact_condition),
            "clearances": [
                {**asdict(item), "interferes": item.interferes} for item in self.clearances
            ],
            "closing_index": self.closing_index,
            "opening_index": self.opening_index,
            "releases": [{"stop": stop, "index": index} for stop, index in self.releases],
            "smallest_stop_force_N": self._smallest("N"),
            "smallest_stop_moment_N_m": self._smallest("N m"),
            "outcome": self.outcome,
            "no_transition": self.no_transition,
            "advice": list(self.urdf.sentences),
            "stops_to_paste": self.urdf.stops,
            "provenance": dict(mechanism.provenance),
        }

    def _smallest(self, unit: str) -> dict[str, Any]:
        """Smallest forces of the stops whose force has a unit, by stop."""
        stops = [stop for stop in self.mechanism.stops if stop.name in self.stop_force]
        return {
            stop.name: asdict(self.stop_force[stop.name])
            for stop in stops
            if force_unit(self.mechanism, stop) == unit
        }


def check(
    mechanism: Mechanism, speed_rpm: float | None = None, start_index: float = START_INDEX
) -> ModelReport:
    """Report structure, timing, clearances and forces of a model over one cycle.

    Args:
        mechanism: The model.
        speed_rpm: Cylinder speed [r/min]; by default the rated one.
        start_index: Index at which the cycle starts, in the initial phase.

    Returns:
        The report of ``nipper-pin check``.

    Raises:
        SimulationError: The cycle cannot be simulated.
        InputError: The speed is none, or this is no mechanism.
    """
    need_mechanism(mechanism, "check")
    speed_rpm = mechanism.cylinder.rated_speed_rpm if speed_rpm is None else speed_rpm
    case = Case(speed_rpm=speed_rpm, window=Window.CYCLE, start_index=start_index)
    solution = simulate(mechanism, case)
    name = mechanism.transition_stop
    closing = next((item.index for item in solution.collisions if item.stop == name), None)
    opening = next(
        (
            _index(solution, event.t)
            for event in solution.events
            if name in event.closed_before and name not in event.closed_after
        ),
        None,
    )
    return ModelReport(
        mechanism=mechanism,
        speed_rpm=speed_rpm,
        start_index=start_index,
        condition=_worst_condition(solution),
        impact_condition=_worst_impact_condition(solution),
        clearances=clearances(solution),
        closing_index=closing,
        opening_index=opening,
        releases=tuple(
            (stop, _index(solution, event.t))
            for event in solution.events
            if event.kind is EventKind.RELEASE
            for stop in event.stops
        ),
        stop_force=_smallest_forces(solution),
        outcome=solution.outcome.value,
        struck=frozenset(item.stop for item in solution.collisions),
        no_transition=_no_transition(mechanism, speed_rpm),
        urdf=urdf_advice(solution),
    )


def _no_transition(mechanism: Mechanism, speed_rpm: float) -> str:
    """Why a transition cannot be simulated; empty if it can. Most take milliseconds."""
    try:
        simulate(mechanism, Case(speed_rpm=speed_rpm))
    except NipperError as error:
        return error.message
    return ""


def _worst_condition(solution: Solution) -> Extreme:
    times = np.linspace(*solution.trajectory.span, _SAMPLES)
    _, jacobian = solution.system.body.closures(solution.trajectory.evaluate(times).q)
    free = [i for i in range(solution.system.body.nv) if i not in solution.system.driven]
    if not jacobian.shape[1]:
        return Extreme(1.0, _index(solution, 0.0))
    conditions = np.linalg.cond((jacobian * solution.system.body.units)[:, :, free])
    worst = int(np.argmax(conditions))
    return Extreme(float(conditions[worst]), _index(solution, float(times[worst])))


def _worst_impact_condition(solution: Solution) -> Extreme:
    system, worst = solution.system, Extreme(1.0, _index(solution, 0.0))
    for segment in solution.segments:
        stops = system.constraint_set(segment.closed).stops
        for panel, _, end in segment.pieces():
            inside = panel.times <= end
            _, jacobian = system.body.closures(panel.q[inside])
            states = zip(panel.times[inside].tolist(), panel.q[inside], jacobian, strict=True)
            for t, q, rows in states:
                condition = impact_condition(system, q, rows, stops)
                if condition > worst.value:
                    worst = Extreme(condition, _index(solution, t))
    return worst


def _smallest_forces(solution: Solution) -> dict[str, Extreme]:
    found: dict[str, Extreme] = {}
    for segment in solution.segments:
        if not segment.closed or segment.t_end <= segment.t_start:
            continue
        count = max(8, int(_SAMPLES * (segment.t_end - segment.t_start) / solution.shaft.period))
        times = np.linspace(segment.t_start, segment.t_end, count)
        # A release ends a segment, so the limit from before the event counts.
        begin = solution.trajectory.reactions(times[:-1])
        end = solution.trajectory.reactions(times[-1:], left=True)
        for name in segment.closed:
            forces = np.concatenate([begin.contacts[name], end.contacts[name]])
            least = int(np.argmin(forces))
            if name not in found or forces[least] < found[name].value:
                found[name] = Extreme(float(forces[least]), _index(solution, float(times[least])))
    return found


def _index(solution: Solution, t: float) -> float:
    return solution.mechanism.cylinder.index_from_angle(float(solution.shaft.angle(t)))

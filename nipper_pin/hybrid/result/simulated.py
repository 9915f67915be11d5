"""A simulated stretch of motion, and what is computed from it when it is asked for."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ...arrays import FloatArray
from ...dynamics import ShaftMotion, System
from ...mechanism import Mechanism
from ...mechanism.parallel import led
from ..case import Case
from ..error_estimate.event_errors import EventError, event_errors
from ..history import Event, EventKind, Outcome, Segment
from ..parallel import errors_for_all, of_leaders
from .tables import Collision, PhaseInterval, Rebounds, Transition

if TYPE_CHECKING:
    from .energy_balance import EnergyBalance
    from .premise import Premise
    from .trajectory import Trajectory


@dataclass(frozen=True)
class LinkVelocities:
    """Velocities of the moving links at one state.

    Attributes:
        links: Names.
        angular: Counter-clockwise in the side view [rad/s], shape (links,).
        centroid: (x, z) of the centre of mass [m/s], shape (links, 2).
    """

    links: tuple[str, ...]
    angular: FloatArray
    centroid: FloatArray


@dataclass(frozen=True)
class Checks:
    """Residuals of a run, all of which should be zero.

    Attributes:
        closure_m: Largest closure gap of the computed motion [m].
        closure_rate_m_s: Largest closure rate [m/s].
        energy_balance: Residual of the energy balance by the largest kinetic energy [-].
    """

    closure_m: float
    closure_rate_m_s: float
    energy_balance: float


# Most runs are asked for none of what the properties below import where they need it.
@dataclass(frozen=True, eq=False, repr=False)
class Simulated:
    """The numbers of a run; :class:`~nipper_pin.Solution` says what each is, and shows them."""

    mechanism: Mechanism
    case: Case
    shaft: ShaftMotion
    events: tuple[Event, ...]
    segments: tuple[Segment, ...]
    outcome: Outcome
    evaluations: int
    wall_s: float
    repeated_from: int | None

    def __getstate__(self) -> dict[str, Any]:
        """What was simulated; Pinocchio's objects, which are found again, cannot be pickled."""
        return {item.name: getattr(self, item.name) for item in fields(self)}

    @cached_property
    def system(self) -> System:
        """The system that the solution belongs to, for evaluations afterwards."""
        return System(self.mechanism, self.shaft, self.case.drive)

    @cached_property
    def led_system(self) -> System:
        """The system that was followed: of stops that close together it has the leader."""
        alone = led(self.mechanism)
        if alone is self.mechanism:
            return self.system
        return System(alone, self.shaft, self.case.drive)

    @cached_property
    def led_events(self) -> tuple[Event, ...]:
        """The events of that system."""
        return of_leaders(self.mechanism, self.events)

    @cached_property
    def trajectory(self) -> Trajectory:
        """Dense motion and forces at any time."""
        from .trajectory import Trajectory

        return Trajectory(self.system, self.segments)

    @cached_property
    def collisions(self) -> tuple[Collision, ...]:
        """Collisions with their rebounds, in order of time; of stops struck at once in theirs."""
        system, table = self.system, list[Collision]()
        rebounds = Rebounds(system, self.segments, self.events, self.case, self.led_system)
        for event in self.events:
            if event.kind is not EventKind.COLLISION:
                continue
            struck = event.struck(self.mechanism)
            psi = float(self.shaft.angle(event.t))
            for stop in struck:
                approach, separation = stop.rate(event.v_before), stop.rate(event.v_after)
                lost = event.energy_lost
                if len(struck) > 1:
                    # What the impulse of one stop takes away: all stops together lose all.
                    lost = -0.5 * event.P_N[stop.name] * (approach + separation)
                table.append(
                    Collision(
                        number=len(table) + 1,
                        stop=stop.name,
                        t=event.t,
                        cylinder_angle=psi,
                        index=self.mechanism.cylinder.index_from_angle(psi),
                        approach_rate=approach,
                        separation_rate=separation,
                        impulse=event.P_N[stop.name] / stop.lever,
                        energy_lost=lost,
                        event=event,
                        rebounds=rebounds,
                    )
                )
        return tuple(table)

    @cached_property
    def phases(self) -> tuple[PhaseInterval, ...]:
        """Phases in order of time; one after a series of bounces starts at the time of rest."""
        mechanism, found = self.mechanism, list[PhaseInterval]()

        def add(closed: frozenset[str], start: float, end: float) -> None:
            if end > start:
                phase = mechanism.phase_of(closed)
                number = None if phase is None else phase.number
                found.append(PhaseInterval(number, closed, start, end))

        start, closed = 0.0, mechanism.phase(mechanism.initial_phase).closed
        for event in self.events:
            if event.closed_after != closed:
                add(closed, start, event.t)
                start, closed = event.t, event.closed_after
        add(closed, start, self.segments[-1].t_end if self.segments else 0.0)
        return tuple(found)

    @cached_property
    def transitions(self) -> tuple[Transition, ...]:
        """Completed bounce series of the transition stop, in order of time."""
        stop, series = self.mechanism.transition_stop, list[Collision]()
        found = []
        by_event = {item.event.number: item for item in self.collisions if item.stop == stop}
        for event in self.events:
            if event.number in by_event:
                series.append(by_event[event.number])
            elif event.kind is EventKind.REST and stop in event.stops and series:
                duration = event.t - series[0].t
                share = None
                if len(series) > 2 and duration > 0.0:
                    share = (series[2].t - series[0].t) / duration
                found.append(Transition(series[0].t, duration, len(series), share))
                series = []
        return tuple(found)

    @cached_property
    def premise(self) -> Premise:
        """Premise of a transition: whether a whole turn arrives in its start state, and why not."""
        from .premise import premise_of

        return premise_of(self.led_system, self.case, self.led_events, self.trajectory)

    @property
    def premise_holds(self) -> bool | None:
        """True or False; None where it was not asked or cannot be told: see ``premise``."""
        return self.premise.holds

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """What to know before its numbers are used, a sentence each; usually nothing."""
        from .premise import bounces_summed_up, law_that_matters, unusual

        mechanism = self.mechanism
        told = (
            unusual(mechanism, self.case),
            mechanism.closing,
            mechanism.curves,
            law_that_matters(self.led_system, self.led_events),
            bounces_summed_up(mechanism, self.case, self.events),
        )
        return tuple(filter(None, told))

    @cached_property
    def errors(self) -> tuple[EventError, ...]:
        """Estimated errors of the events, in their order."""
        found = event_errors(self.led_system, self.segments, self.led_events)
        return errors_for_all(self.mechanism, found)

    @cached_property
    def energy(self) -> EnergyBalance:
        """Energy balance of the whole run."""
        from .energy_balance import energy_balance

        return energy_balance(self.system, self.segments, self.events)

    @cached_property
    def checks(self) -> Checks:
        """Closure and energy residuals of the whole run."""
        from .trajectory import closure_residuals

        gap, rate = closure_residuals(self.system, self.segments)
        return Checks(gap, rate, self.energy.relative)

    def link_velocities(self, event: Event) -> tuple[LinkVelocities, LinkVelocities]:
        """Velocities of every link before and after an event (eqs 18 to 27 of the paper)."""
        before, after = (
            LinkVelocities(self.mechanism.links, *self.system.body.link_velocities(event.q, v))
            for v in (event.v_before, event.v_after)
        )
        return before, after

"""What a simulation returns: events, motion between them, and how the run ended."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import InputError
from ...frames import data_frame
from ...notebook import html
from ...terms.shown import counted
from ...units import MS_PER_S
from ..history import Event, EventKind, State, found_after
from ..run.phase_manager import PhaseManager, go_on
from .columns import TABLES, columns
from .simulated import Simulated

if TYPE_CHECKING:
    from .trajectory import Motion


_SHOWN = ("number", "stop", "time_s", "index", "approach_rate", "separation_rate", "energy_lost_J",
          "rebound_amplitude", "rebound_time_s")  # fmt: skip


class Solution(Simulated):
    """A simulated stretch of motion; a transition without rebound is a collision and no motion.

    Tables, dense motion, forces and balances are computed when they are first asked for; a solution
    that is pickled leaves them behind.

    Attributes:
        mechanism: The mechanism.
        case: The case.
        shaft: Motion of the cylinder; its start angle belongs to time zero.
        events: Events in order of time.
        segments: Motion between events, in order of time, without gaps.
        outcome: How the run ended.
        evaluations: Evaluations of the constrained dynamics.
        wall_s: Wall time of the run [s].
        repeated_from: Turn that all further ones are copies of, or None.
    """

    def __repr__(self) -> str:
        """One line; nothing is computed for it."""
        hits = (event for event in self.events if event.kind is EventKind.COLLISION)
        count = sum(len(event.struck(self.mechanism)) for event in hits)
        return (
            f"<Solution of {self.mechanism.name}: {self._told_case}, "
            f"{counted(count, 'collision')}, {self.outcome.name.lower()}>"
        )

    def _repr_html_(self) -> str:
        """The case, how the run ended, and its collisions."""
        facts = {"case": self._told_case, "outcome": self.outcome.value}
        if self.transitions:
            facts["transition"] = f"{MS_PER_S * self.transitions[0].duration:.6g} ms"
        table = columns(self, "collisions")
        shown = {name: table[name] for name in _SHOWN if name in table}
        rows = list(zip(*shown.values(), strict=True))
        return html(self.mechanism.title or self.mechanism.name, facts, list(shown), rows)

    @property
    def _told_case(self) -> str:
        case = self.case
        window = case.window.value
        told = counted(case.cycles, "turn") if window == "cycle" else window
        return f"{case.speed_rpm:g} r/min, {told}, {case.drive.value} drive"

    def to_frame(
        self, table: str | None = None, library: str | None = None, *, units: str = "SI"
    ) -> Any:
        """A table of the run as a data frame.

        Args:
            table: "collisions", with the names of the JSON document; "phases", "links" (their
                velocities at collisions) or "motion", as the CSV files of ``simulate --out``. A
                library alone may stand here, too.
            library: "pandas", "polars" or "pyarrow"; by default the first that is installed.
            units: "SI", or "mm" for mm and degrees.

        Raises:
            InputError: There is no such table, or the library is not installed.
        """
        if library is None and table is not None and table not in TABLES:
            table, library = None, table
        return data_frame(columns(self, table or "collisions", units), library)

    def motion_at(self, event: Event) -> Motion:
        """State just after an event, at its own time; not computed before it is asked for.

        The limit of a series of bounces lies beyond the last collision that is computed, whose
        configuration and velocities ``event.q`` and ``event.v_after`` of a rest are. The motion is
        followed from there with the stop at rest.

        Args:
            event: One of the events of this solution.

        Returns:
            The state, with one row.

        Raises:
            SimulationError: The motion cannot be followed to the time of a rest.
        """
        from .trajectory import Motion

        system, t = self.led_system, event.t
        q, v = event.q, event.v_after
        if event.kind is EventKind.REST:
            if self.segments and t <= self.segments[-1].t_end:
                return self.trajectory.evaluate(t)
            began = found_after(self.events, event).t
            closed = self.led_events[event.number - 1].closed_after
            reached, _ = go_on(system, self.case, State.at(system, began, q, v, closed), t)
            if reached is not None:
                q, v = reached.q, reached.v
        times = np.array([t])
        names = tuple(joint.name for joint in self.mechanism.joints)
        return Motion(times, system.shaft.angle(times), q[None], v[None], names)

    def continued(self, to: float) -> Solution:
        """This run with the motion after its last event, until the next one or a later time.

        Args:
            to: The time [s], after the last event.

        Returns:
            The same events, and motion that goes on behind the last of them.

        Raises:
            InputError: The run has no event, or its last one comes later.
            SimulationError: The motion cannot be followed.
        """
        if not self.events or not to > self.events[-1].t:
            there = f"comes at {self.events[-1].t:.6g} s" if self.events else "is not there"
            message = f"to = {to:g} s: a run is continued behind its last event, which {there}"
            raise InputError(message, to=to)
        last, system = self.led_events[-1], self.led_system
        motion = self.motion_at(last)
        start = State.at(system, last.t, motion.q[0], motion.v[0], last.closed_after)
        manager = PhaseManager(system, self.case, start)
        manager.step(to)
        before = [item for item in self.segments if item.t_start < last.t]
        return replace(self, segments=(*before, *manager.segments))

"""Turns of many cases as they come in, from both engines."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ...errors import NipperError
from ...hybrid import START_INDEX, Case, Outcome, Solution, Window, simulate
from ...hybrid.result.turns import Turn, of_turn, read_of, reported_turn, turn_names
from ...mechanism import INDEX_PER_TURN, Mechanism, within_turn
from ...reduced.results import TURN_REASONS
from ...reduced.turns import TurnQuantities, TurnStatus, turn_quantities
from ..cases import Cases, Settings, one_of
from ..transitions import FAILED, REDUCED
from .table import FOLLOWED, TurnTable

DIRECT = "direct"
# Turns of the direct engine that are computed at first, and how many times as many then.
_FIRST_TURNS, _MORE_TURNS = 5, 4
# Travels of the reduced engine by the columns of indices.
_TRAVELS = {
    "closing_index": "closed_at",
    "rest_index": "rests_at",
    "loss_index": "lost_at",
    "opening_index": "opened_at",
}
_PER_RAD = INDEX_PER_TURN / math.tau
_STATUS = {int(status): status.name.lower() for status in TurnStatus}


@dataclass(frozen=True, kw_only=True)
class TurnSettings(Settings):
    """Settings of all cases.

    Attributes:
        turns: Largest number of turns of a case.
        least_force: Force above which the transition stop clamps [N].
        torques: Whether the largest torques of the drives are computed.
        wanted: Names of the quantities that the direct engine reads, None for all of these: errors
            cost it more than the turn.
    """

    turns: int
    least_force: float = 0.0
    torques: bool = False
    wanted: frozenset[str] | None = None


class Run:
    """Results of all cases as they come in."""

    def __init__(self, mechanism: Mechanism, cases: Cases, settings: TurnSettings) -> None:
        """Begin with none."""
        n = len(cases.speed_rpm)
        self._mechanism, self._cases, self._settings = mechanism, cases, settings
        self._engine = np.full(n, DIRECT, dtype="U7")
        self._outcome = np.full(n, FAILED, dtype="U24")
        self._message = [""] * n
        self._turns = np.zeros(n, dtype=np.int64)
        names = turn_names(mechanism, drives=settings.torques)
        self._read = {name: of_turn(name, mechanism) for name in names}
        # By the attribute of the table and, where it is of a stop or a drive, its name.
        self._found = {
            (item.column, part): np.full(n, np.nan) for item, part in self._read.values()
        }
        self._restitution = {
            stop.name: cases.others.get(stop.name, np.full(n, stop.restitution))
            for stop in mechanism.stops
        }
        self._restitution[mechanism.transition_stop] = cases.restitution

    def reduced(self, *, keep_all: bool) -> list[int]:
        """Follow all cases by the reduced engine; returns those that it leaves to the other."""
        settings = self._settings
        found = turn_quantities(
            self._mechanism,
            speed_rpm=self._cases.speed_rpm,
            turns=settings.turns,
            start_index=START_INDEX,
            restitution=self._restitution,
            stiffness=self._cases.stiffness,
            preload=self._cases.preload,
            least_force=settings.least_force,
            torques=settings.torques,
            rest_rate=settings.rest_rate,
            tolerance=settings.tolerance,
            max_collisions=settings.max_collisions,
        )
        status = found.status
        self._found = {key: _reduced_column(found, *key) for key in self._found}
        self._engine[:] = REDUCED
        self._outcome[:] = [_STATUS[number] for number in status.tolist()]
        self._turns = np.where(status == TurnStatus.FOLLOWED, found.turns, 0)
        left = np.flatnonzero(status != TurnStatus.FOLLOWED).tolist()
        for number in left:
            reason = TURN_REASONS[TurnStatus(int(status[number]))]
            self._message[number] = f"the reduced engine: {reason}"
        return [] if keep_all else left

    def direct(self, number: int) -> None:
        """Simulate one case by the direct engine."""
        self._engine[number], self._outcome[number], self._turns[number] = DIRECT, FAILED, 0
        for column in self._found.values():
            column[number] = np.nan
        try:
            mechanism, case = one_of(self._mechanism, self._cases, self._settings, number)
            turns = replace(case, window=Window.CYCLE, cycles=self._settings.turns)
            self._follow(number, mechanism, turns)
        except NipperError as error:
            self._message[number] = error.message

    def _follow(self, number: int, mechanism: Mechanism, case: Case) -> None:
        solution, turn = _until_repeated(mechanism, case, self._settings.least_force)
        if turn is None:
            self._outcome[number] = solution.outcome.name.lower()
            self._message[number] = solution.outcome.value
            return
        wanted = self._settings.wanted
        for name, (item, part) in self._read.items():
            if item.read is None or not (wanted is None or name in wanted):
                continue
            value: Any = item.read(solution, read_of(turn, item, part))
            if value is not None:
                self._found[item.column, part][number] = value
        self._found["repeats_after", ""][number] = turn.repeats_after
        self._turns[number], self._outcome[number] = turn.number, FOLLOWED

    def table(self, why: str) -> TurnTable:
        """The table of all cases."""
        columns: dict[str, Any] = {"largest_torque": {}, "largest_torque_error": {}}
        for (column, part), values in self._found.items():
            if part:
                columns.setdefault(column, {})[part] = values
            else:
                columns[column] = values
        again = columns.pop("repeats_after")
        return TurnTable(
            model=self._mechanism.name,
            why=why,
            engine=self._engine,
            outcome=self._outcome,
            message=tuple(self._message),
            speed_rpm=self._cases.speed_rpm,
            restitution=self._restitution,
            stiffness=self._cases.stiffness,
            preload=self._cases.preload,
            turns=self._turns,
            repeats_after=np.nan_to_num(again).astype(np.int64),
            mechanism=self._mechanism,
            **columns,
        )


def _reduced_column(found: TurnQuantities, column: str, part: str) -> FloatArray:
    """A column of the table, by its attribute and the name of a stop or drive, if it is of one."""
    travel = _TRAVELS.get(column.removesuffix("_error"))
    if travel is not None:
        if column.endswith("_error"):
            return np.asarray(_PER_RAD * getattr(found, f"{travel}_error"))
        return within_turn(START_INDEX + _PER_RAD * getattr(found, travel))
    values = getattr(found, column)
    if part:
        parts = found.drives if column.startswith("largest_torque") else found.stops
        values = values[:, parts.index(part)]
    return np.array(values, dtype=np.float64)


def _until_repeated(
    mechanism: Mechanism, case: Case, least_force: float
) -> tuple[Solution, Turn | None]:
    """Follow more and more turns until they repeat; no turn where there are too many collisions."""
    cycles = min(_FIRST_TURNS, case.cycles)
    while True:
        solution = simulate(mechanism, replace(case, cycles=cycles))
        if solution.outcome is Outcome.TOO_MANY_COLLISIONS:
            return solution, None
        turn = reported_turn(solution, least_force)
        if cycles == case.cycles or turn.repeats_after:
            return solution, turn
        cycles = min(_MORE_TURNS * cycles, case.cycles)

"""Turns of many cases as they come in, from both engines."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ...dynamics.system import DriveMode
from ...errors import NipperError
from ...hybrid.case import START_INDEX, Case, Resolution, Window
from ...hybrid.result.solution import Solution
from ...hybrid.result.turns import Turn, of_turn, reported_turn, turn_names
from ...hybrid.run.outcome import Outcome
from ...hybrid.simulate import simulate
from ...mechanism import Mechanism
from ...mechanism.cylinder import INDEX_PER_TURN
from ...reduced.turns import TurnQuantities, TurnStatus, turn_quantities
from ...reduced.turns.results import TURN_REASONS
from ..cases import Cases
from ..transitions import FAILED, REDUCED, retuned
from .table import FOLLOWED, TurnTable

DIRECT = "direct"
# Turns of the direct engine that are computed at first, and how many times as many then.
_FIRST_TURNS, _MORE_TURNS = 5, 4
_STATUS = {int(status): status.name.lower() for status in TurnStatus}


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Settings of all cases.

    Attributes:
        turns: Largest number of turns of a case.
        least_force: Force above which the transition stop clamps [N].
        drive: Behaviour of the driven shafts.
        rest_rate: None: series end at their limit. A number: rest at the first slower rebound.
        tolerance: Relative accuracy.
        max_collisions: Largest number of collisions of a turn.
        wanted: Names of the quantities that are read, None for all: some cost more than the turn.
    """

    turns: int
    least_force: float
    drive: DriveMode
    rest_rate: float | None
    tolerance: float
    max_collisions: int
    wanted: frozenset[str] | None = None


class Run:
    """Results of all cases as they come in."""

    def __init__(self, mechanism: Mechanism, cases: Cases, settings: Settings) -> None:
        """Begin with none."""
        n = len(cases.speed_rpm)
        self._mechanism, self._cases, self._settings = mechanism, cases, settings
        self._engine = np.full(n, DIRECT, dtype="U7")
        self._outcome = np.full(n, FAILED, dtype="U24")
        self._message = [""] * n
        self._turns = np.zeros(n, dtype=np.int64)
        self._read = {name: of_turn(name, mechanism) for name in turn_names(mechanism)}
        # By the attribute of the table and, where it is of a stop, the stop.
        self._found = {
            (item.column, stop): np.full(n, np.nan) for item, stop in self._read.values()
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
            rest_rate=settings.rest_rate,
            tolerance=settings.tolerance,
            max_collisions=settings.max_collisions,
        )
        self._engine[:] = REDUCED
        self._outcome[:] = [_STATUS[status] for status in found.status.tolist()]
        self._turns = np.where(found.status == TurnStatus.FOLLOWED, found.turns, 0)
        for key, values in reduced_columns(found).items():
            self._found[key] = values
        left = np.flatnonzero(found.status != TurnStatus.FOLLOWED).tolist()
        for number in left:
            reason = TURN_REASONS[TurnStatus(int(found.status[number]))]
            self._message[number] = f"the reduced engine: {reason}"
        return [] if keep_all else left

    def direct(self, number: int) -> None:
        """Simulate one case by the direct engine."""
        cases, settings = self._cases, self._settings
        self._engine[number], self._outcome[number], self._turns[number] = DIRECT, FAILED, 0
        for column in self._found.values():
            column[number] = np.nan
        try:
            mechanism = retuned(
                self._mechanism,
                {name: float(e_N[number]) for name, e_N in self._restitution.items()},
                cases.stiffness[number],
                cases.preload[number],
            )
            case = Case(
                speed_rpm=float(cases.speed_rpm[number]),
                window=Window.CYCLE,
                cycles=settings.turns,
                drive=settings.drive,
                rest_rate=settings.rest_rate,
                resolution=Resolution(tolerance=settings.tolerance),
                max_collisions=settings.max_collisions,
            )
            self._follow(number, mechanism, case)
        except NipperError as error:
            self._message[number] = error.message

    def _follow(self, number: int, mechanism: Mechanism, case: Case) -> None:
        solution, turn = _until_repeated(mechanism, case, self._settings.least_force)
        if turn is None:
            self._outcome[number] = solution.outcome.name.lower()
            self._message[number] = solution.outcome.value
            return
        wanted = self._settings.wanted
        for name, (item, stop) in self._read.items():
            if item.read is None or not (wanted is None or name in wanted):
                continue
            value: Any = item.read(solution, turn.at(stop) if stop else turn)
            if value is not None:
                self._found[item.column, stop][number] = value
        self._found["repeats_after", ""][number] = turn.repeats_after
        self._turns[number], self._outcome[number] = turn.number, FOLLOWED

    def table(self, why: str) -> TurnTable:
        """The table of all cases."""
        columns: dict[str, Any] = {}
        for (column, stop), values in self._found.items():
            if stop:
                columns.setdefault(column, {})[stop] = values
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
        # Rebounds at the end of the last turn are only known from the next one.
        if cycles == case.cycles or (turn.repeats_after and turn.number < cycles):
            return solution, turn
        cycles = min(_MORE_TURNS * cycles, case.cycles)


def reduced_columns(found: TurnQuantities) -> dict[tuple[str, str], FloatArray]:
    """Columns of a table from the reduced engine, by attribute and stop.

    Args:
        found: Quantities of the last turn of each case.
    """
    whole = {
        "repeats_after": found.repeats_after.astype(np.float64),
        "clamped_time": found.clamped_time,
        "clamped_share": found.clamped_share,
        "closing_index": _index(found.closed_at),
        "rest_index": _index(found.rests_at),
        "loss_index": _index(found.lost_at),
        "opening_index": _index(found.opened_at),
        "least_clamping_force": found.least_force,
        "largest_clamping_force": found.most_force,
        "clamping_force_error": found.force_error,
        "largest_gap": found.largest_gap,
        "largest_gap_error": found.gap_error,
        "energy_lost": found.energy_lost,
    }
    each = {
        "collisions": found.collisions,
        "impulse_sum": found.impulse_sum,
        "impulse_sum_error": found.impulse_sum_error,
        "largest_impulse": found.largest_impulse,
    }
    return {
        **{(name, ""): np.array(values) for name, values in whole.items()},
        **{
            (name, stop): np.array(values[:, place])
            for name, values in each.items()
            for place, stop in enumerate(found.stops)
        },
    }


def _index(travel: FloatArray) -> FloatArray:
    """Indices at travels from the start of a turn [rad]."""
    return np.asarray(START_INDEX + INDEX_PER_TURN * travel / (2.0 * np.pi))

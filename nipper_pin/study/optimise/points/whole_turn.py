"""Quantities of whole turns of the designs of one problem, by the engine that suits it.

Tables of turns cost as much as nine points by the direct engine (176 ms of processor time, and 20,
the E62 at 650 r/min). They are made where one machine serves all points, since only speed,
restitution, spring rates and preloads are free: a point then takes 1 ms. A geometry that changes
with each point would need tables for each, so those problems take the direct engine.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....errors import SimulationError
from ....hybrid import START_INDEX
from ....mechanism import Mechanism, counted_from
from ....tolerances.study import COARSEST_TURN, QUANTITY_ROUND_OFF
from ...cases import cases_of
from ...transitions import REDUCED_TURN, TURN
from ...turns.engine_choice import turns_of
from ...turns.run import TurnSettings
from ...turns.table import FOLLOWED, TurnTable
from ..problem.problem import Problem
from ..problem.quantities import MARGIN, QUANTITIES
from .one_machine import sampled_once

# Turns before one repeats, collisions of a turn, and how much coarser the second run is.
_TURNS, _MOST_COLLISIONS, _COARSER = 8, 500, 100.0
_FORCES = ("least_clamping_force_N", "largest_clamping_force_N")


@dataclass(frozen=True, eq=False)
class WholeTurn:
    """The turn of one design, which repeats.

    Attributes:
        engine: "reduced_turn" or "turn".
        values: Quantities by name; NaN where the turn has none.
        bounds: Errors that the engine states of them, by name.
    """

    engine: str
    values: Mapping[str, float]
    bounds: Mapping[str, float]


class WholeTurns:
    """Turns of the designs of one problem."""

    def __init__(self, problem: Problem) -> None:
        """Prepare; nothing is computed yet."""
        self._problem = problem
        self._names = tuple(
            name for name in problem.quantities if QUANTITIES[name].source == "turn"
        )

    @property
    def asked(self) -> bool:
        """Whether the problem asks for any of their quantities."""
        return bool(self._names)

    @property
    def why(self) -> str:
        """Reason for the choice of the engine."""
        return self._sampled[1]

    def at(self, mechanism: Mechanism, speed_rpm: float, *, coarse: bool = False) -> WholeTurn:
        """The turn of one design.

        Args:
            coarse: Whether to compute it with a coarser tolerance, to see what that changes.

        Raises:
            SimulationError: The turns cannot be followed, or differ from one another.
        """
        base = self._sampled[0]
        if base is not None:
            table = self._followed(base, mechanism, speed_rpm, coarse=coarse)
            if table.outcome[0] == FOLLOWED:
                return self._read(table, REDUCED_TURN)
        table = self._followed(None, mechanism, speed_rpm, coarse=coarse)
        if table.outcome[0] != FOLLOWED:
            reason = table.message[0] or str(table.outcome[0]).replace("_", " ")
            message = f"{mechanism.name}: its turns cannot be followed: {reason}"
            raise SimulationError(message, speed_rpm=speed_rpm)
        return self._read(table, TURN)

    def errors(self, mechanism: Mechanism, speed_rpm: float) -> dict[str, float]:
        """Stated errors of the quantities of a turn, by name: what a coarser tolerance changes."""
        fine = self.at(mechanism, speed_rpm)
        coarse = self.at(mechanism, speed_rpm, coarse=True).values
        return {
            name: abs(value - coarse[name]) + QUANTITY_ROUND_OFF * abs(value)
            + fine.bounds.get(name, 0.0)
            for name, value in fine.values.items()
        }  # fmt: skip

    def _followed(
        self, base: Mechanism | None, mechanism: Mechanism, speed_rpm: float, *, coarse: bool
    ) -> TurnTable:
        """One case: by the tables of a base, or by the direct engine."""
        tolerance = self._problem.tolerance
        settings = TurnSettings(
            turns=_TURNS,
            rest_rate=self._problem.rest_rate,
            tolerance=min(_COARSER * tolerance, COARSEST_TURN) if coarse else tolerance,
            max_collisions=_MOST_COLLISIONS,
            wanted=frozenset({*self._names, "repeats_after", "rest_index", "opening_index"}),
        )
        cases = cases_of(
            base or mechanism,
            speed_rpm,
            {stop.name: stop.restitution for stop in mechanism.stops},
            np.array([[spring.stiffness for spring in mechanism.springs]]),
            np.array([[spring.preload for spring in mechanism.springs]]),
        )
        return turns_of(base or mechanism, cases, settings, "direct" if base is None else "reduced")

    def _read(self, table: TurnTable, engine: str) -> WholeTurn:
        if table.repeats_after[0] != 1:
            message = f"{table.model}: turns differ from one another, and so do their quantities"
            raise SimulationError(message, speed_rpm=float(table.speed_rpm[0]))
        values, bounds = {}, {}
        for name in self._names:
            if name == MARGIN:
                opening, rest = (
                    counted_from(START_INDEX, index)
                    for index in (table.opening_index, table.rest_index)
                )
                values[name] = float(opening[0] - rest[0])
            else:
                values[name] = float(table.quantity(name)[0])
            if name in _FORCES:
                bounds[name] = float(np.nan_to_num(table.clamping_force_error[0]))
            if name == "largest_gap":
                bounds[name] = float(np.nan_to_num(table.largest_gap_error[0]))
        return WholeTurn(engine, values, bounds)

    @cached_property
    def _sampled(self) -> tuple[Mechanism | None, str]:
        return sampled_once(self._problem, self._with_tables)

    def _with_tables(self, mechanism: Mechanism) -> Mechanism:
        """Follow one turn, for which the tables are made and kept."""
        self._followed(mechanism, mechanism, self._problem.speed_rpm, coarse=True)
        return mechanism

"""From free numbers to quantities and slacks; settings alone do not build a machine again."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ....arrays import FloatArray
from ....errors import NipperError, SimulationError
from ....mechanism import Mechanism, changed, retuned
from ....tolerances.study import QUANTITY_ROUND_OFF
from ...identify.problem.working_cycle import WorkingCycle, working_cycle
from ..problem.problem import Problem, read_text
from ..problem.quantities import QUANTITIES, cycle_values, lowest, thinned
from .bounces import Bounces, Transitions
from .point import Point, slack_rows
from .turn import differs, turn_values
from .whole_turn import WholeTurn, WholeTurns

# Machines that are kept: those of a central difference in a few parameters.
_MACHINES = 16
# Turns of a machine that arrives in its initial phase start a quarter of a turn before the touch.
_BEFORE = 0.25


@dataclass(frozen=True, eq=False)
class _Known:
    """What was computed for one design, each if it is needed."""

    bounces: Bounces | None
    cycle: WorkingCycle | None
    turn: WholeTurn | None = None

    @property
    def engine(self) -> str:
        """Engine of the turn if that is asked for, else of the transition."""
        if self.turn is not None:
            return self.turn.engine
        return "" if self.bounces is None else self.bounces.engine


class Evaluator:
    """Points of one problem, by unit coordinates of shape (parameters,)."""

    def __init__(self, problem: Problem) -> None:
        """Prepare; nothing is computed yet."""
        self.problem = problem
        self.transitions = Transitions(problem)
        self.turns = WholeTurns(problem)
        self._moving = [item for item in problem.parameters if item.target.kind == "model"]
        self._built = lru_cache(_MACHINES)(self._changed)

    @property
    def why(self) -> str:
        """Reason for the choice of the engine."""
        return self.turns.why if self.turns.asked else self.transitions.why

    def at(self, z: FloatArray) -> Point:
        """Quantities and slacks of one set of numbers."""
        try:
            known = self._known(z)
            values = self._values(known, z)
        except NipperError as error:
            return Point(z=z, values={}, rows=np.zeros(0), owners=(), why=error.message)
        waiting = np.zeros(0)
        if known.cycle is not None:
            waiting = lowest(known.cycle.waiting.index, known.cycle.waiting.force)
        rows, owners = slack_rows(self.problem.limits, values, waiting)
        return Point(z=z, values=values, rows=rows, owners=owners, engine=known.engine)

    def errors(self, z: FloatArray) -> dict[str, float]:
        """Stated errors of the quantities of a usable point, by name."""
        known = self._known(z)
        values = self._values(known, z)
        coarse = self._values(known, z, thin=True)
        errors = {
            name: abs(value - coarse[name]) + QUANTITY_ROUND_OFF * abs(value)
            for name, value in values.items()
        }
        if known.bounces is not None:
            errors |= known.bounces.errors
        if known.turn is not None:
            errors |= self.turns.errors(self.mechanism(z), self.problem.speed(z))
        return errors

    def mechanism(self, z: FloatArray) -> Mechanism:
        """The mechanism with these numbers.

        Raises:
            InputError: They make none.
        """
        numbers = self.problem.numbers(z)
        base = self._built(*(numbers[item.name] for item in self._moving))
        restitution = base.stop(base.transition_stop).restitution
        stiffness = np.array([spring.stiffness for spring in base.springs])
        preload = np.array([spring.preload for spring in base.springs])
        for item in self.problem.parameters:
            value = numbers[item.name]
            if item.target.kind == "restitution":
                restitution = value
            elif item.target.kind == "stiffness":
                stiffness[item.target.spring] = value
            elif item.target.kind == "preload":
                preload[item.target.spring] = item.target.scale * value
        return retuned(
            base,
            restitution={base.transition_stop: restitution},
            stiffness=stiffness,
            preload=preload,
        )

    def _changed(self, *values: float) -> Mechanism:
        """The machine with other numbers of those that need one of its own."""
        paths = [item.target.path for item in self._moving]
        return changed(self.problem.mechanism, dict(zip(paths, values, strict=True)))

    def _known(self, z: FloatArray) -> _Known:
        """Transition and cycle of a design; the turn is simulated where they would be wrong."""
        mechanism, speed = self.mechanism(z), self.problem.speed(z)
        asked = frozenset(self.problem.quantities)
        sources = {QUANTITIES[name].source for name in asked}
        turn = self.turns.at(mechanism, speed) if self.turns.asked else None
        if turn is not None and not sources & {"transition", "cycle"}:
            return _Known(None, None, turn)
        bounces = self.transitions.at(mechanism, speed, dense="cycle" in sources)
        if "cycle" not in sources:
            return _Known(bounces, None, turn)
        cycle = working_cycle(mechanism, speed)
        why = differs(cycle, bounces.values["duration_s"], asked)
        if why and bounces.turn is None:
            bounces = self.transitions.in_turn(mechanism, speed, why, _BEFORE)
        return _Known(bounces, cycle, turn)

    def _values(self, known: _Known, z: FloatArray, *, thin: bool = False) -> dict[str, float]:
        """Quantities of a design.

        Args:
            thin: Whether curves are looked at in half of their samples, to see what that changes.
        """
        values = {"speed_rpm": self.problem.speed(z)}
        if known.bounces is not None:
            values |= known.bounces.values
        if known.cycle is not None:
            values |= cycle_values(thinned(known.cycle) if thin else known.cycle)
            if known.bounces is not None and known.bounces.turn is not None:
                values |= turn_values(known.bounces.turn, thin=thin)
        if known.turn is not None:
            values |= known.turn.values
        missing = [name for name in self.problem.quantities if not np.isfinite(values[name])]
        if missing:
            what = "turn" if known.bounces is None else "transition"
            message = f"the {what} has no {', '.join(missing)}"
            raise SimulationError(message, missing=missing)
        return values


@lru_cache(maxsize=2)
def evaluator(text: bytes) -> Evaluator:
    """The evaluator of a problem by its text, kept in this process."""
    return Evaluator(read_text(text))

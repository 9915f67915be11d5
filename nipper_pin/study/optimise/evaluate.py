"""From free numbers to quantities and slacks; settings alone do not build a machine again."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec

import numpy as np

from ...arrays import FloatArray
from ...errors import NipperError, SimulationError
from ...mechanism import Mechanism
from ...reduced import ReducedModel, build, transition, unfit
from ..identify.parameters import with_values
from ..identify.targets import Condition, transition_quantities
from ..identify.working import working_cycle
from ..transitions import retuned
from .problem import Limit, Problem, read_text
from .quantities import INDICES, QUANTITIES, cycle_values, lowest, nearest_turn

# Machines that are kept: those of a central difference in a few parameters.
_MACHINES = 16


@dataclass(frozen=True, eq=False, kw_only=True)
class Point:
    """What is known of one set of free numbers.

    Attributes:
        z: Unit coordinates, shape (parameters,).
        values: Quantities by name; empty without a machine that can be simulated.
        rows: Slacks of the limits, positive inside, each in the unit of its quantity, in the order
            of ``owners``; empty without a machine.
        owners: Place of the limit that a row belongs to.
        why: Why there are no quantities; empty if there are.
    """

    z: FloatArray
    values: Mapping[str, float]
    rows: FloatArray
    owners: tuple[int, ...]
    why: str = ""

    @property
    def slacks(self) -> tuple[float, ...]:
        """Slack of every limit: the least of its rows."""
        count = max(self.owners, default=-1) + 1
        return tuple(
            min(float(row) for row, owner in zip(self.rows, self.owners, strict=True) if owner == k)
            for k in range(count)
        )

    @property
    def usable(self) -> bool:
        """Whether these numbers make a machine that can be simulated."""
        return not self.why


class Evaluator:
    """Points of one problem, the engine chosen once for all of them.

    The tables of the reduced engine hold for one machine; only restitution, spring rates, preloads
    and the speed leave it the same. Where nothing else is free they are sampled once and a
    transition costs some 50 us. A machine of its own for every point would pay 60 ms for tables to
    save 2 ms of the direct engine: those problems are solved by that one.
    """

    def __init__(self, problem: Problem) -> None:
        """Prepare; nothing is computed yet."""
        self.problem = problem
        self._moving = [item for item in problem.parameters if item.target.kind == "model"]
        self._built: OrderedDict[tuple[float, ...], Mechanism] = OrderedDict()
        self._tables: tuple[ReducedModel | None] | None = None

    def at(self, z: FloatArray) -> Point:
        """Quantities and slacks of one set of numbers.

        Args:
            z: Unit coordinates, shape (parameters,).
        """
        owners: list[int] = []
        rows: list[float] = []
        try:
            machine = self.mechanism(z)
            values, waiting = self._values(machine, z)
        except NipperError as error:
            return Point(z=z, values={}, rows=np.zeros(0), owners=(), why=error.message)
        for place, limit in enumerate(self.problem.limits):
            found = _slacks(limit, values, waiting)
            rows.extend(found)
            owners.extend([place] * len(found))
        return Point(z=z, values=values, rows=np.array(rows), owners=tuple(owners))

    def mechanism(self, z: FloatArray) -> Mechanism:
        """The mechanism with these numbers.

        Args:
            z: Unit coordinates, shape (parameters,).

        Raises:
            InputError: They make none.
        """
        numbers = self.problem.numbers(z)
        key = tuple(numbers[item.name] for item in self._moving)
        if key in self._built:
            self._built.move_to_end(key)
        else:
            values = {item.target.path: numbers[item.name] for item in self._moving}
            self._built[key] = with_values(self.problem.sources, values).build()
            if len(self._built) > _MACHINES:
                self._built.popitem(last=False)
        base = self._built[key]
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
        return retuned(base, restitution, stiffness, preload)

    @property
    def engine(self) -> str:
        """The engine of the transitions, "reduced" or "direct"."""
        return "direct" if self._reduced() is None else "reduced"

    def _reduced(self) -> ReducedModel | None:
        if self._tables is None:
            self._tables = (self._sampled(),)
        return self._tables[0]

    def _sampled(self) -> ReducedModel | None:
        if self._moving or find_spec("numba") is None:
            return None
        try:
            mechanism = self.problem.sources.build()
            return None if unfit(mechanism) else build(mechanism)
        except NipperError:
            return None

    def _values(self, mechanism: Mechanism, z: FloatArray) -> tuple[dict[str, float], FloatArray]:
        """Quantities that the problem asks for, and the stop force in every interval of phase 1."""
        speed = self.problem.speed(z)
        asked = {QUANTITIES[name].source for name in self.problem.quantities}
        values: dict[str, float] = {"speed_rpm": speed}
        waiting = np.zeros(0)
        if "transition" in asked:
            values |= self._bounces(mechanism, speed)
        if "cycle" in asked:
            cycle = working_cycle(mechanism, speed)
            values |= cycle_values(cycle)
            waiting = lowest(cycle.waiting.index, cycle.waiting.force)
        missing = [name for name in self.problem.quantities if not np.isfinite(values[name])]
        if missing:
            message = f"the transition has no {', '.join(missing)}"
            raise SimulationError(message, missing=missing)
        return values, waiting

    def _bounces(self, mechanism: Mechanism, speed: float) -> dict[str, float]:
        found = self._by_tables(mechanism, speed)
        if found is None:
            found = transition_quantities(
                mechanism, Condition(speed), self.problem.tolerance, self.problem.rest_rate
            )
        kind = mechanism.joints[mechanism.stop(mechanism.transition_stop).index].kind
        return {
            name: found[name]
            for name, item in QUANTITIES.items()
            if item.source == "transition" and item.joint in (None, kind)
        }

    def _by_tables(self, mechanism: Mechanism, speed: float) -> dict[str, float] | None:
        """Quantities by the reduced engine; None where it does not know them."""
        model = self._reduced()
        if model is None:
            return None
        try:
            found = transition(
                model,
                speed_rpm=speed,
                restitution=mechanism.stop(mechanism.transition_stop).restitution,
                stiffness=np.array([spring.stiffness for spring in mechanism.springs]),
                preload=np.array([spring.preload for spring in mechanism.springs]),
                rest_rate=self.problem.rest_rate,
                tolerance=self.problem.tolerance,
            )
        except NipperError:
            return None
        return {
            "rebound_amplitude_1": float(found.rebound_amplitude[0]),
            "rebound_time_s_1": float(found.rebound_time[0]),
            "duration_s": found.duration,
        }


def _slacks(limit: Limit, values: Mapping[str, float], waiting: FloatArray) -> list[float]:
    """Rows of one limit; the stop force has one for each interval, since its least has kinks."""
    sign = 1.0 if limit.side == "lower" else -1.0
    if limit.quantity == "stop_force_N" and sign > 0.0:
        return [float(force) - limit.value for force in waiting]
    value = values[limit.quantity]
    if limit.quantity in INDICES:
        value = nearest_turn(value, limit.value)
    return [sign * (value - limit.value)]


@lru_cache(maxsize=2)
def evaluator(text: bytes) -> Evaluator:
    """The evaluator of a problem, kept in this process.

    Args:
        text: Text of the :class:`~nipper_pin.study.optimise.problem.Problem`.
    """
    return Evaluator(read_text(text))

"""What the reduced engine returns: one transition, many of them as arrays, or whole turns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from .kernels import layout

ENGINE = "reduced"


class Status(IntEnum):
    """How a transition ended."""

    AT_REST = 0
    """The stop came to rest: the only status with a duration."""
    LEFT_TRAVEL = 1
    """Still bouncing at the largest travel of the model."""
    LEFT_GAP = 2
    """A rebound went beyond the largest gap of the model."""
    OTHER_STOP = 3
    """Another stop closed, or nearly did."""
    NOT_PRESSED = 4
    """The stop came to rest without a contact force that keeps it closed."""
    TOO_MANY_COLLISIONS = 5
    """More collisions than ``max_collisions``."""
    UNRESOLVED = 6
    """A flight could not be resolved."""
    UNTOLD = 7
    """The tables do not determine how the simulated turn arrives at the touch."""


REASONS = {
    Status.LEFT_TRAVEL: (
        "the stop is not at rest at the end of the reduced model, a travel of {travel:.4g} rad; "
        "use the direct engine, or nipper_pin.reduced.build with a larger travel_rad"
    ),
    Status.LEFT_GAP: (
        "a rebound leaves the reduced model, whose largest gap is {gap:.4g}; use the direct "
        "engine, or nipper_pin.reduced.build with a larger gap_max"
    ),
    Status.OTHER_STOP: "another stop closes during the transition; use the direct engine",
    Status.NOT_PRESSED: "the stop is not pressed shut when it is at rest; use the direct engine",
    Status.TOO_MANY_COLLISIONS: (
        "the stop is not at rest after {most} collisions; raise max_collisions, or end the series "
        "by a rate (rest_rate)"
    ),
    Status.UNRESOLVED: "a flight cannot be resolved; use the direct engine",
    Status.UNTOLD: (
        "the tables cannot tell how the machine arrives ({why}); simulate whole turns with the "
        "direct engine, use nipper_pin.reduced.build with a larger gap_max, or take the "
        "transition as assumed, by nipper_pin.reduced.transition with assumed=True"
    ),
}


class TurnStatus(IntEnum):
    """How a run of turns ended."""

    FOLLOWED = layout.AT_REST
    """All turns were followed, or they repeat."""
    LEFT_GAP = layout.LEFT_GAP
    """A flight went beyond the largest gap of the model."""
    OTHER_STOP = layout.OTHER_STOP
    """A stop closed outside the stretches of the turn that the model knows."""
    TOO_MANY_COLLISIONS = layout.TOO_MANY
    """More collisions than a series or a run may have."""
    UNRESOLVED = layout.UNRESOLVED
    """A flight could not be resolved."""
    UNTOLD = layout.UNTOLD
    """Round-off decides whether a stop comes to rest, or is released."""
    JAM = layout.JAM
    """Two stops jam the mechanism against its drives."""
    OFF_ROWS = layout.OFF_ROWS
    """A spring may leave the rows of its table, beyond which no force is known."""


TURN_REASONS = {
    TurnStatus.LEFT_GAP: "a flight goes higher than the widest tables",
    TurnStatus.OTHER_STOP: "a stop closes where the tables do not hold it",
    TurnStatus.TOO_MANY_COLLISIONS: "there are more collisions than max_collisions allows",
    TurnStatus.UNRESOLVED: "a flight cannot be resolved",
    TurnStatus.UNTOLD: "round-off decides whether a stop comes to rest or is released",
    TurnStatus.JAM: "two stops jam the mechanism against its drives",
    TurnStatus.OFF_ROWS: "a spring may leave the rows of its table",
}


class Column:
    """A column of a result's table, read by its name; or a row.

    Args:
        place: Its number, or index.
        table: Name of the table.
    """

    def __init__(self, *place: int | slice, table: str = "table") -> None:
        """Store the place."""
        self._index, self._table = (..., *place), table

    def __get__(self, result: object, kind: type) -> FloatArray:
        """The column, as a view."""
        return np.asarray(getattr(result, self._table)[self._index])


class Number(Column):
    """A number of a row, likewise."""

    def __get__(self, result: object, kind: type) -> float:  # type: ignore[override]
        """The number."""
        return float(super().__get__(result, kind))


def _row(place: int) -> Column:
    """A row of a table of collisions."""
    return Column(place, slice(None))


class EventRows:
    """Rows of a table of events, the last axis of which counts the events.

    Attributes:
        time: Their times [s]; of a transition from the first collision, of turns from their start.
        approach_rate: Rate before [rad/s or m/s], negative.
        separation_rate: Rate after.
        impulse: Normal impulse at the contact point [N s]; along the joint of a stop without one
            [N s or N m s].
        energy_lost: Kinetic energy lost [J].
        rebound_amplitude: Largest coordinate of the rebound after it that ends at the same stop.
        rebound_time: Its time [s].
        time_error: Bound on the error of ``time`` [s].
        rate_error: Bound on the error of ``approach_rate``.
        impulse_error: Bound on the error of ``impulse``, in its unit.
        amplitude_error: Bound on the error of ``rebound_amplitude``.
        rebound_error: Bound on the error of ``rebound_time`` [s].
        engine: The engine that computed them.
    """

    engine = ENGINE
    time = _row(layout.TIME)
    approach_rate = _row(layout.APPROACH)
    separation_rate = _row(layout.SEPARATION)
    impulse = _row(layout.IMPULSE)
    energy_lost = _row(layout.ENERGY)
    rebound_amplitude = _row(layout.AMPLITUDE)
    rebound_time = _row(layout.REBOUND)
    time_error = _row(layout.TIME_ERROR)
    rate_error = _row(layout.RATE_ERROR)
    impulse_error = _row(layout.IMPULSE_ERROR)
    amplitude_error = _row(layout.AMPLITUDE_ERROR)
    rebound_error = _row(layout.REBOUND_ERROR)


class CollisionRows(EventRows):
    """Rows of the collisions of transitions.

    Attributes:
        cylinder_angle: psi at the collisions [rad].
    """

    cylinder_angle = _row(layout.ANGLE)


@dataclass(frozen=True, eq=False)
class TransitionRows(CollisionRows):
    """Transitions of n cases, or a single one: what is told of it has no axis of cases.

    Attributes:
        model: Name of the model.
        rest: Row of the rest, with its travel for the angle, NaN without one, shape (n, rows).
        table: All rows of the collisions, shape (n, rows, most).
        tell: Computes the premise.
        duration: Time from the first collision to rest [s], NaN without rest, shape (n,).
        duration_error: Bound on its error [s], shape (n,).
        share: Share of the first two rebounds in the duration; NaN with fewer, shape (n,).
        error_bound: Bound on the worst relative error of the first two rebound times, the first
            amplitude and the duration, shape (n,).
    """

    model: str
    rest: FloatArray = field(repr=False)
    table: FloatArray = field(repr=False)
    tell: Callable[[], NDArray[np.int64]] = field(repr=False)

    @cached_property
    def _relative(self) -> FloatArray:
        """Share and error bound."""
        time, wrong = (self.rest[..., row] for row in (layout.TIME, layout.TIME_ERROR))
        third = self.time[..., 2] if self.time.shape[-1] > 2 else np.nan
        values = [time[..., None], self.rebound_amplitude[..., :1], self.rebound_time[..., :2]]
        errors = [wrong[..., None], self.amplitude_error[..., :1], self.rebound_error[..., :2]]
        of, by = np.concatenate(errors, axis=-1), np.concatenate(values, axis=-1)
        worst = np.divide(of, by, out=np.zeros_like(by), where=by > 0.0).max(axis=-1)
        return np.stack([third / time, np.where(np.isnan(time), np.nan, worst)], axis=-1)


@dataclass(frozen=True, eq=False)
class TransitionBatch(TransitionRows):
    """Transitions of n cases; the rows have shape (n, most), NaN beyond the last collision.

    Attributes:
        status: :class:`Status` of each case, shape (n,).
        collisions: Number of collisions computed, shape (n,).
    """

    status: NDArray[np.int64]
    collisions: NDArray[np.int64]

    duration = Column(layout.TIME, table="rest")
    duration_error = Column(layout.TIME_ERROR, table="rest")
    share = Column(0, table="_relative")
    error_bound = Column(1, table="_relative")

    @cached_property
    def premise(self) -> NDArray[np.int64]:
        """Whether machines arrive in their initial phase, as a transition assumes, shape (n,).

        1 where they do, 0 where not, -1 where that is not known. Computed when it is first read.
        """
        return self.tell()


@dataclass(frozen=True, eq=False)
class ReducedTransition(TransitionRows):
    """One transition that came to rest; the rows have shape (collisions,).

    Attributes:
        collisions: Number of collisions computed.
    """

    collisions: int

    duration = Number(layout.TIME, table="rest")
    duration_error = Number(layout.TIME_ERROR, table="rest")
    share = Number(0, table="_relative")
    error_bound = Number(1, table="_relative")

    def __repr__(self) -> str:
        """Its numbers by their names."""
        names = "model", "collisions", "duration", "duration_error", "share", "error_bound"
        told = ", ".join(f"{name}={getattr(self, name)!r}" for name in names)
        return f"ReducedTransition({told})"

    @cached_property
    def premise_holds(self) -> bool | None:
        """Whether the machine arrives in its initial phase, as a transition assumes, or None.

        None where that is not known. Computed when it is first read.
        """
        return {layout.HOLDS: True, layout.FAILS: False}.get(self.tell()[0])


@dataclass(frozen=True, eq=False)
class ReducedTurns(EventRows):
    """Whole turns; the rows have shape (events,), NaN where a rest or a release has none.

    Attributes:
        model: Name of the model.
        stops: Names of the stops.
        turns: Turns that were followed.
        repeats_after: After how many turns the last one repeats an earlier one, so that all further
            ones are known; 0 if it does not.
        travel: Travels of the cylinder from the start of the first turn [rad].
        energy_error: Bounds on the errors of ``energy_lost`` [J].
        table: All rows, shape (rows, events).
    """

    model: str
    stops: tuple[str, ...]
    turns: int
    repeats_after: int
    table: FloatArray = field(repr=False)

    travel = _row(layout.TRAVEL)
    energy_error = _row(layout.ENERGY_ERROR)

    @property
    def kind(self) -> tuple[str, ...]:
        """Each event: collision, rest or release."""
        names = {layout.COLLISION: "collision", layout.REST: "rest", layout.RELEASE: "release"}
        return tuple(names[int(number)] for number in self.table[layout.KIND])

    @property
    def stop(self) -> tuple[str, ...]:
        """The stop of each event."""
        return tuple(self.stops[number] for number in self.stop_number)

    @property
    def stop_number(self) -> NDArray[np.int64]:
        """Its place among the stops."""
        return np.asarray(self.table[layout.STOP], dtype=np.int64)

    @property
    def collisions(self) -> NDArray[np.bool_]:
        """Which events are collisions."""
        return np.asarray(self.table[layout.KIND] == layout.COLLISION)

"""What whole turns of the reduced engine return: their events, and how they ended."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ..kernels import layout
from ..results import ENGINE, Column


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


@dataclass(frozen=True, eq=False)
class ReducedTurns:
    """Whole turns; arrays have shape (events,), NaN where a rest or a release has none.

    Attributes:
        model: Name of the model.
        stops: Names of the stops.
        turns: Turns that were followed.
        repeats_after: After how many turns the last one repeats an earlier one, so that all further
            ones are known; 0 if it does not.
        table: The events, shape (events, columns).
        engine: The engine that computed it.
    """

    model: str
    stops: tuple[str, ...]
    turns: int
    repeats_after: int
    table: FloatArray = field(repr=False)
    engine: str = ENGINE

    time = Column(layout.TIME)
    """Times from the start of the first turn [s]."""
    travel = Column(layout.TRAVEL)
    """Travels of the cylinder from there [rad]."""
    approach_rate = Column(layout.APPROACH)
    """Rates of the gap before collisions [rad/s or m/s], negative."""
    separation_rate = Column(layout.SEPARATION)
    """Rates after them."""
    impulse = Column(layout.IMPULSE)
    """Normal impulses at the contact points [N s]; along the joint without one [N m s]."""
    energy_lost = Column(layout.ENERGY)
    """Kinetic energy lost [J]."""
    rebound_amplitude = Column(layout.AMPLITUDE)
    """Largest gaps of the rebounds that end at the same stop [rad or m]; NaN for others."""
    rebound_time = Column(layout.REBOUND)
    """Times of these rebounds [s]."""
    time_error = Column(layout.TIME_ERROR)
    """Bounds on the errors of ``time`` [s]."""
    rate_error = Column(layout.RATE_ERROR)
    """Bounds on the errors of ``approach_rate``."""
    impulse_error = Column(layout.IMPULSE_ERROR)
    """Bounds on the errors of ``impulse``, in its unit."""
    amplitude_error = Column(layout.AMPLITUDE_ERROR)
    """Bounds on the errors of ``rebound_amplitude``."""
    rebound_error = Column(layout.REBOUND_ERROR)
    """Bounds on the errors of ``rebound_time`` [s]."""
    energy_error = Column(layout.ENERGY_ERROR)
    """Bounds on the errors of ``energy_lost`` [J]."""

    @property
    def kind(self) -> tuple[str, ...]:
        """Each event: collision, rest or release."""
        names = {layout.COLLISION: "collision", layout.REST: "rest", layout.RELEASE: "release"}
        return tuple(names[int(number)] for number in self.table[:, layout.KIND])

    @property
    def stop(self) -> tuple[str, ...]:
        """The stop of each event."""
        return tuple(self.stops[number] for number in self.stop_number)

    @property
    def stop_number(self) -> NDArray[np.int64]:
        """Its place among the stops."""
        return self.table[:, layout.STOP].astype(np.int64)

    @property
    def collisions(self) -> NDArray[np.bool_]:
        """Which events are collisions."""
        return np.asarray(self.table[:, layout.KIND] == layout.COLLISION)

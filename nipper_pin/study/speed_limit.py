"""How fast a machine can run: turns over a range of cylinder speeds."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..errors import InputError, SimulationError
from ..given import number, whole
from ..mechanism import Mechanism
from ..mechanism.cylinder import INDEX_PER_TURN
from ..reduced.turns import (
    START_INDEX,
    TURN_REASONS,
    TurnQuantities,
    TurnStatus,
    turn_quantities,
)

# Turns that are shown of each speed, and halvings of the step of a limit.
_LAST, _HALVINGS = 32, 12
_MOST_SPEEDS = 10_000
# Speeds that are followed without a look at what the user wants, an interrupt for example.
_BLOCK = 64
# As of a case of the direct engine.
_FASTEST_RPM = 1e9
_NAMES = {int(status): status.name.lower() for status in TurnStatus}
_FOLLOWED = _NAMES[TurnStatus.FOLLOWED]


@dataclass(frozen=True, eq=False)
class SpeedLimit:
    """Turns of a machine by cylinder speed; arrays over speeds have shape (n,).

    Indices count from the start of a turn, index 24, to its end, index 64; they are those of the
    last turn that was followed, NaN where it has no such event.

    Attributes:
        model: Name of the model.
        title: Its title.
        stop: The clamping stop.
        speed_rpm: Cylinder speeds, increasing [r/min].
        status: How the turns of each speed ended; "followed" is the usual one. The limits below
            are sought below the first speed of another one.
        turns: Turns that were followed.
        repeats_after: After how many turns the last one repeats an earlier one, 0: it does not.
        closing: Index of the first collision of the clamping stop.
        rest: Index of its rest.
        opening: Index at which another stop throws it open, or its force falls to zero.
        clamped_share: Share of the turn with the stop closed and its force above the given one.
        margin: Indices between rest and opening.
        rests: Rest indices of the turns that go on, shape (n, 32): those of one period, or the last
            ones where turns do not repeat.
        touches: Indices of their first collisions, likewise.
        settles_rpm: Speed from which on the stop is not at rest before it opens, refined; None if
            it always is.
        repeats_rpm: Speed from which on the turns do not repeat after one; None if they always do.
    """

    model: str
    title: str
    stop: str
    speed_rpm: FloatArray
    status: tuple[str, ...]
    turns: NDArray[np.int64]
    repeats_after: NDArray[np.int64]
    closing: FloatArray
    rest: FloatArray
    opening: FloatArray
    clamped_share: FloatArray
    margin: FloatArray
    rests: FloatArray = field(repr=False)
    touches: FloatArray = field(repr=False)
    settles_rpm: float | None
    repeats_rpm: float | None

    @property
    def lost(self) -> str:
        """Where turns could not be followed, and why; empty if they could at every speed."""
        places = [i for i, status in enumerate(self.status) if status != _FOLLOWED]
        if not places:
            return ""
        why = TURN_REASONS[TurnStatus[self.status[places[0]].upper()]]
        return (
            f"At {len(places)} of {len(self.status)} speeds, the first of them "
            f"{self.speed_rpm[places[0]]:.5g} r/min, turns cannot be followed: {why}."
        )

    def record(self) -> dict[str, Any]:
        """The study as plain data; what is not a number is None."""
        rows = [
            {
                "speed_rpm": float(speed),
                "status": status,
                "turns": int(turns),
                "repeats_after": int(again),
                **{key: _number(value) for key, value in zip(_COLUMNS, values, strict=True)},
            }
            for speed, status, turns, again, *values in zip(
                self.speed_rpm, self.status, self.turns, self.repeats_after, self.closing,
                self.rest, self.opening, self.margin, self.clamped_share, strict=True,
            )
        ]  # fmt: skip
        return {
            "model": self.model,
            "stop": self.stop,
            "settles_rpm": self.settles_rpm,
            "repeats_rpm": self.repeats_rpm,
            "speeds": rows,
        }


_COLUMNS = ("closing_index", "rest_index", "opening_index", "margin_index", "clamped_share")


def speed_limit(
    mechanism: Mechanism,
    *,
    low_rpm: float,
    high_rpm: float,
    speeds: int = 241,
    turns: int = 400,
    least_force: float = 0.0,
) -> SpeedLimit:
    """Follow turns at many speeds until they repeat, and find where the machine stops working.

    Args:
        mechanism: The mechanism.
        low_rpm: Least cylinder speed [r/min].
        high_rpm: Largest one.
        speeds: Number of speeds, equally spaced.
        turns: Largest number of turns at a speed.
        least_force: Force above which the clamping stop clamps [N].

    Raises:
        InputError: The range is none, the machine has no stop or no drive, or the reduced engine
            cannot follow its turns.
        SimulationError: A point of the turn cannot be reached or is singular, or turns can be
            followed at no speed.
    """
    speed = _speeds(low_rpm, high_rpm, speeds)
    _need_drive(mechanism)

    def followed(rpm: FloatArray) -> TurnQuantities:
        return turn_quantities(
            mechanism, speed_rpm=rpm, turns=turns, least_force=least_force, last=_LAST
        )

    blocks = [followed(speed[i : i + _BLOCK]) for i in range(0, speeds, _BLOCK)]
    found = _joined(blocks)
    known = _known(found)
    settled, single = _settled(found), found.repeats_after == 1
    goes_on, closing = _goes_on(found), _index(found.closed_at)
    rest, opening = _index(found.rests_at), _index(np.fmin(found.lost_at, found.opened_at))
    return SpeedLimit(
        model=mechanism.name,
        title=mechanism.title,
        stop=mechanism.transition_stop,
        speed_rpm=speed,
        status=tuple(_NAMES[int(status)] for status in found.status),
        turns=found.turns,
        repeats_after=found.repeats_after,
        closing=closing[:, 0],
        rest=rest[:, 0],
        opening=opening[:, 0],
        clamped_share=found.clamped_share[:, 0],
        margin=(opening - rest)[:, 0],
        rests=np.where(goes_on, rest, np.nan),
        touches=np.where(goes_on, closing, np.nan),
        settles_rpm=_limit(speed[:known], settled, lambda rpm: bool(_settled(followed(rpm))[0])),
        repeats_rpm=_limit(speed[:known], single, lambda rpm: followed(rpm).repeats_after[0] == 1),
    )


def _need_drive(mechanism: Mechanism) -> None:
    """Refuse a machine whose turns have no bounces, or nothing to do with the cylinder."""
    for parts, noun in ((mechanism.stops, "stop"), (mechanism.drives, "drive")):
        if not parts:
            message = (
                f"{mechanism.name} has no {noun}, and a speed limit is that of a cylinder whose "
                "turns make a stop bounce: add one, or simulate the machine as it is"
            )
            raise InputError(message, model=mechanism.name)


def _speeds(low_rpm: float, high_rpm: float, speeds: int) -> FloatArray:
    """The speeds of a range, checked."""
    whole("speeds", speeds, 2, _MOST_SPEEDS)
    low_rpm = number("low_rpm", low_rpm, 0.0, _FASTEST_RPM, open_low=True)
    high_rpm = number("high_rpm", high_rpm, 0.0, _FASTEST_RPM, open_low=True)
    if not low_rpm < high_rpm:
        message = (
            f"speeds from {low_rpm:g} to {high_rpm:g} r/min cannot be used: from a speed to a "
            "larger one"
        )
        raise InputError(message, low_rpm=low_rpm, high_rpm=high_rpm, speeds=speeds)
    return np.linspace(low_rpm, high_rpm, speeds)


def _known(found: TurnQuantities) -> int:
    """How many speeds there are below the first at which turns cannot be followed."""
    lost = found.status != TurnStatus.FOLLOWED
    if lost.all():
        status = TurnStatus(int(found.status[0]))
        message = (
            f"{found.model}: turns can be followed at none of these speeds: {TURN_REASONS[status]}"
        )
        raise SimulationError(message, status=_NAMES[status])
    return int(np.argmax(lost)) if lost.any() else len(lost)


def _joined(parts: list[TurnQuantities]) -> TurnQuantities:
    """Quantities of all speeds in one."""
    return replace(
        parts[0],
        status=np.concatenate([part.status for part in parts]),
        turns=np.concatenate([part.turns for part in parts]),
        repeats_after=np.concatenate([part.repeats_after for part in parts]),
        speed=np.concatenate([part.speed for part in parts]),
        table=np.concatenate([part.table for part in parts]),
    )


def _index(travel: FloatArray) -> FloatArray:
    """Indices at travels from the start of a turn [rad]."""
    return np.asarray(START_INDEX + INDEX_PER_TURN * travel / math.tau)


def _settled(found: TurnQuantities) -> NDArray[np.bool_]:
    """Whether the stop rests in every turn that goes on."""
    rests = np.isfinite(found.rests_at) | ~_goes_on(found)
    return np.asarray(rests.all(axis=1) & (found.status == TurnStatus.FOLLOWED))


def _goes_on(found: TurnQuantities) -> NDArray[np.bool_]:
    """Which of the last turns go on: a turn that repeats after p turns is one of p."""
    place = np.arange(found.table.shape[1])
    period = np.where(found.repeats_after > 0, found.repeats_after, found.turns)
    return np.asarray(place < np.minimum(period, found.turns)[:, None])


def _limit(
    speed: FloatArray, good: NDArray[np.bool_], ask: Callable[[FloatArray], bool]
) -> float | None:
    """The first speed that is no longer good, between two of those that were computed."""
    good = good[: len(speed)]
    if good.all():
        return None
    first = int(np.argmin(good))
    if first == 0:
        return float(speed[0])
    low, high = float(speed[first - 1]), float(speed[first])
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if ask(np.array([middle])):
            low = middle
        else:
            high = middle
    return high


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None

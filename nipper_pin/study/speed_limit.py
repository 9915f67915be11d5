"""How fast a machine can run: turns over a range of cylinder speeds."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from enum import Enum
from itertools import groupby, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..errors import InputError, SimulationError, with_words
from ..given import number, whole
from ..hybrid import FASTEST_RPM, START_INDEX
from ..mechanism import INDEX_PER_TURN, Mechanism, within_turn
from ..reduced.turns import TURN_REASONS, TurnQuantities, TurnStatus, turn_quantities

# Turns that are shown of each speed, and halvings of the step of a limit.
_LAST, _HALVINGS = 32, 12
# Ranges of one verdict that a sentence lists.
_SAID = 4
_MOST_SPEEDS = 10_000
# Speeds that are followed without a look at what the user wants, an interrupt for example.
_BLOCK = 64
# What tables of turns are told to do where the reduced engine cannot follow them.
_OTHER_ENGINE = "use the direct engine"
_SINGLE_SPEEDS = (
    "a speed limit takes no other engine: simulate whole turns (simulate --window cycle --speed "
    "RPM), or tables of them in Python (turn_table), at speeds of your choice"
)
_NAMES = {int(status): status.name.lower() for status in TurnStatus}
_FOLLOWED = _NAMES[TurnStatus.FOLLOWED]


class Verdict(Enum):
    """What is known at a speed, of rest or of turns that repeat."""

    YES = 1
    NO = 0
    UNKNOWN = -1
    """Turns cannot be followed."""


@dataclass(frozen=True)
class SpeedRange:
    """Neighbouring speeds of one verdict.

    Attributes:
        low_rpm: Least speed [r/min].
        high_rpm: Largest one, the least of the next range.
        verdict: What is known there.
    """

    low_rpm: float
    high_rpm: float
    verdict: Verdict


@dataclass(frozen=True, eq=False)
class SpeedLimit:
    """Turns of a machine by cylinder speed; arrays over speeds have shape (n,).

    Indices are those of the last turn that was followed, NaN where it has no such event.

    Attributes:
        model: Name of the model.
        stop: The clamping stop.
        speed_rpm: Cylinder speeds, increasing [r/min].
        status: How the turns of each speed ended; "followed" is the usual one.
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
        settled: Where the stop rests before it opens, in ranges that follow one another. Between
            two speeds of different verdicts one border is sought; what happens twice between
            neighbouring speeds is not seen.
        single: Where every turn repeats the one before, likewise.
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
    settled: tuple[SpeedRange, ...]
    single: tuple[SpeedRange, ...]

    @property
    def settles_rpm(self) -> float | None:
        """The one speed [r/min] up to which the stop rests and beyond which it does not.

        The least speed of the range if it rests at none; None if there is no such speed.
        """
        return _one_limit(self.settled)

    @property
    def repeats_rpm(self) -> float | None:
        """The one speed [r/min] beyond which turns do not repeat the one before, likewise."""
        return _one_limit(self.single)

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
            "at_rest": _listed(self.settled, Verdict.YES),
            "not_at_rest": _listed(self.settled, Verdict.NO),
            "repeats": _listed(self.single, Verdict.YES),
            "not_known": _listed(self.settled, Verdict.UNKNOWN),
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
    """Follow turns at many speeds until they repeat, and find at which the machine works.

    Args:
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

    try:
        blocks = [followed(speed[i : i + _BLOCK]) for i in range(0, speeds, _BLOCK)]
    except InputError as error:
        raise with_words(error, {_OTHER_ENGINE: _SINGLE_SPEEDS}) from error
    found = _joined(blocks)
    _need_followed(found)
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
        closing=within_turn(closing[:, 0]),
        rest=within_turn(rest[:, 0]),
        opening=within_turn(opening[:, 0]),
        clamped_share=found.clamped_share[:, 0],
        margin=(opening - rest)[:, 0],
        rests=within_turn(np.where(goes_on, rest, np.nan)),
        touches=within_turn(np.where(goes_on, closing, np.nan)),
        settled=_ranges(speed, _settled(found), lambda rpm: _settled(followed(rpm))),
        single=_ranges(speed, _single(found), lambda rpm: _single(followed(rpm))),
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
    low_rpm = number("low_rpm", low_rpm, 0.0, FASTEST_RPM, open_low=True)
    high_rpm = number("high_rpm", high_rpm, 0.0, FASTEST_RPM, open_low=True)
    if not low_rpm < high_rpm:
        message = (
            f"speeds from {low_rpm:g} to {high_rpm:g} r/min cannot be used: from a speed to a "
            "larger one"
        )
        raise InputError(message, low_rpm=low_rpm, high_rpm=high_rpm, speeds=speeds)
    return np.linspace(low_rpm, high_rpm, speeds)


def _need_followed(found: TurnQuantities) -> None:
    """Refuse a range in which turns can be followed at no speed."""
    if (found.status != TurnStatus.FOLLOWED).all():
        status = TurnStatus(int(found.status[0]))
        message = (
            f"{found.model}: turns can be followed at none of these speeds: {TURN_REASONS[status]}"
        )
        raise SimulationError(message, status=_NAMES[status])


def _joined(parts: list[TurnQuantities]) -> TurnQuantities:
    """Quantities of all speeds in one."""
    names = ("status", "turns", "repeats_after", "speed", "table")
    joined: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in names
    }
    return replace(parts[0], **joined)


def _index(travel: FloatArray) -> FloatArray:
    """Indices at travels from the start of a turn [rad]."""
    return np.asarray(START_INDEX + INDEX_PER_TURN * travel / math.tau)


def _settled(found: TurnQuantities) -> list[Verdict]:
    """Whether the stop rests in every turn that goes on."""
    rests = np.isfinite(found.rests_at) | ~_goes_on(found)
    return _verdicts(found, np.asarray(rests.all(axis=1)))


def _single(found: TurnQuantities) -> list[Verdict]:
    """Whether every turn repeats the one before."""
    return _verdicts(found, np.asarray(found.repeats_after == 1))


def _verdicts(found: TurnQuantities, good: NDArray[np.bool_]) -> list[Verdict]:
    known = found.status == TurnStatus.FOLLOWED
    return [Verdict(int(g)) if k else Verdict.UNKNOWN for g, k in zip(good, known, strict=True)]


def _goes_on(found: TurnQuantities) -> NDArray[np.bool_]:
    """Which of the last turns go on: a turn that repeats after p turns is one of p."""
    place = np.arange(found.table.shape[1])
    period = np.where(found.repeats_after > 0, found.repeats_after, found.turns)
    return np.asarray(place < np.minimum(period, found.turns)[:, None])


def _ranges(
    speed: FloatArray, found: list[Verdict], ask: Callable[[FloatArray], list[Verdict]]
) -> tuple[SpeedRange, ...]:
    """Speeds by their verdict; borders by halving, each between two speeds that were computed."""
    changes = [i for i, (one, next_one) in enumerate(pairwise(found)) if one is not next_one]
    low, high = speed[changes], speed[[i + 1 for i in changes]]
    # More changes than this are those of turns without order, whose borders say nothing.
    for _ in range(_HALVINGS if 0 < len(changes) <= _BLOCK else 0):
        middle = 0.5 * (low + high)
        same = np.array([v is found[i] for v, i in zip(ask(middle), changes, strict=True)])
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    borders = [float(speed[0]), *map(float, high), float(speed[-1])]
    verdicts = [verdict for verdict, _ in groupby(found)]
    return tuple(
        SpeedRange(*ends, verdict)
        for ends, verdict in zip(pairwise(borders), verdicts, strict=True)
    )


def _one_limit(ranges: tuple[SpeedRange, ...]) -> float | None:
    """Where YES ends and NO begins, if the two change once; the first speed if all are NO."""
    known = [part for part in ranges if part.verdict is not Verdict.UNKNOWN]
    verdicts = [verdict for verdict, _ in groupby(part.verdict for part in known)]
    if verdicts not in ([Verdict.YES, Verdict.NO], [Verdict.NO]):
        return None
    first = next(i for i, part in enumerate(ranges) if part.verdict is Verdict.NO)
    # Not known below it: the limit may lie there.
    if first > 0 and ranges[first - 1].verdict is Verdict.UNKNOWN:
        return None
    return ranges[first].low_rpm


def where(ranges: tuple[SpeedRange, ...], verdict: Verdict) -> str:
    """Say at which speeds a verdict holds: "from 60 to 80 and from 120 to 200 r/min".

    Args:
        ranges: Ranges that follow one another.

    Returns:
        The words; empty if it holds nowhere.
    """
    if all(part.verdict is verdict for part in ranges):
        return "at every speed"
    parts = [part for part in ranges if part.verdict is verdict]
    if not parts:
        return ""
    words = [f"from {part.low_rpm:.5g} to {part.high_rpm:.5g}" for part in parts[:_SAID]]
    if len(parts) > _SAID:
        words.append(f"in {len(parts) - _SAID} more ranges up to {parts[-1].high_rpm:.5g}")
    *before, last = words
    return f"{', '.join(before)} and {last} r/min" if before else f"{last} r/min"


def _listed(ranges: tuple[SpeedRange, ...], verdict: Verdict) -> list[dict[str, float]]:
    return [
        {"from_rpm": part.low_rpm, "to_rpm": part.high_rpm}
        for part in ranges
        if part.verdict is verdict
    ]


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None

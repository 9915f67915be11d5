"""Cases of one mechanism whose turns are followed together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import FloatArray
from ...errors import InputError, UnknownNameError
from ...given import number, whole
from ..inputs import cases_of, checked_run
from ..kernels.layout import COLUMNS, TURNS, Job, Settings
from .model import TurnModel

# Events of a turn that there is room for beyond its collisions.
BESIDE = 64
_MOST_TURNS = 10_000
# Rooms for events, which take 128 bytes each.
_MOST_EVENTS = 4_000_000
# Numbers of a batch; they and a copy of them take 400 MB.
_MOST_NUMBERS = 25_000_000


@dataclass(frozen=True)
class Run:
    """What all cases of a call share.

    Attributes:
        turns: Largest number of turns.
        most: Largest number of collisions of a series, and in a turn.
        least_force: Force above which the clamping stop clamps [N].
    """

    turns: int
    settings: Settings
    most: int
    least_force: float

    def events(self) -> FloatArray:
        """Room for what turns do; memory that no event is written to is never touched."""
        return np.empty((1, self.turns * (self.most + BESIDE), COLUMNS))

    def of(self, model: TurnModel) -> Job:
        """What is asked of the turns of a model."""
        return Job(int(TURNS), self.most, self.turns, model.begin, model.clamp, self.least_force)


def run_of(key: str, turns: int, rest_rate: float | None, tolerance: float, most: int,
           least_force: float = 0.0) -> Run:  # fmt: skip
    """What cases share, checked."""
    settings = checked_run(rest_rate, tolerance, most)
    whole(key, turns, 1, _MOST_TURNS)
    if turns * (most + BESIDE) > _MOST_EVENTS:
        message = (
            f"{key} = {turns} with max_collisions = {most} cannot be used: together at most "
            f"{_MOST_EVENTS:,} events"
        )
        raise InputError(message, key=key, value=turns, max_collisions=most)
    return Run(turns, settings, most, number("least_force", least_force))


def room_for(cases: int, last: int | None, columns: int) -> FloatArray:
    """Room for what is told of the last turns, or the last one, shape (cases, turns, columns)."""
    if last is not None:
        whole("last", last, 1, max(1, _MOST_NUMBERS // (columns * max(1, cases))))
    return np.empty((cases, last or 1, columns))


def turn_cases(
    model: TurnModel, speed_rpm: ArrayLike,
    restitution: ArrayLike | Mapping[str, ArrayLike] | None, stiffness: ArrayLike | None,
    preload: ArrayLike | None, *, one: bool = False,
) -> FloatArray:  # fmt: skip
    """Numbers of n cases, as of :func:`~..inputs.cases_of`.

    Args:
        restitution: e_N of the transition stop, or of stops by name; None: the mechanism's.
    """
    if not isinstance(restitution, Mapping):
        restitution = {} if restitution is None else {model.transition_stop: restitution}
    given = {}
    for name, value in restitution.items():
        if name not in model.stops:
            raise UnknownNameError(kind="stop", name=name, known=model.stops)
        given[model.stops.index(name)] = f"restitution of {name}", value
    return cases_of(model, speed_rpm, given, stiffness, preload, one=one)

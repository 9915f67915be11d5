"""Phases 1 and 2 over a turn in which the jaw closes without a bounce."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from nipper_pin.mechanism import INDEX_PER_TURN, Mechanism
from nipper_pin.mechanism.cylinder import within_turn

from .branches import branch, touch_index

_PLACES = 1440


@dataclass(frozen=True)
class Kinematics:
    """Marks of the turn, on which the speed has no influence.

    Attributes:
        speed_rpm: Speed of the branches [r/min].
        closing_index: Where the jaw closes.
        opening_index: Where it opens.
        largest_jaw_angle_rad: Widest opening.
        largest_stroke: Longest way of the stop that is closed while the jaw is open [m or rad].
    """

    speed_rpm: float
    closing_index: float
    opening_index: float
    largest_jaw_angle_rad: float
    largest_stroke: float

    def record(self) -> dict[str, Any]:
        """Return the marks as plain data."""
        return asdict(self)


def kinematics(mechanism: Mechanism, speed_rpm: float) -> Kinematics:
    """Follow both phases, each with one closed stop, over one turn.

    Raises:
        ConvergenceError: A stop cannot stay closed through the whole turn.
    """
    index = touch_index(mechanism) + np.linspace(0.0, INDEX_PER_TURN, _PLACES + 1)
    initial = mechanism.phase(mechanism.initial_phase).closed
    jaw = mechanism.stop(mechanism.transition_stop)
    opened = branch(mechanism, initial, speed_rpm, index)
    closed = branch(mechanism, frozenset({jaw.name}), speed_rpm, index)
    gap = jaw.gaps(opened.q)
    is_open = gap > 0.0
    first_open = int(np.argmax(is_open[1:])) + 1
    # The gap crosses zero between two neighbours; a straight line is within 1e-4 of the index.
    low, high = gap[first_open - 1], gap[first_open]
    opening = index[first_open - 1] + (index[1] - index[0]) * low / (low - high)
    angle, stroke = (
        np.where(is_open, opened.q[:, place], closed.q[:, place]).max()
        for place in (jaw.index, mechanism.stop(min(initial)).index)
    )
    return Kinematics(
        speed_rpm, touch_index(mechanism), float(within_turn(opening)), float(angle), float(stroke)
    )

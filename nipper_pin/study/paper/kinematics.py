"""Kinematics of the oscillating guide and of the nipper over a turn, phases 1 and 2."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...dynamics.shaft import ShaftMotion
from ...mechanism import INDEX_PER_TURN, Mechanism, rad_s_from_rpm
from ...mechanism.cylinder import within_turn
from .branches import Branch, branch, touch_index

PLACES = 1440


@dataclass(frozen=True)
class Guide:
    """Motion of the driven shafts at one speed.

    Attributes:
        speed_rpm: Cylinder speed [r/min].
        angle: By drive, from the touch configuration, shape (K, drives) [rad].
        rate: Shape (K, drives) [rad/s].
        acceleration: Shape (K, drives) [rad/s^2].
    """

    speed_rpm: float
    angle: FloatArray
    rate: FloatArray
    acceleration: FloatArray


@dataclass(frozen=True)
class Kinematics:
    """One turn in which the jaw closes without a bounce.

    The phase with the jaw open reaches as far as the jaw angle is positive, the other as far as the
    stroke is. Rates go with the speed, accelerations with its square.

    Attributes:
        speed_rpm: Speed of the branches [r/min].
        index: Places on the comber's scale, one turn from the touch configuration, shape (K,).
        guides: Driven shafts by speed.
        open: Motion with the steeve on its stop.
        closed: Motion with the jaw shut.
        is_open: Where the jaw is open, shape (K,).
        link_angles: Rotation of every link from the touch configuration, shape (K, links) [rad].
        link_rates: Their rates, shape (K, links) [rad/s].
        link_accelerations: Their accelerations, shape (K, links) [rad/s^2].
        stop_jaw: Place of the jaw angle in q.
        stop_steeve: Place in q of the stop that is closed while the jaw is open: the steeve's.
        closing_index: Where the jaw closes.
        opening_index: Where it opens.
    """

    speed_rpm: float
    index: FloatArray
    guides: tuple[Guide, ...]
    open: Branch
    closed: Branch
    is_open: NDArray[np.bool_]
    link_angles: FloatArray
    link_rates: FloatArray
    link_accelerations: FloatArray
    stop_jaw: int
    stop_steeve: int
    closing_index: float
    opening_index: float

    def of_phases(self, quantity: str, column: int) -> FloatArray:
        """Column of "q", "v" or "a" through both phases, shape (K,)."""
        one, two = getattr(self.open, quantity), getattr(self.closed, quantity)
        values: FloatArray = np.where(self.is_open, one[:, column], two[:, column])
        return values

    @property
    def largest_jaw_angle(self) -> float:
        """Widest opening [rad]."""
        return float(self.of_phases("q", self.stop_jaw).max())

    @property
    def largest_stroke(self) -> float:
        """Longest way of the other stop, the steeve's stroke in the E62 [m or rad]."""
        return float(self.of_phases("q", self.stop_steeve).max())

    def record(self) -> dict[str, Any]:
        """Return the marks of the turn as plain data."""
        return {
            "speed_rpm": self.speed_rpm,
            "closing_index": self.closing_index,
            "opening_index": self.opening_index,
            "largest_jaw_angle_rad": self.largest_jaw_angle,
            "largest_stroke": self.largest_stroke,
        }


def kinematics(mechanism: Mechanism, speeds_rpm: tuple[float, ...]) -> Kinematics:
    """Follow phases 1 and 2 over one turn.

    Args:
        mechanism: The mechanism: one stop is closed in each of the two phases.
        speeds_rpm: Speeds at which the driven shafts are shown; the first is that of the branches.

    Raises:
        ConvergenceError: A stop cannot stay closed through the whole turn.
    """
    cylinder = mechanism.cylinder
    index = touch_index(mechanism) + np.linspace(0.0, INDEX_PER_TURN, PLACES + 1)
    initial = mechanism.phase(mechanism.initial_phase).closed
    jaw = mechanism.stop(mechanism.transition_stop)
    steeve = mechanism.stop(min(initial))
    opened = branch(mechanism, initial, speeds_rpm[0], index)
    closed = branch(mechanism, frozenset({jaw.name}), speeds_rpm[0], index)
    gap = jaw.gaps(opened.q)
    is_open = gap > 0.0
    first_open = int(np.argmax(is_open[1:])) + 1
    # The gap crosses zero between two neighbours; a straight line is within 1e-4 of the index.
    low, high = gap[first_open - 1], gap[first_open]
    opening = index[first_open - 1] + (index[1] - index[0]) * low / (low - high)
    guides = []
    for speed in speeds_rpm:
        shaft = ShaftMotion(mechanism, rad_s_from_rpm(speed), cylinder.angle_at_touch_rad)
        times = shaft.period * (index - index[0]) / INDEX_PER_TURN
        guides.append(Guide(speed, *shaft.driven(times)))
    angles, rates, accelerations = (
        _of_links(mechanism, np.where(is_open[:, None], one, two))
        for one, two in ((opened.q, closed.q), (opened.v, closed.v), (opened.a, closed.a))
    )
    return Kinematics(
        speed_rpm=speeds_rpm[0],
        index=index,
        guides=tuple(guides),
        open=opened,
        closed=closed,
        is_open=is_open,
        link_angles=angles,
        link_rates=rates,
        link_accelerations=accelerations,
        stop_jaw=jaw.index,
        stop_steeve=steeve.index,
        closing_index=touch_index(mechanism),
        opening_index=float(within_turn(opening)),
    )


def _of_links(mechanism: Mechanism, values: FloatArray) -> FloatArray:
    """Sums over the hinges from the frame to every link, shape (K, links).

    Hinges of a planar mechanism turn about one direction: angles, rates and accelerations add up.
    """
    sums: dict[str, FloatArray] = {}
    for joint in mechanism.joints:
        turns = joint.kind == "revolute"
        own = joint.sense * values[:, joint.index] if turns else np.zeros(len(values))
        sums[joint.child] = sums.get(joint.parent, np.zeros(len(values))) + own
    return np.stack([sums[link] for link in mechanism.links], axis=1)

"""Cams with dwell: laws of motion of unit lift over a unit angle, and a turn made of them.

R. L. Norton, Cam Design and Manufacturing Handbook, 2nd ed., chapters 3 and 4.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from ...arrays import FloatArray
from ...errors import InputError
from ...tolerances.mechanics import KNOT_ANGLE, TURN_ROUND_OFF
from ...units import M_PER_MM
from ..files.description import NotNegative, Positive
from ..files.law_tables import AnyTable
from ..laws import Evaluation

CamMotion = Literal["cycloidal", "modified_sine", "polynomial_345", "polynomial_4567"]


def _cycloidal(u: FloatArray) -> Evaluation:
    turned = math.tau * u
    sine = np.sin(turned)
    return u - sine / math.tau, 1.0 - np.cos(turned), math.tau * sine


def _modified_sine(u: FloatArray) -> Evaluation:
    """Quarters of a fast sine at both ends, half a slow one between them."""
    ends = np.abs(u - 0.5) > 0.375
    angle = np.where(ends, 4.0 * math.pi * u, (4.0 * u + 1.0) * math.pi / 3.0)
    sine, cosine = np.sin(angle), np.cos(angle)
    before = np.where(ends, np.where(u > 0.5, 4.0, 0.0), 2.0)
    scale = 1.0 / (4.0 + math.pi)
    return (
        scale * (before + math.pi * u - np.where(ends, 0.25, 2.25) * sine),
        scale * math.pi * (1.0 - np.where(ends, 1.0, 3.0) * cosine),
        scale * 4.0 * math.pi**2 * sine,
    )


def _polynomial_345(u: FloatArray) -> Evaluation:
    left = 1.0 - u
    x = np.minimum(u, left)
    value = x**3 * (10.0 + x * (-15.0 + 6.0 * x))
    return _mirrored(u, value), 30.0 * (u * left) ** 2, 60.0 * u * left * (left - u)


def _polynomial_4567(u: FloatArray) -> Evaluation:
    left = 1.0 - u
    x = np.minimum(u, left)
    value = x**4 * (35.0 + x * (-84.0 + x * (70.0 - 20.0 * x)))
    return _mirrored(u, value), 140.0 * (u * left) ** 3, 420.0 * (u * left) ** 2 * (left - u)


def _mirrored(u: FloatArray, value: FloatArray) -> FloatArray:
    """A lift from its value on the half that u lies on: near the top terms of a sum cancel."""
    return np.where(u > 0.5, 1.0 - value, value)


_MOTIONS: dict[str, Callable[[FloatArray], Evaluation]] = {
    "cycloidal": _cycloidal,
    "modified_sine": _modified_sine,
    "polynomial_345": _polynomial_345,
    "polynomial_4567": _polynomial_4567,
}
_INNER_KNOTS = {"modified_sine": (0.125, 0.875)}


@dataclass(frozen=True, kw_only=True)
class Cam:
    """A cam that lifts its follower, keeps it up, lets it return and rests.

    Attributes:
        motion: Law of rise and return; accelerations are continuous with all of them.
        lift: Lift [rad or m].
        start_rad: Cylinder angle at which the rise begins [rad].
        rise_rad: Cylinder angle of the rise [rad].
        dwell_rad: Cylinder angle for which the follower stays up [rad].
        return_rad: Cylinder angle of the return [rad].

    Raises:
        InputError: Rise, dwell and return are longer than a turn,
            or rise or return have no length.
    """

    motion: CamMotion
    lift: float
    start_rad: float
    rise_rad: float
    dwell_rad: float
    return_rad: float

    def __post_init__(self) -> None:
        """Refuse more than a turn, and a rise or return in no time."""
        if min(self.rise_rad, self.return_rad) < KNOT_ANGLE:
            message = (
                f"rise and return take at least {math.degrees(KNOT_ANGLE):.2g} deg each; they take "
                f"{math.degrees(self.rise_rad):g} and {math.degrees(self.return_rad):g} deg"
            )
            raise InputError(message, rise_rad=self.rise_rad, return_rad=self.return_rad)
        total = self.rise_rad + self.dwell_rad + self.return_rad
        if total > math.tau * (1.0 + TURN_ROUND_OFF):
            message = (
                "rise, dwell and return have to fit into a turn; together they have "
                f"{math.degrees(total):g} deg"
            )
            raise InputError(message, total_rad=total)

    @property
    def knots_rad(self) -> tuple[float, ...]:
        """Cylinder angles at which a higher derivative jumps [rad]."""
        inner = (0.0, *_INNER_KNOTS.get(self.motion, ()), 1.0)
        down = self.start_rad + self.rise_rad + self.dwell_rad
        rise = [self.start_rad + share * self.rise_rad for share in inner]
        fall = [down + share * self.return_rad for share in inner]
        return tuple(sorted({*rise, *fall}))

    def evaluate(self, psi: FloatArray) -> Evaluation:
        """Evaluate the law; see ``DriveLaw.evaluate``."""
        place = np.remainder(np.subtract(psi, self.start_rad), math.tau)
        beyond = place - (self.rise_rad + self.dwell_rad)
        rising, falling = place < self.rise_rad, (beyond >= 0.0) & (beyond < self.return_rad)
        up = np.where(beyond < 0.0, 1.0, 0.0)
        width = np.where(rising, self.rise_rad, self.return_rad)
        # Moving parts are evaluated within 0 to 1; dwells at an end, where the rate is zero.
        u = np.where(rising, place / self.rise_rad, np.where(falling, 1.0 - beyond / width, up))
        value, first, second = _MOTIONS[self.motion](u)
        sense = np.where(rising, 1.0, np.where(falling, -1.0, 0.0))
        slope = self.lift / width
        return (
            self.lift * value,
            sense * slope * first,
            np.abs(sense) * slope / width * second,
        )


class CamDrive(AnyTable, frozen=True, kw_only=True, tag="cam"):
    """A cam with dwell: rise, dwell, return, and rest for what is left of the turn.

    Attributes:
        motion: How it rises and returns.
        lift_mm: Lift of a slide [mm].
        lift_deg: Lift of a hinge [deg].
        start_deg: Cylinder angle at which the rise begins [deg].
        rise_deg: Cylinder angle of the rise [deg].
        dwell_deg: Cylinder angle for which the follower stays up [deg].
        return_deg: Cylinder angle of the return [deg].
    """

    motion: CamMotion
    rise_deg: Positive
    return_deg: Positive
    dwell_deg: NotNegative = 0.0
    start_deg: float = 0.0
    lift_mm: float | None = None
    lift_deg: float | None = None

    hinge_keys: ClassVar[tuple[str, ...]] = ("lift_deg",)
    slide_keys: ClassVar[tuple[str, ...]] = ("lift_mm",)
    not_zero: ClassVar[tuple[str, ...]] = ("lift_deg", "lift_mm")

    def build(self) -> Cam:
        """Return the law; see :meth:`DriveTable.build`."""
        return Cam(
            motion=self.motion,
            lift=math.radians(self.lift_deg or 0.0) + M_PER_MM * (self.lift_mm or 0.0),
            start_rad=math.radians(self.start_deg),
            rise_rad=math.radians(self.rise_deg),
            dwell_rad=math.radians(self.dwell_deg),
            return_rad=math.radians(self.return_deg),
        )

    def culprit(self) -> tuple[str, object]:
        """Rise, dwell and return that are longer than a turn are told by the dwell."""
        return "dwell_deg", self.dwell_deg

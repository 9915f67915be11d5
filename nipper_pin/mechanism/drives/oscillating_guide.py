"""A crank pin on the cylinder that rocks a guide bar."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ...arrays import FloatArray
from ...errors import InputError
from ...units import M_PER_MM, MM_PER_M
from ..files.description import PlanePoint, Positive
from ..files.law_tables import ShaftTable
from ..laws import Evaluation


@dataclass(frozen=True, kw_only=True)
class OscillatingGuide:
    """A crank pin that slides in a guide bar, which rocks about its own axis.

    Attributes:
        crank_radius_m: Distance of the pin from the cylinder axis [m].
        crank_axis: Cylinder axis (x, z) [m].
        guide_axis: Axis of the guide (x, z) [m].
        guide_offset_m: Distance of the bar's line from the guide axis, positive to the left of the
            direction towards the pin [m].
        sense: 1 if the law grows counter-clockwise, -1 if clockwise.

    Raises:
        InputError: The crank circle reaches the guide axis or its offset, so the guide would turn
            round or jam.
    """

    crank_radius_m: float
    crank_axis: tuple[float, float]
    guide_axis: tuple[float, float]
    guide_offset_m: float = 0.0
    sense: float = 1.0
    knots_rad: ClassVar[tuple[float, ...]] = ()
    _distance: float = field(init=False, repr=False, compare=False)
    _direction: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Refuse a guide that does not oscillate, and compute the constants."""
        dx = self.crank_axis[0] - self.guide_axis[0]
        dz = self.crank_axis[1] - self.guide_axis[1]
        distance = math.hypot(dx, dz)
        if not 0.0 < self.crank_radius_m < distance:
            message = (
                f"a crank of {MM_PER_M * self.crank_radius_m:g} mm, {MM_PER_M * distance:g} mm "
                "from the guide axis, does not make the guide oscillate: the radius must be the "
                "smaller one"
            )
            raise InputError(message, crank_radius_m=self.crank_radius_m, distance_m=distance)
        if not abs(self.guide_offset_m) < distance - self.crank_radius_m:
            message = (
                f"a guide offset of {MM_PER_M * self.guide_offset_m:g} mm jams the guide: it must "
                f"be smaller than {MM_PER_M * (distance - self.crank_radius_m):g} mm, the least "
                "distance of the pin from the guide axis"
            )
            raise InputError(message, guide_offset_m=self.guide_offset_m, distance_m=distance)
        object.__setattr__(self, "_distance", distance)
        object.__setattr__(self, "_direction", math.atan2(dz, dx))

    def evaluate(self, psi: FloatArray) -> Evaluation:
        """Evaluate the law; see ``DriveLaw.evaluate``.

        The angle is measured from the line of centres, from which the pin never turns away by a
        right angle, so it is continuous over any number of turns.
        """
        r, d = self.crank_radius_m, self._distance
        turned = psi - self._direction
        across = r * np.sin(turned)
        along = r * np.cos(turned)
        projected = d * along
        square = (d * d + r * r) + 2.0 * projected
        value = np.arctan2(across, along + d) + self._direction
        first = (projected + r * r) / square
        second = (d * (r * r - d * d)) * across / (square * square)
        if self.guide_offset_m != 0.0:
            value, first, second = self._offset(value, first, second, square, d * across, projected)
        if self.sense < 0.0:
            return -value, -first, -second
        return value, first, second

    def _offset(
        self,
        value: FloatArray,
        first: FloatArray,
        second: FloatArray,
        square: FloatArray,
        swept: FloatArray,
        projected: FloatArray,
    ) -> Evaluation:
        """Subtract the angle between the bar's line and the line to the pin, asin(offset / R)."""
        e = self.guide_offset_m
        slope = -2.0 * swept
        free = np.sqrt(square - e * e)
        value = value - np.arcsin(e / np.sqrt(square))
        first = first + 0.5 * e * slope / (square * free)
        bend = -2.0 * projected - slope * slope * (1.0 / square + 0.5 / (free * free))
        second = second + 0.5 * e * bend / (square * free)
        return value, first, second


class OscillatingGuideDrive(ShaftTable, frozen=True, kw_only=True, tag="oscillating_guide"):
    """A crank pin on the cylinder that slides in a guide bar fixed to the driven link.

    Attributes:
        crank_radius_mm: Distance of the pin from the cylinder axis [mm].
        crank_axis_mm: Cylinder axis (x, z) [mm].
        guide_axis_mm: Axis of the driven shaft (x, z) [mm].
        guide_offset_mm: Distance of the bar's line from the guide axis, positive to the left of
            the direction towards the pin [mm].
    """

    crank_radius_mm: Positive
    crank_axis_mm: PlanePoint
    guide_axis_mm: PlanePoint
    guide_offset_mm: float = 0.0

    def build(self) -> OscillatingGuide:
        """Return the law; see :meth:`DriveTable.build`."""
        return OscillatingGuide(
            crank_radius_m=M_PER_MM * self.crank_radius_mm,
            crank_axis=(M_PER_MM * self.crank_axis_mm[0], M_PER_MM * self.crank_axis_mm[1]),
            guide_axis=(M_PER_MM * self.guide_axis_mm[0], M_PER_MM * self.guide_axis_mm[1]),
            guide_offset_m=M_PER_MM * self.guide_offset_mm,
        )

    def culprit(self) -> tuple[str, object]:
        """Return the crank where the guide does not oscillate, the offset where it jams."""
        if self.crank_radius_mm < math.dist(self.crank_axis_mm, self.guide_axis_mm):
            return "guide_offset_mm", self.guide_offset_mm
        return "crank_radius_mm", self.crank_radius_mm

"""Tables over one turn."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ...arrays import FloatArray
from ...errors import InputError
from ...tolerances.mechanics import DRIVE_REPEATS
from ...units import M_PER_MM
from ..elements import wrong_rows
from ..files.description import Name
from ..files.law_tables import AnyTable
from ..laws import Evaluation
from ..scale import written


@dataclass(frozen=True, kw_only=True)
class Table:
    """A periodic quintic spline (four continuous derivatives) through a table over one turn.

    Attributes:
        cylinder_angle_rad: Angles, rising over exactly one turn, at least seven [rad].
        coordinate: Coordinate at each angle, equal at both ends [rad or m].

    Raises:
        InputError: The table is not one turn of a periodic function.
    """

    cylinder_angle_rad: tuple[float, ...]
    coordinate: tuple[float, ...]
    _splines: tuple[Callable[[FloatArray], FloatArray], ...] = field(
        init=False, repr=False, compare=False
    )

    def __post_init__(self) -> None:
        """Check the table and fit the spline."""
        from scipy.interpolate import make_interp_spline

        angles = np.array(self.cylinder_angle_rad, dtype=float)
        values = np.array(self.coordinate, dtype=float)
        if message := _wrong_turn(angles, values):
            raise InputError(message, rows=int(angles.size))
        # The ends agree only to the accuracy of the check; the periodic spline needs them equal.
        angles[-1] = angles[0] + math.tau
        values[-1] = values[0]
        # Rows that lie very unevenly have no such spline: its equations are singular.
        with np.errstate(all="ignore"):
            spline = make_interp_spline(angles, values, k=5, bc_type="periodic")
        if not np.isfinite(spline.c).all():
            message = "no smooth curve passes through the drive table: its rows are too uneven"
            raise InputError(message, rows=len(angles))
        object.__setattr__(self, "_splines", (spline, spline.derivative(1), spline.derivative(2)))

    @property
    def knots_rad(self) -> tuple[float, ...]:
        """Cylinder angles of the rows: the spline changes its polynomial there [rad]."""
        return self.cylinder_angle_rad[1:]

    def evaluate(self, psi: FloatArray) -> Evaluation:
        """Evaluate the law; see ``DriveLaw.evaluate``."""
        start = self.cylinder_angle_rad[0]
        reduced = start + np.remainder(np.subtract(psi, start), math.tau)
        value, first, second = (spline(reduced) for spline in self._splines)
        return value, first, second


def _wrong_turn(angles: FloatArray, values: FloatArray) -> str:
    """What is wrong with a table that is not one turn of a periodic function; empty if it is."""

    def falling(row: int) -> str:
        return (
            f"the cylinder angle must rise from row to row; row {row + 1} of the drive table has "
            f"{math.degrees(angles[row]):g} after {math.degrees(angles[row - 1]):g} deg"
        )

    columns = ("an angle", "a coordinate")
    if message := wrong_rows(angles, values, "drive table", 7, columns, falling):
        return message
    if abs(angles[-1] - angles[0] - math.tau) > DRIVE_REPEATS:
        return (
            "a drive table must span exactly one turn, first and last row 360 deg apart; it spans "
            f"{math.degrees(angles[-1] - angles[0]):.12g} deg"
        )
    if abs(values[-1] - values[0]) > DRIVE_REPEATS * written(float(np.ptp(values))):
        return (
            "the first and the last row of a drive table are the same position and need the same "
            f"coordinate; found {values[0]:g} and {values[-1]:g} [rad or m]"
        )
    return ""


class TableDrive(AnyTable, frozen=True, kw_only=True, tag="table"):
    """A table over one turn, from a CSV file in the model folder or written out here.

    Attributes:
        file: CSV file with the columns cylinder_angle_deg and coordinate_rad or coordinate_mm.
        cylinder_angle_deg: Cylinder angles, rising over exactly one turn [deg].
        coordinate_rad: Coordinate of a hinge at each angle [rad].
        coordinate_mm: Coordinate of a slide at each angle [mm].
    """

    file: Name | None = None
    cylinder_angle_deg: tuple[float, ...] = ()
    coordinate_rad: tuple[float, ...] = ()
    coordinate_mm: tuple[float, ...] = ()

    hinge_keys: ClassVar[tuple[str, ...]] = ("coordinate_rad",)
    slide_keys: ClassVar[tuple[str, ...]] = ("coordinate_mm",)

    def build(self) -> Table:
        """Return the law; see :meth:`DriveTable.build`."""
        angles = tuple(math.radians(angle) for angle in self.cylinder_angle_deg)
        rows = self.coordinate_rad or tuple(M_PER_MM * value for value in self.coordinate_mm)
        return Table(cylinder_angle_rad=angles, coordinate=rows)

    def culprit(self) -> tuple[str, object]:
        """The rows are told by their number."""
        return "cylinder_angle_deg", f"{len(self.cylinder_angle_deg)} rows"

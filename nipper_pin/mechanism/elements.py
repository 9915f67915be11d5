"""Springs and dampers beyond the linear spring on a joint: dampers, tables, two-point elements."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ..arrays import FloatArray
from ..errors import InputError
from ..given import LARGEST
from ..tolerances.mechanics import LEAST_TABLE_STEP

MOST_ROWS = 100_000
"""Most rows of a table. A motion is divided at each of them, so that long tables make slow runs."""
Interpolation = Literal["smooth", "linear"]
# Places of a piece at which its curve is compared with its line, and one more.
_LOOKS = 8


@dataclass(frozen=True, kw_only=True)
class Damper:
    """A linear damper on one coordinate x: force -damping * x_dot.

    Attributes:
        name: Name of the damper.
        index: Place of the coordinate in q and v.
        damping: [N s/m] or [N m s/rad].
    """

    name: str
    index: int
    damping: float


@dataclass(frozen=True, kw_only=True)
class Characteristic:
    """Force of a spring over its coordinate, through the rows of a table.

    A piecewise cubic with continuous slope that never overshoots: between two rows the force stays
    between theirs, so a table that rises makes a spring that is stable everywhere, and rows on a
    line give the line. A smoother spline would ring at the kink of a progressive spring and make
    stiffness of the wrong sign there. Where few rows describe a kink, straight lines between
    them are what is meant.

    Source: F. N. Fritsch, J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300 (PCHIP).

    Attributes:
        coordinate: Rising coordinates, at least two [m or rad].
        force: Force against the coordinate at each of them [N or N m].
        interpolation: "smooth": that cubic; "linear": straight lines; None: smooth, as nothing was
            said.

    Raises:
        InputError: The rows are not such a table.
    """

    coordinate: tuple[float, ...]
    force: tuple[float, ...]
    interpolation: Interpolation | None = None
    _force: Callable[[FloatArray], FloatArray] = field(init=False, repr=False, compare=False)
    _energy: Callable[[FloatArray], FloatArray] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Check the rows and fit the interpolant."""
        from scipy.interpolate import PchipInterpolator, PPoly

        x, y = np.array(self.coordinate, dtype=float), np.array(self.force, dtype=float)
        columns = ("a coordinate", "a force")
        message = wrong_rows(x, y, "spring table", 2, columns, _not_rising)
        if message:
            raise InputError(message, rows=int(x.size))
        if self.interpolation == "linear":
            force = PPoly(np.array([np.diff(y) / np.diff(x), y[:-1]]), x)
        else:
            # The reciprocal of a slope of nearly none may overflow: the harmonic mean then is zero.
            with np.errstate(over="ignore"):
                force = PchipInterpolator(x, y)
        object.__setattr__(self, "_force", force)
        object.__setattr__(self, "_energy", force.antiderivative())

    @property
    def ends(self) -> tuple[float, float]:
        """First and last coordinate [m or rad]."""
        return self.coordinate[0], self.coordinate[-1]

    @property
    def departure(self) -> tuple[float, int]:
        """How far the curve leaves the straight lines between rows, by the range of the forces [1].

        With the number, from 1, of the row at which the piece begins that leaves its line most.
        """
        x, y = np.array(self.coordinate), np.array(self.force)
        shares = np.arange(1, _LOOKS)[:, None] / _LOOKS
        lines = y[:-1] + shares * np.diff(y)
        with np.errstate(over="ignore"):
            off = np.abs(self.forces(x[:-1] + shares * np.diff(x)) - lines).max(axis=0)
        row = int(off.argmax())
        return float(off[row] / (np.ptp(y) or 1.0)), row + 1

    @property
    def reach(self) -> tuple[float, float]:
        """Coordinates between which the force is that of a piece; constant beyond [m or rad]."""
        low, high = self.ends
        length = high - low
        return low - length, high + length

    def forces(self, x: FloatArray) -> FloatArray:
        """Force against the coordinate [N or N m].

        Args:
            x: Coordinates, shape (N,). Beyond the ends the last cubic goes on for the length of the
                table, and then its value: an iteration may try such a state and must not run away
                to infinity there, but no motion that contains one is accepted.

        Returns:
            Shape (N,).
        """
        return np.asarray(self._force(np.clip(x, *self.reach)))

    def energies(self, x: FloatArray) -> FloatArray:
        """Energy stored since the first row [J], the exact integral of the force, shape (N,)."""
        return np.asarray(self._energy(x))


def _not_rising(row: int) -> str:
    return f"the coordinate must rise from row to row; row {row + 1} of the spring table does not"


def wrong_rows(
    x: FloatArray,
    y: FloatArray,
    table: str,
    least: int,
    columns: tuple[str, str],
    falling: Callable[[int], str],
) -> str:
    """What is wrong with rows of numbers that should be a function; empty if nothing is.

    Args:
        falling: The words for the row after which, counted from 1, x does not rise.
    """
    first, second = columns
    if x.shape != y.shape or x.size < least:
        return (
            f"a {table} needs at least {least} rows with {first} and {second} each; found "
            f"{x.size} {first.split()[1]}s and {y.size} {second.split()[1]}s"
        )
    if x.size > MOST_ROWS:
        return f"a {table} has at most {MOST_ROWS} rows; found {x.size}"
    usable = (np.abs(x) <= LARGEST) & (np.abs(y) <= LARGEST)
    if not usable.all():
        return (
            f"row {int(np.argmin(usable)) + 1} of the {table} holds a value that is not a finite "
            f"number of at most {LARGEST:g}"
        )
    steps = np.diff(x)
    if (steps <= 0.0).any():
        return falling(int(np.argmax(steps <= 0.0)) + 1)
    if (steps < LEAST_TABLE_STEP).any():
        row = int(np.argmax(steps < LEAST_TABLE_STEP)) + 1
        return f"rows {row} and {row + 1} of the {table} are too near to tell a slope"
    return ""


@dataclass(frozen=True, kw_only=True)
class TabulatedSpring:
    """A spring on one coordinate x whose force -f(x) comes from a table.

    Attributes:
        name: Name of the spring.
        index: Place of the coordinate in q and v.
        characteristic: f.
    """

    name: str
    index: int
    characteristic: Characteristic


@dataclass(frozen=True, kw_only=True)
class Strut:
    """A linear spring or damper between two points, acting along the line that joins them.

    With the distance l of the points its tension is
    stiffness * (l - free_length) + damping * l_dot.

    Attributes:
        name: Name of the spring or damper.
        kind: The table of the model file that it stands in.
        frame_a: URDF frame whose origin is the first point.
        frame_b: URDF frame whose origin is the second point.
        stiffness: Zero for a damper [N/m].
        free_length: Distance without force of a spring [m].
        damping: Zero for a spring [N s/m].
    """

    name: str
    kind: Literal["spring", "damper"]
    frame_a: str
    frame_b: str
    stiffness: float = 0.0
    free_length: float = 0.0
    damping: float = 0.0

    @property
    def directed(self) -> bool:
        """True if the force has no direction where the points coincide.

        The force of a spring of free length zero is proportional to the line itself, and
        vanishes with it.
        """
        return self.damping > 0.0 or self.stiffness * self.free_length > 0.0

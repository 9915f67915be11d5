"""First downward zero of a function that is resolved on a fine grid."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...arrays import FloatArray
from ...errors import ConvergenceError
from ...tolerances.hybrid import ROOT_RESOLUTION, SHALLOW_DIP

_MAX_STEPS = 80
# Parabolas through points around the bottom of a dip, each closer by this factor than the last.
_PARABOLAS, _CLOSER = 3, 0.1


def first_descent(
    grid: FloatArray, values: FloatArray, function: Callable[[float], float]
) -> tuple[float, float] | None:
    """Bracket the first passage from positive to not positive.

    Values before the first positive one are passed over: a trigger is half open, so a gap that
    starts at zero fires only after it has opened. Between grid points a dip is followed to its
    lowest point, so that two close zeros are not missed.

    Args:
        grid: Increasing abscissae, shape (S,).
        values: Function values there, shape (S,).
        function: The function itself, for the lowest points of dips.

    Returns:
        Bracket (left, right): positive at the left end, not positive at the right; or None.
    """
    positive = values > 0.0
    if not positive.any():
        return None
    armed = int(np.argmax(positive))
    below = np.flatnonzero(~positive[armed:])
    end = armed + int(below[0]) if below.size else len(grid)
    inner = values[armed:end]
    if inner.size >= 3:
        lower = inner[1:] < inner[:-1]
        # Before the second point and behind the last but one a dip leaves no lowest point inside.
        dips = [1] if not lower[0] else []
        dips += (1 + np.flatnonzero(lower[:-1] & ~lower[1:])).tolist()
        dips += [inner.size - 2] if lower[-1] else []
        for dip in (armed + place for place in dips):
            near = slice(dip - 1, dip + 2)
            lowest, estimate = _vertex(grid[near], values[near])
            # The parabola of a resolved function is good to a fraction of the dip's depth.
            if (
                not grid[dip - 1] < lowest < grid[dip + 1]
                or estimate > SHALLOW_DIP * values[near].max()
            ):
                continue
            lowest, value = _lowest(function, lowest, grid[near])
            if value <= 0.0:
                return float(grid[int(np.searchsorted(grid, lowest)) - 1]), lowest
    if not below.size:
        return None
    return float(grid[end - 1]), float(grid[end])


def _vertex(x: FloatArray, y: FloatArray) -> tuple[float, float]:
    """Lowest point of the parabola through three points; the middle one if it has none."""
    # Plain numbers are faster than elements of arrays.
    (x0, x1, x2), (y0, y1, y2) = x.tolist(), y.tolist()
    left, right = (y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1)
    curvature = (right - left) / (x2 - x0)
    if curvature <= 0.0:
        return x1, y1
    slope = left + curvature * (x1 - x0)
    return x1 - 0.5 * slope / curvature, y1 - 0.25 * slope**2 / curvature


def _lowest(
    function: Callable[[float], float], place: float, grid: FloatArray
) -> tuple[float, float]:
    """Lowest place of a dip between three points, as far as it decides on the sign, and its value.

    The place is improved by parabolas through ever closer points: what one leaves of the depth goes
    with the square of its distance, that of the next with the fourth power.
    """
    value, apart = function(place), _CLOSER * float(grid[2] - grid[0])
    for _ in range(_PARABOLAS):
        if value <= 0.0:
            break
        x = np.clip([place - apart, place, place + apart], grid[0], grid[2])
        if not x[0] < x[1] < x[2]:
            break
        sides = function(float(x[0])), function(float(x[2]))
        found, _ = _vertex(x, np.array([sides[0], value, sides[1]]))
        found = min(max(found, float(grid[0])), float(grid[2]))
        lower = function(found)
        if lower >= value:
            break
        place, value, apart = found, lower, _CLOSER * apart
    return place, value


def polish(
    function: Callable[[float], tuple[float, float]],
    left: float,
    right: float,
    start: float | None = None,
) -> float:
    """Solve function = 0 in a bracket to round-off: Newton steps, bisection where they do not help.

    Args:
        function: Value and derivative (an approximate one is enough); positive at the left end.
        right: Right end; the function is not positive there.
        start: Where to start; the right end by default.

    Raises:
        ConvergenceError: No root to round-off after many steps.
    """
    low, high, x = left, right, right if start is None else start
    resolution = ROOT_RESOLUTION * max(abs(left), abs(right))
    previous = np.inf
    for _ in range(_MAX_STEPS):
        value, slope = function(x)
        if value == 0.0:
            return x
        low, high = (x, high) if value > 0.0 else (low, x)
        step = abs(value / slope) if slope != 0.0 else np.inf
        new = x - value / slope if slope != 0.0 else np.inf
        inside = low < new < high
        fine = step <= 256.0 * resolution
        # The next step would be shorter by as much as this one is; one that is not shorter only
        # shows the round-off of the function.
        if step <= resolution or (
            fine and (step >= previous or (previous < np.inf and step**2 <= resolution * previous))
        ):
            return new if inside else x
        if high - low <= resolution:
            return high
        # A slope that is only roughly known may send the steps to and fro.
        new = new if inside and (step <= 0.5 * previous or fine) else 0.5 * (low + high)
        previous, x = abs(new - x), new
    message = f"no event time to round-off in [{left!r}, {right!r}]: the motion is not smooth there"
    raise ConvergenceError(message, residual=value, tolerance=resolution, iterations=_MAX_STEPS)

"""The lips close up: where a camera along the hinge stands in every frame, and how much it sees.

The camera moves with the lower lip, so that this one stands still in its picture, and what is on
the near side of the contact point is cut away: all moving links are cut by the plane of that point.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...mechanism import Mechanism
from ...units import MM_PER_M
from .arrows import arrow_body, arrow_place
from .film import Film, bouncing_stop, highest_drawn, worlds
from .solids import FIXED, Solid, across_plane

# Height of the picture by the largest gap of a rebound as it is drawn, and its least [m].
_BY_GAP, _LEAST_M = 4.0, 0.012
# Steps of the scale [mm].
_STEPS_MM = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
# A plane through corners of a mesh cuts none of their edges: it is moved by this part of the size.
_ASIDE = 1e-7


@dataclass(frozen=True)
class CloseUp:
    """A camera that follows the lower lip; places are in the plane of the mechanism.

    Attributes:
        stop: Name of the stop.
        place: Contact point on the lower lip, shape (K, 2) [m].
        angle: Direction in which the upper lip opens, from x towards z, shape (K,) [rad].
        across: Place of the cut along the hinge [m].
        height: Height of what is seen [m].
        scale_mm: Length of the scale [mm].
    """

    stop: str
    place: FloatArray
    angle: FloatArray
    across: float
    height: float
    scale_mm: float

    def record(self) -> dict[str, object]:
        """As plain data for the page."""
        return {
            "stop": self.stop,
            "x": [float(f"{value:.7g}") for value in self.place[:, 0]],
            "z": [float(f"{value:.7g}") for value in self.place[:, 1]],
            "angle": [float(f"{value:.7g}") for value in self.angle],
            "across": self.across,
            "height": self.height,
            "scale_mm": self.scale_mm,
        }


def close_up(film: Film) -> CloseUp | None:
    """The close-up of the transition stop; None if it has no contact point."""
    mechanism = film.solution.mechanism
    stop = bouncing_stop(mechanism)
    if stop is None or stop.contact is None:
        return None
    body, local = arrow_body(mechanism, stop), arrow_place(mechanism, stop)
    opening = math.atan2(local[2, 1], local[0, 1])
    place = worlds(film.position, film.angle)[:, body, :2] @ [local[0, 3], local[2, 3], 1.0]
    turned = np.column_stack([film.angle, np.zeros(len(film.angle))])[:, body]
    gap = highest_drawn(film.solution, film.pace.machine, stop.gaps(film.drawn))
    height = max(_LEAST_M, _BY_GAP * stop.lever * gap)
    steps = [step for step in _STEPS_MM if step <= 0.3 * MM_PER_M * height]
    return CloseUp(
        stop.name, place, turned + opening, float(stop.contact.point[1]), height,
        steps[-1] if steps else _STEPS_MM[0],
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class LipCut:
    """The cut through one solid.

    Attributes:
        solid: Place of the solid among those that are drawn.
        body: Its link, a place in ``mechanism.joints``.
        loops: Outlines (x, z) in the frame of the link, each of shape (K, 2) [m], the largest
            first; others inside of it are holes.
    """

    solid: int
    body: int
    loops: tuple[FloatArray, ...]


def lip_cuts(mechanism: Mechanism, drawn: Sequence[Solid], across: float) -> list[LipCut]:
    """Cut all solids of moving links by a plane, at its place along the hinge [m].

    Raises:
        InputError: A mesh cannot be read.
    """
    heights = across_plane(mechanism)
    found = []
    for place, item in enumerate(drawn):
        # Frame and cylinder stand behind the lips and would hide nothing but confuse.
        if item.body <= FIXED or item.spring is not None:
            continue
        loops = section(item.corners, item.mesh[1], across - heights[item.body])
        if loops:
            found.append(LipCut(place, item.body, tuple(loops)))
    return found


def section(corners: FloatArray, faces: NDArray[np.intp], y: float) -> list[FloatArray]:
    """Closed outlines of a cut through a mesh.

    Args:
        corners: Corners, shape (N, 3) [m].
        faces: Their places, shape (F, 3).
        y: Place of the plane [m].

    Returns:
        Outlines (x, z), each of shape (K, 2) [m], the largest first.
    """
    side = corners[:, 1] - y - _ASIDE * float(np.ptp(corners))
    above = side[faces] > 0.0
    cut = faces[above.any(axis=1) & ~above.all(axis=1)]
    if not len(cut):
        return []
    edges = np.sort(cut[:, [[0, 1], [1, 2], [2, 0]]], axis=2)
    crossed = (side[edges[..., 0]] > 0.0) != (side[edges[..., 1]] > 0.0)
    # Two edges of each face that is cut are crossed.
    pairs = edges[crossed].reshape(-1, 2, 2)
    keys, numbers = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    first, second = side[keys[:, 0]], side[keys[:, 1]]
    share = (first / (first - second))[:, None]
    points = (1.0 - share) * corners[keys[:, 0]] + share * corners[keys[:, 1]]
    loops = [points[loop][:, [0, 2]] for loop in _loops(numbers.reshape(-1, 2))]
    return sorted(loops, key=_area, reverse=True)


def _loops(links: NDArray[np.intp]) -> Iterator[list[int]]:
    """Chains of points that are linked by pairs, from each point on to the next one."""
    beside: dict[int, list[int]] = {}
    for one, other in links.tolist():
        beside.setdefault(one, []).append(other)
        beside.setdefault(other, []).append(one)
    while beside:
        start = place = next(iter(beside))
        loop = []
        while place in beside:
            loop.append(place)
            following = beside.pop(place)
            place = next((item for item in following if item in beside), start)
        if len(loop) > 2:
            yield loop


def _area(loop: FloatArray) -> float:
    """Area of an outline [m^2]."""
    x, z = loop.T
    return abs(0.5 * float(np.sum(x * np.roll(z, -1) - z * np.roll(x, -1))))

"""Cuts through all moving links by the plane of the contact point, along the hinge."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...mechanism import Mechanism
from .solids import FIXED, Solid, across_plane

# A plane through corners of a mesh cuts none of their edges: it is moved by this part of the size.
_ASIDE = 1e-7


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

"""Camera positions from which all that is drawn is in sight, in every frame of a film."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np

from ...arrays import FloatArray
from .film import Film, worlds
from .solids import Solid, across_plane

OBLIQUE, ALONG = (0.38, -1.0, 0.34), (0.0, -1.0, 0.0)
"""Directions from the mechanism to the camera: from the front and above, and along the hinges."""
# The page shows 40 degrees from top to bottom, half of it here with a margin, and in width at least
# a quarter more: in a pane that is less wide it moves the camera back.
_HALF, _WIDE = math.radians(19.3), 1.25
_FRAMES = 200  # of a film that are looked at, evenly spaced on the machine's clock


def corners(shown: Film, drawn: Sequence[Solid]) -> FloatArray:
    """Corners of what stands, and of boxes around what moves in frames all over a film.

    Returns:
        Shape (N, 3) [m].

    Raises:
        InputError: A mesh cannot be read.
    """
    t = shown.pace.machine
    places = np.unique(np.searchsorted(t, np.linspace(t[0], t[-1], _FRAMES)))
    planes = worlds(shown.position[places], shown.angle[places])
    heights = across_plane(shown.solution.mechanism)
    return np.concatenate([np.zeros((0, 3)), *_boxes(drawn, planes, heights)])


def _boxes(
    drawn: Sequence[Solid], planes: FloatArray, heights: Sequence[float]
) -> Iterator[FloatArray]:
    for solid in drawn:
        points = solid.corners
        # Frame and cylinder stand where they are.
        if solid.body < 0:
            yield points
            continue
        ends = points.min(axis=0), points.max(axis=0)
        box = np.array(list(itertools.product(*zip(*ends, strict=True))))
        moved = planes[:, solid.body, :2, :2] @ box[:, [0, 2]].T + planes[:, solid.body, :2, 2:]
        x, z = moved.transpose(1, 0, 2).reshape(2, -1)
        yield np.column_stack([x, np.tile(heights[solid.body] + box[:, 1], len(planes)), z])


def camera(points: FloatArray, direction: tuple[float, float, float]) -> tuple[FloatArray, ...]:
    """Target and position of the nearest camera that has all points in sight.

    Args:
        points: Shape (N, 3) [m].
        direction: From the mechanism to the camera (x, y, z).

    Returns:
        Target and position (x, y, z), each of shape (3,) [m].
    """
    towards = np.array(direction) / np.linalg.norm(direction)
    across = np.cross([0.0, 0.0, 1.0], towards)
    across /= np.linalg.norm(across)
    axes = np.array([across, np.cross(towards, across), towards])
    seen = points @ axes.T
    middle = 0.5 * (seen.min(axis=0) + seen.max(axis=0))
    off = seen - middle
    reach = np.maximum(np.abs(off[:, 0]) / _WIDE, np.abs(off[:, 1])) / math.tan(_HALF)
    distance = float((reach + off[:, 2]).max())
    target = middle @ axes
    return target, target + distance * towards

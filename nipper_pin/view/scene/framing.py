"""Camera position from which a whole mechanism is visible, from front and above."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...mechanism import Mechanism, joint_placements
from .solids import Solid, plain_solids

OBLIQUE, ALONG = (0.38, -1.0, 0.34), (0.0, -1.0, 0.0)
"""Directions from the mechanism to the camera: from the front and above, and along the hinges."""


def camera(
    mechanism: Mechanism,
    points: FloatArray,
    near: float,
    direction: tuple[float, float, float] = OBLIQUE,
    lower: float = 0.0,
) -> tuple[FloatArray, FloatArray]:
    """Target and position of the camera.

    Args:
        points: Places (x, z) that are to be seen besides the shapes, shape (K, 2) [m].
        near: Distance, by the size of what is to be seen [-].
        direction: From the mechanism to the camera (x, y, z).
        lower: How far below the middle to look, by the size of what is to be seen [-].

    Returns:
        Target and position (x, y, z), each of shape (3,) [m].
    """
    seen = np.concatenate([points, _corners(mechanism)])
    low, high = seen.min(axis=0), seen.max(axis=0)
    size = max(float(np.linalg.norm(high - low)), 0.5 * mechanism.reach_m)
    middle = 0.5 * (low + high)
    target = np.array([middle[0], 0.0, middle[1] - lower * size])
    towards = np.array(direction) / np.linalg.norm(direction)
    return target, target + near * size * towards


def _corners(mechanism: Mechanism) -> FloatArray:
    """Corners (x, z) of boxes around all plain collision shapes at q = 0, shape (2 S, 2) [m]."""
    world = joint_placements(mechanism.model)
    found = [np.zeros((0, 2))]
    for solid in plain_solids(mechanism):
        place = solid.placement
        if solid.body >= 0:
            joint = mechanism.model.getJointId(mechanism.joints[solid.body].name)
            place = world[joint].homogeneous @ place
        reach = _reach(solid, place[:3, :3])
        found.append(np.array([place[:3, 3] - reach, place[:3, 3] + reach])[:, [0, 2]])
    return np.concatenate(found)


def _reach(solid: Solid, rotation: FloatArray) -> FloatArray:
    """Half extents of a shape along the axes of the world, shape (3,) [m]."""
    if solid.kind == "box":
        return np.asarray(np.abs(rotation) @ (0.5 * np.array(solid.sizes)))
    radius, length = solid.sizes if solid.kind == "cylinder" else (solid.sizes[0], 0.0)
    along = np.abs(rotation[:, 2]) if length else np.zeros(3)
    return np.asarray(0.5 * length * along + radius * np.sqrt(np.maximum(0.0, 1.0 - along**2)))

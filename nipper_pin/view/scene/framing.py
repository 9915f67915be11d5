"""Camera position from which a whole mechanism is visible, from front and above."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...mechanism import Mechanism
from ...mechanism.build.placements import joint_placements
from .solids import Solid, plain_solids

_DIRECTION = (0.38, -1.0, 0.34)


def camera(
    mechanism: Mechanism, points: FloatArray, near: float, shift: tuple[float, float] = (0.0, 0.0)
) -> tuple[FloatArray, FloatArray]:
    """Target and position of the camera.

    Args:
        mechanism: The mechanism.
        points: Places (x, z) that are to be seen besides the shapes, shape (K, 2) [m].
        near: Distance, by the size of what is to be seen [-].
        shift: How far beside the middle to look (x, z), by the size of what is to be seen [-].

    Returns:
        Target and position (x, y, z), each of shape (3,) [m].
    """
    seen = np.concatenate([points, _corners(mechanism)])
    low, high = seen.min(axis=0), seen.max(axis=0)
    size = max(float(np.linalg.norm(high - low)), 0.5 * mechanism.reach_m)
    middle = 0.5 * (low + high)
    target = np.array([middle[0] + shift[0] * size, 0.0, middle[1] + shift[1] * size])
    direction = np.array(_DIRECTION) / np.linalg.norm(_DIRECTION)
    return target, target + near * size * direction


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

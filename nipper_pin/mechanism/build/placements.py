"""Where the joints of a tree are, and which joints move a body."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from ...arrays import FloatArray


def joint_placements(model: pin.Model) -> list[pin.SE3]:
    """World placement of every joint at q = 0, by joint identity, without any ``pin.Data``."""
    placements = [pin.SE3.Identity()]
    for identity in range(1, model.njoints):
        above = placements[model.parents[identity]]
        placements.append(above * model.jointPlacements[identity])
    return placements


def joint_axis(model: pin.Model, world: Sequence[pin.SE3], joint: int) -> FloatArray:
    """Direction of sliding and axis of turning of a joint in world axes at q = 0, shape (6,)."""
    local = np.asarray(model.joints[joint].createData().S).reshape(2, 3)
    return np.asarray((local @ world[joint].rotation.T).reshape(6))


def supports(model: pin.Model, joint: int) -> list[int]:
    """Identities of the joints that move the body behind a joint, itself included."""
    chain = []
    while joint > 0:
        chain.append(joint)
        joint = model.parents[joint]
    return chain

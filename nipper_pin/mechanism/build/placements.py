"""Where the joints of a tree are, and which joints move a body."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from ...arrays import FloatArray


def own_frame(model: pin.Model, link: str) -> pin.Frame:
    """Frame of a link as its file has it, in which it is drawn: the side view may have another."""
    own = own_name(link)
    name = own if model.existFrame(own, pin.FrameType.OP_FRAME) else link
    kind = pin.FrameType.BODY if name == link else pin.FrameType.OP_FRAME
    return model.frames[model.getFrameId(name, kind)]


def own_name(link: str) -> str:
    """Name of that frame in a model, where it is one of its own."""
    return f"{link} in the file"


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

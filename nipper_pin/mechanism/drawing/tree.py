"""The tree of a drawing: which joint carries which body, and which joints close loops."""

from __future__ import annotations

from dataclasses import dataclass

from .checks import check_parts
from .layout import FRAME, JointTable
from .places import Place, place
from .read import Drawn


@dataclass(frozen=True)
class Tree:
    """The bodies of a drawing as they hang on one another.

    Attributes:
        carried: Joints that carry a body, by their names, the frame's first.
        cut: Pins and slots that close loops, by their names.
        origins: Place of the frame of each link [mm].
    """

    drawn: Drawn
    carried: dict[str, JointTable]
    cut: dict[str, JointTable]
    origins: dict[str, Place]


def grown(drawn: Drawn) -> Tree:
    """Grow the tree of a drawing from its frame, joints in the order in which they are listed.

    Raises:
        ModelError: A body hangs on nothing, a slide closes a loop, or a part cannot be used.
    """
    check_parts(drawn)
    origins: dict[str, Place] = {FRAME: (0.0, 0.0)}
    carried: dict[str, JointTable] = {}
    while True:
        before = len(carried)
        for name, joint in drawn.joints.items():
            if joint.slot or joint.parent not in origins or joint.child in origins:
                continue
            carried[name] = joint
            origins[joint.child] = place(drawn.points, joint.point)
        if len(carried) == before:
            break
    for name, body in drawn.table.bodies.items():
        if name not in origins:
            allowed = "a body to which a joint leads, from the frame or from one that hangs on it"
            drawn.refuse(f"bodies.{name}", body.points, allowed)
    cut = {name: joint for name, joint in drawn.joints.items() if name not in carried}
    for number, (name, joint) in enumerate(drawn.joints.items()):
        if joint.follows in cut or (joint.follows and name in cut):
            allowed = f"one of two joints that carry bodies: {', '.join(carried)}"
            drawn.refuse(f"joints[{number}].follows", joint.follows, allowed)
        if joint.slide and name in cut:
            allowed = "a slide that carries its child: only pins and slots close loops"
            drawn.refuse(f"joints[{number}].slide", name, allowed)
    return Tree(drawn, carried, cut, origins)

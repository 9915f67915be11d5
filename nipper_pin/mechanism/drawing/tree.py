"""The tree of a drawing: which joint carries which body, and which joints close loops."""

from __future__ import annotations

from dataclasses import dataclass

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
        ModelError: A body hangs on nothing, or a slide closes a loop.
    """
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
            key = f"bodies.{name}"
            raise drawn.refused(key, body.points, allowed)
    cut = {name: joint for name, joint in drawn.joints.items() if name not in carried}
    for name, joint in cut.items():
        if joint.slide:
            key = f"joints[{[*drawn.joints].index(name)}].slide"
            allowed = "a slide that carries its child: only pins and slots close loops"
            raise drawn.refused(key, name, allowed)
    return Tree(drawn, carried, cut, origins)

"""The tree of a drawing: which joint carries which body, and which joints close loops."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from ...errors import InputError
from ..files.toml_text import plain
from .parts import FRAME, Body, Drawing, Joint, Pin, Place, Slide, Slot
from .places import place


@dataclass(frozen=True)
class Tree:
    """The bodies of a drawing as they hang on one another.

    Attributes:
        bodies: The bodies by name.
        carried: Joints that carry a body, by their names, the frame's first.
        cut: Pins and slots that close loops, by their names.
        origins: Place of the frame of each link [mm].
    """

    drawing: Drawing
    bodies: dict[str, Body]
    carried: dict[str, Pin | Slide]
    cut: dict[str, Pin | Slot]
    origins: dict[str, Place]

    def slides(self, joint: str) -> bool:
        """Whether a joint with a coordinate is a slide; the block of a slot is one, too.

        Raises:
            InputError: There is no such joint, or it closes a loop and has no coordinate.
        """
        if joint in self.carried:
            return isinstance(self.carried[joint], Slide)
        if isinstance(self.cut.get(joint), Slot):
            return True
        there = ", ".join([*self.carried, *(n for n, j in self.cut.items() if isinstance(j, Slot))])
        message = f"{self.drawing.name}: {joint!r} has no coordinate; joints that have: {there}"
        raise InputError(message, joint=joint)


def grown(drawing: Drawing) -> Tree:
    """Grow the tree of a drawing from its frame, joints in the order in which they are listed.

    Raises:
        InputError: A name is missing or given twice, or a body hangs on nothing.
    """
    drawing = plain(drawing)
    bodies = {part.name: part for part in drawing.parts if isinstance(part, Body)}
    joints = named_joints(drawing)
    for name, joint in joints.items():
        for link in _links(joint):
            if link not in bodies and link != FRAME:
                message = f"{drawing.name}: joint {name} is on {link!r}, which is no body"
                raise InputError(message, joint=name, body=link)
    origins: dict[str, Place] = {FRAME: (0.0, 0.0)}
    carried: dict[str, Pin | Slide] = {}
    while True:
        before = len(carried)
        for name, joint in joints.items():
            if isinstance(joint, Slot) or joint.parent not in origins or joint.child in origins:
                continue
            carried[name] = joint
            at = joint.point if isinstance(joint, Pin) else joint.at
            origins[joint.child] = place(drawing.points, at)
        if len(carried) == before:
            break
    if loose := [name for name in bodies if name not in origins]:
        message = f"{drawing.name}: {', '.join(loose)} hang on nothing: no joint leads there"
        raise InputError(message, bodies=loose)
    cut: dict[str, Pin | Slot] = {}
    for name, joint in joints.items():
        if name in carried:
            continue
        if isinstance(joint, Slide):
            message = f"{drawing.name}: slide {name} closes a loop, which only pins and slots can"
            raise InputError(message, joint=name)
        cut[name] = joint
    return Tree(drawing, bodies, carried, cut, origins)


def named_joints(drawing: Drawing) -> dict[str, Joint]:
    """The joints of a drawing by their names, in its order.

    Raises:
        InputError: A name is given twice.
    """
    found: dict[str, Joint] = {}
    for part in drawing.parts:
        if not isinstance(part, Pin | Slide | Slot):
            continue
        name = part.name
        if isinstance(part, Pin) and not name:
            name = part.point if part.point not in found else f"{part.point}_{part.child}"
        if name in found:
            message = f"{drawing.name}: two joints are called {name!r}; give one a name"
            raise InputError(message, joint=name)
        found[name] = part
    names = Counter(part.name for part in drawing.parts if isinstance(part, Body))
    if twice := [name for name, count in names.items() if count > 1 or name == FRAME]:
        message = f"{drawing.name}: {', '.join(twice)} cannot name one body more"
        raise InputError(message, bodies=twice)
    return found


def _links(joint: Joint) -> tuple[str, str]:
    if isinstance(joint, Slot):
        return joint.slotted, joint.pinned
    return joint.parent, joint.child

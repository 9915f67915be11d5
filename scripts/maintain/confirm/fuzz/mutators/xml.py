"""Changes of a URDF: its attributes and elements."""

from __future__ import annotations

import copy
import random
from xml.etree import ElementTree

from .lines import change_lines
from .words import TEXTS, other_text

# How many changes there are.
_CHANGES = (1, 1, 1, 2, 3)
_TAGS = (
    "link", "joint", "inertial", "mass", "inertia", "origin", "axis", "limit", "dynamics", "mimic",
    "visual", "collision", "geometry", "mesh", "box", "sphere", "cylinder", "capsule", "material",
    "color", "texture", "parent", "child", "safety_controller", "calibration", "robot", "sensor",
)  # fmt: skip
_NAMES = (
    "name", "type", "xyz", "rpy", "value", "filename", "scale", "size", "radius", "length", "link",
    "rgba", "damping", "friction", "lower", "upper", "effort", "velocity", "ixx", "ixz", "iyy",
    "joint", "multiplier",
)  # fmt: skip


def change_xml(data: bytes, chance: random.Random) -> bytes:
    """Change a URDF; one that is no XML by its lines.

    Args:
        data: The text.
        chance: Source of chance.
    """
    try:
        root = ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError, LookupError):
        return change_lines(data, chance)
    for _ in range(chance.choice(_CHANGES)):
        every = list(root.iter())
        element = chance.choice(every)
        kind = chance.random()
        if kind < 0.6:
            _attribute(element, every, chance)
        elif kind < 0.7:
            parent = chance.choice(every)
            if len(parent):
                parent.remove(chance.choice(list(parent)))
        elif kind < 0.8 and element is not root:
            chance.choice([root, *every]).append(copy.deepcopy(element))
        elif kind < 0.9:
            element.tag = chance.choice(_TAGS)
        else:
            ElementTree.SubElement(
                element, chance.choice(_TAGS), {chance.choice(_NAMES): chance.choice(TEXTS)}
            )
    return ElementTree.tostring(root)


def _attribute(
    element: ElementTree.Element, every: list[ElementTree.Element], chance: random.Random
) -> None:
    """Give an element another value, that of another element, or a new attribute."""
    if not element.attrib or chance.random() < 0.1:
        element.set(chance.choice(_NAMES), chance.choice(TEXTS))
        return
    name = chance.choice(list(element.attrib))
    kind = chance.random()
    if kind < 0.6:
        element.set(name, other_text(element.get(name, ""), chance))
    elif kind < 0.85:
        values = [item.get(name, "") for item in every if name in item.attrib]
        element.set(name, chance.choice(values))
    else:
        del element.attrib[name]

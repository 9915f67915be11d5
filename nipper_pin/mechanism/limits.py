"""Limits of the joints of a URDF, and the stops that would enforce them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

from ..units import DEG_PER_RAD, MM_PER_M, coordinate_text
from .mechanism import Mechanism
from .parts import Joint

# A limit of half a turn or more, or of ten times the size of the machine, is written where the
# format asks for one.
_WIDE_RAD, _WIDE_REACHES = 3.1, 10.0
_PLACES = {"prismatic": ("at_mm", MM_PER_M), "revolute": ("at_deg", DEG_PER_RAD)}
_RESTITUTION = 0.2


@dataclass(frozen=True)
class Limit:
    """A limit of a joint.

    Attributes:
        side: Side of the stop that would enforce it.
        at: The limit [rad or m].
    """

    joint: Joint
    side: str
    at: float

    @property
    def sense(self) -> float:
        """1 of a lower limit, -1 of an upper one."""
        return 1.0 if self.side == "lower" else -1.0

    @property
    def text(self) -> str:
        """The limit in the unit of people."""
        return coordinate_text(self.at, self.joint.kind)

    def stop(self) -> tuple[str, dict[str, Any]]:
        """Name and table of a stop; its restitution is a guess."""
        key, factor = _PLACES[self.joint.kind]
        return f"{self.joint.name}_{self.side}", {
            "joint": self.joint.name,
            "side": self.side,
            key: float(f"{factor * self.at:.9g}"),
            "restitution": _RESTITUTION,
        }

    def narrow(self, mechanism: Mechanism) -> bool:
        """Whether it means something."""
        wide = _WIDE_RAD if self.joint.kind == "revolute" else _WIDE_REACHES * mechanism.reach_m
        return abs(self.at) < wide


def joint_limits(root: ElementTree.Element, mechanism: Mechanism) -> Iterator[tuple[Limit, ...]]:
    """Limits of each joint that forces move, at most two."""
    written = {item.get("name"): item for item in root.findall("joint")}
    driven = {drive.index for drive in mechanism.drives}
    for joint in mechanism.joints:
        element = written.get(joint.name)
        if element is None or joint.index in driven or element.get("type") == "continuous":
            continue
        limit = element.find("limit")
        if limit is not None:
            found = ((side, number(limit.get(side))) for side in ("lower", "upper"))
            yield tuple(Limit(joint, side, at) for side, at in found if at is not None)


def without_room(limits: tuple[Limit, ...]) -> bool:
    """Whether no coordinate lies between both limits."""
    return len(limits) == 2 and not limits[0].at < limits[1].at


def number(text: str | None) -> float | None:
    """A number of the URDF; None for what is none, which the reading has refused or ignores."""
    try:
        value = float(text or "")
    except ValueError:
        return None
    return value if math.isfinite(value) else None

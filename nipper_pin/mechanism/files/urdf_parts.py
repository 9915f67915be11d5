"""The parts of a URDF that a mechanism is built from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import pinocchio as pin

from ...arrays import FloatArray
from .plane import Plane
from .urdf_shapes import UrdfShape


@dataclass(frozen=True, kw_only=True)
class Mimic:
    """A joint that follows another: its coordinate is a multiple of the other's.

    Attributes:
        joint: The joint that it follows.
        multiplier: Its coordinate by the other's [1, m/rad or rad/m].
    """

    joint: str
    multiplier: float


@dataclass(frozen=True, kw_only=True)
class UrdfJoint:
    """One joint of the URDF.

    Attributes:
        name: Joint name.
        kind: "revolute", "prismatic" or "fixed".
        parent: Parent link.
        child: Child link.
        placement: Of the child's frame in the parent's at coordinate zero.
        axis: Unit axis of rotation or translation in the joint frame; zero if fixed.
        damping: Of its <dynamics> [N s/m or N m s/rad].
        mimic: The joint that it follows, None if it follows none.
        written: What the file has as its axis, for messages.
    """

    name: str
    kind: Literal["revolute", "prismatic", "fixed"]
    parent: str
    child: str
    placement: pin.SE3
    axis: tuple[float, float, float]
    damping: float = 0.0
    mimic: Mimic | None = None
    written: object = None


@dataclass(frozen=True, kw_only=True)
class UrdfLink:
    """One link of the URDF.

    Attributes:
        inertia: Its inertia in its frame; None without mass, and of a link that cannot move.
        shapes: Its collision shapes in the order of the file.
    """

    inertia: pin.Inertia | None = None
    shapes: tuple[UrdfShape, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Urdf:
    """A checked URDF, in the side view: y of every frame points into the page.

    Attributes:
        root: Name of the root link.
        links: All links by name.
        joints: All joints by name.
        plane: The plane of the file that became the side view.
        own_axes: Frames of the file in the frames here where they differ, by link, shape (3, 3).
    """

    root: str
    links: Mapping[str, UrdfLink]
    joints: Mapping[str, UrdfJoint]
    plane: Plane
    own_axes: Mapping[str, FloatArray]

    @property
    def shapes(self) -> dict[str, tuple[str, ...]]:
        """Names of the collision elements of each link, in the order of the file."""
        return {
            name: tuple(shape.name for shape in link.shapes) for name, link in self.links.items()
        }

    def downwards(self) -> list[UrdfJoint]:
        """All joints, depth first and by name: the order of the coordinates of a tree."""
        below: dict[str, list[UrdfJoint]] = {}
        for joint in sorted(self.joints.values(), key=lambda joint: joint.name, reverse=True):
            below.setdefault(joint.parent, []).append(joint)
        found, waiting = [], below.get(self.root, [])
        while waiting:
            found.append(waiting.pop())
            waiting += below.get(found[-1].child, [])
        return found

"""What solids of all links share: sizes of shafts, and what a drawn solid is."""

from __future__ import annotations

import math
from dataclasses import dataclass

import trimesh
from e62_shapes import Model

FRONT, WALL, WALL_BACK = -0.130, 0.150, 0.158  # ends of the shafts, wall behind the mechanism
BOSS = 0.166
SHAFT, PLAY = 0.0095, 0.0001  # radius of the cylinder shaft; clearance of a pin in its hole
RIM = 0.001  # least thickness of an eccentric around its shaft


@dataclass(frozen=True)
class Part:
    """One drawn solid of a link.

    Attributes:
        link: Link that it belongs to.
        name: Name of the visual, and of the file unless several visuals share one.
        material: Material of the URDF.
        mesh: The solid in the link's frame [m]; None if the file comes with another visual.
        file: File name without suffix.
        origin: Attributes of the origin element.
        scale: Scale attribute of the mesh, or None.
    """

    link: str
    name: str
    material: str
    mesh: trimesh.Trimesh | None
    file: str = ""
    origin: str = ""
    scale: str | None = None


def tension_radius(model: Model) -> float:
    """Radius of the tension shaft: no larger than its eccentrics can hold."""
    off = math.hypot(*model.joint["eccentric_pin_fixed"])
    return min(model.radius("tension_shaft"), model.radius("eccentric_disc_left") - off - RIM)

"""Cuts through all moving links by the plane of the contact point, along the hinge."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...dynamics import Multibody
from .meshes import mesh_of
from .sections import section
from .solids import FIXED, Solid


@dataclass(frozen=True, eq=False)
class LipCut:
    """The cut through one solid.

    Attributes:
        solid: Place of the solid among those that are drawn.
        body: Its link, a place in ``mechanism.joints``.
        loops: Outlines (x, z) in the frame of the link, each of shape (K, 2) [m], the largest
            first; others inside of it are holes.
    """

    solid: int
    body: int
    loops: tuple[FloatArray, ...]


def lip_cuts(body: Multibody, drawn: Sequence[Solid], across: float) -> list[LipCut]:
    """Cut all solids of moving links.

    Args:
        drawn: What the mechanism is drawn with.
        across: Place of the plane along the hinge [m].

    Raises:
        InputError: A mesh cannot be read.
    """
    # Links move in planes, so their places along the hinge are those of any configuration.
    heights = [float(item.translation[1]) for item in body.placements(np.zeros(body.nv))]
    found = []
    for place, item in enumerate(drawn):
        # Frame and cylinder stand behind the lips and would hide nothing but confuse.
        if item.body <= FIXED or item.spring is not None:
            continue
        corners, faces = mesh_of(item)
        at = (corners * item.scale) @ item.placement[:3, :3].T + item.placement[:3, 3]
        loops = section(at, faces, across - heights[item.body])
        if loops:
            found.append(LipCut(place, item.body, tuple(loops)))
    return found

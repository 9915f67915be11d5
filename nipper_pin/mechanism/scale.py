"""The size of a machine, by which its tolerances go: a machine of another size moves alike."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from ..arrays import FloatArray
from .parts import Joint, Start, Stop

_SMALL = 1e-3


def reach(model: pin.Model, joints: Sequence[Joint], places: Sequence[Stop | Start]) -> float:
    """Length that the round-off of a closure gap is proportional to [m].

    Args:
        places: Where slides have stops, or start: they tell the size where no link has a length.
    """
    lengths = sum(np.linalg.norm(placement.translation) for placement in model.jointPlacements)
    slides = {joint.index for joint in joints if joint.kind == "prismatic"}
    travels = (abs(item.at) for item in places if item.index in slides)
    return float(lengths) or max(travels, default=0.0) or 1.0


def unit_of(reach_m: float) -> float:
    """Length that slides and gaps are compared with radians by [m].

    It is a power of two near the reach: dividing by it changes no digit.
    """
    return 2.0 ** round(math.log2(reach_m))


def units_of(joints: Sequence[Joint], unit_m: float) -> FloatArray:
    """Of each coordinate: a radian, or the unit of length of a slide, shape (nv,)."""
    return np.where([joint.kind == "revolute" for joint in joints], 1.0, unit_m)


def written(size: float) -> float:
    """Factor on errors of written lengths, which have as many places in most files.

    They grow with large machines, and with machines of less than a millimetre they fall.

    Args:
        size: Length of the machine, or travel of a drive [m or rad].
    """
    return min(max(1.0, size), size / _SMALL)

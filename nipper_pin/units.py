"""Factors between SI units and those that people read and write in files.

Inside, every quantity is in SI units. A name says what one of the second unit is in the first:
a length [m] times ``MM_PER_M`` is in mm. So are a rate [m/s] in mm/s, and a stiffness [N/m]
times ``M_PER_MM`` in N/mm.
"""

from __future__ import annotations

import math
from typing import Final

MM_PER_M: Final = 1e3
M_PER_MM: Final = 1e-3
UM_PER_M: Final = 1e6
DEG_PER_RAD: Final = 180.0 / math.pi
RAD_PER_DEG: Final = math.pi / 180.0
MRAD_PER_RAD: Final = 1e3
MDEG_PER_DEG: Final = 1e3
MS_PER_S: Final = 1e3
S_PER_MS: Final = 1e-3
US_PER_S: Final = 1e6
US_PER_MS: Final = 1e3
S_PER_MIN: Final = 60.0
S_PER_H: Final = 3600.0
MJ_PER_J: Final = 1e3
DEG_PER_TURN: Final = 360.0


def coordinate_text(coordinate: float, kind: str) -> str:
    """A coordinate of a joint as people read it: "12 mm" of a slide, "0.5 deg" of a hinge.

    Args:
        coordinate: The coordinate, or a difference of two [m or rad].
        kind: Kind of the joint: "prismatic", or one that turns.
    """
    factor, unit = (MM_PER_M, "mm") if kind == "prismatic" else (DEG_PER_RAD, "deg")
    return f"{factor * coordinate:.6g} {unit}"


def rate_text(rate: float, kind: str) -> str:
    """A rate of a joint likewise: "300 mm/s", "4 rad/s"; arguments as of `coordinate_text`."""
    return f"{MM_PER_M * rate:.6g} mm/s" if kind == "prismatic" else f"{rate:.6g} rad/s"

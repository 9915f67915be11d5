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

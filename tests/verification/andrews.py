"""Andrews' squeezing mechanism as its source states it: the start and the published values.

E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, section VI.9 (from W. Schiehlen,
ed., Multibody Systems Handbook, 1990), and W. M. Lioen, J. J. B. de Swart, Test set for initial
value problem solvers, CWI, problem "Andrews' squeezing mechanism". All angles [rad], SI units.
"""

from __future__ import annotations

import numpy as np

NAMES = ("beta", "theta", "gamma", "phi", "delta", "omega", "epsilon")
START = np.array(
    [
        -0.0617138900142764496358948458001,
        0.0,
        0.455279819163070380255912382449,
        0.222668390165885884674473185609,
        0.487364979543842550225598953530,
        -0.222668390165885884674473185609,
        1.23054744454982119249735015568,
    ]
)
# Published values at t = 0.03 s, and the two accelerations at t = 0 that are not zero.
ANGLES = np.array(
    [
        0.1581077119629904e2,
        -0.1575637105984298e2,
        0.4082224013073101e-1,
        -0.5347301163226948,
        0.5244099658805304,
        0.5347301163226948,
        0.1048080741042263e1,
    ]
)
RATES = np.array(
    [
        0.1139920302151208e4,
        -0.1424379294994111e4,
        0.1103291221937134e2,
        0.1929337464421385e2,
        0.5735699284790808,
        -0.1929337464421385e2,
        0.3231791658026955,
    ]
)
FIRST_ACCELERATIONS = np.array([14222.4439199541138705911625887, -10666.8329399655854029433719415])
END = 0.03

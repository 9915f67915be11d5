"""Andrews' squeezing mechanism as its source states it: numbers, equations, published values.

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

_M1, _M2, _M3, _M4, _M5, _M6, _M7 = 0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498
_I1, _I2, _I3, _I4 = 2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7
_I5, _I6, _I7 = 1.169e-5, 5.667e-7, 1.912e-5
_XB, _YB, _XC, _YC = -0.03635, 0.03273, 0.014, 0.072
_C0, _L0, _MOM = 4530.0, 0.07785, 0.033
_D, _DA, _E, _EA, _RR, _RA = 28e-3, 115e-4, 2e-2, 1421e-5, 7e-3, 92e-5
_SS, _SA, _SB, _SC, _SD = 35e-3, 1874e-5, 1043e-5, 18e-3, 2e-2
_TA, _TB, _U, _UA, _UB = 2308e-5, 916e-5, 4e-2, 1228e-5, 449e-5
_ZF, _ZT, _FA = 2e-2, 4e-2, 1421e-5


def _applied(gamma: float) -> tuple[float, float]:
    """Torque of the motor on beta and of the coil spring on gamma [N m]."""
    across = _SD * np.cos(gamma) + _SC * np.sin(gamma)
    along = _SD * np.sin(gamma) - _SC * np.cos(gamma)
    x, y = across + _XB - _XC, along + _YB - _YC
    length = np.hypot(x, y)
    pull = -_C0 * (length - _L0) / length
    return _MOM, float(pull * (y * across - x * along))


def _mass(q: np.ndarray) -> np.ndarray:
    """Mass matrix, shape (7, 7)."""
    _, theta, _, phi, _, omega, _ = q
    arm, lever = _E - _EA, _ZF - _FA
    M = np.zeros((7, 7))
    M[0, 0] = _M1 * _RA**2 + _M2 * (_RR**2 - 2 * _DA * _RR * np.cos(theta) + _DA**2) + _I1 + _I2
    M[0, 1] = M[1, 0] = _M2 * (_DA**2 - _DA * _RR * np.cos(theta)) + _I2
    M[1, 1] = _M2 * _DA**2 + _I2
    M[2, 2] = _M3 * (_SA**2 + _SB**2) + _I3
    M[3, 3] = _M4 * arm**2 + _I4
    M[3, 4] = M[4, 3] = _M4 * (arm**2 + _ZT * arm * np.sin(phi)) + _I4
    M[4, 4] = (
        _M4 * (_ZT**2 + 2 * _ZT * arm * np.sin(phi) + arm**2) + _M5 * (_TA**2 + _TB**2) + _I4 + _I5
    )
    M[5, 5] = _M6 * lever**2 + _I6
    M[5, 6] = M[6, 5] = _M6 * (lever**2 - _U * lever * np.sin(omega)) + _I6
    M[6, 6] = (
        _M6 * (lever**2 - 2 * _U * lever * np.sin(omega) + _U**2)
        + _M7 * (_UA**2 + _UB**2)
        + _I6
        + _I7
    )
    return M


def _forces(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Applied and gyroscopic forces, shape (7,)."""
    beta_dot, theta_dot, _, phi_dot, delta_dot, omega_dot, epsilon_dot = v
    motor, coil = _applied(q[2])
    bend = _M2 * _DA * _RR * np.sin(q[1])
    turn = _M4 * _ZT * (_E - _EA) * np.cos(q[3])
    fold = _M6 * _U * (_ZF - _FA) * np.cos(q[5])
    return np.array(
        [
            motor - bend * theta_dot * (theta_dot + 2 * beta_dot),
            bend * beta_dot**2,
            coil,
            turn * delta_dot**2,
            -turn * phi_dot * (phi_dot + 2 * delta_dot),
            -fold * epsilon_dot**2,
            fold * omega_dot * (omega_dot + 2 * epsilon_dot),
        ]
    )


def _spans(q: np.ndarray) -> list[tuple[int, tuple[int, ...], float, float]]:
    """Loop vectors: (row of x, coordinates in the angle, angle [rad], length [m])."""
    quarter = 0.5 * np.pi
    spans = []
    for row in (0, 2, 4):
        spans.append((row, (0,), q[0], _RR))
        spans.append((row, (0, 1), q[0] + q[1], -_D))
    spans.append((0, (2,), q[2] - quarter, -_SS))
    spans.append((2, (3, 4), q[3] + q[4] - quarter, -_E))
    spans.append((2, (4,), q[4], -_ZT))
    spans.append((4, (5, 6), q[5] + q[6], -_ZF))
    spans.append((4, (6,), q[6] - quarter, -_U))
    return spans


def accelerations(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Accelerations from the stated equations, M a = f + G' la, G a = -G_dot v, shape (7,)."""
    G, bent = np.zeros((6, 7)), np.zeros(6)
    for row, columns, angle, length in _spans(q):
        rate = sum(v[column] for column in columns)
        for column in columns:
            G[row, column] -= length * np.sin(angle)
            G[row + 1, column] += length * np.cos(angle)
        bent[row] -= length * np.cos(angle) * rate**2
        bent[row + 1] -= length * np.sin(angle) * rate**2
    system = np.block([[_mass(q), G.T], [G, np.zeros((6, 6))]])
    return np.linalg.solve(system, np.concatenate([_forces(q, v), -bent]))[:7]

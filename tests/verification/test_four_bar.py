"""A four-bar over a turn of its crank against Freudenstein's equation in closed form.

Ground d, crank a, coupler b, rocker c; crank angle f, rocker angle y from the line of the ground:

    F(f, y) = K1 cos y - K2 cos f + K3 - cos(f - y) = 0,
    K1 = d / a,  K2 = d / c,  K3 = (a^2 - b^2 + c^2 + d^2) / (2 a c).

Written as sin f sin y + (cos f - K1) cos y = K3 - K2 cos f it gives y in closed form; derivatives
follow from F by implicit differentiation.
"""

from pathlib import Path

import numpy as np
import pytest

from nipper_pin import Case, Outcome, Solution, load, simulate

MODEL = Path(__file__).parent / "models" / "four_bar"
GROUND, CRANK = 0.10, 0.03
# The rocker's end in the touch configuration, where the crank points along the ground.
END = complex(0.03 + 0.05785714285714285, 0.06893874832348035)
COUPLER, ROCKER = abs(END - CRANK), abs(END - GROUND)
SPEED_RPM = 300.0
TOLERANCE = 1e-12


def rocker(f: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rocker angle and its first two derivatives by the crank angle."""
    K1, K2 = GROUND / CRANK, GROUND / ROCKER
    K3 = (CRANK**2 - COUPLER**2 + ROCKER**2 + GROUND**2) / (2.0 * CRANK * ROCKER)
    across, along, right = np.sin(f), np.cos(f) - K1, K3 - K2 * np.cos(f)
    # Of the two assemblies, the one with the rocker's end above the ground.
    y = np.arctan2(across, along) - np.arccos(right / np.hypot(across, along))
    y = np.mod(y, 2.0 * np.pi)
    F_f = K2 * np.sin(f) + np.sin(f - y)
    F_y = -K1 * np.sin(y) - np.sin(f - y)
    first = -F_f / F_y
    F_ff, F_fy = K2 * np.cos(f) + np.cos(f - y), -np.cos(f - y)
    F_yy = -K1 * np.cos(y) + np.cos(f - y)
    return y, first, -(F_ff + 2.0 * F_fy * first + F_yy * first**2) / F_y


@pytest.fixture(scope="module")
def turn() -> Solution:
    return simulate(load(MODEL), Case(speed_rpm=SPEED_RPM, window="cycle", start_index=0.0))


def test_rocker_follows_freudensteins_equation(turn: Solution) -> None:
    """Angle, rate and acceleration of the rocker are the closed ones, to 1e-12.

    The motion is kinematic: angles are met to the closures' round-off (1e-16 m by a rocker of
    0.07 m: a few 1e-15 rad), rates and accelerations in units of the crank's speed and its square
    likewise, times the condition of the closures, some 10 to 100. The rocker swings by 50 degrees,
    and the other assembly would be off by radians.
    """
    index = {joint.name: joint.index for joint in turn.mechanism.joints}
    t = np.linspace(0.0, turn.shaft.period, 241)
    motion, forces = turn.trajectory.evaluate(t), turn.trajectory.reactions(t)
    speed = turn.shaft.rate
    f = speed * t
    angle, first, second = rocker(f)
    start = float(np.angle(END - GROUND))
    place = index["rocker_axis"]
    assert turn.outcome is Outcome.COMPLETED
    assert np.ptp(angle) > 0.8
    assert np.abs(motion.q[:, index["crank_axis"]] - f).max() <= 1e-14 * 2.0 * np.pi
    assert np.abs(motion.q[:, place] + start - angle).max() <= TOLERANCE
    assert np.abs(motion.v[:, place] / speed - first).max() <= TOLERANCE
    assert np.abs(forces.a[:, place] / speed**2 - second).max() <= TOLERANCE


def test_crank_torque_does_the_work_of_the_turn(turn: Solution) -> None:
    """Over a whole turn at constant speed the crank's torque does no work.

    T and V are periodic, so the torque's mean over the angle vanishes; the trapezoidal rule
    converges exponentially on a period, so 256 points leave round-off. The torque itself varies
    by 0.7 N m, so its mean can vanish only by balance.
    """
    t = np.linspace(0.0, turn.shaft.period, 257)[:-1]
    torque = turn.trajectory.reactions(t).drives["crank"]
    assert np.ptp(torque) > 0.5
    assert abs(np.mean(torque)) <= 1e-12 * np.ptp(torque)
    assert turn.checks.energy_balance <= 1e-12

"""Found by the stress campaign: a four-bar driven into and past its dead centre.

Messages said "after t = 0 s (index 0.000)" wherever on the way the motion broke down, and not how
near the dead centre was (cases 83, 102 of seed 1).
"""

import math

import mpmath
import numpy as np
import pytest

from benchmarks.stress.machines.small_machines import four_bar
from nipper_pin import (
    Case,
    ConvergenceError,
    SimulationError,
    SingularConfigurationError,
    Window,
    simulate,
)
from nipper_pin.mechanism import from_sources


def run(distance: float, speed_rpm: float = 300.0) -> object:
    """One turn; coupler and rocker are (1 + distance) times as long as they need to be."""
    both = 0.14 * (1.0 + distance)
    source = four_bar(0.10, 0.04, 0.5 * both - 0.01, 0.5 * both + 0.01, (0.1, 0.2, 0.3))
    mechanism = from_sources(source.name, source.urdf, source.description, source.folder)
    case = Case(speed_rpm=speed_rpm, window=Window.CYCLE, start_index=0.0)
    return simulate(mechanism, case)


@pytest.mark.parametrize("distance", [-1e-2, -1e-4, -1e-8, -1e-12, 0.0])
def test_the_error_says_where_and_how_near(distance: float) -> None:
    """The links cannot pass half a turn, which is index 20.

    sqrt(-distance) is the angle, of order one, by which the crank falls short: 1 in index is 9
    degrees. The condition near a dead centre grows like one over that angle.
    """
    with pytest.raises((ConvergenceError, SingularConfigurationError)) as caught:
        run(distance)
    evidence = caught.value.evidence
    assert abs(evidence["index"] - 20.0) <= 20.0 * abs(distance) ** 0.5 + 1e-2
    assert evidence["condition"] > 1e3
    assert set(evidence["joints"]) <= {"crank_axis", "crank_pin", "rocker_axis"}
    assert evidence["joints"]
    assert "condition" in caught.value.message


def test_no_motion_is_wrong_on_the_way_through() -> None:
    """Whatever passes the dead centre keeps its energy balance; all else is refused.

    Where the constrained dynamics gave up after 20 of its iterations, finite wrong torques left an
    imbalance of 3e-4 of the largest kinetic energy (case 273), and of 1.8 where the dead centre is
    passed by less than round-off (case 102).
    """
    passed = 0
    for exponent in range(1, 15):
        try:
            solution = run(10.0**-exponent)
        except SimulationError:
            continue
        passed += 1
        assert solution.checks.energy_balance <= 1e-5  # type: ignore[attr-defined]
    assert passed >= 5


def test_accelerations_beside_it_are_those_of_the_geometry() -> None:
    """A rocker of 600 kg behind a coupler of 1 g, 4e-10 of the links' lengths past the dead centre.

    The crank determines the motion; the rocker's acceleration from the constrained dynamics was off
    by 1.5 % there, and the balance of energy by 2.6e-3 of the largest kinetic energy (case 61 of
    seed 431). By the law of cosines, in 40 digits, of the links' lengths in double precision. The
    crank's angle to the dead centre is 3e-5, so round-off of coordinates changes the acceleration
    by 2e-16 / 3e-5^2, of order 1e-6.
    """
    ground, crank, rate = 0.1, 0.02098066649013637, 50.0
    both = (ground + crank) * (1.0 + 4.2e-10)
    coupler, rocker = 0.6 * both, 0.4 * both
    source = four_bar(ground, crank, coupler, rocker, (0.06, 1e-3, 600.0))
    mechanism = from_sources(source.name, source.urdf, source.description, source.folder)
    speed = 60.0 * rate / (2.0 * math.pi)
    case = Case(speed_rpm=speed, window=Window.CYCLE, start_index=0.0)
    solution = simulate(mechanism, case)
    base = ground - crank
    x = (coupler**2 + base**2 - rocker**2) / (2.0 * base)
    z = math.sqrt(coupler**2 - x**2)

    def angle(t: float) -> mpmath.mpf:
        """Of the rocker, between the line to the crank's pin and its own side."""
        across, along = crank * mpmath.sin(rate * t), crank * mpmath.cos(rate * t) - ground
        distance = mpmath.sqrt(across**2 + along**2)
        rod = mpmath.hypot(x, z), mpmath.hypot(x - mpmath.mpf(base), z)
        cosine = (rod[1] ** 2 + distance**2 - rod[0] ** 2) / (2 * rod[1] * distance)
        return mpmath.atan2(-across, -along) - mpmath.acos(cosine)

    half = math.pi / rate
    times = half + np.array([-1e-3, -1e-5, -1e-6, 0.0, 1e-6, 1e-5, 1e-3])
    found = solution.trajectory.reactions(times).a[:, 2]
    with mpmath.workdps(40):
        true = [float(mpmath.diff(angle, mpmath.mpf(t), 2, h=mpmath.mpf("1e-12"))) for t in times]
    assert np.abs(found).max() > 1e6
    assert found == pytest.approx(true, rel=1e-4)
    assert abs(solution.checks.energy_balance) < 1e-5

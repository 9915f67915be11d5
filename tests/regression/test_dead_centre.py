"""Found by the stress campaign: a four-bar driven into and past its dead centre.

Messages said "after t = 0 s (index 0.000)" wherever on the way the motion broke down, and not how
near the dead centre was (cases 83, 102 of seed 1).
"""

import pytest

from nipper_pin import (
    Case,
    ConvergenceError,
    SimulationError,
    SingularConfigurationError,
    Window,
    simulate,
)
from nipper_pin.mechanism import from_sources
from nipper_pin.study.stress.machines import four_bar


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

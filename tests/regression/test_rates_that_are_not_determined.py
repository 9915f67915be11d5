"""Found by the stress campaign (cases 7721 and 7664 of seed 7): within round-off of a dead centre.

"energy that is left over [J]: 1.56, at most 0.00122": at a condition of 1e8 round-off of positions
decided on the rates, which jumped from one branch to the other without a word. And "invalid value
encountered in reduce", a warning on the way to a refusal.
"""

import warnings

import pytest

from benchmarks.stress.machines.small_machines import four_bar
from nipper_pin import (
    Case,
    DriveMode,
    Mechanism,
    SimulationError,
    SingularConfigurationError,
    Window,
)
from nipper_pin import simulate as run
from nipper_pin.mechanism import from_sources


def machine(lengths: tuple[float, ...], masses: tuple[float, float, float]) -> Mechanism:
    """The four-bar of a case."""
    source = four_bar(*lengths, masses)
    return from_sources(source.name, source.urdf, source.description, source.folder)


def test_rates_that_round_off_decides_on_are_refused() -> None:
    """Coupler and rocker are as long together as they need to be, to one unit of round-off.

    Behind the dead centre there are two motions, 5.5 and 4.8 rad/s; the one that came out began on
    the first and ended on the second, a third of its kinetic energy lost. The message names place,
    condition and joints.
    """
    lengths = 0.1, 0.029765829900476708, 0.07142140327096898, 0.05834442662950774
    masses = 844.0445018587659, 0.025349922719742044, 169.60278364847434
    case = Case(speed_rpm=46.053612229907756, window=Window.CYCLE, start_index=0.0)
    with pytest.raises(SingularConfigurationError, match="round-off decides") as caught:
        run(machine(lengths, masses), case)
    assert caught.value.evidence["index"] == pytest.approx(20.0, abs=1e-3)
    assert caught.value.evidence["condition"] > 4e4


@pytest.mark.slow
def test_infinite_accelerations_are_refused_without_a_warning() -> None:
    """An inertial shaft shakes in a dead centre until accelerations of both signs overflow."""
    lengths = 0.1, 0.02990616209864714, 0.054051767254931535, 0.07585439502474135
    masses = 498.59694602185715, 0.4357437753100228, 0.005382356405203924
    case = Case(
        speed_rpm=2.7854288392067437,
        window=Window.CYCLE,
        start_index=0.0,
        cycles=2,
        drive=DriveMode.INERTIAL,
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(SimulationError, match="cannot be resolved"):
            run(machine(lengths, masses), case)


def test_a_free_shaft_is_not_followed_where_all_links_are_in_line() -> None:
    """Found by case 6201 of seed 12: half of the kinetic energy was lost there without a word."""
    lengths = 0.1, 0.024377879307950788, 0.07712676242385766, 0.04725111688409314
    case = Case(
        speed_rpm=1477.3836212311314,
        window=Window.CYCLE,
        start_index=0.0,
        cycles=2,
        drive=DriveMode.INERTIAL,
    )
    with pytest.raises(SingularConfigurationError, match="dead centre"):
        run(machine(lengths, (0.001, 86.73275802532613, 1000.0)), case)

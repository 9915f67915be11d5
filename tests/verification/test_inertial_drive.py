"""Shafts that an impact may slow down become held drives as their inertia grows.

With reflected inertia I an impact P changes the shaft's rate by O(P / I), and the elastic train of
fixed frequency w (stiffness I w^2) deflects by O(torque / (I w^2)): the held motion is the limit,
approached like 1 / I.
"""

import numpy as np
import pytest

from nipper_pin import Case, Collision, Mechanism, Solution, load, simulate
from nipper_pin.dynamics import drive_impulses

# Above 1e4 the deviation, some 1e-8, comes near the accuracy of event times over a rebound (1e-12).
SCALES = 10.0 ** np.arange(1.0, 4.5, 0.5)


@pytest.fixture(scope="module", params=[450.0, 650.0])
def runs(request: pytest.FixtureRequest, e62: Mechanism) -> tuple[Solution, list[Solution]]:
    """The held transition and inertial ones with all reflected inertias scaled."""
    key = "drives.{}.reflected_inertia_kg_m2"
    scaled = [
        load("e62", {key.format(d.name): float(k * d.reflected_inertia) for d in e62.drives})
        for k in SCALES
    ]
    case = {"speed_rpm": request.param}
    return (
        simulate(e62, Case(**case)),
        [simulate(model, Case(**case, drive="inertial")) for model in scaled],
    )


@pytest.mark.parametrize("quantity", ["rebound_time", "rebound_amplitude", "impulse"])
def test_inertial_drives_converge_to_held_ones(
    runs: tuple[Solution, list[Solution]], quantity: str
) -> None:
    """First rebound and first impulse deviate from the held ones like 1 / inertia: slope -1.

    The next order, 1 / I^2, is below 1 % of the deviation at the smallest scale, so a slope within
    0.1 is far from chance; a wrong limit (another impact law, a shaft that is not carried along by
    its law) would show as a slope of zero, a wrong power of the inertia as 0.5 or 2.
    """
    held, inertial = runs

    def value(collision: Collision) -> float:
        number = getattr(collision, quantity)
        assert number is not None
        return number

    exact = value(held.collisions[0])
    deviation = [abs(value(run.collisions[0]) / exact - 1.0) for run in inertial]
    slope = np.polyfit(np.log10(SCALES), np.log10(deviation), 1)[0]
    assert abs(slope + 1.0) <= 0.1
    # The deviation is there to begin with, and the limit is the held value.
    assert deviation[0] > 1e-7
    assert deviation[-1] <= 2e-3 * deviation[0]


def test_shaft_speeds_jump_by_the_inverse_of_the_inertia(
    runs: tuple[Solution, list[Solution]],
) -> None:
    """The first impact changes the pendulum shaft's rate, and by 1 / I of its impulse.

    The impulse that holds a held shaft is the limit of I times the jump of a free one.
    """
    held, inertial = runs
    shaft = held.mechanism.drives[0]
    hit = held.events[0]
    limit = drive_impulses(held.system, hit.q, hit.delta, hit.P_g)[0]
    jumps = [run.events[0].v_after[shaft.index] - run.events[0].v_before[shaft.index]
             for run in inertial]  # fmt: skip
    impulses = -shaft.reflected_inertia * SCALES * np.array(jumps)
    error = np.abs(impulses / limit - 1.0)
    slope = np.polyfit(np.log10(SCALES), np.log10(error), 1)[0]
    assert abs(slope + 1.0) <= 0.1
    assert error[-1] < 1e-3

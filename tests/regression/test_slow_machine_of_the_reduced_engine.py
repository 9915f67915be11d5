"""Found by the stress campaign (case 2868 of seed 3): round-off of the weight in forces of inertia.

"durations differ by 5.47e-15 s, stated 1.14e-15 s". Functions were sampled at one radian a second,
where the forces of inertia drown in the round-off of the weight, and multiplied by the square of
the speed.
"""

import numpy as np
import pytest

from benchmarks.stress.machines.small_machines import (
    bouncing_mass,
)
from nipper_pin.mechanism import from_sources, rad_s_from_rpm
from nipper_pin.reduced import build, transitions

SPEED = 457.0


def test_a_ballistic_flight_is_as_accurate_as_is_stated_at_any_speed() -> None:
    """A mass on a table that rises evenly: its bounces last 2 e V / (g (1 - e)) exactly.

    The table has no acceleration, so what the engine found of it was round-off alone: 1e-15 at one
    radian a second is 2e-13 of gravity at 457 r/min, two hundred times what was stated.
    """
    source = bouncing_mass(mass=0.0035, lead_mm=60.0, restitution=0.2, gravity=9.81)
    mechanism = from_sources(source.name, source.urdf, source.description, source.folder)
    batch = transitions(
        build(mechanism),
        speed_rpm=np.array([SPEED]),
        restitution=np.array([0.2]),
        stiffness=np.zeros((1, 0)),
        preload=np.zeros((1, 0)),
    )
    approach = 0.06 / (2.0 * np.pi) * rad_s_from_rpm(SPEED)
    exact = 2.0 * 0.2 * approach / (9.81 * 0.8)
    assert abs(batch.duration[0] - exact) <= 2.0 * batch.duration_error[0] + 4e-16 * exact
    assert batch.duration[0] == pytest.approx(exact, rel=1e-14)

"""Machines that the reduced engine took for others: found by the stress campaign."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from benchmarks.stress.machines.small_machines import bouncing_mass
from nipper_pin import InputError
from nipper_pin.mechanism import rad_s_from_rpm
from nipper_pin.reduced import build, transition, transitions


def test_a_mass_that_nothing_presses_on_the_table_is_refused_with_the_reason() -> None:
    """Without gravity no rebound ever comes back, so there is no gap that the tables could cover.

    A division by the acceleration, which is zero, would be a warning, and that an error here.
    """
    mechanism = bouncing_mass(mass=0.7, lead_mm=1.0, restitution=0.0, gravity=0.0).mechanism()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InputError, match="not pressed shut"):
            build(mechanism)


def test_a_ballistic_flight_is_as_accurate_as_is_stated_at_any_speed() -> None:
    """A mass on a table that rises evenly: its bounces last 2 e V / (g (1 - e)) exactly.

    The table has no acceleration, so what the engine found of it was round-off alone: 1e-15 at one
    radian a second is 2e-13 of gravity at 457 r/min, two hundred times what was stated.
    """
    mechanism = bouncing_mass(mass=0.0035, lead_mm=60.0, restitution=0.2, gravity=9.81).mechanism()
    batch = transitions(
        build(mechanism),
        speed_rpm=np.array([457.0]),
        restitution=np.array([0.2]),
        stiffness=np.zeros((1, 0)),
        preload=np.zeros((1, 0)),
    )
    approach = 0.06 / (2.0 * np.pi) * rad_s_from_rpm(457.0)
    exact = 2.0 * 0.2 * approach / (9.81 * 0.8)
    assert abs(batch.duration[0] - exact) <= 2.0 * batch.duration_error[0] + 4e-16 * exact
    assert batch.duration[0] == pytest.approx(exact, rel=1e-14)


def test_a_rebound_higher_than_the_tables_is_refused() -> None:
    """Of a mass that is thrown up by e V: (e V)^2 / (2 g), and tables that end just above or below.

    What they do not hold is extrapolated without a word, unless it is refused at their end.
    """
    mechanism = bouncing_mass(mass=0.7, lead_mm=60.0, restitution=0.2, gravity=9.81).mechanism()
    height = (0.2 * 0.06 * 457.0 / 60.0) ** 2 / (2.0 * 9.81)
    found = transition(build(mechanism, gap_max=1.001 * height), speed_rpm=457.0)
    assert found.rebound_amplitude[0] == pytest.approx(height, rel=1e-12)
    with pytest.raises(InputError) as caught:
        transition(build(mechanism, gap_max=0.999 * height), speed_rpm=457.0)
    assert caught.value.evidence["status"] == "LEFT_GAP"

"""Found by the stress campaign (case 531 of seed 2): a machine in which nothing accelerates.

"RuntimeWarning: overflow encountered in divide" where the reduced engine is built.
"""

import warnings

import pytest

from benchmarks.stress.machines.small_machines import (
    bouncing_mass,
)
from nipper_pin import InputError
from nipper_pin.mechanism import from_sources
from nipper_pin.reduced import build


def test_a_mass_that_nothing_presses_on_the_table_is_refused_with_the_reason() -> None:
    """Without gravity no rebound ever comes back, so there is no gap that the tables could cover.

    A division by the acceleration, which is zero, would be a warning, and that an error here.
    """
    source = bouncing_mass(mass=0.7, lead_mm=1.0, restitution=0.0, gravity=0.0)
    mechanism = from_sources(source.name, source.urdf, source.description, source.folder)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InputError, match="not pressed shut"):
            build(mechanism)

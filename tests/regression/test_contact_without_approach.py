"""Found by the stress campaign (cases 200 and 238 of seed 1): a contact that only grazes.

"no impulses at flap1, flap2, flap3 satisfy the impact law: these stops jam the mechanism against
its drives": the flaps arrived at their stops at +3e-15 rad/s, which is round-off. No impulse is
needed there, and the law was not asked whether none would do.
"""

import numpy as np
import pytest

from nipper_pin import Mechanism
from nipper_pin.dynamics.impact import collide
from nipper_pin.dynamics.shaft import ShaftMotion
from nipper_pin.dynamics.system import System
from nipper_pin.mechanism import from_sources
from nipper_pin.study.stress.machines import flaps


@pytest.fixture(scope="module")
def machine() -> Mechanism:
    source = flaps(2, (0.3,), 0.5, 0.02, 10.0, 9.81)
    return from_sources(source.name, source.urdf, source.description, source.folder)


@pytest.mark.parametrize(("rate", "after"), [(0.0, 0.0), (3e-15, 0.0), (0.25, 0.25)])
def test_contacts_that_do_not_approach_take_no_impulse(
    machine: Mechanism, rate: float, after: float
) -> None:
    """P = 0 satisfies the law where every rate is positive; one that is round-off becomes zero.

    The arm turns at 1 rad/s, so 3e-15 rad/s is round-off and 0.25 rad/s is not.
    """
    system = System(machine, ShaftMotion(machine, 10.0, 0.0))
    q, v = np.zeros(3), np.array([1.0, rate, rate])
    impact = collide(system, q, v, np.empty((0, 3)), machine.stops, [0.5, 0.5])
    assert set(impact.P_N.values()) == {0.0}
    assert not impact.delta.any()
    assert impact.energy_lost == 0.0
    assert impact.v_after.tolist() == [1.0, after, after]

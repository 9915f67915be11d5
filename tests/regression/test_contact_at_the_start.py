"""Found by the stress campaign (cases 75 and 189 of seed 1): contact at the start of a cycle.

"stop table penetrates [rad or m]: 1.13e-06, at most 1e-13" with held drives, and with inertial ones
"stop 'table' is open but its gap starts to close from zero: ... please report the case". A gap is
watched from the moment it opens, so one that was zero at the start and closing was never seen.
"""

import numpy as np
import pytest

from benchmarks.stress.machines.small_machines import (
    bouncing_mass,
)
from nipper_pin import Case, DriveMode, EventKind, Window, simulate
from nipper_pin.mechanism import from_sources


@pytest.mark.parametrize("drive", list(DriveMode))
def test_a_stop_that_closes_at_the_start_collides_there(drive: DriveMode) -> None:
    """The table arrives under the mass at time zero, at lead times speed.

    The first event is that collision, at the speed of the table, and no gap is ever negative;
    without the collision the table would pass through the mass, by a millimetre in this turn.
    """
    source = bouncing_mass(mass=0.7, lead_mm=1.0, restitution=0.0, gravity=9.81)
    mechanism = from_sources(source.name, source.urdf, source.description, source.folder)
    case = Case(speed_rpm=180.0, window=Window.CYCLE, start_index=0.0, drive=drive)
    solution = simulate(mechanism, case)
    first = solution.events[0]
    height = mechanism.stop("table").index
    assert (first.t, first.kind, first.stops[0]) == (0.0, EventKind.COLLISION, "table")
    assert first.v_before[height] == pytest.approx(-3e-3, rel=1e-12)
    times = np.linspace(0.0, solution.trajectory.span[1], 50)
    assert solution.trajectory.evaluate(times).q[:, height].min() >= -1e-15

"""Found by the stress campaign (case 293 of seed 171): a heavy link near a dead centre.

"energy that is left over [J]: 0.0787, at most 0.0109": the proximal iteration of the constrained
dynamics regularised closures with 1e-10 per kg, more than the smallest eigenvalue that a rocker of
1 t has there, and stopped after 200 steps with accelerations that were off by 2.3e-4.
"""

import numpy as np
import pytest

from benchmarks.stress.machines.small_machines import four_bar
from nipper_pin import Case, SingularConfigurationError, Solution, Window, load, simulate
from nipper_pin.mechanism import from_sources


@pytest.fixture(scope="module", params=[354.61857986667974, 354.6, 355.0, 300.0, 600.0])
def turn(request: pytest.FixtureRequest) -> Solution:
    """Turns at the speed of the case and at others: the round-off of none makes panels shorter."""
    lengths = 0.1, 0.03557373794834266, 0.06830322956792707, 0.06727050841323236
    masses = 0.0015538976659508553, 25.163547434882677, 1000.0
    source = four_bar(*lengths, masses)
    machine = from_sources(source.name, source.urdf, source.description, source.folder)
    case = Case(speed_rpm=request.param, window=Window.CYCLE, start_index=0.0)
    return simulate(machine, case)


def test_accelerations_meet_the_closures_whatever_the_masses(turn: Solution) -> None:
    """G a + G_dot v = 0 at every node of the panels next to the dead centre.

    G_dot v is a central difference along v: its step of 1e-6 rad leaves a truncation of 1e-12 and a
    round-off of 2e-16 / 1e-6 of itself, and it is as large as G a. 9e-10 of that was there.
    """
    body = turn.system.body
    (segment,) = turn.segments
    nearest = sorted(segment.panels, key=lambda panel: panel.h)[:5]
    for panel in nearest:
        step = 1e-6 / np.abs(panel.v).max()
        _, before = body.closures(panel.q - step * panel.v)
        _, after = body.closures(panel.q + step * panel.v)
        _, here = body.closures(panel.q)
        turning = np.einsum("nij,nj->ni", (after - before) / (2.0 * step), panel.v)
        left = np.einsum("nij,nj->ni", here, panel.a) + turning
        size = np.einsum("nij,nj->ni", np.abs(here), np.abs(panel.a))
        assert np.abs(left).max() <= 3e-10 * size.max()


def test_energy_balances_beside_the_dead_centre(turn: Solution) -> None:
    """Rates are known to 16 eps times the square of the condition, 7e-6: so is the energy."""
    assert turn.energy.relative <= 7e-6


def test_an_iteration_that_does_not_end_is_an_error() -> None:
    """Both stops of the nipper closed with held drives ask for more than two loops can do.

    No acceleration satisfies such rows; the one of the last iteration is not to be had.
    """
    solution = simulate(load(), Case(speed_rpm=450.0))
    system, panel = solution.system, solution.segments[0].panels[0]
    rows = system.constraint_set(frozenset({"jaw", "steeve"}))
    motion = system.shaft.driven(panel.times)
    with pytest.raises(SingularConfigurationError, match="no solution"):
        system.accelerations(motion, panel.q, panel.v, rows)

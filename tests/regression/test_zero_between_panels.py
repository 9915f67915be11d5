"""Found by the stress campaign (case 332 of seed 1): a zero on the border of two panels.

"stop jaw penetrates [rad or m]: 0.0711, at most 2.42e-13": the start was such that the jaw touches
exactly where a panel of a twelfth of a turn ends. By round-off the zero lay behind the one panel
and before the other, and the lips passed through each other for the rest of the turn.
"""

import numpy as np
import pytest

from nipper_pin import Case, Mechanism, Window, simulate


@pytest.mark.parametrize("panels", range(3, 8))
def test_first_contact_at_the_end_of_a_panel_is_not_missed(e62: Mechanism, panels: int) -> None:
    """Cycles that start whole panels before the touch, and a hair more or less.

    In each the jaw collides within the turn and its gap stays above zero, to round-off; a missed
    contact leaves it 0.07 rad below.
    """
    touch = e62.cylinder.index_from_angle(e62.cylinder.angle_at_touch_rad)
    jaw = e62.stop("jaw").index
    start = touch - 40.0 * panels / 12.0
    found = 0
    for off in (-4e-15, -2e-15, 0.0, 2e-15, 4e-15):
        case = Case(speed_rpm=115.6, window=Window.CYCLE, start_index=start + off)
        solution = simulate(e62, case)
        times = np.linspace(0.0, solution.trajectory.span[1], 200)
        assert solution.trajectory.evaluate(times).q[:, jaw].min() >= -1e-12
        found += any(hit.stop == "jaw" for hit in solution.collisions)
    assert found == 5

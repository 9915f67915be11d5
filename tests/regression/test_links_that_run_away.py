"""Found by the stress campaign (case 9303 of seed 131): a link that leaves for ever.

"energy that is left over [J]: 2.94e+32, at most 4.76e+25": a slide on a turning arm, thrown out to
1e15 m, had more inertia than the shaft that was to be held.
"""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from small_machines import SHAFT, hinge, link, machine, slide

from nipper_pin import Case, Mechanism, SimulationError, Window, simulate

TURN = Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0)
START = 0.1


def arm() -> Mechanism:
    """A bead slides without friction on an arm that turns at constant speed."""
    turning = {"joint": "shaft", "law": "constant_speed", "ratio": 1.0, **SHAFT}
    parts = [
        link("arm"), hinge("shaft", "frame", "arm"),
        link("bead", 1.0, 0.01), slide("out", "arm", "bead", at=(START, 0.0)),
    ]  # fmt: skip
    return machine(parts, 2, drives={"shaft": turning})


@pytest.mark.parametrize("turns", [1, 2])
def test_a_bead_on_a_turning_arm_is_thrown_outwards(turns: int) -> None:
    """r = r_0 cosh(angle): 27 m after one turn, 14 km after two."""
    there = simulate(arm(), replace(TURN, cycles=turns)).trajectory.evaluate(turns, left=True)
    wanted = START * (math.cosh(2.0 * math.pi * turns) - 1.0)
    assert there.q[0, 1] == pytest.approx(wanted, rel=1e-9)


def test_a_bead_that_leaves_for_ever_is_refused() -> None:
    """After four turns r would be 4e9 m, and more than 1e9 m of it one step; the joint is named."""
    with pytest.raises(SimulationError, match="joint out runs away") as caught:
        simulate(arm(), replace(TURN, cycles=4))
    assert caught.value.evidence["moved"] > 1e9

"""Found by the stress campaign (case 2125 of seed 51): a flight that was not iterated to its end.

"flight at 0.846182423 s: equations between nodes [share]: 1.43e-08, at most 7.84e-09": the
acceleration of a closed stop is round-off of its infinite armature, 1e-30 m/s2. Relative to itself
it changed by 1 in the first sweep and not at all in the second, which was taken for a contraction
that makes a third one unnecessary.
"""

from __future__ import annotations

import numpy as np
import pytest
from small_machines import SHAFT, hinge, link, machine, slide

from nipper_pin import DriveMode, Resolution
from nipper_pin.dynamics import ShaftMotion, System
from nipper_pin.hybrid.motion.panel import Begin
from nipper_pin.hybrid.motion.picard import flight_panel

TOLERANCE, LENGTH = 1e-10, 0.02


@pytest.mark.parametrize("round_off", [0.0, 1e-30, 1e-24])
def test_round_off_of_a_closed_stop_does_not_end_the_iteration(round_off: float) -> None:
    """Accelerations at the nodes are those of the states there, whatever the stop's was before.

    The shaft swings about its law by 1 mrad at 10 Hz, so that it needs some five sweeps; after one
    or two the accelerations are wrong by 1e-4 of what moves it.
    """
    press = machine(
        [link("wheel"), hinge("shaft", "frame", "wheel"), link("block"),
         slide("lift", "frame", "block", (0.0, 1.0))],
        2,
        gravity=9.81,
        drives={"shaft": {"joint": "shaft", "law": "constant_speed", "ratio": 1.0, **SHAFT}},
        stops={"lift": {"joint": "lift", "restitution": 0.5}},
    )  # fmt: skip
    shaft = ShaftMotion(press, 2.0 * np.pi, 0.0)
    system = System(press, shaft, DriveMode.INERTIAL)
    rows = system.constraint_set(frozenset({"lift"}))
    wheel, lift = (
        next(joint.index for joint in press.joints if joint.name == name)
        for name in ("shaft", "lift")
    )
    q, v = np.zeros(2), np.zeros(2)
    q[wheel], v[wheel] = 1e-3, 2.0 * np.pi
    motion = shaft.driven(np.zeros(1))
    start = system.accelerations(motion, q[None], v[None], rows)[0]
    assert abs(start[wheel]) > 1.0
    start[lift] = round_off
    none = np.zeros((0, 2))
    split = system.split(none, rows.given, (wheel,))
    begin = Begin(0.0, q, v, start, none)
    attempt = flight_panel(system, rows, split, begin, LENGTH, Resolution(tolerance=TOLERANCE))
    panel = attempt.panel
    assert panel is not None
    exact = system.accelerations(shaft.driven(panel.times), panel.q, panel.v, rows)
    wrong = np.abs(exact - panel.a)[:, wheel].max() * LENGTH**2
    assert wrong <= 10.0 * TOLERANCE * (LENGTH * v[wheel])

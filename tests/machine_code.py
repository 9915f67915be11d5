"""Compile the reduced engine before the tests start, so that no two of them compile the same.

Machine code is kept on disk: where it is there already, this takes two seconds.
"""

from concurrent.futures import ProcessPoolExecutor

import numpy as np

import nipper_pin as nip
from nipper_pin.reduced import build, transition
from nipper_pin.reduced.turns import turns

SPEED_RPM = np.array([600.0, 650.0])


def transitions() -> None:
    e62 = nip.load("e62")
    nip.transition_table(e62, speed_rpm=SPEED_RPM, engine="reduced")
    transition(build(e62), speed_rpm=SPEED_RPM[0])


def whole_turns() -> None:
    e62 = nip.load("e62")
    nip.turn_table(e62, speed_rpm=SPEED_RPM, torques=True, engine="reduced")
    turns(e62, speed_rpm=SPEED_RPM[0])


if __name__ == "__main__":
    # Each in a process of its own: they have few functions in common.
    with ProcessPoolExecutor(2) as pool:
        for compiled in [pool.submit(part) for part in (transitions, whole_turns)]:
            compiled.result()

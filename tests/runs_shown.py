"""Runs that many tests of views look at, each computed once: machines of unlike kinds."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from boxed_mass import box
from judge import press
from small_machines import link, machine, slide

from nipper_pin import Case, Mechanism, Solution, Window, load, simulate


def balls() -> Mechanism:
    """Two balls that fall from one height, so that one event strikes both of their floors."""
    return machine(
        [link("m0", 1.0), slide("z0", "frame", "m0", axis=(0.0, 1.0)),
         link("m1", 2.0), slide("z1", "frame", "m1", axis=(0.0, 1.0), at=(1.0, 0.0))],
        2, gravity=9.81, transition_stop="s1",
        stops={"s0": {"joint": "z0", "restitution": 0.3},
               "s1": {"joint": "z1", "restitution": 0.4}},
        initial={"z0": {"at_mm": 100.0}, "z1": {"at_mm": 100.0}},
    )  # fmt: skip


def turn(mechanism: Mechanism, speed: float, start: float = 0.0, turns: int = 1) -> Solution:
    """Some turns from an index on."""
    case = Case(speed_rpm=speed, window=Window.CYCLE, cycles=turns, start_index=start)
    return simulate(mechanism, case)


RUNS: dict[str, Callable[[], Solution]] = {
    # A contact point, and a stop of a slide; one without contact at a hinge, on a machine that
    # starts at index zero; stops on the upper side and away from zero; two struck together.
    "e62": lambda: turn(load("e62"), 650.0, 24.0),
    "transition": lambda: simulate(load("e62"), Case(speed_rpm=650.0)),
    "press": lambda: turn(press(), 60.0),
    "boxed": lambda: turn(box(-1.0, 0.15), 60.0, turns=2),
    "balls": lambda: turn(balls(), 60.0),
}


@cache
def run_of(name: str) -> Solution:
    """One of them."""
    return RUNS[name]()


TURNS = tuple(name for name in RUNS if name != "transition")
"""Those of whole turns."""

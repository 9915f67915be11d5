"""A mass on a spring between two walls that shake, against the exact motion between impacts.

A crank drives the base by a pin in a slot (Scotch yoke): the base stands at r (cos W t - 1). In its
frame the mass, of natural frequency w0, has

    x'' + w0^2 x = r W^2 cos W t,
    x = A cos w0 t + B sin w0 t + C cos W t,  C = r W^2 / (w0^2 - W^2),

and hits walls at x = -a and x = b, which return e of its rate (two-sided impact oscillator). A and
B follow from the state after each impact, the next impact from a search on this formula alone.
"""

from __future__ import annotations

from functools import cache
from math import cos, pi, sin

import numpy as np
import pytest
from scipy.optimize import brentq
from small_machines import SHAFT, frame, hinge, link, machine, slide

from nipper_pin import Case, Solution, Window, simulate

RADIUS, NATURAL, MASS = 0.05, 9.0, 2.0
LEFT, RIGHT, E_LEFT, E_RIGHT = 0.012, 0.02, 0.8, 0.7
SPEED = 2.0 * pi
STEADY = RADIUS * SPEED**2 / (NATURAL**2 - SPEED**2)
TURNS = 3


@cache
def run() -> Solution:
    """Three turns of a second each."""
    shaker = machine(
        [
            link("crank"), hinge("crank_axis", "frame", "crank"),
            frame("crank_pin", "crank", (RADIUS, 0.0)),
            link("base"), slide("base_x", "frame", "base", at=(RADIUS, 0.0)),
            link("mass", MASS), slide("gap", "base", "mass"),
        ],
        2,
        drives={"crank": {"joint": "crank_axis", "law": "constant_speed", "ratio": 1.0, **SHAFT}},
        springs={"coil": {"joint": "gap", "stiffness_N_per_m": MASS * NATURAL**2,
                          "preload_length_mm": 0.0}},
        stops={
            "left": {"joint": "gap", "restitution": E_LEFT, "at_mm": -1e3 * LEFT},
            "right": {"joint": "gap", "restitution": E_RIGHT, "side": "upper",
                      "at_mm": 1e3 * RIGHT},
        },
        closures={"yoke": {"frame_a": "base", "frame_b": "crank_pin", "slot_axis": "z",
                           "block_mass_kg": 0.1}},
    )  # fmt: skip
    case = Case(speed_rpm=60.0, window=Window.CYCLE, cycles=TURNS, start_index=0.0)
    return simulate(shaker, case)


def exact() -> list[tuple[str, float, float]]:
    """Wall, time and rate before of every impact, from the formula."""
    hits = []
    t, x, v = 0.0, 0.0, 0.0
    while True:
        # Coefficients of the free motion from the state at t.
        free = x - STEADY * cos(SPEED * t)
        swing = (v + STEADY * SPEED * sin(SPEED * t)) / NATURAL
        start = t

        def place(s: float, free=free, swing=swing, start=start) -> float:
            phase = NATURAL * (s - start)
            return free * cos(phase) + swing * sin(phase) + STEADY * cos(SPEED * s)

        def rate(s: float, free=free, swing=swing, start=start) -> float:
            phase = NATURAL * (s - start)
            own = NATURAL * (swing * cos(phase) - free * sin(phase))
            return own - STEADY * SPEED * sin(SPEED * s)

        times = np.linspace(start, start + 1.0, 20001)[1:]
        outside = [s for s in times if not -LEFT < place(s) < RIGHT]
        if not outside or outside[0] > TURNS:
            return hits
        wall, at, e = ("left", -LEFT, E_LEFT) if place(outside[0]) < 0.0 else (
            "right", RIGHT, E_RIGHT)  # fmt: skip
        low = outside[0] - (times[1] - times[0])
        t = brentq(lambda s: place(s) - at, low, outside[0], xtol=1e-15, rtol=1e-15)  # noqa: B023
        hits.append((wall, t, rate(t)))
        x, v = at, -e * rate(t)


def test_impacts_are_those_of_the_exact_motion() -> None:
    """Walls, times and rates of all impacts of three turns.

    A flight is resolved to 1e-12 of itself, and restitutions below one let earlier errors shrink.
    The walls differ in distance and restitution, so one in the wrong place or on the wrong side
    shows at once.
    """
    solution, wanted = run(), exact()
    assert len(wanted) == 10
    assert {wall for wall, _, _ in wanted} == {"left", "right"}
    assert [hit.stop for hit in solution.collisions] == [wall for wall, _, _ in wanted]
    for hit, (wall, t, rate) in zip(solution.collisions, wanted, strict=True):
        assert hit.t == pytest.approx(t, abs=1e-12)
        closing = rate if wall == "left" else -rate
        assert closing < 0.0
        assert hit.approach_rate == pytest.approx(closing, rel=1e-11)
        e = E_LEFT if wall == "left" else E_RIGHT
        assert hit.separation_rate == pytest.approx(-e * closing, rel=1e-11)
        assert hit.impulse == pytest.approx(-MASS * (1.0 + e) * closing, rel=1e-11)

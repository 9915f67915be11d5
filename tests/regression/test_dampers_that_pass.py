"""Found by the stress campaign where the points of a damper pass each other closely.

Case 101 of seed 77: "event 3: times differ by 3.59e-10 s, stated 9.05e-11 s": the points pass at
15 nm on an arc, and the chord between two nodes met the point that the arc passes by.

Case 309 of seed 321: a release 1.15e-11 s late where 5.75e-12 s are stated: at rest, when dampers
have no force, the points are 3 nm apart, and the line turns by 0.4 rad in the first 10 us of a
panel of 29 ms.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from small_machines import SHAFT, frame, hinge, link, machine, slide

from nipper_pin import Case, Mechanism, Window, simulate
from nipper_pin.dynamics import Partition, ShaftMotion, System
from nipper_pin.hybrid.motion.panel import Panel
from nipper_pin.hybrid.motion.residual_check import shows_turns

RADIUS = 0.5
OIL = {"oil": {"frame_a": "post", "frame_b": "tip", "damping_N_s_per_m": 1.0}}


def swept(mechanism: Mechanism, rate: np.ndarray, middle: float = 0.0) -> bool:
    """Whether four nodes, at -1/2, -1/4, 1/4 and 1/2 of this way, show the damper's turning."""
    system = System(mechanism, ShaftMotion(mechanism, math.tau, 0.0))
    way = np.array([0.0, 0.25, 0.75, 1.0])[:, None] - 0.5
    q, v = middle + way * rate, np.repeat(rate[None], 4, axis=0)
    split = Partition((), tuple(range(len(rate))))
    assert system.elements is not None
    panel = Panel(0.0, 1.0, q, v, np.zeros_like(q), split, integrated=True)
    return shows_turns(system.elements, panel, 1e-12)


@pytest.mark.parametrize("beside_m", [-1e-10, 0.0, 1e-10])
@pytest.mark.parametrize("distance_m", [1.5e-8, 1e-6, 1e-4])
def test_a_chord_does_not_hide_that_points_pass(distance_m: float, beside_m: float) -> None:
    """The tip of an arm passes a post below its arc; the chord of two nodes meets the post.

    Half of the chord spans the angle whose cosine is 1 - d / R. Within 1 nm the chord takes the
    points for one, and the line between them for one that needs no direction; the arc does not.
    """
    half = math.acos(1.0 - distance_m / RADIUS)
    post = (0.0, RADIUS - distance_m + beside_m)
    arm = machine(
        [link("arm"), hinge("pin", "frame", "arm"), frame("tip", "arm", (0.0, RADIUS)),
         frame("post", "frame", post)], 1, dampers=OIL,
    )  # fmt: skip
    assert not swept(arm, np.array([4.0 * half]))


@pytest.mark.parametrize("turning", [0.0, 1e-3])
def test_points_that_meet_need_no_direction(turning: float) -> None:
    """A slide carries one point of a damper straight through the other, on a base that may turn."""
    slider = machine(
        [link("base"), hinge("shaft", "frame", "base"), link("mass"),
         slide("x", "base", "mass", axis=(0.6, 0.8), at=(-0.06, -0.08)),
         frame("tip", "mass"), frame("post", "base")], 2, dampers=OIL,
        drives={"shaft": {"joint": "shaft", "law": "constant_speed", "ratio": 1.0, **SHAFT}},
    )  # fmt: skip
    assert swept(slider, np.array([turning, 0.02]), middle=0.1)


@pytest.mark.parametrize("distance_m", [1e-6, 1e-4])
def test_points_that_pass_in_many_nodes_are_shown(distance_m: float) -> None:
    """Nodes on a way as short as the distance see the line turn by and by."""
    arm = machine(
        [link("arm"), hinge("pin", "frame", "arm"), frame("tip", "arm", (0.0, RADIUS)),
         frame("post", "frame", (0.0, RADIUS - distance_m))], 1, dampers=OIL,
    )  # fmt: skip
    assert swept(arm, np.array([distance_m / RADIUS]))


@pytest.mark.parametrize(("damping", "distance_m"), [(5.0, 2e-9), (5.0, 1e-8), (20.0, 2e-9)])
def test_a_damper_that_turns_as_its_points_leave_each_other_keeps_its_impulse(
    damping: float, distance_m: float
) -> None:
    """A mass is pushed away from the post of its damper, at first a little aside.

    m v = F t - c int X^2 / (X^2 + d^2) dX = F t - c (x - d (atan(X / d) - atan(2))), X = 2 d + x.
    The arcs turn by half a radian where the mass hardly moves yet. Of a share of 1e-12 that a panel
    may leave nothing is seen; without short panels beside the post 0.46 c d is missing, a share of
    15e-12 to 77e-12.
    """
    m, F, c, d = 1.0, 300.0, damping, distance_m
    mass = machine(
        [link("mass", m), slide("x", "frame", "mass", at=(2.0 * d, 0.0)), frame("tip", "mass"),
         frame("post", "frame", (0.0, d))], 1,
        springs={"push": {"joint": "x", "coordinate_mm": [-1.0, 9e5], "force_N": [-F, -F]}},
        dampers={"oil": {**OIL["oil"], "damping_N_s_per_m": c}},
    )  # fmt: skip
    solution = simulate(mass, Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0))
    t = np.linspace(0.0, 1.0, 101)
    motion = solution.trajectory.evaluate(t)
    x, v = motion.q[:, 0], motion.v[:, 0]
    turned = np.arctan((2.0 * d + x) / d) - math.atan(2.0)
    assert np.abs(m * v - F * t + c * (x - d * turned)).max() < 1e-12 * F
    assert c * d * turned[-1] > 15e-12 * F

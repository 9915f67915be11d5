"""Small machines with springs and dampers; closed forms are in the tests."""

from __future__ import annotations

import tomllib

import numpy as np
import small_machines
from small_machines import SHAFT, frame, hinge, link, slide

from nipper_pin import Case, Mechanism, Solution, Window, simulate

MASS = 0.7
INERTIA = 0.02
STIFFNESS = 90.0
GRAVITY = 9.81

# A shaft that nothing hangs on keeps the time of the run.
CLOCK = {**SHAFT, "joint": "clock", "law": "constant_speed", "ratio": 1.0,
         "reflected_inertia_kg_m2": 1e-12}  # fmt: skip
SLIDE_X = ("x", (1.0, 0.0), (0.0, 0.0))
SLIDE_Z = ("z", (0.0, 1.0), (0.0, 0.0))
HINGE = ("turn", None, (0.0, 0.0))

Joint = tuple[str, tuple[float, float] | None, tuple[float, float]]


def machine(
    joints: list[Joint],
    springs: str,
    *,
    frames: dict[str, tuple[str, float, float]] | None = None,
    centre: tuple[float, float] = (0.0, 0.0),
    gravity: float = 0.0,
) -> Mechanism:
    """A chain of links from the frame outwards, and a clock.

    Args:
        joints: Name, axis of a slide, and origin (x, z) in the link before [m]; the link behind
            joint j is called ``link_j``. Only the last link and hinged ones have mass.
        springs: Tables of springs and dampers.
        frames: Named frames by name: link and place (x, z) on it [m].
        centre: Centre of mass (x, z) of every link [m].
        gravity: [m/s2].
    """
    parts = [link("hand", 1e-9, 1e-12), hinge("clock", "frame", "hand")]
    below = "frame"
    for name, axis, origin in joints:
        own = f"link_{name}"
        heavy = axis is None or name == joints[-1][0]
        parts.append(link(own, *((MASS, INERTIA) if heavy else (1e-12, 1e-12)), centre))
        parts.append(slide(name, below, own, axis, origin) if axis
                     else hinge(name, below, own, origin))  # fmt: skip
        below = own
    parts += [frame(name, parent, (x, z)) for name, (parent, x, z) in (frames or {}).items()]
    freedom, tables = len(joints) + 1, tomllib.loads(springs)
    return small_machines.machine(
        parts, freedom, gravity=gravity, drives={"clock": CLOCK}, **tables
    )


def swing(mechanism: Mechanism, seconds: float, **case: object) -> Solution:
    """A run from rest at touch."""
    case = {"window": Window.CYCLE, **case}
    return simulate(mechanism, Case(speed_rpm=60.0 / seconds, **case))  # type: ignore[arg-type]


def moved(solution: Solution, t: np.ndarray, joint: str) -> tuple[np.ndarray, np.ndarray]:
    """Coordinate and rate of a joint."""
    motion = solution.trajectory.evaluate(t, left=True)
    place = next(j.index for j in solution.mechanism.joints if j.name == joint)
    return motion.q[:, place], motion.v[:, place]


MANY = f"""
[springs.table]
joint = "lower"
coordinate_deg = [-400.0, -60.0, 10.0, 45.0, 400.0]
torque_N_m = [-9.0, -2.0, 0.5, 3.0, 20.0]
[springs.linear]
joint = "turn"
stiffness_N_m_per_rad = 3.0
preload_deg = 20.0
[dampers.hinge]
joint = "lower"
damping_N_m_s_per_rad = 0.2
[springs.first]
frame_a = "post"
frame_b = "tip"
stiffness_N_per_m = {STIFFNESS}
free_length_mm = 350.0
[springs.second]
frame_a = "knee"
frame_b = "tip"
stiffness_N_per_m = 40.0
free_length_mm = 100.0
[dampers.first]
frame_a = "post"
frame_b = "knee"
damping_N_s_per_m = 4.0
[dampers.second]
frame_a = "knee"
frame_b = "tip"
damping_N_s_per_m = 2.0
"""
LOWER = ("lower", None, (0.3, -0.1))
FRAMES = {
    "post": ("frame", 0.6, 0.5),
    "knee": ("link_turn", 0.05, 0.12),
    "tip": ("link_lower", 0.25, -0.07),
}


def double_pendulum() -> Mechanism:
    return machine([HINGE, LOWER], MANY, frames=FRAMES, centre=(0.1, -0.05), gravity=GRAVITY)

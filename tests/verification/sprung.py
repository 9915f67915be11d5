"""Small machines with springs and dampers, written to a folder; closed forms are in the tests."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nipper_pin import Case, Mechanism, Solution, Window, load, simulate

MASS = 0.7
INERTIA = 0.02
STIFFNESS = 90.0
GRAVITY = 9.81

_TOML = """format = 1
title = "machine of a test"
degrees_of_freedom = {freedom}
gravity_m_s2 = {gravity!r}
initial_phase = 1

[cylinder]
rated_speed_rpm = 60.0
direction = "counter-clockwise"
angle_at_touch_deg = 0.0
reference_index = 0.0
reference_angle_deg = 0.0

# Keeps the time of the run: a shaft that nothing hangs on.
[drives.clock]
joint = "clock"
law = "constant_speed"
ratio = 1.0
reflected_inertia_kg_m2 = 1e-12
shaft_frequency_hz = 1.0
shaft_damping_ratio = 0.0

[[phases]]
number = 1
name = "swinging"
closed = []

"""
SLIDE_X = ("x", "prismatic", "1 0 0", (0.0, 0.0))
SLIDE_Z = ("z", "prismatic", "0 0 1", (0.0, 0.0))
HINGE = ("turn", "continuous", "0 -1 0", (0.0, 0.0))

Joint = tuple[str, str, str, tuple[float, float]]


def machine(
    folder: Path,
    joints: list[Joint],
    springs: str,
    *,
    frames: dict[str, tuple[str, float, float]] | None = None,
    centre: tuple[float, float] = (0.0, 0.0),
    gravity: float = 0.0,
    overrides: dict[str, object] | None = None,
) -> Mechanism:
    """A chain of links from the frame outwards, and a clock.

    Args:
        folder: Folder to write the model folder into.
        joints: Name, type, axis and origin (x, z) in the link before [m]; the link behind joint j
            is called ``link_j``. Only the last link and hinged ones have mass.
        springs: Tables of springs and dampers.
        frames: Named frames by name: link and place (x, z) on it [m].
        centre: Centre of mass (x, z) of every link that has mass [m].
        gravity: [m/s2].
        overrides: As for ``load``.
    """
    parts = ['<robot name="sprung"><link name="frame"/>', _link("hand", 1e-9, 1e-12, (0.0, 0.0)),
             _joint("clock", "continuous", "0 -1 0", "frame", "hand", (0.0, 0.0))]  # fmt: skip
    below = "frame"
    for place, (name, kind, axis, origin) in enumerate(joints):
        last = place == len(joints) - 1 or kind == "continuous"
        mass, inertia = (MASS, INERTIA) if last else (1e-12, 1e-12)
        parts.append(_link(f"link_{name}", mass, inertia, centre))
        parts.append(_joint(name, kind, axis, below, f"link_{name}", origin))
        below = f"link_{name}"
    for name, (link, x, z) in (frames or {}).items():
        parts.append(f'<link name="{name}"/>')
        parts.append(_joint(f"{name}_fixed", "fixed", "1 0 0", link, name, (x, z)))
    home = folder / "sprung"
    home.mkdir(parents=True, exist_ok=True)
    (home / "sprung.urdf").write_text("".join(parts) + "</robot>", encoding="utf-8")
    text = _TOML.format(freedom=len(joints) + 1, gravity=gravity) + springs
    (home / "sprung.toml").write_text(text, encoding="utf-8")
    return load(home, overrides)


def _link(name: str, mass: float, inertia: float, centre: tuple[float, float]) -> str:
    return (
        f'<link name="{name}"><inertial><origin xyz="{centre[0]!r} 0 {centre[1]!r}"/>'
        f'<mass value="{mass!r}"/><inertia ixx="{inertia!r}" iyy="{inertia!r}" izz="{inertia!r}" '
        'ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def _joint(
    name: str, kind: str, axis: str, parent: str, child: str, origin: tuple[float, float]
) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{origin[0]!r} 0 {origin[1]!r}"/><axis xyz="{axis}"/>'
        '<limit lower="-10" upper="10" effort="1e6" velocity="1e6"/></joint>'
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
LOWER = ("lower", "continuous", "0 -1 0", (0.3, -0.1))
FRAMES = {
    "post": ("frame", 0.6, 0.5),
    "knee": ("link_turn", 0.05, 0.12),
    "tip": ("link_lower", 0.25, -0.07),
}


def double_pendulum(folder: Path, **more: object) -> Mechanism:
    return machine(folder, [HINGE, LOWER], MANY, frames=FRAMES, centre=(0.1, -0.05), **more)  # type: ignore[arg-type]

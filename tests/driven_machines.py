"""Five machines that any law of a drive moves, and laws whose pieces end within the turn."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from small_machines import SHAFT, SLED, frame, hinge, link, machine, slide

from nipper_pin import Mechanism

GRAVITY = 9.81
Law = dict[str, Any]


def cam(motion: str, rise: float, dwell: float, back: float, start: float = 0.0) -> Law:
    """A cam of unit lift; angles in degrees."""
    angles = {"rise_deg": rise, "dwell_deg": dwell, "return_deg": back, "start_deg": start}
    return {"law": "cam", "motion": motion, "lift": 1.0, **angles}


def table(rows: int) -> Law:
    """Rows of an uneven motion between 0 and 1."""
    angle = [360.0 * row / rows for row in range(rows + 1)]
    wave = [math.sin(math.radians(0.5 * psi)) ** 4 for psi in angle]
    return {"law": "table", "cylinder_angle_deg": angle, "coordinate": [*wave[:-1], wave[0]]}


LAWS: dict[str, Law] = {
    **{
        f"{motion}, {name}": cam(motion, *angles)
        for motion in ("cycloidal", "modified_sine", "polynomial_345", "polynomial_4567")
        for name, angles in (
            ("dwells", (90.0, 90.0, 90.0)),
            ("late", (70.0, 35.0, 110.0, 81.3)),
            ("no dwell", (170.0, 0.0, 190.0, -40.0)),
        )
    },
    "12 rows": table(12),
    "90 rows": table(90),
    "Fourier": {"law": "fourier", "mean": 0.5, "cosine": [-0.5, 0.1], "sine": [0.0, 0.05]},
    "oscillating guide": {"law": "oscillating_guide", "crank_radius_mm": 20.0},
}


def _drive(
    law: Law, joint: str, *, degrees: float = 0.0, mm: float = 0.0, height_mm: float = 0.0
) -> dict[str, Any]:
    """A drive of a hinge at (0, height), by so many degrees, or of a slide by so many mm."""
    turns = degrees != 0.0
    shares = {
        "lift": ("lift_deg", degrees) if turns else ("lift_mm", mm),
        **{
            key: (f"{key}_rad", math.radians(degrees)) if turns else (f"{key}_mm", mm)
            for key in ("coordinate", "mean", "cosine", "sine")
        },
    }
    drive: dict[str, Any] = {"joint": joint, **(SHAFT if turns else SLED)}
    if law["law"] == "oscillating_guide":
        drive |= {"guide_axis_mm": [0.0, height_mm], "crank_axis_mm": [150.0, height_mm]}
    for key, value in law.items():
        if key not in shares:
            drive[key] = value
            continue
        name, factor = shares[key]
        drive[name] = [factor * x for x in value] if isinstance(value, list) else factor * value
    return drive


def clamp(law: Law) -> Mechanism:
    """A lever closes a clamp by a buffered rod: a loop and two stops."""
    return machine(
        [
            link("lever", 0.25, 1e-4, (0.03, 0.0)),
            hinge("lever", "frame", "lever", (0.0, 0.1)),
            link("upper", 0.08, 2e-5, (0.0, -0.02)),
            hinge("pin", "lever", "upper", (0.06, 0.0)),
            link("lower", 0.06, 2e-5, (0.0, 0.02)),
            slide("buffer", "upper", "lower", (0.0, 1.0), (0.0, -0.08)),
            link("arm", 0.3, 3e-4, (0.05, 0.015)),
            hinge("arm", "frame", "arm", (0.0, 0.02)),
            frame("eye", "arm", (0.06, 0.0)),
        ],
        2,
        gravity=GRAVITY,
        cylinder={"rated_speed_rpm": 300.0, "direction": "counter-clockwise",
                  "angle_at_touch_deg": 240.0, "reference_index": 24.0,
                  "reference_angle_deg": 135.0},
        drives={"cam": _drive(law, "lever", degrees=12.0, height_mm=100.0)},
        springs={"buffer": {"joint": "buffer", "stiffness_N_per_m": 8e3,
                            "preload_length_mm": 8.0}},
        stops={"lip": {"joint": "arm", "restitution": 0.35},
               "buffer": {"joint": "buffer", "restitution": 0.2}},
        closures={"foot": {"frame_a": "lower", "frame_b": "eye"}},
        phases=[{"number": 1, "name": "open", "closed": ["buffer"]},
                {"number": 2, "name": "clamped", "closed": ["lip"]},
                {"number": 3, "name": "bouncing", "closed": []}],
    )  # fmt: skip


def follower(law: Law, *, sprung: bool = True) -> Mechanism:
    """A mass that a spring from above, or its weight alone, holds on a cam."""
    valve = {"frame_a": "anchor", "frame_b": "mass", "stiffness_N_per_m": 900.0,
             "free_length_mm": 512.0}  # fmt: skip
    return machine(
        [
            frame("anchor", "frame", (0.0, 0.5)),
            link("cam", 0.1, 1e-3),
            slide("lift", "frame", "cam", (0.0, 1.0)),
            link("mass", 0.8, 1e-3),
            slide("gap", "cam", "mass", (0.0, 1.0)),
        ],
        2,
        gravity=GRAVITY,
        drives={"cam": _drive(law, "lift", mm=36.0)},
        springs={"valve": valve} if sprung else {},
        stops={"cam": {"joint": "gap", "restitution": 0.3}},
        phases=[{"number": 1, "name": "on the cam", "closed": ["cam"]},
                {"number": 2, "name": "in the air", "closed": []}],
    )  # fmt: skip


def carriage(law: Law) -> Mechanism:
    """A slide and nothing else, without weight: in a dwell nothing moves and nothing pulls."""
    return machine(
        [link("carriage"), slide("x", "frame", "carriage")],
        1,
        drives={"cam": _drive(law, "x", mm=20.0)},
    )


def swing(law: Law) -> Mechanism:
    """A pendulum on a driven arm, between two cushions that it may hit."""
    return machine(
        [
            link("arm", 0.5, 1e-3, (0.05, 0.0)),
            hinge("arm", "frame", "arm"),
            link("pendulum", 0.2, 1e-4, (0.0, -0.08)),
            hinge("swing", "arm", "pendulum", (0.1, 0.0)),
        ],
        2,
        gravity=GRAVITY,
        drives={"cam": _drive(law, "arm", degrees=25.0)},
        stops={"left": {"joint": "swing", "restitution": 0.6, "at_deg": -12.0},
               "right": {"joint": "swing", "side": "upper", "restitution": 0.4, "at_deg": 15.0}},
    )  # fmt: skip


def rocker(law: Law) -> Mechanism:
    """A four-bar linkage without weight: in a dwell its links stand still."""
    return machine(
        [
            link("crank", 0.1, 1e-4),
            hinge("crank", "frame", "crank"),
            link("coupler", 0.2, 1e-4, (0.05, 0.0)),
            hinge("pin", "crank", "coupler", (0.03, 0.04)),
            link("rocker", 0.3, 1e-3, (0.0, 0.05)),
            hinge("rocker", "frame", "rocker", (0.12, 0.0)),
            frame("end", "coupler", (0.1, 0.05)),
            frame("eye", "rocker", (0.01, 0.09)),
        ],
        1,
        drives={"cam": _drive(law, "crank", degrees=30.0)},
        closures={"end": {"frame_a": "end", "frame_b": "eye"}},
    )


MACHINES: dict[str, Callable[[Law], Mechanism]] = {
    "clamp": clamp,
    "follower": follower,
    "carriage": carriage,
    "swing": swing,
    "rocker": rocker,
}

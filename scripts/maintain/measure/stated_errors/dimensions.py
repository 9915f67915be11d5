"""Machines of the E62 class with other dimensions: all numbers within ten per cent, as decimals.

Differences of places are taken of the decimals and rounded once, so that what a machine is wrong by
from its decimals is the rounding of its numbers.
"""

from __future__ import annotations

import sys
from decimal import Decimal
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

TESTS = Path(__file__).resolve().parents[4] / "tests"
_SPREAD = 0.1
# Of the case, or the same everywhere.
_KEPT = ("speed_rpm", "gravity_m_s2")
_Point = tuple[Decimal, Decimal]


def parameters() -> dict[str, str]:
    """Numbers of the E62-class machine, as decimals, by the names of the independent solution."""
    return dict(_imported("reference/planar").PARAMETERS)


def random_numbers(random: np.random.Generator) -> dict[str, str]:
    """Other numbers of six digits."""
    return {
        name: repr(float(f"{float(text) * (1.0 + random.uniform(-_SPREAD, _SPREAD)):.6g}"))
        for name, text in parameters().items()
        if name not in _KEPT
    }


def machine(numbers: dict[str, str]) -> Any:
    """The machine with these numbers, by name; a stop without a contact has its hinge's impulse."""
    number = {name: Decimal(text) for name, text in (parameters() | numbers).items()}
    value = {name: float(item) for name, item in number.items()}
    return _imported("small_machines").machine(
        _parts(number), 3, gravity=value["gravity_m_s2"], **_tables(value)
    )


def _parts(number: dict[str, Decimal]) -> list[str]:
    """Links and joints; those that only follow the drives have any mass."""
    small = _imported("small_machines")

    def place(name: str) -> _Point:
        return number[f"{name}_x_mm"] / 1000, number[f"{name}_z_mm"] / 1000

    def link(name: str, mass: str, inertia: str, centre: _Point) -> str:
        rounded = float(number[mass]), float(number[inertia])
        return str(small.link(name, *rounded, tuple(map(float, centre))))

    shaft, elbow, pin = map(place, ("pendulum_shaft", "pendulum_to_nipper", "nipper_to_rocker"))
    pivot, rod, tension = map(place, ("top_nipper_pivot", "top_nipper_to_rod", "tension_shaft"))
    eccentric, com4 = place("eccentric_pin"), place("com4")
    upward = rod[0] - eccentric[0], rod[1] - eccentric[1]
    length = (upward[0] ** 2 + upward[1] ** 2).sqrt()
    axis = upward[0] / length, upward[1] / length
    com5, com6 = (
        (sign * axis[0] * number[name] / 1000, sign * axis[1] * number[name] / 1000)
        for sign, name in ((1, "com5_from_eccentric_pin_mm"), (-1, "com6_from_rod_pin_mm"))
    )
    origin = Decimal(0), Decimal(0)
    return [
        small.frame("cylinder_axis", "frame"),
        small.link("arm"), small.hinge("arm", "frame", "arm", _apart(shaft, origin)),
        small.link("bottom"), small.hinge("elbow", "arm", "bottom", _apart(elbow, shaft)),
        small.link("rocker"), small.hinge("rocker", "bottom", "rocker", _apart(pin, elbow)),
        small.frame("foot", "rocker", _apart(origin, pin)),
        link("top", "mass4_kg", "inertia4_kg_m2", (com4[0] - pivot[0], com4[1] - pivot[1])),
        small.hinge("jaw", "bottom", "top", _apart(pivot, elbow)),
        link("lower", "mass6_kg", "inertia6_kg_m2", com6),
        small.hinge("rod", "top", "lower", _apart(rod, pivot)),
        link("upper", "mass5_kg", "inertia5_kg_m2", com5),
        small.slide("steeve", "lower", "upper", tuple(map(float, axis)), _apart(eccentric, rod)),
        small.frame("head", "upper"),
        small.link("disc"), small.hinge("disc", "frame", "disc", _apart(tension, origin)),
        small.frame("eccentric", "disc", _apart(eccentric, tension)),
    ]  # fmt: skip


def _tables(value: dict[str, float]) -> dict[str, Any]:
    """What the description says beside the links."""
    shaft = dict(_imported("small_machines").SHAFT)
    guide = {
        "joint": "arm", "law": "oscillating_guide", "crank_radius_mm": value["crank_radius_mm"],
        "crank_axis_mm": [0.0, 0.0], **shaft,
        "guide_axis_mm": [value["pendulum_shaft_x_mm"], value["pendulum_shaft_z_mm"]],
    }  # fmt: skip
    gear = {"joint": "disc", "law": "geared", "of": "pendulum", "ratio": value["gear_ratio"]}
    return {
        "cylinder": {
            "rated_speed_rpm": 450.0, "direction": "clockwise", "reference_index": 24.0,
            "angle_at_touch_deg": value["cylinder_angle_at_touch_deg"],
            "reference_drive": "pendulum", "reference_extreme": "minimum",
        },
        "drives": {"pendulum": guide, "tension": gear | shaft},
        "closures": {
            "axis": {"frame_a": "foot", "frame_b": "cylinder_axis"},
            "pin": {"frame_a": "head", "frame_b": "eccentric"},
        },
        "springs": {
            "steeve": {
                "joint": "steeve", "stiffness_N_per_m": value["stiffness_N_per_m"],
                "preload_length_mm": value["preload_length_mm"],
            },
        },
        "stops": {
            "jaw": {"joint": "jaw", "restitution": value["jaw_restitution"]},
            "steeve": {"joint": "steeve", "restitution": value["stop_restitution"]},
        },
        "phases": [
            {"number": 1, "name": "open", "closed": ["steeve"]},
            {"number": 2, "name": "closed", "closed": ["jaw"]},
            {"number": 3, "name": "free", "closed": []},
        ],
    }  # fmt: skip


def _apart(point: _Point, other: _Point) -> tuple[float, float]:
    return float(point[0] - other[0]), float(point[1] - other[1])


def _imported(name: str) -> Any:
    """A module of the tests."""
    path = TESTS / name
    if str(path.parent) not in sys.path:
        sys.path.insert(0, str(path.parent))
    return import_module(path.name)

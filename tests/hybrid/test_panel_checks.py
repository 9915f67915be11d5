"""Which checks of panels a machine has, and that a machine without elements has none."""

from __future__ import annotations

import copy
from typing import Any

import pytest

from nipper_pin import Mechanism, Resolution, load
from nipper_pin.dynamics import ShaftMotion, System
from nipper_pin.hybrid.motion.panel_checks import panel_checks
from nipper_pin.mechanism import from_sources

TABLE = {"coordinate_mm": [-1.0, 0.0, 8.0], "force_N": [90.0, 100.0, 180.0], "joint": "steeve"}
POINTS = {"frame_a": "frame", "frame_b": "eccentric_pin"}


def names(mechanism: Mechanism) -> list[str]:
    system = System(mechanism, ShaftMotion(mechanism, 50.0, 0.0))
    return [check.name for check in panel_checks(system, Resolution())]


@pytest.mark.parametrize("model", ["e62", "hanging_pendulum", "e62_offset_guide"])
def test_a_nipper_needs_none(model: str) -> None:
    """Linear springs on joints: the nodes show all that their forces do."""
    assert names(load(model)) == []


@pytest.mark.parametrize(
    ("section", "table", "expected"),
    [
        ("springs", TABLE, ["ends of tables", "forces between nodes"]),
        (
            "dampers", {**POINTS, "damping_N_s_per_m": 5.0},
            ["turns of dampers between points", "forces between nodes"],
        ),
        (
            "springs", {**POINTS, "stiffness_N_per_m": 50.0, "free_length_mm": 100.0},
            ["forces between nodes"],
        ),
        (
            "forces", {"joint": "steeve", "law": "orifice", "c_N_s2_per_m2": 1.0},
            ["heat of force laws", "forces between nodes"],
        ),
    ],
)  # fmt: skip
def test_each_element_brings_its_checks(
    section: str, table: dict[str, Any], expected: list[str]
) -> None:
    e62 = load("e62")
    data = copy.deepcopy(dict(e62.description))
    data.setdefault(section, {})["added"] = table
    assert names(from_sources("e62", e62.urdf, data, e62.mesh_folder)) == expected

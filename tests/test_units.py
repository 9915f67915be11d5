"""Factors between units, held against what they are made of."""

from __future__ import annotations

import math

import pytest

from nipper_pin import units

# What each unit of a name is, in the smallest unit of its kind.
SIZE = {
    "M": 1e6, "MM": 1e3, "UM": 1.0,
    "S": 1e6, "MS": 1e3, "US": 1.0, "MIN": 60e6, "H": 3600e6,
    "TURN": math.tau, "RAD": 1.0, "DEG": math.tau / 360.0, "MRAD": 1e-3, "MDEG": math.tau / 360e3,
    "J": 1.0, "MJ": 1e-3,
}  # fmt: skip
NAMES = [name for name in vars(units) if "_PER_" in name]


@pytest.mark.parametrize("name", NAMES)
def test_a_factor_is_what_its_name_says(name: str) -> None:
    """So many of the first unit are one of the second, but for two roundings."""
    first, second = name.split("_PER_")
    assert getattr(units, name) == pytest.approx(SIZE[second] / SIZE[first], rel=4.5e-16)


def test_angles_are_those_of_the_standard_library() -> None:
    """To the last bit: files that were written with one are read with the other."""
    assert math.degrees(1.0) == units.DEG_PER_RAD
    assert math.radians(1.0) == units.RAD_PER_DEG

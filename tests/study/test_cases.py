"""Cases of transitions in SI units."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from nipper_pin import InputError, Mechanism
from nipper_pin.study.cases import cases_of, spring_values


@pytest.fixture(name="two")
def two_springs(e62: Mechanism) -> Mechanism:
    """A spring on a slide, and one on a hinge."""
    hinge = replace(e62.springs[0], name="jaw", index=e62.stop("jaw").index, stiffness=7.0,
                    preload=0.5)  # fmt: skip
    return replace(e62, springs=(*e62.springs, hinge))


def test_springs_in_the_units_of_their_files(two: Mechanism) -> None:
    """Millimetres and degrees; the others keep what they have."""
    own = two.springs[0]
    stiffness, preload = spring_values(two, {
        "stiffness_N_per_m": [8000.0, 9000.0], "preload_length_mm": None, "preload_deg": 90.0,
    })  # fmt: skip
    assert stiffness.tolist() == [[8000.0, 7.0], [9000.0, 7.0]]
    assert preload == pytest.approx(np.array([[own.preload, math.pi / 2.0]]))
    stiffness, preload = spring_values(two, {
        "stiffness_N_m_per_rad": 3.0, "preload_length_mm": [10.0, 12.0],
    })  # fmt: skip
    assert stiffness.tolist() == [[own.stiffness, 3.0]]
    assert preload == pytest.approx(np.array([[0.010, 0.5], [0.012, 0.5]]))


@pytest.mark.parametrize(
    ("key", "right", "wrong", "most", "unit"),
    [
        ("stiffness_N_per_m", 1e10, 1.01e10, 1e10, "N/m"),
        ("preload_length_mm", -999.0, 1.01e3, 1e3, "mm"),
        ("preload_deg", 3600.0, -3601.0, 3600.0, "deg"),
        ("stiffness_N_m_per_rad", 1e10, 1.01e10, 1e10, "N m/rad"),
    ],
)  # fmt: skip
def test_springs_in_another_unit(
    two: Mechanism, key: str, right: float, wrong: float, most: float, unit: str
) -> None:
    """As long as the machine, ten turns and 1e10 are plausible; more is another unit."""
    most = max(most, 1e3 * two.reach_m) if key == "preload_length_mm" else most
    spring_values(two, {key: right})
    with pytest.raises(InputError, match=f"this is in {unit}, and e62 takes") as caught:
        spring_values(two, {key: math.copysign(max(abs(wrong), 1.01 * most), wrong)})
    assert caught.value.evidence["most"] == pytest.approx(most)
    assert (caught.value.evidence["key"], caught.value.evidence["unit"]) == (key, unit)


def test_springs_that_are_not_there(e62: Mechanism, two: Mechanism) -> None:
    with pytest.raises(InputError, match="preload_deg: e62 has no spring on a joint that moves in"):
        spring_values(e62, {"preload_deg": 3.0})
    given = {"preload_length_mm": [1.0, 2.0], "preload_deg": [1.0, 2.0, 3.0]}
    with pytest.raises(InputError, match="need the same number of cases"):
        spring_values(two, given)
    with pytest.raises(InputError, match="need the same number of cases"):
        cases_of(e62, [400.0, 500.0], [0.1, 0.2, 0.3])


def test_cases_of_a_machine(e62: Mechanism) -> None:
    """Its own numbers where none are given, everything as often as the longest."""
    found = cases_of(e62, [400.0, 500.0])
    spring = e62.springs[0]
    assert found.speed_rpm.tolist() == [400.0, 500.0]
    assert found.restitution.tolist() == [e62.stop("jaw").restitution] * 2
    assert found.stiffness.tolist() == [[spring.stiffness]] * 2
    assert found.preload.tolist() == [[spring.preload]] * 2
    found = cases_of(e62, 450.0, [0.0, 1.0], [7e3, 8e3], [0.01, -0.01])
    assert found.speed_rpm.tolist() == [450.0, 450.0]
    assert found.restitution.tolist() == [0.0, 1.0]
    assert found.stiffness.tolist() == [[7e3], [8e3]]
    assert found.preload.tolist() == [[0.01], [-0.01]]
    for wrong in ((0.0,), (450.0, 1.01), (450.0, -0.01), (450.0, 0.1, -1.0)):
        with pytest.raises(InputError):
            cases_of(e62, *wrong)

"""A machine of another size does the same at the same times: all lengths a power of two as long.

Times, angles and masses stay, so that accelerations and weight, forces, moments and energies go
with the length or its square. In binary such factors change no digit of a product or a quotient;
what is left is the round-off of the units of the files and of additions in another order.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import cache
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from small_machines import hinge, link, machine, slide

from nipper_pin import AssemblyError, Case, Mechanism, Solution, load, simulate, transition_table
from nipper_pin.mechanism import from_sources
from nipper_pin.mechanism.gallery import GALLERY, drawn

# Powers of the length in the units of keys; masses, times and angles stay.
_POWERS = {
    "_kg_m2": 2, "_N_m_per_rad": 2, "_N_m_s_per_rad": 2, "_N_per_m": 0, "_N_s_per_m": 0,
    "_N_s2_per_m2": -1, "_N_m": 2, "_N": 1, "_mm_per_s": 1, "_mm": 1, "_m_s2": 1,
}  # fmt: skip
_PLACES = ("radius", "length", "size", "scale")


def scaled(mechanism: Mechanism, factor: float) -> Mechanism:
    """A mechanism whose lengths are ``factor`` times as long.

    Powers of two change no digit of any length, so the same course in time has to come out.

    Args:
        mechanism: The mechanism, without meshes that collide.
        factor: The factor.
    """
    root = ElementTree.fromstring(mechanism.urdf)
    for item in root.iter():
        _multiply(item, "xyz", factor if item.tag == "origin" else 1.0)
        for key in _PLACES:
            _multiply(item, key, factor)
        for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
            _multiply(item, key, factor**2)
    for joint in root.iter("joint"):
        if joint.get("type") != "prismatic":
            for dynamics in joint.iter("dynamics"):
                _multiply(dynamics, "damping", factor**2)
    urdf = ElementTree.tostring(root, encoding="unicode")
    description = _scaled(mechanism.description, 1.0, factor)
    return from_sources(mechanism.name, urdf, description, mechanism.mesh_folder)


def _multiply(item: ElementTree.Element, key: str, factor: float) -> None:
    if key in item.attrib:
        item.set(key, " ".join(repr(factor * float(word)) for word in item.attrib[key].split()))


def _scaled(value: Any, by: float, factor: float) -> Any:
    if isinstance(value, Mapping):
        return {
            key: _scaled(item, factor ** _power(key, value), factor) for key, item in value.items()
        }
    if isinstance(value, list | tuple):
        return [_scaled(item, by, factor) for item in value]
    return value if by == 1.0 or not isinstance(value, float | int) else by * value


def _power(key: str, table: Mapping[str, Any]) -> int:
    if table.get("law") == "falling" and key == "scale":
        # Of the stop of a slide; no hinge of these machines has such a law.
        return 1
    return next((power for unit, power in _POWERS.items() if key.endswith(unit)), 0)


# From 60 nm to 4 km for a machine of a metre.
SIZES = (-24, -16, -12, -4, 4, 12)
# Of times up to a second that are sums of rounded flights.
ROUND_OFF = 64.0 * sys.float_info.epsilon


@cache
def e62_of_its_size(window: str) -> Solution:
    e62 = load("e62")
    return simulate(e62, Case(speed_rpm=e62.cylinder.rated_speed_rpm, window=window))


def both(mechanism: Mechanism, power: int, window: str) -> tuple[Solution, Solution]:
    """The motion of a machine, and of one of another size."""
    case = Case(speed_rpm=mechanism.cylinder.rated_speed_rpm, window=window)
    return simulate(mechanism, case), simulate(scaled(mechanism, 2.0**power), case)


def alike(one: Solution, other: Solution) -> None:
    """The same events at the same stops and times."""
    assert [(item.kind, item.stops) for item in one.events] == [
        (item.kind, item.stops) for item in other.events
    ]
    times = [[item.t for item in solution.events] for solution in (one, other)]
    assert np.abs(np.subtract(*times)).max(initial=0.0) <= ROUND_OFF


@pytest.mark.parametrize("window", ["transition", "cycle"])
@pytest.mark.parametrize("power", SIZES)
def test_e62(power: int, window: str) -> None:
    one = e62_of_its_size(window)
    other = simulate(scaled(one.mechanism, 2.0**power), one.case)
    alike(one, other)
    stated = [[item.time for item in solution.errors] for solution in (one, other)]
    assert np.allclose(*stated, rtol=1e-6)


@pytest.mark.sampled(7)
@pytest.mark.parametrize("power", [-24, -12, 12])
@pytest.mark.parametrize("name", sorted(GALLERY))
def test_gallery(name: str, power: int) -> None:
    alike(*both(drawn(name).mechanism(), power, "cycle"))


@pytest.mark.parametrize("power", SIZES)
def test_one_slide(power: int) -> None:
    """No link has a length: the height from which it falls tells the size."""
    parts = [link("ball"), slide("height", "frame", "ball", (0.0, 1.0))]
    ball = machine(
        parts,
        1,
        gravity=9.81,
        stops={"floor": {"joint": "height", "restitution": 0.5}},
        initial={"height": {"at_mm": 400.0}},
    )
    alike(*both(ball, power, "cycle"))


def test_reduced_engine(e62: Mechanism) -> None:
    one, *others = (
        transition_table(mechanism, speed_rpm=[450.0, 650.0], engine="reduced")
        for mechanism in (e62, scaled(e62, 2.0**-24), scaled(e62, 2.0**12))
    )
    for other in others:
        assert np.array_equal(one.collisions, other.collisions)
        assert np.abs(one.time - other.time).max() <= ROUND_OFF
        assert np.array_equal(one.premise_holds, other.premise_holds)


@pytest.mark.parametrize(
    ("size", "verdict"), [(1e-6, "refused"), (1e-5, "closed"), (1e-3, "met"), (1.0, "met")]
)
def test_a_gap_of_a_millionth_of_a_millimetre(size: float, verdict: str) -> None:
    """Large machines have as many places; in small ones it is a gap, closed or too large."""
    parts = [
        link("crank"),
        hinge("O", "frame", "crank"),
        link("coupler"),
        hinge("A", "crank", "coupler", (0.0, size)),
        link("rocker"),
        hinge("C", "frame", "rocker", (size, 0.0)),
        f'<link name="end"/><joint name="Bc" type="fixed"><parent link="coupler"/>'
        f'<child link="end"/><origin xyz="{size + 0.9e-9!r} 0 0"/></joint>',
        f'<link name="other"/><joint name="Br" type="fixed"><parent link="rocker"/>'
        f'<child link="other"/><origin xyz="0 0 {size!r}"/></joint>',
    ]
    tables = {"closures": {"B": {"frame_a": "end", "frame_b": "other"}}}
    if verdict != "refused":
        assert bool(machine(parts, 1, **tables).closing) == (verdict == "closed")
    else:
        with pytest.raises(AssemblyError, match="a gap of 9e-07 mm"):
            machine(parts, 1, **tables)

"""Random machines as they grow: what each step adds, by hand, and what later steps go by."""

from __future__ import annotations

import math
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from benchmarks.stress.machines import chains, draws
from benchmarks.stress.machines.chains import Chain
from benchmarks.stress.machines.element_families import slotted_lever


class Drawn:
    """A generator whose numbers are told: they come in turn, whatever is asked for."""

    def __init__(self, *numbers: Any) -> None:
        self.numbers, self.asked = list(numbers), []

    def _next(self, *asked: Any) -> Any:
        self.asked.append(asked)
        return self.numbers.pop(0)

    def random(self) -> Any:
        return self._next("random")

    def uniform(self, *bounds: Any) -> Any:
        found = self._next("uniform", *bounds)
        return np.array(found) if isinstance(found, list) else found

    def choice(self, values: Any) -> Any:
        return self._next("choice", tuple(values))

    def permutation(self, count: int) -> Any:
        return np.array(self._next("permutation", count))


def origin(parts: list[str], name: str) -> list[float]:
    """Place of a joint on its parent (x, z), and its angle about y."""
    root = ElementTree.fromstring(f"<robot>{''.join(parts)}</robot>")
    (item,) = (joint.find("origin") for joint in root.iter("joint") if joint.get("name") == name)
    assert item is not None
    x, _, z = (float(number) for number in item.get("xyz", "").split())
    return [x, z, float(item.get("rpy", "0 0 0").split()[1])]


def parent(parts: list[str], name: str) -> str | None:
    root = ElementTree.fromstring(f"<robot>{''.join(parts)}</robot>")
    (item,) = (joint.find("parent") for joint in root.iter("joint") if joint.get("name") == name)
    return None if item is None else item.get("link")


def test_a_slotted_lever() -> None:
    """What may hang on it later, and where that is at touch."""
    machine = slotted_lever(np.random.default_rng(3), 0.05, (0.02, -0.04), 0.25)
    assert machine.links == [("frame", (0.0, 0.0)), ("lever", (0.02, -0.04)), ("flap", (0.05, 0.0))]
    assert machine.joints == {"flap": True}
    assert machine.freedom == 2
    assert origin(machine.parts, "flap") == pytest.approx([0.03, 0.04, 0.0])
    assert parent(machine.parts, "flap") == "lever"
    assert origin(machine.parts, "slot_line_fixed")[2] == pytest.approx(-math.atan2(0.04, 0.03))
    assert machine.tables["closures"]["slot"]["block_mass_kg"] == 0.25
    root = ElementTree.fromstring(f"<robot>{''.join(machine.parts)}</robot>")
    (flap,) = (link for link in root.iter("link") if link.get("name") == "flap")
    numbers = {item.tag: item.attrib for item in flap.iter()}
    assert float(numbers["mass"]["value"]) == machine.mass
    assert float(numbers["inertia"]["iyy"]) == pytest.approx(machine.mass * (0.3 * 0.05) ** 2)
    centre = [float(x) for x in numbers["origin"]["xyz"].split()]
    assert centre == pytest.approx([0.025, 0.0, 0.005])


def test_bases() -> None:
    """One freedom each, and a link that the next one hangs on; none of them adds nothing."""
    machine = Chain()
    machine.add_base(np.random.default_rng(1), "none")
    assert (machine.parts, machine.freedom) == ([], 0)
    laws = {"swing": "fourier", "turn": "constant_speed", "lift": "screw", "yoke": "constant_speed"}
    for kind, law in laws.items():
        machine = Chain()
        machine.add_base(np.random.default_rng(1), kind)
        assert machine.freedom == 1
        drive = machine.tables["drives"]["shaft"]
        assert (drive["law"], drive["joint"]) == (law, "shaft")
        assert ("reflected_mass_kg" in drive) is (kind == "lift")
        name, place = machine.links[1]
        if kind == "yoke":
            radius = origin(machine.parts, "crank_pin_fixed")[0]
            assert (name, place) == ("yoke", (radius, 0.0))
            assert origin(machine.parts, "yoke_x") == [radius, 0.0, 0.0]
        else:
            assert (name, place) == ("base", (0.0, 0.0))
        assert machine.joints == {}


def test_links_are_placed_from_touch() -> None:
    """Each hangs on the last one, at a place of that; places add up."""
    machine = Chain()
    rng: Any = Drawn([0.1, -0.2], [0.05, 0.06], 0.2, [0.3, 0.4], [0.0, 0.0], 0.1, 0.5 * math.pi)
    machine.add_link(rng, True, 3.0)
    assert machine.links[-1] == ("b0", (0.1, -0.2))
    assert (machine.mass, machine.freedom, machine.joints) == (3.0, 1, {"j0": True})
    machine.add_link(rng, False, 5.0)
    name, place = machine.links[-1]
    assert (name, machine.mass, machine.freedom) == ("b1", 5.0, 2)
    assert place == pytest.approx((0.4, 0.2))
    assert machine.joints == {"j0": True, "j1": False}
    assert [parent(machine.parts, joint) for joint in ("j0", "j1")] == ["frame", "b0"]
    assert origin(machine.parts, "j1") == [0.3, 0.4, 0.0]
    bounds = [asked[1:] for asked in rng.asked]
    shape = (-0.4, 0.4, 2), (-0.3, 0.3, 2), (0.03, 0.3)
    assert bounds == [*shape, *shape, (0.0, 2.0 * math.pi)]


@pytest.mark.parametrize(("kind", "freedom"), [("none", 1), ("links", 1), ("slot", 0)])
def test_ties(kind: str, freedom: int) -> None:
    """A slot takes one freedom and its block has a coordinate; links leave what there is."""
    machine = Chain()
    machine.add_link(np.random.default_rng(2), True, 2.0)
    x, z = machine.links[-1][1]
    machine.tie(np.random.default_rng(2), kind)
    assert machine.freedom == freedom
    assert ("rail" in machine.joints) is (kind == "slot")
    if kind == "slot":
        assert machine.joints["rail"] is False
        assert origin(machine.parts, "rail_fixed")[:2] == pytest.approx([x + 0.2, z + 0.1])
    if kind == "links":
        assert origin(machine.parts, "rocker_axis")[:2] == pytest.approx([x + 1.0, z + 0.3])
        # The tip and the coupler's end meet at touch.
        ends = [origin(machine.parts, name)[:2] for name in ("elbow", "coupler_end_fixed")]
        there = [x + 1.0 + ends[0][0] + ends[1][0], z + 0.3 + ends[0][1] + ends[1][1]]
        assert there == pytest.approx([x + 0.2, z + 0.1])


def test_elements_in_their_units() -> None:
    """Hinges count in degrees, slides in millimetres."""
    machine = Chain(joints={"h": True, "s": False})
    for joint in "hs":
        machine.stop(joint, "upper", 0.5, 0.25)
        machine.spring(f"s{joint}", joint, 7.0, 0.25)
        machine.table(f"t{joint}", joint, ([-0.5, 0.25], [1.0, 2.0]))
        machine.damper(f"d{joint}", joint, 3.0)
    half, quarter = math.degrees(0.5), math.degrees(0.25)
    assert machine.tables["stops"] == {
        "h upper": {"joint": "h", "restitution": 0.25, "side": "upper", "at_deg": half},
        "s upper": {"joint": "s", "restitution": 0.25, "side": "upper", "at_mm": 500.0},
    }
    assert machine.tables["springs"] == {
        "sh": {"joint": "h", "stiffness_N_m_per_rad": 7.0, "preload_deg": quarter},
        "ss": {"joint": "s", "stiffness_N_per_m": 7.0, "preload_length_mm": 250.0},
        "th": {"joint": "h", "coordinate_deg": [-half, quarter], "torque_N_m": [1.0, 2.0]},
        "ts": {"joint": "s", "coordinate_mm": [-500.0, 250.0], "force_N": [1.0, 2.0]},
    }
    assert machine.tables["dampers"] == {
        "dh": {"joint": "h", "damping_N_m_s_per_rad": 3.0},
        "ds": {"joint": "s", "damping_N_s_per_m": 3.0},
    }
    source = machine.source("both", 3.0, ["s upper", "h upper"])
    wanted = {key: machine.tables[key] for key in ("springs", "dampers", "stops")}
    assert {key: source.description.get(key) for key in machine.tables} == {
        "drives": None, "closures": None, **wanted,
    }  # fmt: skip
    assert source.description["transition_stop"] == "h upper"
    closed = ["h upper", "s upper"]
    assert source.description["phases"] == [{"number": 1, "name": "start", "closed": closed}]
    assert source.description["gravity_m_s2"] == 3.0
    assert source.description["title"] == "random machine: both"
    assert Chain().source("none", 9.81, []).description["transition_stop"] == ""


@pytest.mark.parametrize("stiffness", [None, 30.0])
@pytest.mark.parametrize("damping", [None, 2.0])
def test_struts(stiffness: float | None, damping: float | None) -> None:
    """Their points are as near to one another at touch as is asked for, whatever carries them."""
    machine = Chain(links=[("frame", (0.0, 0.0)), ("a", (0.5, -0.25)), ("b", (-1.0, 2.0))])
    # The links, a place of the first, an angle, a free length of one and a half times.
    rng: Any = Drawn([2, 1, 0], [0.125, 0.25], 1.0, 0.75, 1.5)
    machine.strut(rng, "st", stiffness, damping, 0.2)
    assert [parent(machine.parts, f"st_{k}_fixed") for k in "ab"] == ["b", "a"]
    first, second = (origin(machine.parts, f"st_{k}_fixed")[:2] for k in "ab")
    assert first == [0.125, 0.25]
    line = [0.5 + second[0] - (-1.0 + first[0]), -0.25 + second[1] - (2.0 + first[1])]
    assert line == pytest.approx([0.2 * math.cos(1.0), 0.2 * math.sin(1.0)])
    ends = {"frame_a": "st_a", "frame_b": "st_b"}
    springs = {"st": {**ends, "stiffness_N_per_m": 30.0, "free_length_mm": pytest.approx(300.0)}}
    assert machine.tables["springs"] == (springs if stiffness else {})
    dampers = {"st": {**ends, "damping_N_s_per_m": 2.0}}
    assert machine.tables["dampers"] == (dampers if damping else {})
    assert rng.asked[0] == ("permutation", 3)
    if stiffness:
        assert rng.asked[-1] == ("choice", (0.0, 1.0, 0.75))


@pytest.mark.parametrize("joint", ["h", "s"])
def test_stops_that_are_closed_at_the_start(joint: str) -> None:
    """Of two on one joint the last; of a joint that stands beyond both the nearer one."""
    assert chains._one_a_joint(["a lower", "b upper", "a upper"]) == ["a upper", "b upper"]
    found = 0
    for seed in range(300):
        machine = Chain(joints={joint: joint == "h"})
        closed = machine.add_stops(np.random.default_rng(seed), 2, (1e-3, 0.1))
        key, unit = ("at_deg", math.degrees(1.0)) if joint == "h" else ("at_mm", 1e3)
        at = {name: stop[key] / unit for name, stop in machine.tables["stops"].items()}
        low, high = at[f"{joint} lower"], at[f"{joint} upper"]
        assert low <= high
        assert max(abs(low), abs(high)) < 0.2 + 1e-12
        if low > 0.0 or high < 0.0:
            found += 1
            assert closed == [f"{joint} lower" if low > 0.0 else f"{joint} upper"]
        else:
            assert {at[name] for name in closed} <= {0.0}
    # A quarter of them, with three times the deviation of a binomial law.
    assert abs(found - 75) < 3.0 * math.sqrt(300 * 0.25 * 0.75)


def test_numbers_over_decades() -> None:
    """The ends themselves one time in ten, else evenly in the logarithm between them."""
    rng: Any = Drawn(0.05, 8.0, 0.5, 2.0)
    assert draws.log(rng, 2.0, 8.0) == 8.0
    assert draws.log(rng, 10.0, 1e3) == 100.0
    assert rng.asked[:2] == [("random",), ("choice", (2.0, 8.0))]
    assert rng.asked[3] == ("uniform", 1.0, 3.0)
    rng = Drawn(0.09, 2.0, 0.11, 2.0, -1.0)
    assert (draws.log(rng, 1.0, 2.0), draws.log(rng, 1.0, 2.0)) == (2.0, 100.0)
    assert draws.sign(rng) == -1.0
    assert rng.asked[-1] == ("choice", (-1.0, 1.0))

"""What a campaign reads off the texts of a model, and what their mirror images are, by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest
from any_plane import rewritten

from benchmarks.stress import observations
from benchmarks.stress.checks import model as model_invariants
from benchmarks.stress.checks import rebounds as rebound_invariants
from benchmarks.stress.machines.mirror import mirrored
from benchmarks.stress.machines.parts import Source
from benchmarks.stress.mechanics.planar_tree import PlanarTree

INERTIA = '<inertia ixx="0.3" iyy="0.4" izz="0.5" ixy="0.02" ixz="-0.03" iyz="0.04"/>'
# Hinges of both senses, a slide between them, and a link that is fixed to the last one.
TREE = f"""<robot name="tree"><link name="frame"/>
<link name="one"><inertial><origin xyz="0.1 0.2 -0.3" rpy="0.4 -0.5 0.6"/><mass value="2.5"/>
{INERTIA}</inertial></link>
<link name="two"><inertial><origin xyz="0 0 0"/><mass value="0.7"/>{INERTIA}</inertial></link>
<link name="three"><inertial><origin xyz="0 0.3 0.1"/><mass value="1.2"/>{INERTIA}</inertial></link>
<link name="tail"><inertial><origin xyz="0.3 0 0" rpy="0 0 1.1"/><mass value="0.4"/>{INERTIA}
</inertial></link>
<joint name="a" type="continuous"><parent link="frame"/><child link="one"/>
<origin xyz="0.5 -0.1 0.2" rpy="0 0.2 0"/><axis xyz="0 -1 0"/></joint>
<joint name="b" type="prismatic"><parent link="one"/><child link="two"/>
<origin xyz="0.2 0.4 0.1" rpy="0 -0.7 0"/><axis xyz="3 0 4"/>
<limit lower="-9" upper="9" effort="9" velocity="9"/></joint>
<joint name="c" type="continuous"><parent link="two"/><child link="three"/>
<origin xyz="0 0.3 0.2"/><axis xyz="0 2 0"/></joint>
<joint name="tail_fixed" type="fixed"><parent link="three"/><child link="tail"/>
<origin xyz="0.2 0.1 0.4" rpy="0.2 0.3 0.4"/></joint>
</robot>"""


@pytest.mark.parametrize("order", [["a", "b", "c"], ["c", "a", "b"]])
@pytest.mark.parametrize("seed", range(4))
def test_inertias_of_a_tree_in_any_plane(order: list[str], seed: int) -> None:
    """Mass matrix and forces by Pinocchio's recursions in space, in any order of coordinates.

    The machine is turned as a whole, and each of its frames for itself.
    """
    rng = np.random.default_rng(seed)
    turn = pin.rpy.rpyToMatrix(*rng.uniform(-3.0, 3.0, 3)) if seed else np.eye(3)
    urdf = rewritten(TREE, turn, {"a": (-1.0) ** seed}, rng if seed else None)
    model = pin.buildModelFromXML(urdf)
    # A hinge without limits is a point of the circle there.
    model.gravity.linear = np.array([0.0, 0.0, -7.5])
    data = model.createData()
    q, v, a = ({"a": x, "b": y, "c": z} for x, y, z in rng.normal(size=(3, 3)))
    pin_q = np.array([math.cos(q["a"]), math.sin(q["a"]), q["b"], math.cos(q["c"]),
                      math.sin(q["c"])])  # fmt: skip
    matrix = pin.crba(model, data, pin_q)
    matrix = np.triu(matrix) + np.triu(matrix, 1).T
    force = pin.rnea(model, data, pin_q, *(np.array([x[n] for n in "abc"]) for x in (v, a)))
    places = ["abc".index(name) for name in order]
    tree = PlanarTree(urdf, {"gravity_m_s2": 7.5}, order)
    state = [np.array([x[name] for name in order]) for x in (q, v, a)]
    # Sums of a few dozen terms of the size of one.
    wanted = matrix[np.ix_(places, places)]
    assert tree.mass_matrix(state[0]) == pytest.approx(wanted, abs=1e-13)
    assert tree.inverse_dynamics(*state) == pytest.approx(force[places], abs=1e-12)
    many = [np.stack([x, 0.5 * x]) for x in state]
    assert tree.inverse_dynamics(*many)[0] == pytest.approx(force[places], abs=1e-12)


def test_links_that_are_fixed_and_the_block_of_a_slot() -> None:
    """Two masses on a hinge at (3, 4) and (-3, 0); the block slides from where the pin is."""

    def link(name: str, mass: float, place: str) -> str:
        return (
            f'<link name="{name}"><inertial><origin xyz="{place}"/><mass value="{mass}"/>'
            '<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )

    def fixed(name: str, parent: str, place: str) -> str:
        return (
            f'<link name="{name}"/><joint name="{name}_f" type="fixed"><parent link="{parent}"/>'
            f'<child link="{name}"/><origin xyz="{place}" rpy="0 -0.5 0"/></joint>'
        )

    urdf = (
        '<robot name="r"><link name="frame"/>'
        + link("arm", 2.0, "3 0 4") + link("back", 5.0, "-3 0 0")
        + '<joint name="h" type="continuous"><parent link="frame"/><child link="arm"/>'
        '<axis xyz="0 -1 0"/></joint><joint name="back_f" type="fixed"><parent link="arm"/>'
        '<child link="back"/></joint>' + fixed("slot", "arm", "1 0 0")
        + fixed("pin", "frame", "2 0 1")
        + "</robot>"
    )  # fmt: skip
    tree, still = PlanarTree(urdf, {"gravity_m_s2": 10.0}, ["h"]), np.zeros(1)
    weight = tree.inverse_dynamics(still, still, still)
    assert weight == pytest.approx([10.0 * (2.0 * 3.0 - 5.0 * 3.0)])
    assert tree.mass_matrix(still) == pytest.approx(np.array([[2.0 * 25.0 + 5.0 * 9.0]]))
    for axis, towards in (("x", (math.cos(0.5), math.sin(0.5))),
                          ("z", (-math.sin(0.5), math.cos(0.5)))):  # fmt: skip
        closure = {"frame_a": "slot", "frame_b": "pin", "slot_axis": axis, "block_mass_kg": 0.25}
        tree = PlanarTree(urdf, {"gravity_m_s2": 10.0, "closures": {"s": closure}}, ["h", "s"])
        along = 1.0 * towards[0] + 1.0 * towards[1] + 0.5
        x, z = 1.0 + along * towards[0], along * towards[1]
        q, still = np.array([0.0, 0.5]), np.zeros(2)
        # A hinge counts counter-clockwise: it moves (x, z) by (-z, x).
        cross = -z * towards[0] + x * towards[1]
        matrix = [[95.0 + 0.25 * (x * x + z * z), 0.25 * cross], [0.25 * cross, 0.25]]
        assert tree.mass_matrix(q) == pytest.approx(np.array(matrix))
        weight = tree.inverse_dynamics(q, still, still)
        assert weight == pytest.approx([-90.0 + 2.5 * x, 2.5 * towards[1]])


def element(**values: Any) -> Any:
    return SimpleNamespace(**values)


DOCUMENT: dict[str, Any] = {
    "springs": {
        "strut": {"frame_a": "a", "stiffness_N_per_m": 5.0, "free_length_mm": 120.0},
        "push": {"coordinate_mm": [-10.0, 20.0], "force_N": [3.0, 4.0]},
        "twist": {"coordinate_deg": [-90.0, 180.0], "torque_N_m": [5.0, 6.0]},
        "coil": {"stiffness_N_m_per_rad": 7.0, "preload_deg": 90.0},
        "bar": {"stiffness_N_per_m": 8.0, "preload_length_mm": 11.0},
    },
    "dampers": {"oil": {"joint": "h", "damping_N_s_per_m": 0.5},
                "gas": {"damping_N_m_s_per_rad": 0.75}},
    "stops": {"low": {"restitution": 0.25, "at_deg": 45.0},
              "high": {"restitution": 0.5, "at_mm": 30.0, "side": "upper"}},
    "drives": {"main": {"reflected_inertia_kg_m2": 2.0, "shaft_frequency_hz": 10.0,
                        "shaft_damping_ratio": 0.125, "law": "screw"},
               "stiff": {"reflected_mass_kg": 3.0}},
}  # fmt: skip


def machine(**changes: Any) -> Any:
    """The machine of the document."""
    rows = [
        element(name="push", characteristic=element(coordinate=[-0.01, 0.02], force=[3.0, 4.0])),
        element(name="twist", characteristic=element(coordinate=[-math.pi / 2, math.pi],
                                                     force=[5.0, 6.0])),
    ]  # fmt: skip
    given = {
        "description": DOCUMENT, "tabulated_springs": rows,
        "springs": [element(name="coil", stiffness=7.0, preload=math.pi / 2),
                    element(name="bar", stiffness=8.0, preload=0.011)],
        "dampers": [element(name="oil", damping=0.5)],
        "struts": [element(name="strut", kind="spring", stiffness=5.0, free_length=0.12,
                           damping=9.0),
                   element(name="gas", kind="damper", stiffness=1.0, free_length=2.0,
                           damping=0.75)],
        "stops": [element(name="low", restitution=0.25, at=math.pi / 4, sense=1.0),
                  element(name="high", restitution=0.5, at=0.03, sense=-1.0)],
        "drives": [element(name="main", reflected_inertia=2.0, shaft_frequency_hz=10.0,
                           shaft_damping_ratio=0.125),
                   element(name="stiff", reflected_inertia=3.0, shaft_frequency_hz=0.0,
                           shaft_damping_ratio=0.0)],
    }  # fmt: skip
    return element(**{**given, **changes})


def test_numbers_of_elements() -> None:
    """Of the document in SI units, and of the machine; they are the same."""
    wanted = {
        "spring strut": (5.0, 0.12), "spring push": (-0.01, 0.02, 3.0, 4.0),
        "spring twist": (-math.pi / 2, math.pi, 5.0, 6.0), "spring coil": (7.0, math.pi / 2),
        "spring bar": (8.0, 0.011), "damper oil": (0.5,), "damper gas": (0.75,),
        "stop low": (0.25, math.pi / 4, 1.0), "stop high": (0.5, 0.03, -1.0),
        "drive main": (2.0, 10.0, 0.125), "drive stiff": (3.0, 0.0, 0.0),
    }  # fmt: skip
    for found in (model_invariants._told(machine()), model_invariants._found(machine())):
        assert list(sorted(found)) == sorted(wanted)
        for name, numbers in wanted.items():
            assert found[name] == pytest.approx(numbers, rel=1e-15)


def full() -> Source:
    """A model that has everything that can be mirrored."""
    urdf = (
        '<robot name="m"><link name="frame"><visual><origin xyz="1 2 3" rpy="0.1 0.2 0.3"/>'
        '</visual></link><joint name="turns" type="continuous"><origin xyz="4 0 5"/>'
        '<axis xyz="0 -1 0"/></joint><joint name="swings" type="revolute"><axis xyz="0 -1 0"/>'
        '</joint><joint name="slides" type="prismatic"><axis xyz="0.6 0 0.8"/></joint></robot>'
    )
    springs = {
        "coil": {"joint": "turns", "stiffness_N_m_per_rad": 2.0, "preload_deg": 10.0},
        "bar": {"joint": "slides", "stiffness_N_per_m": 2.0, "preload_length_mm": 10.0},
        "block": {"joint": "slot", "coordinate_mm": [-1.0, 2.0, 4.0], "force_N": [-7.0, 1.0, 9.0]},
        "other": {"joint": "upright", "preload_length_mm": 3.0},
        "twist": {"joint": "swings", "coordinate_deg": [-1.0, 5.0], "torque_N_m": [2.0, 3.0]},
        "straight": {"joint": "slides", "coordinate_mm": [-1.0, 5.0], "force_N": [2.0, 3.0]},
        "sled": {"joint": "slot", "preload_length_mm": 6.0},
        "strut": {"frame_a": "a", "free_length_mm": 4.0},
    }
    stops = {
        "low": {"joint": "turns", "at_deg": 20.0}, "high": {"joint": "swings", "side": "upper"},
        "own": {"joint": "slides", "side": "upper", "at_mm": 3.0},
        "slot": {"joint": "slot", "side": "lower", "at_mm": 2.0},
    }  # fmt: skip
    drives = {
        "even": {"law": "constant_speed", "ratio": 2.0},
        "waves": {"law": "fourier", "mean_rad": 0.5, "cosine_rad": [1.0, -2.0], "sine_rad": [3.0]},
        "screw": {"law": "screw", "lead_mm_per_turn": 4.0},
        "lobe": {"law": "cam", "joint": "turns", "lift_deg": 8.0, "rise_deg": 60.0},
        "rows": {"law": "table", "coordinate_rad": [0.0, 0.5], "cylinder_angle_deg": [0.0, 180.0]},
        "lift": {"law": "cam", "joint": "slides", "lift_mm": 3.0},
        "gear": {"law": "geared", "of": "even", "ratio": -3.0},
    }
    initial = {
        "turns": {"at_deg": 3.0, "rate_rad_per_s": -2.0}, "slides": {"at_mm": 4.0},
        "slot": {"rate_mm_per_s": 5.0},
    }  # fmt: skip
    cylinder = {"reference_drive": "lobe", "reference_extreme": "maximum"}
    closures = {"slot": {"slot_axis": "x"}, "upright": {"slot_axis": "z"}, "pin": {}}
    document: dict[str, Any] = {
        "springs": springs, "stops": stops, "drives": drives, "closures": closures,
        "initial": initial, "cylinder": cylinder,
    }  # fmt: skip
    return Source("m", urdf, document, "there")


def test_mirror_image() -> None:
    """Each key that changes its sign or its side, and no other."""
    source = full()
    image = mirrored(source)
    assert image is not None
    assert source == full()
    assert (image.name, image.folder) == ("m", "there")
    wanted = full().description
    wanted["springs"]["coil"]["preload_deg"] = -10.0
    wanted["springs"]["block"] |= {"coordinate_mm": [-4.0, -2.0, 1.0], "force_N": [-9.0, -1.0, 7.0]}
    wanted["springs"]["twist"] |= {"coordinate_deg": [-5.0, 1.0], "torque_N_m": [-3.0, -2.0]}
    wanted["springs"]["sled"]["preload_length_mm"] = -6.0
    wanted["stops"]["low"] |= {"side": "upper", "at_deg": -20.0}
    wanted["stops"]["high"]["side"] = "lower"
    wanted["stops"]["slot"] |= {"side": "upper", "at_mm": -2.0}
    wanted["drives"]["even"]["ratio"] = -2.0
    wanted["drives"]["waves"] |= {
        "mean_rad": -0.5, "cosine_rad": [-1.0, 2.0], "sine_rad": [-3.0],
    }  # fmt: skip
    wanted["drives"]["lobe"]["lift_deg"] = -8.0
    wanted["drives"]["rows"]["coordinate_rad"] = [0.0, -0.5]
    wanted["initial"]["turns"] = {"at_deg": -3.0, "rate_rad_per_s": 2.0}
    wanted["initial"]["slot"]["rate_mm_per_s"] = -5.0
    wanted["cylinder"]["reference_extreme"] = "minimum"
    assert image.description == wanted
    root = ElementTree.fromstring(image.urdf)

    def numbers(path: str, key: str) -> list[list[float]]:
        return [[float(x) for x in item.get(key, "").split()] for item in root.iterfind(path)]

    assert numbers(".//origin", "xyz") == [[-1, 2, 3], [-4, 0, 5]]
    assert numbers(".//origin", "rpy") == [[0.1, -0.2, 0.3], []]
    assert numbers(".//axis", "xyz") == [[0, -1, 0], [0, -1, 0], [-0.6, 0, 0.8]]


@pytest.mark.parametrize("change", ["law", "contact"])
def test_what_has_no_mirror_image(change: str) -> None:
    source = full()
    if change == "law":
        source.description["drives"]["even"]["law"] = "oscillating_guide"
    else:
        source.description["stops"]["low"]["contact"] = {}
    assert mirrored(source) is None
    assert mirrored(replace(source, description={})) is not None


@pytest.mark.parametrize(
    ("count", "most", "places"),
    [(0, 3, []), (1, 3, [0]), (3, 3, [0, 1, 2]), (4, 3, [0, 2, 3]), (9, 3, [0, 4, 8]),
     (9, 4, [0, 3, 5, 8]), (2, 9, [0, 1])],
)  # fmt: skip
def test_places_that_are_looked_at(count: int, most: int, places: list[int]) -> None:
    found = observations.some(count, most)
    assert len(found) == len(places)
    assert found[:1] + found[-1:] == places[:1] + places[-1:]
    assert all(abs(one - other) <= 1 for one, other in zip(found, places, strict=True))


def test_what_is_beyond_a_limit() -> None:
    assert [*observations.beyond("x", 1.0, 1.0)] == []
    assert [*observations.beyond("x", 1.25, 1.0)] == ["x: 1.25, at most 1"]
    assert [*observations.beyond("x", math.nan, 1.0)] == ["x: nan, at most 1"]


def test_panels_that_are_looked_at() -> None:
    """Three of the panels of a segment, each with five times; copies of a turn once."""
    panels = [object() for _ in range(10)]
    pieces = [(panel, float(n), n + 0.5) for n, panel in enumerate(panels)]
    parts = ((0, 5, 0), (5, 10, 0), (5, 8, 2))
    segments = [
        SimpleNamespace(
            pieces=lambda i=i, j=j: iter(pieces[i:j]), panels=panels[i:j], source=source
        )
        for i, j, source in parts
    ]
    run: Any = SimpleNamespace(segments=segments)
    found = [*observations.samples(run)]
    assert [(segments.index(item[0]), panels.index(item[1])) for item in found] == [
        (0, 0), (0, 2), (0, 4), (2, 5), (2, 6), (2, 7),
    ]  # fmt: skip
    assert found[1][2] == pytest.approx([2.0, 2.125, 2.25, 2.375, 2.5], rel=1e-15)


def parts_of(begin: float, end: float, count: int) -> Any:
    """A segment of panels of one length."""
    ends = np.linspace(begin, end, count + 1).tolist()
    panel = SimpleNamespace(order=13)
    pieces = [(panel, *pair) for pair in pairwise(ends)]
    return SimpleNamespace(t_start=begin, pieces=lambda: iter(pieces))


@pytest.mark.parametrize("top", [0.437, 0.5, 0.811])
@pytest.mark.parametrize("crests", [3, 7, 40, 100, 399])
def test_the_highest_of_many_crests(crests: int, top: float) -> None:
    """A body on a stiff spring swings while it flies: 1 - (t - top)^2 + cos(w (t - top)) / 4.

    At t = top both terms are largest; the next crests are lower by less than (2 pi / w)^2, far
    more than the table of a run is held to.
    """
    w = 2.0 * math.pi * crests

    def gap(t: np.ndarray) -> np.ndarray:
        return 1.0 - (t - top) ** 2 + 0.25 * np.cos(w * (t - top))

    stop: Any = SimpleNamespace(gaps=lambda q: q)
    trajectory = SimpleNamespace(evaluate=lambda t, **_: SimpleNamespace(q=gap(t)))
    run: Any = SimpleNamespace(trajectory=trajectory, segments=[parts_of(0.0, 1.0, 2 * crests)])
    found = rebound_invariants._highest(run, stop, 0.0, 1.0)
    assert found == pytest.approx(1.25, rel=1e-9)
    before = rebound_invariants._highest(run, stop, 0.0, top - 0.5 / crests)
    wanted = gap(np.linspace(0.0, top - 0.5 / crests, 400_001)).max()
    assert before == pytest.approx(wanted, abs=0.125 * (w / 400_000) ** 2)


def test_highest_gap_of_a_motion() -> None:
    """A parabola's top to 1e-9 of its height; that of the higher of two stretches; or an end."""

    def gap(t: np.ndarray) -> np.ndarray:
        first = 0.3 - 5.0 * (t - 0.123) ** 2
        # They meet at t = 0.5.
        second = 0.5 - (0.2 + 5.0 * 0.377**2) * ((t - 0.876) / 0.376) ** 2
        return np.where(t <= 0.5, first, second)

    stop: Any = SimpleNamespace(gaps=lambda q: q)
    trajectory = SimpleNamespace(
        evaluate=lambda t, left: SimpleNamespace(q=gap(t - (1e-12 if left else -1e-12)))
    )
    segments = [parts_of(t, t + 0.5, 1) for t in (0.0, 0.5, 1.0)]
    run: Any = SimpleNamespace(trajectory=trajectory, segments=segments)
    assert rebound_invariants._highest(run, stop, 0.0, 1.0) == pytest.approx(0.5, rel=1e-9)
    assert rebound_invariants._highest(run, stop, 0.0, 0.5) == pytest.approx(0.3, rel=1e-9)
    assert rebound_invariants._highest(run, stop, 0.2, 0.4) == pytest.approx(
        0.3 - 5.0 * 0.077**2, rel=1e-9
    )
    assert rebound_invariants._highest(run, stop, 0.0, 0.1) == pytest.approx(
        0.3 - 5.0 * 0.023**2, rel=1e-9
    )


def test_segments_that_are_looked_at() -> None:
    """Twenty-four of many, evenly chosen, to the last time that is before their end."""
    panels = [object() for _ in range(70)]
    segments = [
        SimpleNamespace(
            pieces=lambda n=n: iter([(panels[n], n + 1.0, n + 2.0)]), panels=[panels[n]], source=n
        )
        for n in range(70)
    ]
    run: Any = SimpleNamespace(segments=segments)
    found = [*observations.samples(run)]
    places = [panels.index(panel) for _, panel, _ in found]
    assert (len(places), places[0], places[-1]) == (24, 0, 69)
    assert set(np.diff(places)) == {3}
    for place, (_, _, t) in zip(places, found, strict=True):
        assert t[0] == place + 1.0
        assert t[-1] == np.nextafter(place + 2.0, 0.0)


@pytest.mark.parametrize("parts", [2, 0])
def test_what_a_solution_shows(parts: int) -> None:
    """Motion, accelerations and forces at times; of the stops those that are closed."""
    t = np.array([1.0, 2.0, 4.0])
    numbers = np.multiply.outer(t, np.array([1.0, -2.0]))
    forces = SimpleNamespace(
        a=3.0 * numbers, closures={k: (k + 5.0) * numbers for k in range(parts)},
        drives={k: (k + 7.0) * t for k in range(parts)}, stops={k: ord(k) * t for k in "abc"},
    )  # fmt: skip
    given = {
        "evaluate": lambda at: SimpleNamespace(q=at[:, None] + numbers, v=2.0 * numbers),
        "reactions": lambda at: forces if at is t else None,
    }
    run: Any = SimpleNamespace(
        trajectory=SimpleNamespace(**given),
        mechanism=SimpleNamespace(stops=[SimpleNamespace(name=name) for name in "cba"]),
    )
    found = observations.shown(run, frozenset("ac"), t)
    assert np.array_equal(found.q, t[:, None] + numbers)
    assert np.array_equal(found.v, 2.0 * numbers)
    assert np.array_equal(found.a, 3.0 * numbers)
    closures = np.hstack([5.0 * numbers, 6.0 * numbers]) if parts else np.empty((3, 0))
    assert np.array_equal(found.closures, closures)
    drives = np.stack([7.0 * t, 8.0 * t], axis=1) if parts else np.empty((3, 0))
    assert np.array_equal(found.drives, drives)
    assert list(found.stops) == ["c", "a"]
    assert all(np.array_equal(found.stops[k], ord(k) * t) for k in "ac")

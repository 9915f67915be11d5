"""Numbers and units that refusals quote, moves of shapes with their links, and single readers."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest

from nipper_pin.errors import InputError, ModelError, UnknownNameError
from nipper_pin.mechanism import from_sources, with_numbers
from nipper_pin.mechanism.drives import Fourier, OscillatingGuide, Table
from nipper_pin.mechanism.edit.overrides import by_path
from nipper_pin.mechanism.edit.toml_paths import number_at, number_from, replace_value
from nipper_pin.mechanism.elements import Characteristic
from nipper_pin.mechanism.files.describe import describe
from nipper_pin.mechanism.files.urdf import check_urdf, parse_xml
from nipper_pin.mechanism.files.urdf_shapes import path_inside
from nipper_pin.mechanism.files.urdf_values import placed, rotation_from_rpy
from nipper_pin.mechanism.mechanism import Start
from tests.small_machines import frame, hinge, link, machine, slide, sources

PARTS = [link("lever"), hinge("pivot", "frame", "lever"), link("sled"),
         slide("rail", "frame", "sled", (0.6, 0.8))]  # fmt: skip
STOPS = {
    "low": {"joint": "pivot", "restitution": 0.1, "at_deg": -20.0},
    "high": {"joint": "pivot", "restitution": 0.1, "side": "upper", "at_deg": 30.0},
    "end": {"joint": "rail", "restitution": 0.1, "at_mm": -4.0},
}


def refused(parts: Any = PARTS, freedom: int = 2, **tables: Any) -> ModelError:
    with pytest.raises(ModelError) as caught:
        machine(parts, freedom, **tables)
    return caught.value


@pytest.mark.parametrize(
    ("joint", "start", "key", "value", "allowed"),
    [
        ("pivot", {"at_deg": 31.5}, "at_deg", 31.5, "that stop high leaves open; this is 1.5 deg"),
        ("pivot", {"at_deg": -22.25}, "at_deg", -22.25, "stop low leaves open; this is 2.25 deg"),
        ("rail", {"at_mm": -4.5}, "at_mm", -4.5, "stop end leaves open; this is 0.5 mm beyond"),
        ("rail", {"at_deg": 1.0}, "at_deg", 1.0, "prismatic joint rail starts with at_mm and rate"),
        ("pivot", {"rate_mm_per_s": 0.0}, "rate_mm_per_s", 0.0, "with at_deg and rate_rad_per_s"),
    ],
)
def test_starts_that_cannot_be(
    joint: str, start: dict[str, float], key: str, value: float, allowed: str
) -> None:
    evidence = refused(stops=STOPS, initial={joint: start}).evidence
    assert (evidence["key"], evidence["value"]) == (f"initial.{joint}.{key}", value)
    assert allowed in evidence["allowed"]


def test_starts_in_si_units() -> None:
    """At a stop is allowed; nothing given is zero; a driven joint and an unknown one have none."""
    initial = {"pivot": {"at_deg": 30.0, "rate_rad_per_s": -2.0},
               "rail": {"at_mm": 5.0, "rate_mm_per_s": 40.0}}  # fmt: skip
    mechanism = machine(PARTS, 2, stops=STOPS, initial=initial)
    pivot, rail = (next(j.index for j in mechanism.joints if j.name == n) for n in initial)
    assert mechanism.starts == (
        Start(joint="pivot", index=pivot, at=pytest.approx(math.pi / 6.0), rate=-2.0),
        Start(joint="rail", index=rail, at=pytest.approx(5e-3), rate=pytest.approx(0.04)),
    )
    still = machine(PARTS, 2, initial={"rail": {}}).starts[0]
    assert (still.at, still.rate) == (0.0, 0.0)
    drive = {"d": {"joint": "pivot", "law": "constant_speed", "ratio": 1.0}}
    told = refused(drives=drive, initial={"pivot": {"at_deg": 3.0}}).evidence
    assert (told["key"], told["value"]) == ("initial.pivot", 3.0)
    assert "drive d says where pivot starts" in told["allowed"]
    with pytest.raises(UnknownNameError, match=r"small\.toml: initial: .*'x'; known: pivot, rail"):
        machine(PARTS, 2, initial={"x": {}})


def test_freedoms_and_gaps_in_numbers() -> None:
    """Joints, rows and the names of closures; millimetres in both directions."""
    parts = [*PARTS, frame("a", "lever", (0.1, 0.0)), frame("b", "sled", (0.1, 0.0))]
    tie = {"tie": {"frame_a": "a", "frame_b": "b"}}
    told = refused(parts, 3, closures=tie).evidence
    assert told["key"] == "degrees_of_freedom"
    assert told["value"] == 3
    words = "the model has 0: 2 tree joints less two rows for each of 1 closures (tie);"
    assert words in told["allowed"]
    assert "0 closures (none)" in refused(PARTS, 1).evidence["allowed"]
    off = [*PARTS, frame("a", "lever", (0.1, 0.0)), frame("b", "sled", (0.103, 0.004))]
    told = refused(off, 2, closures=tie).evidence
    assert told["key"] == "closures.tie"
    assert told["value"] == "a gap of 5 mm (x 3, z 4) from a to b"
    assert "the frames meet within 1e-06 mm" in told["allowed"]
    slot = {"tie": {"frame_a": "a", "frame_b": "b", "slot_axis": "x", "block_mass_kg": 0.1}}
    told = refused(off, 1, closures=slot).evidence
    assert told["value"] == "a gap of 4 mm (x 0, z 4) from the slot along x of a to b"
    assert "the pin stands on the line of its slot" in told["allowed"]
    on = [*PARTS, frame("a", "lever", (0.1, 0.0)), frame("b", "sled", (0.103, 0.0))]
    told = refused(on, 4, closures=slot).evidence
    assert "has 1: 3 tree joints (1 of them blocks in slots) less two rows" in told["allowed"]
    assert machine(on, 1, closures=slot).closures[0].frame_a == "tie_block"


@pytest.mark.parametrize(
    ("stops", "key", "value", "allowed"),
    [
        ({"a": {"joint": "pivot", "restitution": 0.0, "at_mm": 1.0}}, "stops.a.at_mm", 1.0,
         "the place of a stop on the revolute joint pivot is at_deg"),
        ({"a": {"joint": "rail", "restitution": 0.0, "at_deg": 1.0}}, "stops.a.at_deg", 1.0,
         "the place of a stop on the prismatic joint rail is at_mm"),
        ({"a": {"joint": "rail", "restitution": 0.0},
          "b": {"joint": "rail", "restitution": 0.0, "at_mm": 3.0}}, "stops.b",
         "lower stop at 0.003", "'a' is on this side of rail already"),
        ({"a": {"joint": "rail", "restitution": 0.0, "at_mm": 3.0},
          "b": {"joint": "rail", "restitution": 0.0, "at_mm": 3.0, "side": "upper"}}, "stops.b",
         "upper stop at 0.003", "rail has no room to move between 'b' and 'a'"),
    ],
)  # fmt: skip
def test_stops_that_cannot_be(stops: Any, key: str, value: object, allowed: str) -> None:
    evidence = refused(stops=stops).evidence
    assert (evidence["key"], evidence["value"]) == (key, value)
    assert allowed in evidence["allowed"]


def test_slots_are_written_in_full() -> None:
    parts = [*PARTS, frame("a", "lever"), frame("b", "sled")]
    for given, missing in (
        ({"slot_axis": "x"}, "block_mass_kg"),
        ({"block_mass_kg": 1.0}, "slot_axis"),
    ):
        told = refused(parts, 1, closures={"t": {"frame_a": "a", "frame_b": "b", **given}})
        assert (told.evidence["key"], told.evidence["value"]) == (f"closures.t.{missing}", None)
    slot = {"frame_a": "a", "frame_b": "b", "slot_axis": "x", "block_mass_kg": 1.0}
    for name, more in (("pivot", []), ("t", [frame("t_block", "lever")])):
        told = refused([*parts, *more], 1, closures={name: slot})
        assert (told.evidence["key"], told.evidence["value"]) == (f"closures.{name}", name)
        assert f"as the link '{name}_block'" in told.evidence["allowed"]
    with pytest.raises(UnknownNameError, match=r"small.toml: closures.t.frame_b: .*'c'"):
        machine(parts, 1, closures={"t": {**slot, "frame_b": "c"}})


def test_shapes_and_mass_turn_with_the_line_of_two_pins() -> None:
    """A lever whose tip goes from the right to above: a quarter turn counter-clockwise.

    Rotations of a URDF about +y are clockwise.
    """
    shape = ('<collision name="bar"><origin xyz="0.1 0 0.05" rpy="0 0.3 0"/>'
             '<geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>')  # fmt: skip
    lever = link("lever", centre=(0.2, 0.01)).replace("</link>", shape)
    parts = [lever, hinge("pivot", "frame", "lever", (0.4, 0.1)), frame("tip", "lever", (0.3, 0.0))]
    moved = with_numbers(machine(parts, 1), {"points.tip.x_mm": 400.0, "points.tip.z_mm": 400.0})
    root = ElementTree.fromstring(moved.urdf)
    bar = root.find("link[@name='lever']/collision/origin")
    assert bar is not None
    assert set(bar.attrib) == {"xyz", "rpy"}
    place, turn = ([float(word) for word in bar.attrib[key].split()] for key in ("xyz", "rpy"))
    np.testing.assert_allclose(place, [-0.05, 0.0, 0.1], atol=1e-15)
    np.testing.assert_allclose(turn, [0.0, 0.3 - 0.5 * math.pi, 0.0], atol=1e-12)
    centre = root.find("link[@name='lever']/inertial/origin")
    assert centre is not None
    at = [float(word) for word in centre.attrib["xyz"].split()]
    np.testing.assert_allclose(at, [-0.01, 0.0, 0.2], atol=1e-15)
    assert "rpy" not in centre.attrib


def test_rotations() -> None:
    """Any three angles by Pinocchio, as a matrix and as a placement."""
    for angles in np.random.default_rng(5).uniform(-3.0, 3.0, (20, 3)):
        np.testing.assert_allclose(
            rotation_from_rpy(angles), pin.rpy.rpyToMatrix(*angles), atol=1e-14
        )
        np.testing.assert_allclose(
            placed(np.ones(3), angles).rotation, pin.rpy.rpyToMatrix(*angles), atol=1e-14
        )


def test_axes_of_unit_length_and_names_of_shapes() -> None:
    """Directions of any length; shapes without a name go by their link and place."""
    shape = "<collision{}><geometry><{}/></geometry></collision>"
    shapes = shape.format("", 'sphere radius="0.1"') + shape.format(' name="b"', 'box size="1 1 1"')
    parts = [PARTS[0].replace("</link>", f"{shapes}</link>"), *PARTS[1:3],
             slide("rail", "frame", "sled", (-3.0, 4.0))]  # fmt: skip
    root = parse_xml(f'<robot name="r"><link name="frame"/>{"".join(parts)}</robot>', "f")
    urdf = check_urdf(root, "f", Path())
    assert urdf.joints["rail"].axis == pytest.approx((-0.6, 0.0, 0.8))
    assert urdf.joints["pivot"].axis == (0.0, -1.0, 0.0)
    assert urdf.shapes == {"frame": (), "lever": ("lever_0", "b"), "sled": ()}
    assert (urdf.root, tuple(urdf.links)) == ("frame", ("frame", "lever", "sled"))
    heavy = PARTS[0].replace('iyy="1.0"', 'iyy="2.1"')
    told = refused([heavy, *PARTS[1:]]).evidence
    assert told["value"] == pytest.approx([1.0, 1.0, 2.1])
    assert "(2.1 > 2 kg m2; ixx = 1, iyy = 2.1, izz = 1)" in told["allowed"]
    machine([PARTS[0].replace('iyy="1.0"', 'iyy="2.0"'), *PARTS[1:]], 2)
    assert path_inside("package://any/a/b.stl", "k", "f") == "a/b.stl"
    for name in ("a:b", "a\\b", "package://only", "a/../../b", "/a", ""):
        with pytest.raises(ModelError) as caught:
            path_inside(name, "k", "f")
        assert (caught.value.evidence["key"], caught.value.evidence["value"]) == ("k mesh", name)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        (7, "8", 8), (7, "8.5", 8.5), (7.0, "8", 8.0), (7, np.int64(3), 3),
        (7, np.float32(0.5), 0.5),
        ("a", "8", "8"), (True, "false", False), (True, False, False), ([1, 2], "[3, 4]", [3, 4]),
        ([1, 2], (3, 4), [3, 4]), (7, "x", None), ([1], "[", None), (7.0, True, True),
    ],
)  # fmt: skip
def test_values_take_the_type_of_what_they_replace(old: Any, new: Any, expected: Any) -> None:
    document: dict[str, object] = {"a": {"b": [old]}}
    if expected is None:
        with pytest.raises(ModelError) as caught:
            replace_value(document, "a.b[0]", new, "f")
        evidence = caught.value.evidence
        assert (evidence["file"], evidence["key"], evidence["value"]) == ("f", "a.b[0]", new)
        return
    replace_value(document, "a.b[0]", new, "f")
    (found,) = document["a"]["b"]  # type: ignore[index]
    assert found == expected
    assert type(found) is type(expected)


def test_numbers_by_path() -> None:
    """Places are written in one way; a truth value, a text and a table are no numbers."""
    document = {"a": {"b": [3, 4.5, True]}, "t": "x", "e": [],
                "drives": {"d": {"law": "cam", "joint": "j"}}}  # fmt: skip
    assert number_at(document, "a.b[1]", "f") == 4.5
    assert isinstance(number_at(document, "a.b[0]", "f"), float)
    assert number_at(document, "drives.d.dwell_deg", "f") == 0.0
    for path in ("a.b[2]", "t", "a.b", "a"):
        with pytest.raises(ModelError, match="the path of one number"):
            number_at(document, path, "f")
    for path, known in (("a.b[3]", r"\[0\] to \[2\]"), ("a.b[01]", r"\[0\] to \[2\]"),
                        ("e[0]", "none"), ("a.c", "b"), ("t.x", "none")):  # fmt: skip
        with pytest.raises(UnknownNameError, match=f"known: {known}"):
            number_at(document, path, "f")
    assert number_from("1e3", "p", "f") == number_from(1000, "p", "f") == 1000.0
    for value in (True, None, [1.0], "much"):
        with pytest.raises(ModelError) as caught:
            number_from(value, "p", "f")
        assert (caught.value.evidence["key"], caught.value.evidence["value"]) == ("p", value)


def test_shortcuts_and_paths_name_a_number_once() -> None:
    data = {"shortcuts": {"k": "springs.s.k"}, "gravity_m_s2": 1.0}
    assert by_path({"k": 3, "gravity_m_s2": 2}, data, "f") == {"springs.s.k": 3, "gravity_m_s2": 2}
    with pytest.raises(ModelError) as caught:
        by_path({"k": 3, "springs.s.k": 4}, data, "f")
    assert caught.value.evidence["key"] == "springs.s.k"
    assert "k = 3 gives the same one" in caught.value.evidence["allowed"]
    with pytest.raises(UnknownNameError, match="'q'; known: gravity_m_s2, k, links, points"):
        by_path({"q": 3}, data, "f")


def test_laws_of_equal_numbers_are_equal() -> None:
    """What is prepared from the numbers is neither compared nor shown."""
    turn = np.linspace(0.0, math.tau, 9).tolist()
    for make in (
        lambda: Fourier(mean=0.1, cosine=(1.0,)),
        lambda: Table(cylinder_angle_rad=tuple(turn), coordinate=(0.0,) * 9),
        lambda: OscillatingGuide(crank_radius_m=1.0, crank_axis=(0.0, 0.0), guide_axis=(3.0, 0.0)),
        lambda: Characteristic(coordinate=(0.0, 1.0), force=(0.0, 2.0)),
    ):
        assert make() == make()
        assert " _" not in repr(make())
        assert "object at" not in repr(make())
    with pytest.raises(InputError):
        OscillatingGuide(crank_radius_m=3.0, crank_axis=(0.0, 0.0), guide_axis=(3.0, 0.0))


SPRING = {"joint": "rail", "stiffness_N_per_m": 1.0, "preload_length_mm": 0.0}


@pytest.mark.parametrize(
    ("tables", "key", "allowed"),
    [
        ({"title": ""}, "title", "a text that is not empty"),
        ({"phases": []}, "phases", "a list that is not empty"),
        ({"degrees_of_freedom": 0}, "degrees_of_freedom", "a whole number at least 1"),
        ({"springs": {"a": {**SPRING, "stiffness_N_per_m": 0.0}}}, "springs.a.stiffness_N_per_m",
         "a number above 0 and at most 1e+15; a force that does not rise is given by the rows of a "
         "table on a joint"),
        ({"springs": {"a": {**SPRING, "stiffness_N_per_m": 1.1e15}}}, "springs.a.stiffness_N_per_m",
         "a finite number of at most 1e+15"),
        ({"dampers": {"a": {"joint": "rail", "damping_N_s_per_m": -1e-9}}},
         "dampers.a.damping_N_s_per_m", "a number at least 0 and at most 1e+15"),
        ({"dampers": {"a": {"joint": "rail", "damping_N_s_per_m": 1.1e15}}},
         "dampers.a.damping_N_s_per_m", "a finite number of at most 1e+15"),
        ({"stops": {"a": {"joint": "rail", "restitution": 1.01}}}, "stops.a.restitution",
         "a number at least 0 and at most 1"),
        ({"gravity_m_s2": -0.1}, "gravity_m_s2", "a number at least 0"),
    ],
)  # fmt: skip
def test_limits_in_words(tables: dict[str, Any], key: str, allowed: str) -> None:
    urdf, document = sources(PARTS, 2)
    with pytest.raises(ModelError) as caught:
        from_sources("small", urdf, {**document, **tables}, ".")
    assert (caught.value.evidence["key"], caught.value.evidence["allowed"]) == (key, allowed)


def test_the_limits_themselves_are_allowed() -> None:
    """The stiffest spring, no damping and the strongest, restitution 0 and 1."""
    stops = {"a": {"joint": "rail", "restitution": 1.0}, "b": {"joint": "pivot", "restitution": 0}}
    dampers = {"a": {"joint": "rail", "damping_N_s_per_m": 1e15},
               "b": {"joint": "pivot", "damping_N_m_s_per_rad": 0.0}}  # fmt: skip
    springs = {"a": {**SPRING, "stiffness_N_per_m": 1e15}}
    found = machine(PARTS, 2, stops=stops, dampers=dampers, springs=springs)
    assert [item.damping for item in found.dampers] == [1e15, 0.0]
    assert found.springs[0].stiffness == 1e15
    assert [item.restitution for item in found.stops] == [1.0, 0.0]
    assert [item.side for item in describe(found.description, "f").stops.values()] == ["lower"] * 2

"""Dimensions as parameters: points, links and single numbers of the URDF by path."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest
from small_machines import frame, hinge, machine, slide
from small_machines import link as body

from nipper_pin import AssemblyError, Mechanism, ModelError, load
from nipper_pin.mechanism import changed, joint_placements, number_of
from nipper_pin.mechanism.build.closures import closure_gaps
from nipper_pin.mechanism.edit import Layout, read_layout
from nipper_pin.mechanism.edit.paths import find_value
from nipper_pin.mechanism.files import parse_xml
from tests.refusals.bases import model

MODELS = ["e62", "e62_offset_guide", "hanging_pendulum"]


def layout(mechanism: Mechanism) -> Layout:
    return read_layout(parse_xml(mechanism.urdf, "urdf"), mechanism.description, "urdf")


def places(mechanism: Mechanism) -> dict[str, np.ndarray]:
    """World places (x, z) at touch of all frames [mm], by Pinocchio."""
    model = mechanism.model
    data = model.createData()
    pin.framesForwardKinematics(model, data, np.zeros(model.nq))
    return {
        frame.name: 1e3 * data.oMf[place].translation[[0, 2]]
        for place, frame in enumerate(model.frames)
        if frame.type in (pin.FrameType.BODY, pin.FrameType.JOINT)
    }


@pytest.mark.parametrize("name", MODELS)
def test_every_point_moves_alone_and_nothing_comes_apart(name: str) -> None:
    """Each pin of each comber goes where it is told, no other pin moves, every closure is closed.

    Places are those of Pinocchio's kinematics of the changed URDF, not those that were written; all
    coordinates are zero there. 1e-9 mm is round-off of 300 mm, a thousand times over. A move that
    changes one link only opens a closure by 0.3 mm, which the loader refuses.
    """
    mechanism = load(name)
    found = layout(mechanism)
    before = places(mechanism)
    for point, pins in found.meeting.items():
        x, z = found.point_mm(point)
        path = f"points.{point}"
        moved = load(name, {f"{path}.x_mm": x + 0.3, f"{path}.z_mm": z - 0.2})
        after = places(moved)
        gaps = closure_gaps(moved.closures, moved.model, joint_placements(moved.model))
        assert np.abs(gaps).max() < 1e-12
        for other, link in found.points.items():
            shift = [0.3, -0.2] if other in pins else [0.0, 0.0]
            np.testing.assert_allclose(after[link] - before[link], shift, rtol=0.0, atol=1e-9)
        for drive in moved.description["drives"].values():  # type: ignore[attr-defined]
            if "guide_axis_mm" in drive:
                shaft = after["pendulum_shaft"]
                np.testing.assert_allclose(drive["guide_axis_mm"], shaft, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("name", MODELS)
def test_masses_stay_where_they_are_unless_their_link_turns(name: str) -> None:
    """Moving the jaw's pivot leaves every centre of mass in the world: the lips still meet."""
    x, z = layout(load(name)).point_mm("jaw")
    moved = load(name, {"points.jaw.x_mm": x + 1.0, "points.jaw.z_mm": z + 1.0})
    for link in moved.links:
        for key in ("com_x_mm", "com_z_mm", "mass_kg", "inertia_kg_m2"):
            path = f"links.{link}.{key}"
            assert number_of(moved, path) == pytest.approx(
                number_of(load(name), path), rel=1e-12, abs=1e-9
            )
    contact, original = (item.stop("jaw").contact for item in (moved, load(name)))
    assert contact is not None
    assert original is not None
    np.testing.assert_allclose(contact.point, original.point, rtol=0.0, atol=1e-6)


def test_a_pin_in_a_slot_goes_its_own_way() -> None:
    """Along the slot, whose frame stays where it is; off its line it opens the closure."""
    parts = [body("crank"), hinge("shaft", "frame", "crank"),
             frame("crank_pin", "crank", (0.05, 0.0)), body("yoke"),
             slide("rail", "frame", "yoke"), frame("guide", "yoke", (0.05, 0.0))]  # fmt: skip
    slot = {"frame_a": "guide", "frame_b": "crank_pin", "slot_axis": "z", "block_mass_kg": 0.1}
    yoke = machine(parts, 1, closures={"slot": slot})
    before = places(yoke)
    assert layout(yoke).meeting["crank_pin"] == ("crank_pin",)
    moved = places(changed(yoke, {"points.crank_pin.z_mm": 20.0}))
    for name in ("crank_pin", "guide", "yoke", "crank"):
        shift = [0.0, 20.0] if name == "crank_pin" else [0.0, 0.0]
        np.testing.assert_allclose(moved[name] - before[name], shift, rtol=0.0, atol=1e-9)
    with pytest.raises(AssemblyError, match=r"a gap of 1 mm \(x 1, z 0\)"):
        changed(yoke, {"points.crank_pin.x_mm": 51.0})
    both = {"points.crank_pin.x_mm": 51.0, "points.guide.x_mm": 51.0}
    assert places(changed(yoke, both))["guide"] == pytest.approx([51.0, 0.0], abs=1e-9)


def test_a_chain_of_polar_points_is_followed_from_the_frame_outwards() -> None:
    """Two lengths and an angle at once, in either order of the overrides, give one machine.

    A length is the distance of a pin from the hinge of its link, along the same line.
    """
    values = {
        "points.rocker_pin.radius_mm": 188.0,
        "points.nipper_pivot.radius_mm": 66.5,
        "points.nipper_pivot.angle_deg": 95.0,
    }
    found = [load("e62", dict(order)) for order in itertools.permutations(values.items())]
    for mechanism in found:
        assert mechanism.urdf == found[0].urdf or mechanism.model == found[0].model
        after = places(mechanism)
        pivot = np.array([-190.0, -20.0]) + 66.5 * np.array(
            [math.cos(math.radians(95.0)), math.sin(math.radians(95.0))]
        )
        np.testing.assert_allclose(after["bottom_nipper"], pivot, rtol=0.0, atol=1e-9)
        arm = after["rocker"] - after["bottom_nipper"]
        assert np.hypot(*arm) == pytest.approx(188.0, abs=1e-9)
    after, start = (
        places(load("e62", chosen)) for chosen in ({"points.rocker_pin.radius_mm": 190.0}, {})
    )
    arm, line = (item["rocker"] - item["bottom_nipper"] for item in (after, start))
    assert np.hypot(*arm) == pytest.approx(190.0, abs=1e-9)
    assert math.atan2(*arm) == pytest.approx(math.atan2(*line), abs=1e-12)


def test_a_hinge_goes_before_what_is_seen_from_it_whatever_their_names() -> None:
    """The crank's pin and the coupler's end, which stands before it in the alphabet, at once."""
    values = {"points.coupler_end.radius_mm": 310.0, "points.crank_pin.angle_deg": 70.0}
    model = Path(__file__).parents[1] / "verification" / "models" / "four_bar"
    before = layout(load(model))
    for order in itertools.permutations(values.items()):
        moved = load(model, dict(order))
        shaft = np.array(before.point_mm(before.hinge_below("crank_pin")))
        pin_at, end = (
            np.array(layout(moved).point_mm(name)) for name in ("crank_pin", "coupler_end")
        )
        crank = pin_at - shaft
        assert math.degrees(math.atan2(crank[1], crank[0])) == pytest.approx(70.0, abs=1e-9)
        assert np.hypot(*(end - pin_at)) == pytest.approx(310.0, abs=1e-9)


def test_centre_of_mass_is_where_it_was_asked_for_also_when_its_link_moves() -> None:
    values = {
        "points.rod_pin.x_mm": -20.0,
        "points.jaw.z_mm": 103.0,
        "links.top_nipper.com_x_mm": -25.0,
        "links.top_nipper.com_z_mm": 101.5,
        "links.top_nipper.mass_kg": "1.4",
        "links.top_nipper.gyration_mm": 32.0,
    }
    mechanism = load("e62", values)
    for path, wanted in values.items():
        assert number_of(mechanism, path) == pytest.approx(float(wanted), abs=1e-9)  # type: ignore[arg-type]
    model = mechanism.model
    body = model.inertias[model.getJointId("jaw")]
    # Comments of the file stay.
    assert "never the\n  maker's data" in mechanism.urdf
    assert body.mass == 1.4
    assert body.inertia[1, 1] == pytest.approx(1.4 * 0.032**2, rel=1e-12)


def test_axes_and_angles_have_letters_and_places(e62: Mechanism) -> None:
    for path in ("joint.rod_pin.origin.xyz", "link.rocker.collision.rocker_arm_left.origin.rpy"):
        letters, places = (
            [number_of(e62, f"urdf.{path}{end}") for end in ends]
            for ends in ([f".{letter}" for letter in path[-3:]], ["[0]", "[1]", "[2]"])
        )
        assert letters == places


def test_shapes_without_a_name_go_by_their_place() -> None:
    """Each of four spheres has a radius of its own, so the one that is read tells itself."""
    sphere = '<collision {}><geometry><sphere radius="{}"/></geometry></collision>'
    first = "".join(sphere.format(*item) for item in (("", 1), ('name="b.c"', 2), ("", 3)))
    text = (
        f'<robot><link name="a">{first}</link><link name="d">{sphere.format("", 4)}</link></robot>'
    )
    for place, radius in {"a.collision[0]": 1.0, "a.collision.b.c": 2.0, "a.collision[2]": 3.0,
                          "d.collision": 4.0, "d.collision[0]": 4.0}.items():  # fmt: skip
        path = f"urdf.link.{place}.geometry.sphere.radius"
        assert find_value(parse_xml(text, "urdf"), path).read(path, "urdf") == radius


def test_own_values_written_back_change_nothing() -> None:
    """Every path of points and links, with the value that it has: the same machine, bit for bit."""
    mechanism = load("hanging_pendulum")
    found = layout(mechanism)
    values = {}
    for point in found.points:
        values[f"points.{point}.x_mm"], values[f"points.{point}.z_mm"] = found.point_mm(point)
    for link in mechanism.links:
        for key in ("mass_kg", "inertia_kg_m2"):
            values[f"links.{link}.{key}"] = number_of(mechanism, f"links.{link}.{key}")
    again = load("hanging_pendulum", values)
    np.testing.assert_array_equal(
        [item.translation for item in again.model.jointPlacements],
        [item.translation for item in mechanism.model.jointPlacements],
    )
    for one, other in zip(again.model.inertias, mechanism.model.inertias, strict=True):
        assert one == other


ENDS = '<parent link="frame"/>\n    <child link="pendulum_arm"/>'


@pytest.mark.parametrize(
    ("edits", "words"),
    [(('frame_a = "rocker_foot"', "frame_a = 3"), r"closures\.rocker_axis\.frame_a = 3"),
     ((ENDS, ENDS.replace("frame", "rocker")), "joints that hang from the frame")],
)  # fmt: skip
def test_a_mistake_of_a_file_is_told_before_points_move(
    edits: tuple[str, str], words: str, tmp_path: Path
) -> None:
    """Points follow closures, guides and the tree of the joints."""
    with pytest.raises(ModelError, match=words):
        load(model("e62", edits, tmp_path), {"points.jaw.x_mm": -72.0})


def test_shapes_and_mass_turn_with_the_line_of_two_pins() -> None:
    """A lever whose tip goes from the right to above: a quarter turn counter-clockwise.

    Rotations of a URDF about +y are clockwise.
    """
    shape = ('<collision name="bar"><origin xyz="0.1 0 0.05" rpy="0 0.3 0"/>'
             '<geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>')  # fmt: skip
    lever = body("lever", centre=(0.2, 0.01)).replace("</link>", shape)
    parts = [lever, hinge("pivot", "frame", "lever", (0.4, 0.1)), frame("tip", "lever", (0.3, 0.0))]
    moved = changed(machine(parts, 1), {"points.tip.x_mm": 400.0, "points.tip.z_mm": 400.0})
    root = ElementTree.fromstring(moved.urdf)
    bar = root.find("link[@name='lever']/collision/origin")
    assert bar is not None
    assert set(bar.attrib) == {"xyz", "rpy"}
    place, turn = ([float(word) for word in bar.attrib[key].split()] for key in ("xyz", "rpy"))
    np.testing.assert_allclose(place, [-0.05, 0.0, 0.1], rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(turn, [0.0, 0.3 - 0.5 * math.pi, 0.0], rtol=0.0, atol=1e-12)
    centre = root.find("link[@name='lever']/inertial/origin")
    assert centre is not None
    at = [float(word) for word in centre.attrib["xyz"].split()]
    np.testing.assert_allclose(at, [-0.01, 0.0, 0.2], rtol=0.0, atol=1e-15)
    assert "rpy" not in centre.attrib

"""Drawings of machines: points, bodies and joints that become a model."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from snapshots import Words

from nipper_pin import InputError, load
from nipper_pin.mechanism.drawing import (
    Body,
    Damper,
    Drawing,
    Drive,
    Force,
    Pin,
    Slide,
    Slot,
    Spring,
    Start,
    Stop,
    Tie,
    between,
    direction,
    distance,
    drawn_mechanism,
    drawn_sources,
    flap,
    meet,
    on_line,
    polar,
    telescope,
    write_drawing,
)
from nipper_pin.mechanism.drawing.places import place, vector
from nipper_pin.mechanism.drawing.urdf_text import mass_of
from nipper_pin.mechanism.files import toml
from nipper_pin.mechanism.gallery import GALLERY, drawn
from nipper_pin.view.sketch import sketch

POINTS = {
    "O": (10.0, 5.0), "A": (30.0, 5.0), "Y": (10.0, 40.0), "F": (0.0, -50.0), "R": (90.0, 0.0),
}  # fmt: skip
# Every kind of part.
PARTS = (
    Body("crank", "O A", 2.0),
    Body("yoke", "Y", mass_kg=1.5, radius_mm=20.0),
    Body("lever", "A O F F", mass_kg=0.9),
    Body("ram", "R", mass_kg=4.0, inertia_kg_m2=0.03, centre_mm=(95.0, 2.0)),
    Pin("O", "frame", "crank"),
    Slide("lift", "frame", "yoke", "Y", "O Y"),
    Slide("feed", "frame", "ram", "R", (3.0, 4.0)),
    Slot("slot", "yoke", "crank", "A", "O A", 0.05),
    Pin("A", "crank", "lever"),
    Tie("coil", ("yoke Y", "frame F"), 100.0, 40.0),
    Damper("lift", 3.0),
    Damper("A", 0.1),
    Spring("A", 2.0, 30.0),
    Spring("lift", 500.0, 4.0),
    Stop("A", "upper", 45.0, 0.3, name="open"),
    Stop("A", "lower", -40.0, 0.1, name="shut"),
    Stop("lift", "lower", -60.0),
    Drive("O", inertia=0.2, frequency_hz=30.0, damping_ratio=0.5),
    Drive("feed", "screw", {"lead_mm_per_turn": 7.0}, 8.0, 20.0, 0.4),
)
YOKE = Drawing(
    "yoke", "a <yoke>", POINTS, PARTS, 12.0, -40.0, 60.0, clockwise=True, struck="shut",
    gravity_m_s2=3.0, known="a book", invented="made up",
)  # fmt: skip
BARE = Drawing("bare", "bare", POINTS, (Body("crank", "O A"), Pin("O", "frame", "crank"),
                                        Drive("O")), 0.0, 0.0, 60.0)  # fmt: skip
CLOSED = Drawing("c", "c", POINTS, (*PARTS[:17], PARTS[18]), 0.0, 0.0, 60.0, closed=("lift",))

PRESS_PARTS = (
    Body("crank", "O A"), Body("ram", "B", mass_kg=1.5), Pin("O", "frame", "crank"),
    Pin("A", "crank", "rod_1"), *telescope("rod", "A B", 20000.0, 10.0),
    Slide("height", "frame", "ram", "B", (0.0, 1.0)), Pin("B", "rod_2", "ram"), Drive("O"),
    Stop("height"),
)  # fmt: skip
PRESS = Drawing(
    "press", "a press", {"O": (0.0, 0.0), "A": (-15.0, -20.0), "B": (0.0, -132.0)}, PRESS_PARTS,
    -126.87, -270.0, 120.0, closed=("rod",),
)  # fmt: skip


def test_files_of_drawings(words: Words) -> None:
    """Units by the kind of each joint; what is not given is not written; places of what is seen.

    Without stops, springs and dampers there are no tables of them.
    """
    texts = {drawing.name: drawn_sources(drawing) for drawing in (YOKE, BARE, CLOSED)}
    shown = [f"--- {name}.toml\n{toml(document)}" for name, (_, document) in texts.items()]
    words("\n".join([f"--- yoke.urdf\n{texts['yoke'][0]}", *shown]))


def test_a_written_drawing_is_read_back(tmp_path: Path) -> None:
    folder = write_drawing(PRESS, tmp_path / "mine")
    mechanism = load(folder)
    assert (mechanism.name, mechanism.title) == ("mine", "a press")
    assert mechanism.description == drawn_mechanism(PRESS).description
    assert sorted(item.name for item in folder.iterdir()) == [
        "mine.toml", "mine.urdf", "model.schema.json",
    ]  # fmt: skip


def test_points_that_circles_and_lines_give() -> None:
    """3-4-5 triangles, and a line beside a circle's centre."""
    assert meet((0.0, 0.0), 3.0, (5.0, 0.0), 4.0, left=True) == pytest.approx((1.8, 2.4))
    assert meet((0.0, 0.0), 3.0, (5.0, 0.0), 4.0, left=False) == pytest.approx((1.8, -2.4))
    assert on_line((0.0, 3.0), 5.0, (9.0, 0.0), (2.0, 0.0), ahead=True) == pytest.approx((4.0, 0.0))
    assert on_line((0.0, 3.0), 5.0, (9.0, 0.0), (-2.0, 0.0), ahead=True)[0] == pytest.approx(-4.0)
    assert polar((1.0, 1.0), 2.0, 90.0) == pytest.approx((1.0, 3.0))
    assert between((0.0, 0.0), (4.0, 0.0), 0.25, 2.0) == pytest.approx((1.0, 2.0))
    assert direction((1.0, 1.0), (1.0, 5.0)) == pytest.approx(90.0)
    assert distance((1.0, 1.0), (4.0, 5.0)) == pytest.approx(5.0)
    points = {"A": (0.0, 2.0), "B": (4.0, 6.0)}
    assert place(points, "B/A") == (2.0, 4.0)
    assert vector(points, "A B") == (4.0, 4.0)
    assert vector(points, (1.0, 3.0)) == (1.0, 3.0)


def test_mass_of_rods_and_discs() -> None:
    """A right angle of two rods, by hand; a disc; numbers that are given."""
    points = {"A": (0.0, 0.0), "B": (300.0, 0.0), "C": (300.0, 300.0)}
    bent = mass_of(Body("bent", "A B C", 2.0), points)
    assert bent.mass == pytest.approx(1.2)
    assert bent.centre == pytest.approx((225.0, 75.0))
    # Two rods of 0.6 kg and 0.3 m, each centre 0.075 sqrt(2) m from that of both.
    assert bent.inertia == pytest.approx(2.0 * 0.6 * (0.09 / 12.0 + 2.0 * 0.075**2))
    disc = mass_of(Body("disc", "A", mass_kg=2.0, radius_mm=100.0), points)
    assert (disc.mass, disc.centre) == (2.0, (0.0, 0.0))
    assert disc.inertia == pytest.approx(0.5 * 2.0 * 0.01)


def test_every_number_of_the_urdf() -> None:
    """Places of joints and frames, axes, masses, centres and inertias, by Pinocchio."""
    mechanism = drawn_mechanism(YOKE)
    model = mechanism.model
    data = model.createData()
    pin.framesForwardKinematics(model, data, np.zeros(model.nq))
    kinds = {joint.name: (joint.kind, joint.parent, joint.child) for joint in mechanism.joints}
    assert kinds["O"] == ("revolute", "frame", "crank")
    assert kinds["lift"] == ("prismatic", "frame", "yoke")
    assert kinds["A"] == ("revolute", "crank", "lever")
    for frame, at in (
        ("crank", "O"), ("lever", "A"), ("yoke", "Y"), ("ram", "R"), ("slot_line", "A"),
        ("crank_A", "A"), ("yoke_Y", "Y"), ("frame_F", "F"),
    ):  # fmt: skip
        found = data.oMf[model.getFrameId(frame)].translation
        x, z = POINTS[at]
        np.testing.assert_allclose(
            found, [1e-3 * x, 0.0, 1e-3 * z], rtol=0.0, atol=1e-15, err_msg=frame
        )
    # 0.9 kg over 20 and sqrt(10^2 + 55^2) mm.
    long = math.hypot(10.0, 55.0)
    first, second = 0.9 * 20.0 / (20.0 + long), 0.9 * long / (20.0 + long)
    centre = ((first * 20.0 + second * 5.0) / 0.9, (first * 5.0 - second * 22.5) / 0.9)
    about = first * (400.0 / 12.0 + math.dist(centre, (20.0, 5.0)) ** 2)
    about += second * (long**2 / 12.0 + math.dist(centre, (5.0, -22.5)) ** 2)
    bodies = {
        # Two kilograms a metre over 20 mm; a disc; what is given.
        "O": (0.04, (20.0, 5.0), 0.04 * 4e-4 / 12.0),
        "lift": (1.5, (10.0, 40.0), 0.5 * 1.5 * 4e-4),
        "feed": (4.0, (95.0, 2.0), 0.03),
        "A": (0.9, centre, 1e-6 * about),
    }
    for joint, (mass, (x, z), inertia) in bodies.items():
        number = model.getJointId(joint)
        body = model.inertias[number]
        assert body.mass == pytest.approx(mass, rel=1e-12)
        world = data.oMi[number].act(body.lever)
        np.testing.assert_allclose(world, [1e-3 * x, 0.0, 1e-3 * z], rtol=0.0, atol=1e-12)
        assert body.inertia[1, 1] == pytest.approx(inertia, rel=1e-9)
    still = {joint: data.oMi[model.getJointId(joint)].translation.copy() for joint in model.names}
    for joint, along in (("lift", (0.0, 1.0)), ("feed", (0.6, 0.8)), ("slot", (1.0, 0.0))):
        q = np.zeros(model.nq)
        q[model.joints[model.getJointId(joint)].idx_q] = 1e-3
        pin.forwardKinematics(model, data, q)
        moved = data.oMi[model.getJointId(joint)].translation - still[joint]
        np.testing.assert_allclose(moved[[0, 2]], 1e-3 * np.array(along), rtol=0.0, atol=1e-12)


def test_groups_of_parts() -> None:
    """A rod that gets longer or shorter, and a lever between two stops to either side."""
    shorter, longer = (telescope("rod", "A B", 2e4, 3.0, longer=how) for how in (False, True))
    assert shorter[:2] == (Body("rod_1", "A A/B", 1.0), Body("rod_2", "A/B B", 1.0))
    assert shorter[2] == Slide("rod", "rod_1", "rod_2", "A/B", "B A")
    assert longer[2] == Slide("rod", "rod_1", "rod_2", "A/B", "A B")
    assert shorter[3:] == longer[3:] == (Spring("rod", 2e4, 3.0), Stop("rod", restitution=0.2))
    left, right = (flap("lid", "box", "A B", 2.0, 15.0, gap) for gap in (40.0, -40.0))
    for parts, sense, sides in ((left, 1.0, ("lower", "upper")), (right, -1.0, ("upper", "lower"))):
        assert parts == (
            Body("lid", "A B", 0.5), Pin("A", "box", "lid", "lid"),
            Spring("lid", 2.0, sense * 15.0), Stop("lid", sides[0], 0.0, 0.4),
            Stop("lid", sides[1], sense * 40.0, 0.4, "lid_open"),
        )  # fmt: skip
    assert telescope("r", "A B", 1.0, 1.0, density_kg_m=3.0, restitution=0.5)[1].density_kg_m == 3.0  # type: ignore[union-attr]


def test_several_elements_on_one_joint() -> None:
    """All of them are in the model, in its sketch too; one element has the name of its joint."""
    law = {"c_N_s2_per_m2": 2.0}
    more = (
        Spring("rod", 5000.0, -3.0), Spring("rod", 1000.0), Damper("rod", 2.0), Damper("rod", 3.0),
        Force("rod", "orifice", law), Force("rod", "orifice", law),
        Tie("rod", ("ram B", "frame O"), 10.0, 9.0),
    )  # fmt: skip
    mechanism = drawn_mechanism(replace(PRESS, parts=(*PRESS_PARTS, *more)))
    found = {item.name: (item.stiffness, item.preload) for item in mechanism.springs}
    assert found == {"rod": (20000.0, 0.01), "rod_2": (5000.0, -0.003), "rod_3": (1000.0, 0.0)}
    assert [item.name for item in mechanism.struts] == ["rod_4"]
    assert [(item.name, item.damping) for item in mechanism.dampers] == [("rod", 2.0), ("rod_2", 3)]
    assert [item.name for item in mechanism.forces] == ["rod", "rod_2"]
    nodes = {node.name: node.spring for node in sketch(mechanism).nodes}
    assert nodes["rod"] == "rod, rod_2, rod_3"


def test_what_cannot_be_drawn_is_refused(words: Words) -> None:
    points = {"A": (0.0, 2.0), "B": (4.0, 6.0)}
    refused = {
        "circles apart": lambda: meet((0.0, 0.0), 1.0, (5.0, 0.0), 1.0, left=True),
        "line apart": lambda: on_line((0.0, 3.0), 1.0, (0.0, 0.0), (1.0, 0.0), ahead=True),
        **{f"point {name!r}": lambda name=name: place(points, name)
           for name in ("C", "A/C", "A/B/A", "")},
        "body of one point": lambda: mass_of(Body("bare", "A"), points),
        "stop that is none": lambda: drawn_mechanism(replace(PRESS, closed=("anvil",))),
    }  # fmt: skip
    more = {
        "two stops": (Stop("height", "upper", 5.0),),
        "two drives": (Drive("O"),),
        "two starts": (Start("height", 1.0), Start("height", 2.0)),
        "loose body": (Body("loose", "O B"),),
        "no body": (Pin("A", "crank", "nobody"),),
        "no point": (Pin("Z", "frame", "ram"),),
        "two bodies": (Body("ram", "O B"),),
        "two joints": (Slide("height", "frame", "ram", "B", (0.0, 1.0)),),
        "slide that closes": (Slide("other", "frame", "ram", "B", (0.0, 1.0)),),
        "stop of a pin that closes": (Stop("B"),),
    }
    for name, parts in more.items():
        drawing = replace(PRESS, parts=(*PRESS_PARTS, *parts))
        refused[name] = lambda drawing=drawing: drawn_mechanism(drawing)
    text = ""
    for name, draw in refused.items():
        with pytest.raises(InputError) as caught:
            draw()
        text += f"{name}\n    {caught.value.message}\n"
    words(text)


def test_any_plain_document_reads_back() -> None:
    """Both truth values, quotes, strokes and line breaks, odd keys, lists and tables in lists."""
    document = {
        "yes": True, "no": False, "text": 'a "b" \\ c\nd', "list": [1, 2.5, [True, "x"]],
        "a key": {"x.y": 1, "deep": {"er": [{"n": 1}, {"n": 2, "in": {"m": False}}]}}, "last": {},
    }  # fmt: skip
    assert tomllib.loads(toml(document)) == document


def _numpy(value: Any) -> Any:
    """The same data with numbers and places of numpy."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        names = [item.name for item in dataclasses.fields(value)]
        return replace(value, **{name: _numpy(getattr(value, name)) for name in names})
    if isinstance(value, Mapping):
        return {key: _numpy(item) for key, item in value.items()}
    if isinstance(value, tuple) and value and all(isinstance(item, float) for item in value):
        return np.array(value)
    if isinstance(value, tuple | list):
        return type(value)(_numpy(item) for item in value)
    kinds: dict[type, Any] = {bool: np.bool_, int: np.int64, float: np.float64, str: np.str_}
    return kinds[type(value)](value) if type(value) in kinds else value


@pytest.mark.sampled(8)
@pytest.mark.parametrize("name", sorted(GALLERY))
def test_numbers_of_numpy_are_written_as_plain_ones(name: str) -> None:
    """Every value type of a drawing: the texts are those of the same drawing in plain numbers."""
    drawing = drawn(name)
    (urdf, document), plain = drawn_sources(_numpy(drawing)), drawn_sources(drawing)
    assert (urdf, toml(document)) == (plain[0], toml(plain[1]))
    assert "np." not in urdf + toml(document)

"""Drawings of machines: points, bodies and joints that become a model."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

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
    meet,
    on_line,
    polar,
    telescope,
    write_drawing,
)
from nipper_pin.mechanism.drawing.masses import mass_of
from nipper_pin.view.sketch import sketch

POINTS = {"O": (0.0, 0.0), "A": (-15.0, -20.0), "B": (0.0, -132.0)}
PARTS = (
    Body("crank", "O A"),
    Body("ram", "B", mass_kg=1.5),
    Pin("O", "frame", "crank"),
    Pin("A", "crank", "rod_1"),
    *telescope("rod", "A B", 20000.0, 10.0),
    Slide("height", "frame", "ram", "B", (0.0, 1.0)),
    Pin("B", "rod_2", "ram"),
    Drive("O"),
    Stop("height"),
)
ENDS = ("ram B", "frame O")
PRESS = Drawing("press", "a press", POINTS, PARTS, -126.87, -270.0, 120.0, closed=("rod",))


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
    with pytest.raises(InputError, match="no point is 1 mm from"):
        meet((0.0, 0.0), 1.0, (5.0, 0.0), 1.0, left=True)
    with pytest.raises(InputError, match="further than 1 mm"):
        on_line((0.0, 3.0), 1.0, (0.0, 0.0), (1.0, 0.0), ahead=True)


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
    given = mass_of(
        Body("given", "A B", mass_kg=3.0, centre_mm=(1.0, 2.0), inertia_kg_m2=0.4), points
    )
    assert (given.mass, given.centre, given.inertia) == (3.0, (1.0, 2.0), 0.4)
    with pytest.raises(InputError, match="has one point"):
        mass_of(Body("bare", "A"), points)


def test_a_drawing_is_the_model_that_one_writes_by_hand() -> None:
    """Places, masses, freedoms and elements of the slider-crank of the tutorial."""
    mechanism = drawn_mechanism(PRESS)
    assert {joint.name for joint in mechanism.joints} == {"O", "A", "rod", "height"}
    assert mechanism.degrees_of_freedom == 2
    assert [closure.name for closure in mechanism.closures] == ["B"]
    rod = next(joint for joint in mechanism.joints if joint.name == "rod")
    place = mechanism.model.jointPlacements[mechanism.model.getJointId("rod")].translation
    assert np.allclose(place, (0.0075, 0.0, -0.056))
    assert rod.kind == "prismatic"
    mass = mechanism.model.inertias[mechanism.model.getJointId("rod")].mass
    assert mass == pytest.approx(1e-3 * 0.5 * math.hypot(15.0, 112.0))
    assert mechanism.stop("rod").restitution == 0.2
    assert mechanism.description["springs"]["rod"]["preload_length_mm"] == 10.0


def test_a_written_drawing_is_read_back(tmp_path: Path) -> None:
    folder = write_drawing(PRESS, tmp_path / "mine")
    mechanism = load(folder)
    assert (mechanism.name, mechanism.title) == ("mine", "a press")
    assert mechanism.description == drawn_mechanism(PRESS).description
    assert sorted(item.name for item in folder.iterdir()) == [
        "mine.toml", "mine.urdf", "model.schema.json",
    ]  # fmt: skip


def test_every_kind_of_part() -> None:
    """A yoke with slot, tie and damper; units of hinges."""
    points = {"O": (0.0, 0.0), "A": (20.0, 0.0), "Y": (0.0, 0.0), "F": (0.0, -50.0)}
    parts = (
        Body("crank", "O A"),
        Body("yoke", "Y", mass_kg=1.0),
        Body("flap", "A O"),
        Pin("O", "frame", "crank"),
        Slide("lift", "frame", "yoke", "Y", (0.0, 1.0)),
        Slot("slot", "yoke", "crank", "A", "O A", 0.05),
        Pin("A", "crank", "flap"),
        Tie("coil", ("yoke Y", "frame F"), 100.0, 40.0),
        Damper("lift", 3.0),
        Spring("A", 2.0, 30.0),
        Damper("A", 0.1),
        Stop("A", "upper", 45.0, name="open"),
        Stop("A", "lower", -45.0, name="shut"),
        Drive("O"),
    )
    drawing = Drawing("yoke", "a yoke", points, parts, 0.0, 0.0, 60.0, gravity_m_s2=0.0)
    table = drawn_mechanism(drawing).description
    assert table["closures"]["slot"]["block_mass_kg"] == 0.05
    assert table["springs"]["coil"]["free_length_mm"] == 40.0
    assert table["springs"]["A"] == {
        "joint": "A",
        "stiffness_N_m_per_rad": 2.0,
        "preload_deg": 30.0,
    }
    assert table["dampers"]["lift"] == {"joint": "lift", "damping_N_s_per_m": 3.0}
    assert table["dampers"]["A"] == {"joint": "A", "damping_N_m_s_per_rad": 0.1}
    assert table["stops"]["open"]["at_deg"] == 45.0
    assert table["degrees_of_freedom"] == 2
    assert table["gravity_m_s2"] == 0.0


def test_several_elements_on_one_joint() -> None:
    """All of them are in the model, in its sketch too; one element has the name of its joint."""
    law = {"c_N_s2_per_m2": 2.0}
    more = (
        Spring("rod", 5000.0, -3.0), Spring("rod", 1000.0), Damper("rod", 2.0), Damper("rod", 3.0),
        Force("rod", "orifice", law), Force("rod", "orifice", law), Tie("rod", ENDS, 10.0, 9.0),
    )  # fmt: skip
    mechanism = drawn_mechanism(replace(PRESS, parts=(*PARTS, *more)))
    found = {item.name: (item.stiffness, item.preload) for item in mechanism.springs}
    assert found == {"rod": (20000.0, 0.01), "rod_2": (5000.0, -0.003), "rod_3": (1000.0, 0.0)}
    assert [item.name for item in mechanism.struts] == ["rod_4"]
    assert [(item.name, item.damping) for item in mechanism.dampers] == [("rod", 2.0), ("rod_2", 3)]
    assert [item.name for item in mechanism.forces] == ["rod", "rod_2"]
    nodes = {node.name: node.spring for node in sketch(mechanism).nodes}
    assert nodes["rod"] == "rod, rod_2, rod_3"


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ((*PARTS, Stop("height", "upper", 5.0)), "two stops are called 'height'"),
        ((*PARTS, Drive("O")), "two drives are called 'O'"),
        ((*PARTS, Start("height", 1.0), Start("height", 2.0)), "two starts are called 'height'"),
        ((*PARTS, Body("loose", "O B")), "loose hang on nothing"),
        ((*PARTS, Pin("A", "crank", "nobody")), "'nobody', which is no body"),
        ((*PARTS, Pin("Z", "frame", "ram")), "no point 'Z'"),
        ((*PARTS, Body("ram", "O B")), "cannot name one body more"),
        ((*PARTS, Slide("height", "frame", "ram", "B", (0.0, 1.0))), "two joints are called"),
        ((*PARTS, Slide("other", "frame", "ram", "B", (0.0, 1.0))), "only pins and slots can"),
        ((*PARTS, Stop("B")), "'B' has no coordinate"),
    ],
)
def test_what_does_not_hang_together_is_refused(
    parts: tuple[Body | Pin | Slide | Stop, ...], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        drawn_mechanism(replace(PRESS, parts=parts))


def test_a_stop_that_is_none_is_refused() -> None:
    with pytest.raises(InputError, match="anvil are no stops"):
        drawn_mechanism(replace(PRESS, closed=("anvil",)))

"""Every key of a drawn machine's document, and every number of its URDF by Pinocchio's reading."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from nipper_pin import InputError
from nipper_pin.mechanism.drawing import (
    Body,
    Damper,
    Drawing,
    Drive,
    Pin,
    Slide,
    Slot,
    Spring,
    Stop,
    Tie,
    drawn_mechanism,
    drawn_texts,
    flap,
    telescope,
    write_drawing,
)
from nipper_pin.mechanism.drawing.places import place, vector
from nipper_pin.mechanism.files.toml_writing import toml
from nipper_pin.mechanism.gallery import GALLERY, drawn

POINTS = {
    "O": (10.0, 5.0),
    "A": (30.0, 5.0),
    "Y": (10.0, 40.0),
    "F": (0.0, -50.0),
    "R": (90.0, 0.0),
}
PARTS = (
    Body("crank", "O A", 2.0),
    Body("yoke", "Y", mass_kg=1.5, radius_mm=20.0),
    Body("lever", "A O F", mass_kg=0.9),
    Body("ram", "R", mass_kg=4.0, inertia_kg_m2=0.03, centre_mm=(95.0, 2.0)),
    Pin("O", "frame", "crank"),
    Slide("lift", "frame", "yoke", "Y", (0.0, 1.0)),
    Slide("feed", "frame", "ram", "R", "Y O"),
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

EXPECTED: dict[str, Any] = {
    "format": 1,
    "title": "a <yoke>",
    "degrees_of_freedom": 3,
    "gravity_m_s2": 3.0,
    "transition_stop": "shut",
    "initial_phase": 1,
    "cylinder": {
        "rated_speed_rpm": 60.0, "direction": "clockwise", "angle_at_touch_deg": 12.0,
        "reference_index": 24.0, "reference_angle_deg": -40.0,
    },
    "drives": {
        "O": {"joint": "O", "law": "constant_speed", "ratio": 1.0, "reflected_inertia_kg_m2": 0.2,
              "shaft_frequency_hz": 30.0, "shaft_damping_ratio": 0.5},
        "feed": {"joint": "feed", "law": "screw", "lead_mm_per_turn": 7.0, "reflected_mass_kg": 8.0,
                 "shaft_frequency_hz": 20.0, "shaft_damping_ratio": 0.4},
    },
    "springs": {
        "coil": {"frame_a": "yoke_Y", "frame_b": "frame_F", "stiffness_N_per_m": 100.0,
                 "free_length_mm": 40.0},
        "A": {"joint": "A", "stiffness_N_m_per_rad": 2.0, "preload_deg": 30.0},
        "lift": {"joint": "lift", "stiffness_N_per_m": 500.0, "preload_length_mm": 4.0},
    },
    "dampers": {
        "lift": {"joint": "lift", "damping_N_s_per_m": 3.0},
        "A": {"joint": "A", "damping_N_m_s_per_rad": 0.1},
    },
    "stops": {
        "open": {"joint": "A", "restitution": 0.3, "side": "upper", "at_deg": 45.0},
        "shut": {"joint": "A", "restitution": 0.1, "at_deg": -40.0},
        "lift": {"joint": "lift", "restitution": 0.2, "at_mm": -60.0},
    },
    "closures": {
        "slot": {"frame_a": "slot_line", "frame_b": "crank_A", "slot_axis": "x",
                 "block_mass_kg": 0.05},
    },
    "phases": [
        {"number": 1, "name": "running", "closed": []},
        {"number": 2, "name": "on the shut", "closed": ["shut"]},
    ],
    "shortcuts": {
        "restitution": "stops.shut.restitution", "stiffness": "springs.coil.stiffness_N_per_m",
    },
    "provenance": {
        "urdf.points": "a book",
        "urdf.links": "invention: bars of an even mass by their length, blocks as given",
        "drives": "made up", "springs": "made up", "stops": "made up",
    },
}  # fmt: skip


def test_every_key_of_the_document() -> None:
    """Units by the kind of each joint; what is not given is not written."""
    assert drawn_mechanism(YOKE).description == EXPECTED


def test_what_a_drawing_need_not_say() -> None:
    """Sense, sources, the stop that is struck; without stops, springs and dampers no tables."""
    bare = Drawing("bare", "bare", POINTS, (Body("crank", "O A"), Pin("O", "frame", "crank"),
                                            Drive("O")), 0.0, 0.0, 60.0)  # fmt: skip
    table = drawn_mechanism(bare).description
    assert set(table) == {
        "format", "title", "degrees_of_freedom", "gravity_m_s2", "initial_phase", "cylinder",
        "drives", "phases", "provenance",
    }  # fmt: skip
    assert table["gravity_m_s2"] == 9.81
    assert table["cylinder"]["direction"] == "counter-clockwise"  # type: ignore[index]
    assert table["phases"] == [{"number": 1, "name": "running", "closed": []}]
    invented = "invention: a plausible machine of its kind"
    assert table["provenance"]["urdf.points"] == invented  # type: ignore[index]
    assert drawn_mechanism(bare).drives[0].reflected_inertia == 0.1
    closed = Drawing("c", "c", POINTS, (*PARTS[:17], PARTS[18]), 0.0, 0.0, 60.0, closed=("lift",))
    table = drawn_mechanism(closed).description
    assert table["transition_stop"] == "open"
    assert [phase["closed"] for phase in table["phases"]] == [["lift"], ["open"], []]  # type: ignore[attr-defined]
    assert [phase["name"] for phase in table["phases"]] == ["running", "on the open", "free"]  # type: ignore[attr-defined]


def test_every_number_of_the_urdf() -> None:
    """Places of joints and frames, axes, masses, centres and inertias, in metres."""
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
        np.testing.assert_allclose(found, [1e-3 * x, 0.0, 1e-3 * z], atol=1e-15, err_msg=frame)
    bodies = {
        # Two kilograms a metre over 20 mm; 0.9 kg over 20 and sqrt(10^2 + 55^2) mm; a disc.
        "O": (0.04, (20.0, 5.0), 0.04 * 4e-4 / 12.0),
        "lift": (1.5, (10.0, 40.0), 0.5 * 1.5 * 4e-4),
        "feed": (4.0, (95.0, 2.0), 0.03),
    }
    long = math.hypot(10.0, 55.0)
    first, second = 0.9 * 20.0 / (20.0 + long), 0.9 * long / (20.0 + long)
    centre = ((first * 20.0 + second * 5.0) / 0.9, (first * 5.0 - second * 22.5) / 0.9)
    about = first * (400.0 / 12.0 + math.dist(centre, (20.0, 5.0)) ** 2)
    about += second * (long**2 / 12.0 + math.dist(centre, (5.0, -22.5)) ** 2)
    bodies["A"] = (0.9, centre, 1e-6 * about)
    for joint, (mass, (x, z), inertia) in bodies.items():
        number = model.getJointId(joint)
        body = model.inertias[number]
        assert body.mass == pytest.approx(mass, rel=1e-12)
        world = data.oMi[number].act(body.lever)
        np.testing.assert_allclose(world, [1e-3 * x, 0.0, 1e-3 * z], atol=1e-12)
        assert body.inertia[1, 1] == pytest.approx(inertia, rel=1e-9)
    # Each slide moves along its direction.
    q = np.zeros(model.nq)
    for joint, along in (("lift", (0.0, 1.0)), ("feed", (0.0, -1.0)), ("slot", (1.0, 0.0))):
        q[:] = 0.0
        q[model.joints[model.getJointId(joint)].idx_q] = 1e-3
        pin.forwardKinematics(model, data, q)
        number = model.getJointId(joint)
        moved = data.oMi[number].translation.copy()
        pin.forwardKinematics(model, data, np.zeros(model.nq))
        np.testing.assert_allclose(
            (moved - data.oMi[number].translation)[[0, 2]], 1e-3 * np.array(along), atol=1e-12
        )


def test_the_written_files_say_what_the_drawing_says(tmp_path: Path) -> None:
    """The points in the comment of the URDF, its title escaped; the document as text."""
    folder = write_drawing(YOKE, tmp_path / "mine")
    text = (folder / "mine.urdf").read_text(encoding="utf-8")
    assert '<robot name="mine">' in text
    assert "a &lt;yoke&gt;, drawn in its touch configuration" in text
    for name, (x, z) in POINTS.items():
        assert f"         {name}  {x:g}  {z:g}\n" in text
    read = tomllib.loads((folder / "mine.toml").read_text(encoding="utf-8"))
    assert {key: value for key, value in read.items() if value} == EXPECTED


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


def test_points_and_directions_by_name() -> None:
    points = {"A": (0.0, 2.0), "B": (4.0, 6.0)}
    assert place(points, "B/A") == (2.0, 4.0)
    assert vector(points, "A B") == (4.0, 4.0)
    assert vector(points, (1.0, 3.0)) == (1.0, 3.0)
    for name in ("C", "A/C", "A/B/A", ""):
        with pytest.raises(InputError, match="its points: A, B") as caught:
            place(points, name)
        assert caught.value.evidence["point"] == name


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
        return dataclasses.replace(
            value,
            **{item.name: _numpy(getattr(value, item.name)) for item in dataclasses.fields(value)},
        )
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
    texts = drawn_texts(_numpy(drawing))
    assert texts == drawn_texts(drawing)
    assert not any("np." in text for text in texts.values())

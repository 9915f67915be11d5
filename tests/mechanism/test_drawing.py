"""Drawings of machines: points, bodies and joints that become a model, or are refused."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from snapshots import Words, blocks, without_the_machine

from nipper_pin import Case, Drawing, InputError, ModelError, Outcome, export, load, simulate
from nipper_pin.cli import main
from nipper_pin.mechanism.drawing.layout import BodyTable
from nipper_pin.mechanism.drawing.mass import mass_of
from nipper_pin.mechanism.files import toml
from nipper_pin.mechanism.gallery import GALLERY, drawn
from nipper_pin.view.sketch import sketch
from tests.refusals.bases import edited

HERE = Path(__file__).parent
POINTS = {
    "O": (10.0, 5.0), "A": (30.0, 5.0), "Y": (10.0, 40.0), "F": (0.0, -50.0), "R": (90.0, 0.0),
}  # fmt: skip
# Every kind of part.
TEXT = """
drawing = 1
title = "a <yoke>"
speed_rpm = 60.0
direction = "clockwise"
touch_deg = 12.0
start_deg = -40.0
transition_stop = "shut"
gravity_m_s2 = 3.0
known = "a book"
invented = "made up"
joints = [
  { pin = "O", parent = "frame", child = "crank" },
  { slide = "lift", parent = "frame", child = "yoke", at = "Y", along = "O Y" },
  { slide = "feed", parent = "frame", child = "ram", at = "R", along = [3.0, 4.0] },
  { slot = "slot", parent = "yoke", child = "crank", at = "A", along = "O A", block_mass_kg = 0.05 },
  { pin = "A", parent = "crank", child = "lever" },
]

[points]
O = [10.0, 5.0]
A = { beside = "O", right_mm = 20.0, up_mm = 0.0 }
Y = [10.0, 40.0]
F = [0.0, -50.0]
R = [90.0, 0.0]

[bodies]
crank = { points = "O A", density_kg_m = 2.0 }
yoke = { points = "Y", mass_kg = 1.5, radius_mm = 20.0 }
lever = { points = "A O F F", mass_kg = 0.9 }
ram = { points = "R", mass_kg = 4.0, inertia_kg_m2 = 0.03, centre_mm = [95.0, 2.0] }

[drives]
O = { joint = "O", law = "constant_speed", ratio = 1.0, reflected_inertia_kg_m2 = 0.2, shaft_frequency_hz = 30.0, shaft_damping_ratio = 0.5 }
feed = { joint = "feed", law = "screw", lead_mm_per_turn = 7.0, reflected_mass_kg = 8.0, shaft_frequency_hz = 20.0, shaft_damping_ratio = 0.4 }

[springs]
coil = { ends = ["yoke Y", "frame F"], stiffness_N_per_m = 100.0, free_length_mm = 40.0 }
A = { joint = "A", stiffness_N_m_per_rad = 2.0, preload_deg = 30.0 }
lift = { joint = "lift", stiffness_N_per_m = 500.0, preload_length_mm = 4.0 }

[dampers]
lift = { joint = "lift", damping_N_s_per_m = 3.0 }
oil = { ends = ["ram R", "frame F"], damping_N_s_per_m = 5.0 }
A = { joint = "A", damping_N_m_s_per_rad = 0.1 }

[stops]
open = { joint = "A", restitution = 0.3, side = "upper", at_deg = 45.0 }
shut = { joint = "A", restitution = 0.1, at_deg = -40.0 }
lift = { joint = "lift", restitution = 0.2, at_mm = -60.0 }
"""  # noqa: E501


YOKE = Drawing(tomllib.loads(TEXT), "yoke")
CRANK = {
    "title": "bare", "speed_rpm": 60.0, "points": POINTS, "bodies": {"crank": {"points": "O A"}},
    "joints": [{"pin": "O", "parent": "frame", "child": "crank"}],
    "drives": {"O": {"joint": "O", "law": "constant_speed", "ratio": 1.0}},
}  # fmt: skip
BARE = Drawing(CRANK, "bare")
CLOSED = Drawing(
    {**CRANK, "closed": ["low"], "transition_stop": "high", "stops": {
        "low": {"joint": "O", "restitution": 0.2},
        "high": {"joint": "O", "side": "upper", "at_deg": 45.0, "restitution": 0.2},
    }}, "c",
)  # fmt: skip


def test_files_of_drawings(words: Words) -> None:
    """What is not given is not written; places of what is seen; names of frames and closures."""
    texts = {drawing.name: drawing.sources() for drawing in (YOKE, BARE, CLOSED)}
    shown = [f"--- {name}.toml\n{toml(document)}" for name, (_, document) in texts.items()]
    words("\n".join([f"--- yoke.urdf\n{texts['yoke'][0]}", *shown]))


def test_a_written_drawing_is_read_back(tmp_path: Path) -> None:
    """As the drawing, alone and in a folder, and as URDF and TOML."""
    alone, folder = YOKE.save(tmp_path / "mine.toml"), YOKE.save(tmp_path / "yours")
    assert Drawing.load(alone) == Drawing(YOKE.tables, "mine")
    whole = export(YOKE.mechanism(), tmp_path / "whole")
    for name, model in (("mine", alone), ("yours", folder), ("whole", whole)):
        assert (load(model).name, load(model).title) == (name, "a <yoke>")
        assert load(model).description == YOKE.mechanism().description
    assert YOKE.points == POINTS


def test_mass_of_rods_and_discs() -> None:
    """A right angle of two rods, by hand; a disc; numbers that are given."""
    points = {"A": (0.0, 0.0), "B": (300.0, 0.0), "C": (300.0, 300.0)}
    bent = mass_of(BodyTable(points="A B C", density_kg_m=2.0), points)
    assert bent.mass == pytest.approx(1.2)
    assert bent.centre == pytest.approx((225.0, 75.0))
    # Two rods of 0.6 kg and 0.3 m, each centre 0.075 sqrt(2) m from that of both.
    assert bent.inertia == pytest.approx(2.0 * 0.6 * (0.09 / 12.0 + 2.0 * 0.075**2))
    disc = mass_of(BodyTable(points="A", mass_kg=2.0, radius_mm=100.0), points)
    assert (disc.mass, disc.centre) == (2.0, (0.0, 0.0))
    assert disc.inertia == pytest.approx(0.5 * 2.0 * 0.01)


def test_mass_of_plates_and_bars() -> None:
    """A square with a corner added, either way around; a bar of a rectangle; a steel disc."""
    points = {"A": (10.0, 20.0), "B": (40.0, 20.0), "C": (40.0, 50.0), "D": (10.0, 50.0),
              "E": (40.0, 80.0)}  # fmt: skip
    square, triangle = 1e-9 * 5.0 * 900.0 * 2700.0, 1e-9 * 5.0 * 450.0 * 2700.0
    for corners in ("A B E D", "D E B A"):
        plate = mass_of(BodyTable(points=corners, thickness_mm=5.0, density_kg_m3=2700.0), points)
        assert plate.mass == pytest.approx(square + triangle)
        x = (square * 25.0 + triangle * 30.0) / (square + triangle)
        z = (square * 35.0 + triangle * 60.0) / (square + triangle)
        assert plate.centre == pytest.approx((x, z))
        # b h (b^2 + h^2) / 12, and of a right triangle (b^2 + h^2) / 18, about their centres.
        about = square * (150.0 + (x - 25.0) ** 2 + (z - 35.0) ** 2)
        about += triangle * (100.0 + (x - 30.0) ** 2 + (z - 60.0) ** 2)
        assert plate.inertia == pytest.approx(1e-6 * about)
    bar = mass_of(BodyTable(points="A B", thickness_mm=5.0, width_mm=10.0), points)
    assert bar.mass == pytest.approx(7.85e-6 * 5.0 * 10.0 * 30.0)
    assert bar.inertia == pytest.approx(1e-6 * bar.mass * (30.0**2 + 10.0**2) / 12.0)
    disc = mass_of(BodyTable(points="A", thickness_mm=8.0, radius_mm=40.0), points)
    assert disc.mass == pytest.approx(7.85e-6 * 8.0 * math.pi * 1600.0)
    assert disc.inertia == pytest.approx(0.5e-6 * disc.mass * 1600.0)


def test_a_drawn_clamp_moves_as_the_one_of_a_urdf() -> None:
    """Cam, buffer, lip on a table: a turn, to the last bit; and units as they are written."""
    drawn_one, urdf = (
        simulate(load(model), Case(speed_rpm=300.0, window="cycle"))
        for model in (HERE / "clamp.toml", HERE.parent / "strangers" / "clamp")
    )
    assert len(urdf.events) > 10
    for one, other in zip(drawn_one.events, urdf.events, strict=True):
        assert (one.kind, one.stops, one.t) == (other.kind, other.stops, other.t)
        np.testing.assert_array_equal(one.q, other.q)
        np.testing.assert_array_equal(one.v_after, other.v_after)
    contacts = [run.mechanism.stop("lip").contact for run in (drawn_one, urdf)]
    assert contacts[0].lever_m == contacts[1].lever_m == pytest.approx(0.09, rel=1e-9)  # type: ignore[union-attr]


def test_a_box_may_lean() -> None:
    """A lip lands on a wedge that leans by 30 degrees: the normal leans with it."""
    tables = Drawing.load(HERE / "clamp.toml").tables
    lean = math.radians(30.0)
    # The face stays under the lip's lowest point in its direction.
    at = (90.0 + 9.0 * math.sin(lean), 4.0 - 9.0 * math.cos(lean))
    table = {**tables["shapes"]["table"], "at": at, "angle_deg": 30.0}
    shapes = {**tables["shapes"], "table": table}
    contact = Drawing({**tables, "shapes": shapes}).mechanism().stop("lip").contact
    assert contact is not None
    expected = [-math.sin(lean), 0.0, math.cos(lean)]
    np.testing.assert_allclose(contact.normal, expected, rtol=0.0, atol=1e-6)


def test_wheels_and_racks_follow() -> None:
    """A wheel and a rack on a driven crank: multiples of its angle, and no freedoms."""
    tables = {
        **CRANK,
        "bodies": {"crank": {"points": "O A"}, "wheel": {"points": "Y F"},
                   "rack": {"points": "R", "thickness_mm": 5.0}},
        "joints": [
            *CRANK["joints"],  # type: ignore[misc]
            {"pin": "Y", "parent": "frame", "child": "wheel", "follows": "O", "ratio": -2.5},
            {"slide": "feed", "parent": "frame", "child": "rack", "at": "R", "along": [1, 0],
             "follows": "O", "lead_cm_per_turn": 10.0},
        ],
    }  # fmt: skip
    mechanism = Drawing(tables).mechanism()
    assert mechanism.degrees_of_freedom == 1
    motion = simulate(mechanism, Case(speed_rpm=60.0, window="cycle")).trajectory.evaluate(0.3)
    crank, wheel, rack = (motion.q[0, mechanism.joints[place].index] for place in range(3))
    assert crank == pytest.approx(0.3 * math.tau, rel=1e-9)
    assert wheel == pytest.approx(-2.5 * crank, rel=1e-12)
    assert rack == pytest.approx(0.3 * 0.1, rel=1e-9)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("stiffness_N_per_m = 500.0", "stiffness_N_per_mm = 0.5"),
        ("preload_deg = 30.0", "preload_rad = 0.5235987755982988"),
        ("density_kg_m = 2.0", "density_g_per_mm = 2.0"),
        ("right_mm = 20.0", "right_cm = 2.0"),
        ("block_mass_kg = 0.05", "block_mass_g = 50.0"),
        ("lead_mm_per_turn = 7.0", "lead_m_per_turn = 0.007"),
        ("centre_mm = [95.0, 2.0]", "centre_m = [0.095, 0.002]"),
        ("gravity_m_s2 = 3.0", "gravity_mm_per_s2 = 3000.0"),
    ],
)
def test_a_key_may_have_another_unit(tmp_path: Path, old: str, new: str) -> None:
    """The same machine, drawn, and of a URDF and a TOML."""
    found, plain = (
        Drawing(tomllib.loads(TEXT.replace(old, new)), "yoke").mechanism(),
        YOKE.mechanism(),
    )
    numbers = [toml(each.description) + each.urdf for each in (found, plain)]
    assert len(numbers[0].split()) == len(numbers[1].split())
    for one, other in zip(*(re.split(r'[\s"]+', text) for text in numbers), strict=True):
        assert one == other or float(one) == pytest.approx(float(other), rel=1e-15)
    folder = export(plain, tmp_path / "yoke")
    file = folder / "yoke.toml"
    file.write_text(file.read_text().replace(old, new), encoding="utf-8")
    assert (
        toml(load(folder).description).split("[cylinder]")[0]
        == toml(plain.description).split("[cylinder]")[0]
    )


def test_places_and_axes_of_the_urdf() -> None:
    """Places of joints and frames, and axes, by Pinocchio."""
    mechanism = YOKE.mechanism()
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
    still = {joint: data.oMi[model.getJointId(joint)].translation.copy() for joint in model.names}
    for joint, along in (("lift", (0.0, 1.0)), ("feed", (0.6, 0.8)), ("slot", (1.0, 0.0))):
        q = np.zeros(model.nq)
        q[model.joints[model.getJointId(joint)].idx_q] = 1e-3
        pin.forwardKinematics(model, data, q)
        moved = data.oMi[model.getJointId(joint)].translation - still[joint]
        np.testing.assert_allclose(moved[[0, 2]], 1e-3 * np.array(along), rtol=0.0, atol=1e-12)


def test_several_elements_on_one_joint() -> None:
    """All of them are in the model, in its sketch too."""
    tables = tomllib.loads(TEXT)
    tables["springs"]["lift_2"] = {**tables["springs"]["lift"], "preload_length_mm": -3.0}
    mechanism = Drawing(tables).mechanism()
    assert [item.name for item in mechanism.springs] == ["A", "lift", "lift_2"]
    assert [(item.name, item.kind) for item in mechanism.struts] == [
        ("coil", "spring"),
        ("oil", "damper"),
    ]
    nodes = {node.name: node.spring for node in sketch(mechanism).nodes}
    assert nodes["lift"] == "lift, lift_2"


def _numpy(value: Any) -> Any:
    """The same data with numbers and places of numpy."""
    if isinstance(value, Mapping):
        return {key: _numpy(item) for key, item in value.items()}
    if isinstance(value, list) and value and all(isinstance(item, float) for item in value):
        return np.array(value)
    if isinstance(value, list):
        return [_numpy(item) for item in value]
    kinds: dict[type, Any] = {bool: np.bool_, int: np.int64, float: np.float64, str: np.str_}
    return kinds[type(value)](value) if type(value) in kinds else value


@pytest.mark.sampled(8)
@pytest.mark.parametrize("name", sorted(GALLERY))
def test_numbers_of_numpy_are_written_as_plain_ones(name: str) -> None:
    """Every value type of a drawing: the texts are those of the same drawing in plain numbers."""
    plain = drawn(name)
    drawing = Drawing(_numpy(plain.tables), name)
    texts = [
        (toml(each.tables), urdf, toml(document))
        for each in (drawing, plain)
        for urdf, document in [each.sources()]
    ]
    assert texts[0] == texts[1]
    assert not any("np." in text for text in texts[0])


@pytest.mark.parametrize(
    ("point", "at"),
    [
        ('{ centre = "A", radius_mm = 2.0, angle_deg = 90.0 }', (0.0, 2.0)),
        ('{ meet = ["A", "B"], radii_mm = [3.0, 4.0], side = "left" }', (1.8, 2.4)),
        ('{ meet = ["A", "B"], radii_mm = [3.0, 4.0], side = "right" }', (1.8, -2.4)),
        ('{ between = ["A", "B"], share = 0.4 }', (2.0, 0.0)),
        ('{ between = ["A", "C"], share = 0.5, left_mm = 2.0 }', (-2.0, 1.5)),
        ('{ centre = "B/C", radius_mm = 2.0, angle_deg = 180.0 }', (0.5, 1.5)),
        ('{ beside = "A/B", right_mm = 0.5, up_mm = -1.0 }', (3.0, -1.0)),
        ('{ centre = "C", radius_mm = 5.0, line = "B", along = [2.0, 0.0], side = "ahead" }',
         (4.0, 0.0)),
        ('{ centre = "C", radius_mm = 5.0, line = [9.0, 0.0], along = [1.0, 0.0], '
         'side = "behind" }', (-4.0, 0.0)),
    ],
)  # fmt: skip
def test_ways_to_find_a_point(point: str, at: tuple[float, float]) -> None:
    """By hand; a point may stand above those that it is found from."""
    text = TEXT.replace("[points]", f"[points]\nP = {point}\nA = [0, 0]\nB = [5, 0]\nC = [0, 3]")
    text = text.replace('A = { beside = "O", right_mm = 20.0, up_mm = 0.0 }\n', "")
    found = Drawing(tomllib.loads(text)).points
    assert found["P"] == pytest.approx(at, abs=1e-14)
    assert [*found][:4] == ["P", "A", "B", "C"]


def test_what_a_file_may_not_say(words: Words) -> None:
    """The mistakes stand in the reviewed text, each above its sentence."""
    told = ""
    for item in blocks(__file__, "test_what_a_file_may_not_say"):
        text = edited({"yoke.toml": TEXT}, item.edits)["yoke.toml"]
        drawing = Drawing(tomllib.loads(text), "yoke")
        with pytest.raises(InputError) as caught:
            drawing.mechanism()
        told += f"{item.text}    {without_the_machine(caught.value.message)}\n"
    words(told, masked=False)


@pytest.mark.parametrize("place", ["machine.toml", "machine/machine.toml", "machine/other.toml"])
def test_where_it_may_be(tmp_path: Path, place: str) -> None:
    """By its own path, or by that of a folder; numbers have the paths of any model."""
    file = tmp_path / place
    file.parent.mkdir(exist_ok=True)
    file.write_text(TEXT, encoding="utf-8")
    model = file if file.parent == tmp_path else file.parent
    mechanism = load(model, {"points.A.z_mm": 6.0, "springs.lift.stiffness_N_per_m": "600"})
    assert (mechanism.name, mechanism.title) == ("machine", "a <yoke>")
    assert [spring.stiffness for spring in mechanism.springs] == [2.0, 600.0]
    assert load(model).description == YOKE.mechanism().description


def test_odd_words_in_a_title_and_a_file_name(tmp_path: Path) -> None:
    """The URDF that is made of them is well formed."""
    file = tmp_path / 'a & "b" <c>.toml'
    file.write_text(TEXT.replace("a <yoke>", "a -- <yoke> --"), encoding="utf-8")
    assert load(file).name == 'a & "b" <c>'


def test_more_than_the_most_is_refused() -> None:
    points = "".join(f"P{number} = [0.0, 0.0]\n" for number in range(1000))
    drawing = Drawing(tomllib.loads(TEXT.replace("[bodies]", f"{points}\n[bodies]")))
    with pytest.raises(ModelError, match="points = '1005 entries' cannot be used: at most 1000"):
        drawing.mechanism()


def test_a_urdf_beside_it_is_another_machine(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(TEXT, encoding="utf-8")
    (tmp_path / "a.urdf").write_text(YOKE.sources()[0], encoding="utf-8")
    for model in (tmp_path / "a.toml", tmp_path):
        with pytest.raises(
            ModelError, match=r"drawing = 1 .*: a\.toml draws a machine, a\.urdf is another"
        ):
            load(model)


def test_new_drawings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A commented press that bounces to rest; no file is replaced."""
    monkeypatch.chdir(tmp_path)
    assert main(["new", "mine.toml"]) == 0
    assert simulate(load("mine.toml"), Case(speed_rpm=120.0)).outcome is Outcome.AT_REST
    before = Path("mine.toml").read_bytes()
    assert main(["new", "--from", "bell", "mine.toml"]) == 2
    assert "mine.toml is there already" in capsys.readouterr().err
    assert {item.name: item.read_bytes() for item in tmp_path.iterdir()} == {"mine.toml": before}

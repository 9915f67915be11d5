"""Drawings in TOML files: they make the machine of the same drawing in Python, or are refused."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from snapshots import Words

from nipper_pin import Case, InputError, ModelError, Outcome, load, simulate
from nipper_pin.cli import main
from nipper_pin.mechanism.drawing import drawing_of, drawn_mechanism, drawn_sources, read_drawing
from nipper_pin.mechanism.files import read_toml
from nipper_pin.mechanism.gallery import GALLERY, drawn

from .test_drawing import PRESS, YOKE

# The drawing YOKE, in which every kind of part occurs.
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
A = { joint = "A", damping_N_m_s_per_rad = 0.1 }

[stops]
open = { joint = "A", restitution = 0.3, side = "upper", at_deg = 45.0 }
shut = { joint = "A", restitution = 0.1, at_deg = -40.0 }
lift = { joint = "lift", restitution = 0.2, at_mm = -60.0 }
"""  # noqa: E501


def test_a_file_makes_the_machine_of_the_same_drawing() -> None:
    drawing = drawing_of(read_toml(TEXT, "yoke.toml"), "yoke", "yoke.toml")
    assert drawn_sources(drawing) == drawn_sources(YOKE)


@pytest.mark.parametrize(
    ("point", "at"),
    [
        ('{ centre = "A", radius_mm = 2.0, angle_deg = 90.0 }', (0.0, 2.0)),
        ('{ meet = ["A", "B"], radii_mm = [3.0, 4.0], side = "left" }', (1.8, 2.4)),
        ('{ meet = ["A", "B"], radii_mm = [3.0, 4.0], side = "right" }', (1.8, -2.4)),
        ('{ between = ["A", "B"], share = 0.4 }', (2.0, 0.0)),
        ('{ between = ["A", "C"], share = 0.5, left_mm = 2.0 }', (-2.0, 1.5)),
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
    found = drawing_of(read_toml(text, "f"), "f", "f").points
    assert found["P"] == pytest.approx(at, abs=1e-14)
    assert [*found][:4] == ["P", "A", "B", "C"]


WRONG = {
    "no such layout": ("drawing = 1", "drawing = 2"),
    "no title": ('title = "a <yoke>"\n', ""),
    "no number": ("speed_rpm = 60.0", "speed_rpm = inf"),
    "two ways": ("right_mm = 20.0", "right_mm = 20.0, radius_mm = 1.0"),
    "half a way": (", up_mm = 0.0", ""),
    "no such key": ("right_mm", "rigth_mm"),
    "no such point": ('beside = "O"', 'beside = "Q"'),
    "found from itself": ('beside = "O"', 'beside = "A/O"'),
    "nowhere": ('beside = "O", right_mm = 20.0, up_mm = 0.0',
                'meet = ["O", "Y"], radii_mm = [9.0, 9.0], side = "left"'),
    "the other kind of side": ('beside = "O", right_mm = 20.0, up_mm = 0.0',
                               'meet = ["O", "Y"], radii_mm = [30.0, 30.0], side = "ahead"'),
    "no words": ("Y = [10.0", '"Y Y" = [10.0'),
    "two strokes": ("Y = [10.0", '"Y--Y" = [10.0'),
    "no kind of joint": ('pin = "O"', 'hinge = "O"'),
    "two kinds": ('slide = "lift"', 'slide = "lift", pin = "O"'),
    "a slide without a direction": (', along = "O Y"', ""),
    "no such body": ('child = "lever"', 'child = "lid"'),
    "no place of a body": ('points = "O A"', 'points = "O Q"'),
    "no ends": ('ends = ["yoke Y", "frame F"]', 'ends = ["yoke"]'),
    "another kind of spring": ("stiffness_N_m_per_rad = 2.0", "stiffness_N_per_m = 2.0"),
    "closures of its own": ("[drives]", "[closures.pin]\nframe_a = 'a'\nframe_b = 'b'\n[drives]"),
}  # fmt: skip


def test_what_a_file_may_not_say(words: Words) -> None:
    told = ""
    for name, (old, new) in WRONG.items():
        assert TEXT.count(old) >= 1, name
        document = read_toml(TEXT.replace(old, new, 1), "yoke.toml")
        with pytest.raises(InputError) as caught:
            drawn_mechanism(drawing_of(document, "yoke", "yoke.toml"))
        told += f"{name}\n    {caught.value.message}\n"
    words(told)


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
    assert load(model).description == drawn_mechanism(YOKE).description


def test_odd_words_in_a_title_and_a_file_name(tmp_path: Path) -> None:
    """The URDF that is made of them is well formed."""
    file = tmp_path / 'a & "b" <c>.toml'
    file.write_text(TEXT.replace("a <yoke>", "a -- <yoke> --"), encoding="utf-8")
    assert load(file).name == 'a & "b" <c>'


def test_more_than_the_most_is_refused() -> None:
    points = "".join(f"P{number} = [0.0, 0.0]\n" for number in range(1000))
    document = read_toml(TEXT.replace("[bodies]", f"{points}\n[bodies]"), "f")
    with pytest.raises(ModelError, match="points = '1005 entries' cannot be used: at most 1000"):
        drawing_of(document, "f", "f")


def test_a_urdf_beside_it_is_another_machine(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(TEXT, encoding="utf-8")
    (tmp_path / "a.urdf").write_text(drawn_sources(PRESS)[0], encoding="utf-8")
    for model in (tmp_path / "a.toml", tmp_path):
        with pytest.raises(
            ModelError, match=r"drawing = 1 .*: a\.toml draws a machine, a\.urdf is another"
        ):
            load(model)


def test_files_that_are_none(tmp_path: Path) -> None:
    for name, content in (("bytes", b"\xff\xfe"), ("toml", b"drawing = ")):
        file = tmp_path / f"{name}.toml"
        file.write_bytes(content)
        with pytest.raises(ModelError):
            read_drawing(file)


def test_new_drawings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A commented press that bounces to rest, or a machine of the gallery; no file is replaced."""
    monkeypatch.chdir(tmp_path)
    assert main(["new", "mine.toml"]) == 0
    assert simulate(load("mine.toml"), Case(speed_rpm=120.0)).outcome is Outcome.AT_REST
    assert main(["new", "--from", "bell", "other.toml"]) == 0
    assert load("other.toml").description == drawn_mechanism(drawn("bell")).description
    before = Path("mine.toml").read_text(encoding="utf-8")
    capsys.readouterr()
    for words in (["mine.toml"], ["e62.toml"], ["--from", "bel", "new.toml"]):
        assert main(["new", *words]) == 2
    said = capsys.readouterr().err
    assert "mine.toml is there already" in said
    assert "e62 is a model that comes with the package" in said
    assert "no machine of the gallery named 'bel'" in said
    assert Path("mine.toml").read_text(encoding="utf-8") == before
    assert sorted(item.name for item in tmp_path.iterdir()) == ["mine.toml", "other.toml"]


def test_commands_take_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = shutil.copy(GALLERY["crank_rocker"], tmp_path / "mine.toml")
    assert main(["check", str(file)]) == 0
    assert main(["simulate", str(file), "--out", str(tmp_path / "run")]) == 0
    assert "mine" in capsys.readouterr().out

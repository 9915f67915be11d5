"""A model of a URDF as another program exported it: what is proposed of what it does not say."""

from __future__ import annotations

import math
import shutil
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from snapshots import Words

from nipper_pin import Case, Drawing, ModelError, load, simulate
from nipper_pin.cli import main
from nipper_pin.mechanism.gallery import drawn
from nipper_pin.mechanism.skeleton import take_urdf

STRANGERS = Path(__file__).parents[1] / "strangers"
# Of four-bars and others: digits, frames and axes as programs write them; frames with a mass;
# mirrored and coupled joints; lips of meshes; no closure at all.
CASES = (
    "sw_fourbar_5", "sw_fourbar_16", "onshape_fivebar_6", "in_mm", "fb_yaxis", "fb_ns", "fb_latin",
    "fb_jointprops", "tiny_frame_mass", "twin_jaws", "mirror_gripper", "clamp",
    "lips_mesh_wedge", "u03_cartpole", "crlf_bom",
)  # fmt: skip


def together(closures: Iterable[Mapping[str, Any]]) -> set[frozenset[str]]:
    """Frames that closures hold in one place; of three in a pin either may be joined to both."""
    groups: list[set[str]] = []
    for each in closures:
        pair = {each["frame_a"], each["frame_b"]}
        near = [group for group in groups if group & pair]
        groups = [group for group in groups if not group & pair] + [pair.union(*near)]
    return {frozenset(group) for group in groups}


@pytest.mark.parametrize("name", CASES)
def test_closures_that_people_wrote_are_found(tmp_path: Path, name: str) -> None:
    """And no others; the model loads, with as many freedoms."""
    found = take_urdf(STRANGERS / name / f"{name}.urdf", tmp_path / "mine")
    own = load(STRANGERS / name)
    written = [each for each in own.description.get("closures", {}).values()]  # type: ignore[attr-defined]
    assert together(found.closures.values()) == together(written)
    assert (found.wrong, found.lost) == ("", ())
    model = load(tmp_path / "mine")
    assert model.degrees_of_freedom == own.degrees_of_freedom
    assert [joint.name for joint in model.joints] == [joint.name for joint in own.joints]


@pytest.mark.parametrize("name", ["moulding_machine", "pantograph", "jansen", "peaucellier"])
def test_several_links_at_one_pin(tmp_path: Path, name: str) -> None:
    """Three at a pin are two closures, whichever is joined to both."""
    machine = drawn(name).mechanism()
    file = tmp_path / "export.urdf"
    file.write_text(machine.urdf, encoding="utf-8")
    found = take_urdf(file, tmp_path / "mine")
    written: Any = machine.description["closures"]
    assert len(found.closures) == len(written)
    assert together(found.closures.values()) == together(written.values())
    assert not found.wrong


def test_an_export_with_a_drive_runs(tmp_path: Path) -> None:
    """The drive that the file proposes, taken in: the motion is that of the full-digit machine."""
    folder = tmp_path / "mine"
    take_urdf(STRANGERS / "sw_fourbar_5" / "sw_fourbar_5.urdf", folder)
    file = folder / "mine.toml"
    text = file.read_text(encoding="utf-8")
    for line in ("[drives.crank_joint]", 'joint = "crank_joint"', 'law = "constant_speed"',
                 "ratio = 1.0"):  # fmt: skip
        assert text.count(f"# {line}") >= 1
        text = text.replace(f"# {line}", line, 1)
    file.write_text(text, encoding="utf-8")
    case = Case(speed_rpm=60.0, window="cycle")
    q = [simulate(load(model), case).trajectory.evaluate(0.4).q
         for model in (folder, STRANGERS / "sw_fourbar_16")]  # fmt: skip
    np.testing.assert_allclose(q[0], q[1], rtol=0.0, atol=1e-3)


LIMITED = """<robot name="hammer">
  <link name="base"/>
  <link name="arm">
    <inertial><origin xyz="0.1 0 0"/><mass value="0.5"/>
      <inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial>
    <visual><geometry><mesh filename="package://hammer/meshes/arm.stl"/></geometry></visual>
    <collision name="head"><origin xyz="0.2 0 0"/>
      <geometry><mesh filename="../meshes/head.stl"/></geometry></collision>
  </link>
  <link name="rod">
    <inertial><mass value="0.1"/>
      <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial>
  </link>
  <joint name="swing" type="revolute"><parent link="base"/><child link="arm"/>
    <axis xyz="0 -1 0"/><limit lower="-0.5" upper="1.2" effort="1" velocity="1"/></joint>
  <joint name="feed" type="prismatic"><parent link="arm"/><child link="rod"/>
    <origin xyz="0.2 0 0"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="1000" effort="1" velocity="1"/></joint>
</robot>
"""


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A package as ROS has them: the URDF in one folder, meshes in another."""
    home = tmp_path / "hammer_description"
    for folder in ("urdf", "meshes"):
        (home / folder).mkdir(parents=True)
    (home / "urdf" / "hammer.urdf").write_text(LIMITED, encoding="utf-8")
    shutil.copyfile(STRANGERS / "lips_mesh_mesh" / "cube.stl", home / "meshes" / "head.stl")
    return home / "urdf" / "hammer.urdf"


def test_limits_are_stops_and_meshes_are_taken_along(tmp_path: Path, package: Path) -> None:
    """Of a slide ten times as far as the machine is large there is none; one mesh is not there."""
    found = take_urdf(package, tmp_path / "mine")
    assert {name: stop.get("at_deg", stop.get("at_mm")) for name, stop in found.stops.items()} == {
        "swing_lower": pytest.approx(math.degrees(-0.5), rel=1e-8),
        "swing_upper": pytest.approx(math.degrees(1.2), rel=1e-8),
        "feed_lower": 0.0,
    }
    assert found.lost == ("package://hammer/meshes/arm.stl",)
    assert found.drives == {"swing": False}
    model = load(tmp_path / "mine")
    assert [stop.name for stop in model.stops] == [*found.stops]
    assert [path.name for path in (tmp_path / "mine" / "meshes").iterdir()] == ["head.stl"]
    provenance = tomllib.loads((tmp_path / "mine" / "mine.toml").read_text())["provenance"]
    assert "guesses" in provenance["stops"]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("../meshes/head.stl", "../meshes/hood.stl", r"hammer\.urdf: collision mesh .*hood"),
        ('axis xyz="1 0 0"', 'axis xyz="0 1 0"', r"hammer\.urdf: joint feed axis"),
        ("<inertial>", "<inertial", r"hammer\.urdf: "),
    ],
)
def test_what_cannot_be_taken(
    tmp_path: Path, package: Path, old: str, new: str, words: str
) -> None:
    """The file of the user is named, and nothing is written."""
    package.write_text(LIMITED.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ModelError, match=words):
        take_urdf(package, tmp_path / "mine")
    assert not (tmp_path / "mine").exists()


def test_a_loop_too_many_is_told(tmp_path: Path) -> None:
    """Written all the same, with what the loader says: a pad that lies on a cam is no pin."""
    file = tmp_path / "valve.urdf"
    file.write_text(drawn("valve_train").mechanism().urdf, encoding="utf-8")
    found = take_urdf(file, tmp_path / "mine")
    assert "pad_line" in found.wrong
    assert (tmp_path / "mine" / "mine.toml").is_file()
    with pytest.raises(ModelError, match="pad_line"):
        load(tmp_path / "mine")


def test_a_pin_may_be_one_in_a_slot(tmp_path: Path) -> None:
    """As a plain pin it would lock the machine, which is told; a line of the table mends it."""
    tables = drawn("scotch_yoke").tables
    parts = {key: tables[key] for key in ("title", "speed_rpm", "points", "drives")}
    parts |= {"joints": tables["joints"][:3],
              "bodies": {name: tables["bodies"][name] for name in ("crank", "yoke")}}  # fmt: skip
    yoke = Drawing(parts).mechanism()
    file, table = tmp_path / "yoke.urdf", tmp_path / "mine" / "mine.toml"
    file.write_text(yoke.urdf, encoding="utf-8")
    found = take_urdf(file, tmp_path / "mine")
    ((name, closure),) = found.closures.items()
    assert found.wrong.endswith("may slide in a slot (slot_axis)")
    text = table.read_text(encoding="utf-8")
    assert 'slot_axis = "x" (or "z")' in text
    (own,) = yoke.description["closures"].values()  # type: ignore[attr-defined]
    assert {own["frame_a"], own["frame_b"]} == {*closure.values()}
    old = "".join(f'{key} = "{value}"\n' for key, value in closure.items())
    new = "".join(f"{key} = {value!r}\n" for key, value in own.items())
    assert old in text
    table.write_text(text.replace(old, new), encoding="utf-8")
    model = load(tmp_path / "mine")
    assert (model.degrees_of_freedom, [item.name for item in model.closures]) == (1, [name])


def test_the_command_tells_what_it_found(
    here: Path, package: Path, words: Words, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["new", "mine", "--urdf", str(package)]) == 0
    fourbar = STRANGERS / "sw_fourbar_5" / "sw_fourbar_5.urdf"
    assert main(["new", "loop", "--urdf", str(fourbar)]) == 0
    said = capsys.readouterr().out
    words(f"{said}\n{(here / 'mine' / 'mine.toml').read_text(encoding='utf-8')}")
    assert main(["check", "mine"]) == 0

"""What `check` says of a URDF: limits, units, and what nobody reads; and nothing of good ones."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from small_machines import hinge, link, sources

from nipper_pin import Case, Mechanism, load, simulate
from nipper_pin.cli import main
from nipper_pin.mechanism import from_sources, known_models
from nipper_pin.mechanism.drawing import drawn_mechanism
from nipper_pin.mechanism.gallery import GALLERY
from nipper_pin.study.check import check_model
from nipper_pin.study.urdf_advice import UrdfAdvice
from nipper_pin.study.urdf_unread import unread

LIMITED = (
    '<joint name="trolley" type="prismatic"><parent link="frame"/><child link="hoist"/>'
    '<axis xyz="0 0 1"/><limit lower="-0.1" upper="0.2" effort="100" velocity="1"/></joint>'
)


def advised(mechanism: Mechanism) -> UrdfAdvice:
    """What is said of a machine at its rated speed."""
    return check_model(mechanism, mechanism.cylinder.rated_speed_rpm).urdf


def built(parts: list[str], **tables: Any) -> Mechanism:
    """A machine of some parts that weight moves."""
    urdf, description = sources(parts, 1, gravity=9.81, **tables)
    return from_sources("small", urdf, description, ".")


@pytest.mark.slow
def test_good_models_get_no_advice() -> None:
    machines = [load(name) for name in known_models() if name != "benchmarks"]
    for mechanism in (*machines, *(drawn_mechanism(draw()) for draw in GALLERY.values())):
        assert advised(mechanism) == UrdfAdvice((), ""), mechanism.name


def test_limits_become_stops_that_enforce_them() -> None:
    """A load falls past the lower limit of its slide; the stops to paste hold it there."""
    parts = [link("hoist"), LIMITED]
    advice = advised(built(parts))
    (sentence,) = advice.sentences
    assert "limits of joint trolley in the URDF (lower -100 mm and upper 200 mm)" in sentence
    assert "not enforced, and this cycle passes the lower one" in sentence
    pasted = tomllib.loads(advice.stops)
    assert pasted["transition_stop"] == "trolley_lower"
    assert {(item["side"], item["at_mm"]) for item in pasted["stops"].values()} == {
        ("lower", -100.0), ("upper", 200.0)
    }  # fmt: skip
    mended = built(parts, stops=pasted["stops"])
    solution = simulate(mended, Case(speed_rpm=60.0, window="cycle"))
    assert solution.collisions[0].t == pytest.approx(math.sqrt(2.0 * 0.1 / 9.81), rel=1e-12)
    assert advised(mended) == UrdfAdvice((), "")


@pytest.mark.parametrize(("lower", "told"), [(0.3, "them: exchange the two"), (0.2, "them; where")])
def test_limits_without_room_become_no_stops(lower: float, told: str) -> None:
    """A lower limit above the upper one, or at its place: no two stops can be there."""
    written = LIMITED.replace('lower="-0.1"', f'lower="{lower}"')
    advice = advised(built([link("hoist"), written]))
    (sentence,) = advice.sentences
    assert f"(lower {1000 * lower:g} mm and upper 200 mm) leave it no room" in sentence
    assert told in sentence
    assert advice.stops == ""


def test_text_of_stops_can_be_pasted_below_others(tmp_path: Path) -> None:
    urdf, description = sources([link("hoist"), LIMITED], 1, gravity=9.81)
    folder = tmp_path / "hoist"
    folder.mkdir()
    (folder / "hoist.urdf").write_text(urdf, encoding="utf-8")
    from nipper_pin.mechanism.files.toml_writing import toml

    del description["transition_stop"]
    (folder / "hoist.toml").write_text(toml(description), encoding="utf-8")
    head, _, tail = advised(load(folder)).stops.partition("# At the end:\n")
    (folder / "hoist.toml").write_text(f"{head}{toml(description)}{tail}", encoding="utf-8")
    assert [stop.name for stop in load(folder).stops] == ["trolley_lower", "trolley_upper"]


@pytest.mark.parametrize(
    ("kind", "lower", "upper", "told"),
    [
        ("revolute", -0.5, 0.25, "lower -28.6479 deg and upper 14.3239 deg"),
        ("revolute", -3.14, 0.25, "upper 14.3239 deg"),
        ("revolute", -10.0, 10.0, ""),
        ("continuous", -0.5, 0.25, ""),
    ],
)
def test_limits_of_hinges(kind: str, lower: float, upper: float, told: str) -> None:
    """Half a turn and more is what files have where the format asks for a limit."""
    limit = f'<limit lower="{lower}" upper="{upper}" effort="1" velocity="1"/>'
    arm = hinge("pivot", "frame", "arm").replace("continuous", kind)
    arm = arm.replace("</joint>", f"{limit}</joint>")
    sentences = advised(built([link("arm", centre=(0.01, -0.1)), arm])).sentences
    if told:
        assert any(f"limits of joint pivot in the URDF ({told})" in text for text in sentences)
    else:
        assert sentences == ()


def test_limits_of_driven_joints_are_not_told() -> None:
    """The drive says where they are."""
    drive = {"law": "constant_speed", "ratio": 1.0, "joint": "pivot"}
    limit = '<limit lower="-0.5" upper="0.5" effort="1" velocity="1"/>'
    arm = hinge("pivot", "frame", "arm").replace("continuous", "revolute")
    arm = arm.replace("</joint>", f"{limit}</joint>")
    assert advised(built([link("arm"), arm], drives={"pivot": drive})).sentences == ()


def bars(length: float, mass: float, inertia: float) -> Mechanism:
    """Two bars in a row."""
    parts = [
        link("one", mass, inertia, (0.5 * length, 0.0)), hinge("A", "frame", "one"),
        link("two", mass, inertia, (0.5 * length, 0.0)), hinge("B", "one", "two", (length, 0.0)),
    ]  # fmt: skip
    urdf, description = sources(parts, 2)
    return from_sources("bars", urdf, description, ".")


@pytest.mark.parametrize(
    ("length", "mass", "inertia", "told"),
    [
        (0.1, 0.2, 0.2 * 0.01 / 12, None),
        (
            0.1,
            0.2,
            1.0,
            "link one has an inertia of 1 kg m2 and 0.2 kg, as a ring of 2.24 m radius",
        ),
        (0.1, 0.2, 0.2 * 0.01, None),
        (100.0, 0.2, 0.2 * 1e4 / 12, "the URDF measures 100 m, and its links weigh 0.4 kg"),
        (6.0, 80.0, 80.0 * 36.0 / 12, None),
        (300.0, 1e6, 1e6 * 9e4 / 12, "are its lengths in mm?"),
    ],
)
def test_units(length: float, mass: float, inertia: float, told: str | None) -> None:
    sentences = advised(bars(length, mass, inertia)).sentences
    assert bool(sentences) == (told is not None)
    assert told is None or told in sentences[0]


PLACES: dict[str, tuple[str, str]] = {
    "robot": ('<robot name="r"><link name="a"/>{}</robot>', ""),
    "link": ('<robot name="r"><link name="a">{}</link></robot>', " in link a"),
    "inertial": (
        '<robot name="r"><link name="a"><inertial>{}</inertial></link></robot>',
        " in link a",
    ),
    "joint": ('<robot name="r"><joint name="j" type="fixed">{}</joint></robot>', " in joint j"),
    "limit": ('<robot name="r"><joint name="j"><limit>{}</limit></joint></robot>', " in joint j"),
    "geometry": (
        '<robot name="r"><link name="a"><visual><geometry>{}</geometry></visual></link></robot>',
        " in link a",
    ),
}


@pytest.mark.parametrize("place", PLACES)
def test_elements_that_nobody_reads_are_named(place: str) -> None:
    text, where = PLACES[place]
    root = ElementTree.fromstring(text.format('<odd value="1"/><!-- of no matter -->'))
    assert [*unread(root)] == [f"the URDF holds what is not read: <odd>{where}"]
    assert [*unread(ElementTree.fromstring(text.format("")))] == []


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('<robot name="r" kind="arm"/>', "attribute kind of <robot>"),
        ('<robot name="r"><link name="a" mass="1"/></robot>', "attribute mass of link a"),
        (
            '<robot name="r"><joint name="j"><limit force="1"/></joint></robot>',
            "attribute force of <limit> in joint j",
        ),
        (
            '<robot name="r" xmlns:x="http://x"><x:arg/><x:arg/></robot>',
            "<arg> (2 times)",
        ),
        (
            '<robot name="r"><joint name="j"><joint_properties damping="1"/></joint></robot>',
            "<joint_properties> in joint j; damping belongs into <dynamics>",
        ),
        (
            f'<robot name="r">{"".join(f"<a{i}/>" for i in range(8))}</robot>',
            "<a0>, <a1>, <a2>, <a3>, <a4>, <a5> and 2 more",
        ),
    ],
)
def test_what_is_not_read(text: str, told: str) -> None:
    root = ElementTree.fromstring(text)
    assert [*unread(root)] == [f"the URDF holds what is not read: {told}"]


@pytest.mark.parametrize("tag", ["origin", "parent", "child", "axis", "limit", "dynamics", "mimic"])
def test_what_counts_once_is_told_if_it_is_there_twice(tag: str) -> None:
    root = ElementTree.fromstring(
        f'<robot name="r"><joint name="j"><{tag}/><{tag}/></joint></robot>'
    )
    assert [*unread(root)] == [
        f"joint j has 2 <{tag}> in the URDF, and only the first one counts: put all that it says "
        "into one"
    ]


def test_what_is_called_ignored_is_not_named() -> None:
    page = (Path(__file__).parents[2] / "docs" / "model_urdf.md").read_text(encoding="utf-8")
    inner: Callable[[str], str] = lambda text: f'<robot name="r" version="1.0">{text}</robot>'  # noqa: E731
    root = ElementTree.fromstring(
        inner(
            '<gazebo><odd/></gazebo><transmission name="t"><odd/></transmission>'
            '<material name="m"><texture filename="f"/></material>'
            '<joint name="j" type="revolute"><calibration rising="1"/><safety_controller k="1"/>'
            '<limit effort="1" velocity="1"/></joint>'
        )
    )
    assert [*unread(root)] == []
    for word in ("gazebo", "transmission", "texture", "calibration", "safety_controller", "effort",
                 "velocity", "version"):  # fmt: skip
        assert f"`{word}`" in page or f"`<{word}>`" in page, word


def test_the_command_prints_advice(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    urdf, description = sources([link("hoist"), LIMITED], 1, gravity=9.81)
    from nipper_pin.mechanism.files.toml_writing import toml

    del description["transition_stop"]
    (tmp_path / "hoist.urdf").write_text(urdf, encoding="utf-8")
    (tmp_path / "hoist.toml").write_text(toml(description), encoding="utf-8")
    assert main(["check", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "To look at" in said
    assert '[stops.trolley_upper]\njoint = "trolley"\nside = "upper"\nat_mm = 200.0' in said
    assert main(["check", str(tmp_path), "--json", "-"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["advice"][0].startswith("limits of joint trolley")
    assert document["stops_to_paste"].count("[stops.") == 2


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("<link name='a'>crank</link>", "text 'crank' in link a"),
        ("<link name='a'><inertial><mass value='1'/> kg</inertial></link>",
         "text 'kg' in <inertial> in link a"),
        ("<joint name='j'><axis xyz='0 -1 0'>0 1 0</axis></joint>",
         "text '0 1 0' in <axis> in joint j"),
        ("<joint name='j'><!-- a note -->x\ty</joint>", "text 'x y' in joint j"),
        ("stray<link name='a'/>", "text 'stray' in <robot>"),
        ("<gazebo>words</gazebo>\n<link name='a'>\n</link>", None),
    ],
)  # fmt: skip
def test_text_between_elements_is_told(text: str, told: str | None) -> None:
    root = ElementTree.fromstring(f"<robot name='r'>{text}</robot>")
    expected = [f"the URDF holds what is not read: {told}"] if told else []
    assert [*unread(root)] == expected

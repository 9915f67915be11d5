"""What `check` says of a URDF: limits, units, and what nobody reads; and nothing of good ones."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from small_machines import hinge, link, machine, sources
from snapshots import Words, blocks

from nipper_pin import Case, Mechanism, check, load, simulate
from nipper_pin.cli import main
from nipper_pin.mechanism import known_models
from nipper_pin.mechanism.files import toml
from nipper_pin.mechanism.gallery import GALLERY, drawn
from nipper_pin.study.urdf_advice import UrdfAdvice
from nipper_pin.study.urdf_unread import unread

LIMITED = (
    '<joint name="trolley" type="prismatic"><parent link="frame"/><child link="hoist"/>'
    '<axis xyz="0 0 1"/><limit lower="-0.1" upper="0.2" effort="100" velocity="1"/></joint>'
)


@pytest.mark.slow
def test_good_models_get_no_advice() -> None:
    machines = [load(name) for name in known_models() if name != "benchmarks"]
    for mechanism in (*machines, *(drawn(name).mechanism() for name in GALLERY)):
        assert check(mechanism).urdf == UrdfAdvice((), ""), mechanism.name


def test_limits_become_stops_that_enforce_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A load falls past the lower limit of its slide; what the document says to paste holds it."""
    urdf, description = sources([link("hoist"), LIMITED], 1, gravity=9.81)
    del description["transition_stop"]
    home = tmp_path / "hoist"
    home.mkdir()
    (home / "hoist.urdf").write_text(urdf, encoding="utf-8")
    (home / "hoist.toml").write_text(toml(description), encoding="utf-8")
    assert main(["check", str(home), "--json", "-"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["advice"][0].startswith("limits of joint trolley")
    head, _, tail = document["stops_to_paste"].partition("# At the end:\n")
    (home / "hoist.toml").write_text(head + toml(description) + tail, encoding="utf-8")
    mended = load(home)
    stops = {stop.name: (stop.sense, stop.at) for stop in mended.stops}
    assert stops == {"trolley_lower": (1.0, -0.1), "trolley_upper": (-1.0, 0.2)}
    solution = simulate(mended, Case(speed_rpm=60.0, window="cycle"))
    assert solution.collisions[0].t == pytest.approx(math.sqrt(2.0 * 0.1 / 9.81), rel=1e-12)
    assert check(mended).urdf == UrdfAdvice((), "")


def slide(lower: float) -> Mechanism:
    """A load on a slide with limits."""
    limited = LIMITED.replace('lower="-0.1"', f'lower="{lower}"')
    return machine([link("hoist"), limited], 1, gravity=9.81)


def swinging(lower: float, upper: float, kind: str = "revolute", **tables: Any) -> Mechanism:
    """A pendulum whose hinge has limits."""
    limit = f'<limit lower="{lower}" upper="{upper}" effort="1" velocity="1"/>'
    arm = hinge("pivot", "frame", "arm").replace("continuous", kind)
    arm = arm.replace("</joint>", f"{limit}</joint>")
    return machine([link("arm", centre=(0.01, -0.1)), arm], 1, gravity=9.81, **tables)


def bars(length: float, mass: float, inertia: float) -> Mechanism:
    """Two bars in a row."""
    parts = [
        link("one", mass, inertia, (0.5 * length, 0.0)), hinge("A", "frame", "one"),
        link("two", mass, inertia, (0.5 * length, 0.0)), hinge("B", "one", "two", (length, 0.0)),
    ]  # fmt: skip
    return machine(parts, 2)


DRIVEN = {"pivot": {"law": "constant_speed", "ratio": 1.0, "joint": "pivot"}}
ADVISED: dict[str, Callable[[], Mechanism]] = {
    "limits that are passed": lambda: slide(-0.1),
    "a lower limit above the upper one": lambda: slide(0.3),
    "two limits at one place": lambda: slide(0.2),
    "limits of a hinge": lambda: swinging(-0.5, 0.25),
    # Half a turn and more is what files have where the format asks for a limit.
    "half a turn": lambda: swinging(-3.14, 0.25),
    "inertia of a ring": lambda: bars(0.1, 0.2, 1.0),
    "a hundred metres": lambda: bars(100.0, 0.2, 0.2 * 1e4 / 12),
    "lengths in mm": lambda: bars(300.0, 1e6, 1e6 * 9e4 / 12),
}
NOT_ADVISED: dict[str, Callable[[], Mechanism]] = {
    "more than a turn": lambda: swinging(-10.0, 10.0),
    "hinge without limits": lambda: swinging(-0.5, 0.25, "continuous"),
    # The drive says where they are.
    "driven hinge": lambda: swinging(-0.5, 0.5, drives=DRIVEN),
    "small bars": lambda: bars(0.1, 0.2, 0.2 * 0.01 / 12),
    "rings": lambda: bars(0.1, 0.2, 0.2 * 0.01),
    "large bars": lambda: bars(6.0, 80.0, 80.0 * 36.0 / 12),
}


def test_advice(words: Words) -> None:
    said = []
    for name, make in ADVISED.items():
        advice = check(make()).urdf
        assert advice.sentences
        said += [f"{name}:", *(f"  {text}" for text in advice.sentences), advice.stops]
    words("\n".join(said))


@pytest.mark.parametrize("name", NOT_ADVISED)
def test_no_advice(name: str) -> None:
    assert check(NOT_ADVISED[name]()).urdf == UrdfAdvice((), "")


# Texts inside the root element.
PLACES = {
    "robot": '<link name="a"/>{}',
    "link": '<link name="a">{}</link>',
    "inertial": '<link name="a"><inertial>{}</inertial></link>',
    "joint": '<joint name="j" type="fixed">{}</joint>',
    "limit": '<joint name="j"><limit>{}</limit></joint>',
    "geometry": '<link name="a"><visual><geometry>{}</geometry></visual></link>',
}


def said(text: str, attributes: str = "") -> list[str]:
    return [*unread(ElementTree.fromstring(f'<robot name="r"{attributes}>{text}</robot>'))]


def test_what_is_not_read(words: Words) -> None:
    """Elements, attributes and texts that nobody reads, and what counts once, by their places."""
    text = ""
    for item in blocks(__file__, "test_what_is_not_read"):
        (sentence,) = said(*item.edits) if item.edits else said("", ' kind="arm"')
        text += f"{item.text}    {sentence}\n"
    words(text, masked=False)


def test_what_is_read_or_called_ignored_is_not_named() -> None:
    for read in (*(place.format("") for place in PLACES.values()),
                 '<gazebo>words</gazebo>\n<link name="a">\n</link>'):  # fmt: skip
        assert said(read) == []
    page = (Path(__file__).parents[2] / "docs" / "model_urdf.md").read_text(encoding="utf-8")
    text = (
        '<gazebo><odd/></gazebo><transmission name="t"><odd/></transmission>'
        '<material name="m"><texture filename="f"/></material>'
        '<joint name="j" type="revolute"><calibration rising="1"/><safety_controller k="1"/>'
        '<limit effort="1" velocity="1"/></joint>'
    )
    assert said(text, ' version="1.0"') == []
    for word in ("gazebo", "transmission", "texture", "calibration", "safety_controller", "effort",
                 "velocity", "version"):  # fmt: skip
        assert f"`{word}`" in page or f"`<{word}>`" in page, word

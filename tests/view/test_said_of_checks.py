"""What `check` says of clearances, the colours of links, and what `live` is asked to open."""

from __future__ import annotations

import io
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest
from rich.console import Console

import nipper_pin.view.live.serve as serve
from nipper_pin import Mechanism
from nipper_pin.cli import main
from nipper_pin.study.interference import Clearance
from nipper_pin.view.scene.colours import link_colour
from nipper_pin.view.scene.solids import _material
from nipper_pin.view.studies.check_report import _clearances


def said(items: tuple[Clearance, ...]) -> str:
    stream = io.StringIO()
    _clearances(SimpleNamespace(clearances=items), Console(file=stream, width=200))  # type: ignore[arg-type]
    return stream.getvalue()


def pair(distance: float, *, interferes: bool, may_touch: bool) -> Clearance:
    values = {
        "link_a": "rocker", "shape_a": "rod", "link_b": "frame", "shape_b": "wall",
        "distance_m": distance, "index": 12.25, "interferes": interferes, "may_touch": may_touch,
    }  # fmt: skip
    return SimpleNamespace(**values)  # type: ignore[return-value]


@pytest.mark.parametrize(
    ("interferes", "may_touch", "word"),
    [(True, False, "INTERFERENCE"), (False, True, "meet"), (False, False, "clear")],
)
def test_clearances_are_told_in_millimetres(interferes: bool, may_touch: bool, word: str) -> None:
    text = said((pair(0.0125, interferes=interferes, may_touch=may_touch),))
    assert f"{word}: rocker (rod) and frame (wall), 12.500 mm at index 12.25" in text
    assert "none" not in text


def test_no_clearance_is_said_to_be_none() -> None:
    assert "none: no two links" in said(())


def test_colours_are_those_of_the_material_itself_or_of_its_name() -> None:
    named = {"steel": (0.1, 0.2, 0.3)}
    own = "<visual><material name='steel'><color rgba='0.5 0.6 0.7 1'/></material></visual>"
    of_name = "<visual><material name='steel'/></visual>"
    unknown = "<visual><material name='brass'/></visual>"
    for text, colour in (
        (own, (0.5, 0.6, 0.7)),
        (of_name, (0.1, 0.2, 0.3)),
        (unknown, link_colour(2)),
        ("<visual/>", link_colour(2)),
    ):
        assert _material(ElementTree.fromstring(text), named, 2) == colour


@pytest.mark.parametrize(("words", "opens"), [([], True), (["--no-browser"], False)])
def test_live_opens_a_browser_unless_told_not_to(
    monkeypatch: pytest.MonkeyPatch, words: list[str], opens: bool
) -> None:
    asked: list[tuple[str, float, int, bool]] = []

    def served(mechanism: Mechanism, speed: float, port: int, *, browser: bool) -> None:
        asked.append((mechanism.name, speed, port, browser))

    monkeypatch.setattr(serve, "serve_live", served)
    assert main(["live", "e62", "--speed", "321", "--port", "4567", *words]) == 0
    assert asked == [("e62", 321.0, 4567, opens)]

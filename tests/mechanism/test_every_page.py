"""What a notebook shows of a mechanism, read as HTML and compared cell by cell."""

from __future__ import annotations

import math
from dataclasses import fields
from html.parser import HTMLParser
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from nipper_pin import Mechanism
from nipper_pin.mechanism import summary
from nipper_pin.mechanism.drives import Fourier, OscillatingGuide, Table
from nipper_pin.mechanism.elements import Characteristic
from nipper_pin.notebook import SHOWN, html


class Tables(HTMLParser):
    """Tables of a page as rows of cells; headings are marked."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tables: list[list[list[str]]] = []
        self.title: list[str] = []
        self.beside: list[str] = []
        self._open: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, _attrs: object) -> None:
        self._open.append(tag)
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append([])
        elif tag in ("td", "th"):
            self.tables[-1][-1].append("")

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        where = self._open[-1]
        if where == "td":
            self.tables[-1][-1][-1] += data
        elif where == "th":
            self.tables[-1][-1][-1] += f"# {data}"
        else:
            (self.title if where == "b" else self.beside).append(data)


def made(**changes: Any) -> Any:
    """A mechanism of two joints whose names all differ."""
    joints = [SimpleNamespace(name=f"joint {k}", kind=f"kind {k}", parent=f"parent {k}",
                              child=f"child {k}") for k in (1, 2)]  # fmt: skip
    given = {
        "name": "short", "title": "A <title> & more", "links": ("one", "two", "three"),
        "joints": joints, "closures": [SimpleNamespace(name="pin"), SimpleNamespace(name="slot")],
        "drives": [SimpleNamespace(name="shaft")], "degrees_of_freedom": 4,
        "stops": [SimpleNamespace(name="jaw", restitution=0.25),
                  SimpleNamespace(name="lift", restitution=0.5)],
        "cylinder": SimpleNamespace(rated_speed_rpm=650.0),
    }  # fmt: skip
    return SimpleNamespace(**{**given, **changes})


def test_page_of_a_mechanism() -> None:
    page = Tables(summary.page(made()))
    assert page.title == ["short: A <title> & more"]
    facts, joints = page.tables
    assert facts == [
        ["links", "one, two, three"], ["closures", "pin, slot"], ["drives", "shaft"],
        ["stops", "jaw (e_N 0.25), lift (e_N 0.5)"], ["mobility", "4"],
        ["rated speed [r/min]", "650"],
    ]  # fmt: skip
    assert joints == [
        ["# joint", "# kind", "# parent", "# child"],
        ["joint 1", "kind 1", "parent 1", "child 1"], ["joint 2", "kind 2", "parent 2", "child 2"],
    ]  # fmt: skip
    bare = Tables(summary.page(made(title="", closures=[], drives=[], stops=[], joints=[])))
    assert bare.title == ["short"]
    (facts,) = bare.tables
    assert [row[1] for row in facts[1:4]] == ["none"] * 3


def test_line_of_a_mechanism() -> None:
    assert summary.line(made()) == (
        "<Mechanism short: 2 joints, 2 closures, 1 drives, stops jaw, lift, mobility 4>"
    )
    assert summary.line(made(stops=[])).endswith("1 drives, stops none, mobility 4>")


def test_page_of_the_comber(e62: Mechanism) -> None:
    """Every joint in the order of the tree, with what it joins."""
    page = Tables(e62._repr_html_())
    assert page.tables[1][1:] == [
        [item.name, item.kind, item.parent, item.child] for item in e62.joints
    ]
    assert repr(e62) == summary.line(e62)


@pytest.mark.parametrize(
    ("rows", "count", "more"),
    [(SHOWN, None, ""), (SHOWN + 1, None, "and 1 more"), (SHOWN, SHOWN, ""),
     (SHOWN, SHOWN + 2000, "and 2,000 more"), (SHOWN - 1, None, "")],
)  # fmt: skip
def test_long_tables_say_how_much_is_left(rows: int, count: int | None, more: str) -> None:
    cells = [(k, 0.5 * k, None, f"<{k}>") for k in range(rows)]
    page = Tables(html("t", {"a": 1.23456789, "b": None}, ("w", "x", "y", "z"), cells, count))
    facts, table = page.tables
    assert facts == [["a", "1.23457"], ["b", "-"]]
    assert table[0] == ["# w", "# x", "# y", "# z"]
    assert table[1:] == [[str(k), f"{0.5 * k:g}", "-", f"<{k}>"] for k in range(min(rows, SHOWN))]
    assert page.beside == ([more] if more else [])


def test_pages_without_a_table() -> None:
    assert len(Tables(html("t", {"a": 1}, ("w",), ())).tables) == 1


@pytest.mark.parametrize(
    "make",
    [
        lambda n: OscillatingGuide(
            crank_radius_m=0.03 * n, crank_axis=(0.1, 0.2), guide_axis=(0.5, 0.6)
        ),
        lambda n: Fourier(mean=0.1 * n, cosine=(0.1, 0.2), sine=(0.0, 0.5)),
        lambda n: Table(
            cylinder_angle_rad=tuple(np.linspace(0.0, math.tau, 9).tolist()),
            coordinate=(0.0, 0.1 * n, 0.2, 0.3, 0.5, 0.3, 0.2, 0.1, 0.0),
        ),
        lambda n: Characteristic(coordinate=(0.0, 0.1, 0.2, 0.5), force=(0.0, 1.0 * n, 3.0, 9.0)),
    ],
)
def test_laws_are_what_they_are_made_of(make: Any) -> None:
    """Equal and told by their numbers; what is computed from these is neither."""
    one = make(1.0)
    assert one == make(1.0)
    assert one != make(2.0)
    assert hash(one) == hash(make(1.0))
    text = repr(one)
    for item in fields(one):
        assert (f"{item.name}=" in text) is not item.name.startswith("_"), item.name

"""What a notebook shows of a mechanism, as reviewed texts, and what laws say of themselves."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Any

import numpy as np
import pytest
from small_machines import SHAFT, hinge, link, machine
from snapshots import Words

from nipper_pin import Mechanism, load
from nipper_pin.mechanism import Characteristic
from nipper_pin.mechanism.drives import Cam, Fourier, Geared, OscillatingGuide, Table
from nipper_pin.notebook import SHOWN, html


def driven() -> Mechanism:
    """A shaft without a stop, whose title is markup."""
    drive = {"joint": "shaft", "law": "constant_speed", "ratio": 1.0, **SHAFT}
    parts = [link("disk"), hinge("shaft", "frame", "disk")]
    return machine(parts, 1, title="A <title> & more", drives={"shaft": drive})


def lines(page: str) -> str:
    """A tag a line, so that a difference can be read."""
    return page.replace("><", ">\n<") + "\n"


def test_pages_of_mechanisms(e62: Mechanism, words: Words) -> None:
    """Facts, and every joint in the order of the tree; in Python one line."""
    bare = machine([link("rod"), hinge("pivot", "frame", "rod")], 1)
    machines = (e62, load("hanging_pendulum"), driven(), bare)
    words("".join(f"{item!r}\n{lines(item._repr_html_())}\n" for item in machines))


@pytest.mark.parametrize(
    ("rows", "count", "more"),
    [(0, None, ""), (SHOWN, SHOWN, ""), (SHOWN + 1, None, "and 1 more"),
     (SHOWN, SHOWN + 2000, "and 2,000 more")],
)  # fmt: skip
def test_long_tables_say_how_much_is_left(rows: int, count: int | None, more: str) -> None:
    cells = [(k, 0.5 * k, None, f"<{k}>") for k in range(rows)]
    shown = html("t", {"a": 1.23456789, "b": None}, tuple("wxyz"), cells, count)
    assert shown.count("<table>") == (2 if cells else 1)
    if not cells:
        return
    facts, page = shown.split("<thead>")
    assert "<td>a</td><td>1.23457</td>" in facts
    assert "<td>b</td><td>-</td>" in facts
    assert "<th>w</th><th>x</th><th>y</th><th>z</th>" in page
    for k in range(rows):
        row = f"<td>{k}</td><td>{0.5 * k:g}</td><td>-</td><td>&lt;{k}&gt;</td>"
        assert (row in page) == (k < SHOWN)
    assert page.endswith(f"<p>{more}</p>" if more else "</table>")


GUIDE = {"crank_axis": (0.1, 0.2), "guide_axis": (0.5, 0.6)}
CAM = {"lift": 1.0, "start_rad": 0.2, "rise_rad": 1.6, "return_rad": 0.8}


@pytest.mark.parametrize(
    "make",
    [
        lambda n: Geared(of=OscillatingGuide(crank_radius_m=0.03 * n, **GUIDE), ratio=2.0),
        lambda n: Fourier(mean=0.1, cosine=(0.1, 0.2 * n), sine=(0.0, 0.5)),
        lambda n: Cam(motion="cycloidal", dwell_rad=0.1 * n, **CAM),
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
    assert repr(one) == repr(make(1.0)) != repr(make(2.0))
    text = repr(one)
    for item in fields(one):
        assert (f"{item.name}=" in text) is not item.name.startswith("_"), item.name

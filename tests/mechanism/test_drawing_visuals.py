"""Places of the visible parts of a drawn machine; thickness and colour are free."""

from __future__ import annotations

import math
from xml.etree import ElementTree

import numpy as np
import pytest

from nipper_pin.mechanism.drawing import Body, Drawing, Drive, Pin, Slide, drawn_mechanism

POINTS = {"O": (10.0, 5.0), "A": (50.0, 35.0), "B": (50.0, -45.0), "R": (90.0, 0.0)}
PARTS = (
    Body("crank", "O A B B"),
    Body("ram", "R", mass_kg=4.0),
    Body("rider", "A", mass_kg=1.0),
    Pin("O", "frame", "crank"),
    Slide("feed", "frame", "ram", "R", (3.0, 4.0)),
    Pin("A", "crank", "rider"),
    Drive("O"),
)


def shapes(link: str) -> dict[str, tuple[list[float], list[float], list[float], str]]:
    """Place [m], angles [rad], sizes [m] and kind of the shapes of a link, by their names."""
    drawing = Drawing("seen", "seen", POINTS, PARTS, 0.0, 0.0, 60.0)
    root = ElementTree.fromstring(drawn_mechanism(drawing).urdf)
    found = {}
    for item in root.findall(f"link[@name='{link}']/visual"):
        origin, solid = item.find("origin"), next(iter(item.findall("geometry/*")))
        assert origin is not None
        place, angles = (
            [float(word) for word in origin.attrib[key].split()] for key in ("xyz", "rpy")
        )
        sizes = [float(word) for value in solid.attrib.values() for word in value.split()]
        found[item.attrib["name"]] = (place, angles, sizes, solid.tag)
    return found


def test_bars_join_the_points_of_a_body() -> None:
    """Halfway between two points, as long as they are apart, along their line; none of no length.

    The frame of the link stands in O; turns about +y are clockwise. Bars are flat and thin.
    """
    found = shapes("crank")
    assert set(found) == {"bar_0", "bar_1", "eye_0", "eye_1", "eye_2"}
    for name, middle, length, angle in (
        ("bar_0", (20.0, 15.0), 50.0, math.atan2(30.0, 40.0)),
        ("bar_1", (40.0, -10.0), 80.0, -0.5 * math.pi),
    ):
        place, angles, sizes, kind = found[name]
        assert kind == "box"
        assert (place[0], place[2]) == pytest.approx([1e-3 * part for part in middle])
        assert angles == pytest.approx([0.0, -angle, 0.0], abs=1e-8)
        assert sizes[0] == pytest.approx(1e-3 * length)
        assert 0.0 < sizes[1] < sizes[2] < 0.1 * sizes[0]
    for number, (x, z) in enumerate(((0.0, 0.0), (40.0, 30.0), (40.0, -50.0))):
        place, angles, sizes, kind = found[f"eye_{number}"]
        assert kind == "cylinder"
        assert (place[0], place[2]) == pytest.approx((1e-3 * x, 1e-3 * z))
        # Its axis is that of the hinge.
        assert angles == pytest.approx([0.5 * math.pi, 0.0, 0.0], abs=1e-9)
        assert sizes[0] > 0.5 * found["bar_0"][2][2]


def test_blocks_and_guides_lie_along_their_slides() -> None:
    """A block on the slide, turned with it; one that only turns is not; the rail is longer."""
    (block,) = shapes("ram").values()
    assert (block[0][0], block[0][2]) == (0.0, 0.0)
    lean = -math.atan2(4.0, 3.0)
    assert block[1] == pytest.approx([0.0, lean, 0.0], abs=1e-8)
    assert block[2][0] == block[2][2]
    (rider,) = shapes("rider").values()
    assert rider[1] == [0.0, 0.0, 0.0]
    frame = shapes("frame")
    assert set(frame) == {"foot_O", "rail_feed"}
    rail, foot = frame["rail_feed"], frame["foot_O"]
    assert (rail[0][0], rail[0][2]) == pytest.approx((0.09, 0.0))
    assert rail[1] == pytest.approx([0.0, lean, 0.0], abs=1e-8)
    assert rail[2][0] > 2.0 * block[2][0]
    # The ground is below its pin, and touches the bar.
    assert foot[0][0] == pytest.approx(0.01)
    assert foot[0][2] + 0.5 * foot[2][2] == pytest.approx(0.005, abs=1e-4)
    assert foot[1] == [0.0, 0.0, 0.0]


def test_layers_do_not_lie_in_one_another() -> None:
    """Each body has a depth of its own, beside the ground; all of them within their sizes."""
    depths = {}
    for link in ("frame", "crank", "ram", "rider"):
        for place, _, sizes, kind in shapes(link).values():
            if kind == "box":
                depths.setdefault(link, set()).add((place[1], sizes[1]))
    layers = [item for (item,) in depths.values()]
    assert len(layers) == 4
    for number, (place, depth) in enumerate(layers):
        for other, _ in layers[:number]:
            assert abs(place - other) > 0.999 * depth
    extent = 1e-3 * np.ptp(list(POINTS.values()), axis=0).max()
    assert all(abs(place) < 0.2 * extent for place, _ in layers)

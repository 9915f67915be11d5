"""The five six-bars of one freedom: Watt's two and Stephenson's three."""

from __future__ import annotations

from ..drawing import (
    Body,
    Drawing,
    Drive,
    Pin,
    Place,
    Stop,
    between,
    direction,
    meet,
    polar,
    telescope,
)

_KNOWN = "chain and frame as in textbooks on the synthesis of mechanisms; sizes are an invention"
_A, _D = (0.0, 0.0), (100.0, 0.0)


def _crank_rocker(touch: float) -> dict[str, Place]:
    b = polar(_A, 30.0, touch)
    return {"A": _A, "B": b, "C": meet(b, 90.0, _D, 60.0, left=True), "D": _D}


def watt_1() -> Drawing:
    """The frame is a link with two pins: the output is carried by coupler and rocker."""
    touch = -20.0
    points = _crank_rocker(touch)
    e = between(points["B"], points["C"], 0.6, 35.0)
    g = polar(_D, 55.0, direction(_D, points["C"]) - 55.0)
    h = meet(e, 75.0, g, 60.0, left=True)
    return Drawing(
        "watt_1",
        "Watt's six-bar I: a dyad between coupler and rocker",
        {**points, "E": e, "G": g, "H": h},
        (
            Body("crank", "A B"),
            Body("coupler", "B C E B"),
            Body("rocker", "C D G"),
            Body("arm", "G H"),
            Pin("A", "frame", "crank"),
            Pin("D", "frame", "rocker"),
            Pin("B", "crank", "coupler"),
            Pin("G", "rocker", "arm"),
            Pin("C", "coupler", "rocker"),
            Pin("E", "coupler", "link_1"),
            *telescope("link", "E H", 6000.0, 6.0, longer=True),
            Pin("H", "link_2", "arm"),
            Drive("A"),
            Stop("G", "upper", restitution=0.3),
        ),
        touch_deg=touch,
        start_deg=touch - 150.0,
        speed_rpm=120.0,
        closed=("link",),
        struck="G",
        known=_KNOWN,
        traced="arm H",
    )


def watt_2() -> Drawing:
    """Two four-bars in a row: the rocker of the first drives the second."""
    touch = -15.0
    points = _crank_rocker(touch)
    e = polar(_D, 45.0, direction(_D, points["C"]) - 60.0)
    f = (200.0, 0.0)
    g = meet(e, 80.0, f, 60.0, left=True)
    return Drawing(
        "watt_2",
        "Watt's six-bar II: two four-bars in a row",
        {**points, "E": e, "F": f, "G": g},
        (
            Body("crank", "A B"),
            Body("coupler", "B C"),
            Body("rocker", "C D E C"),
            Body("output", "F G"),
            Pin("A", "frame", "crank"),
            Pin("D", "frame", "rocker"),
            Pin("F", "frame", "output"),
            Pin("B", "crank", "coupler"),
            Pin("C", "coupler", "rocker"),
            Pin("E", "rocker", "link_1"),
            *telescope("link", "E G", 6000.0, 6.0),
            Pin("G", "link_2", "output"),
            Drive("A"),
            Stop("F", restitution=0.3),
        ),
        touch_deg=touch,
        start_deg=touch - 150.0,
        speed_rpm=120.0,
        closed=("link",),
        struck="F",
        known=_KNOWN,
        traced="output G",
    )


def stephenson_1() -> Drawing:
    """Crank and rocker have three pins each: a dyad joins them."""
    touch = 45.0
    points = _crank_rocker(touch)
    e = polar(_A, 18.0, touch - 120.0)
    g = polar(_D, 50.0, direction(_D, points["C"]) + 70.0)
    h = meet(e, 95.0, g, 70.0, left=False)
    return Drawing(
        "stephenson_1",
        "Stephenson's six-bar I: a dyad between crank and rocker",
        {**points, "E": e, "G": g, "H": h},
        (
            Body("crank", "E A B"),
            Body("coupler", "B C"),
            Body("rocker", "C D G"),
            Body("arm", "G H"),
            Pin("A", "frame", "crank"),
            Pin("D", "frame", "rocker"),
            Pin("B", "crank", "coupler"),
            Pin("G", "rocker", "arm"),
            Pin("C", "coupler", "rocker"),
            Pin("E", "crank", "link_1"),
            *telescope("link", "E H", 6000.0, 6.0),
            Pin("H", "link_2", "arm"),
            Drive("A"),
            Stop("G", "upper", restitution=0.3),
        ),
        touch_deg=touch,
        start_deg=touch - 150.0,
        speed_rpm=120.0,
        closed=("link",),
        struck="G",
        known=_KNOWN,
        traced="arm H",
    )


def stephenson_2() -> Drawing:
    """The crank has three pins; two links lead to a floating one, which a rocker guides."""
    touch = 60.0
    a, f = (0.0, 0.0), (170.0, -70.0)
    b, e = polar(a, 20.0, touch), polar(a, 20.0, touch + 110.0)
    c, g, h = (110.0, 70.0), (70.0, -50.0), (165.0, 10.0)
    return Drawing(
        "stephenson_2",
        "Stephenson's six-bar II: a floating link between two links of the crank and a rocker",
        {"A": a, "B": b, "E": e, "C": c, "G": g, "H": h, "F": f},
        (
            Body("crank", "B A E B"),
            Body("first", "B C"),
            Body("floating", "C G H C"),
            Body("rocker", "F H"),
            Pin("A", "frame", "crank"),
            Pin("F", "frame", "rocker"),
            Pin("B", "crank", "first"),
            Pin("C", "first", "floating"),
            Pin("E", "crank", "second_1"),
            *telescope("second", "E G", 6000.0, 6.0),
            Pin("G", "second_2", "floating"),
            Pin("H", "floating", "rocker"),
            Drive("A"),
            Stop("F", restitution=0.3),
        ),
        touch_deg=touch,
        start_deg=touch + 150.0,
        clockwise=True,
        speed_rpm=120.0,
        closed=("second",),
        struck="F",
        known=_KNOWN,
        traced="floating H",
    )


def stephenson_3() -> Drawing:
    """A point of a four-bar's coupler drives a rocker."""
    touch = -125.0
    points = _crank_rocker(touch)
    p = between(points["B"], points["C"], 0.5, 50.0)
    f = (-70.0, 30.0)
    g = meet(p, 90.0, f, 80.0, left=True)
    return Drawing(
        "stephenson_3",
        "Stephenson's six-bar III: a coupler point drives a rocker",
        {**points, "P": p, "G": g, "F": f},
        (
            Body("crank", "A B"),
            Body("coupler", "B C P B"),
            Body("rocker", "D C"),
            Body("output", "F G"),
            Pin("A", "frame", "crank"),
            Pin("D", "frame", "rocker"),
            Pin("F", "frame", "output"),
            Pin("B", "crank", "coupler"),
            Pin("C", "coupler", "rocker"),
            Pin("P", "coupler", "link_1"),
            *telescope("link", "P G", 6000.0, 6.0),
            Pin("G", "link_2", "output"),
            Drive("A"),
            Stop("F", restitution=0.3),
        ),
        touch_deg=touch,
        start_deg=touch - 150.0,
        speed_rpm=120.0,
        closed=("link",),
        struck="F",
        known=_KNOWN,
        traced="coupler P",
    )


SIX_BARS = (watt_1, watt_2, stephenson_1, stephenson_2, stephenson_3)

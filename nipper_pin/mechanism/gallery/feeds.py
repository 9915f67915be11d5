"""Machines that sew and feed."""

from __future__ import annotations

from ..drawing import (
    Body,
    Drawing,
    Drive,
    Pin,
    Slide,
    Stop,
    between,
    flap,
    meet,
    on_line,
    polar,
    telescope,
)


def needle_bar() -> Drawing:
    """One crank moves needle bar and take-up lever, which has a check spring."""
    touch = -140.0
    o, f = (0.0, 0.0), (26.0, 22.0)
    a = polar(o, 16.0, touch)
    n = on_line(a, 45.0, o, (0.0, -1.0), ahead=True)
    b = meet(a, 34.0, f, 24.0, left=True)
    e = between(a, b, 2.2, 10.0)
    return Drawing(
        "needle_bar",
        "needle bar with its buffer, and take-up lever with its check spring",
        {"O": o, "A": a, "N": n, "F": f, "B": b, "E": e, "S": (e[0], e[1] + 14.0)},
        (
            Body("crank", "O A"),
            Body("take_up", "A B E", 0.3),
            Body("guide", "F B", 0.3),
            Body("bar", "N", mass_kg=0.05),
            Pin("O", "frame", "crank"),
            Pin("F", "frame", "guide"),
            Slide("height", "frame", "bar", "N", (0.0, 1.0)),
            Pin("A", "crank", "take_up"),
            Pin("B", "take_up", "guide"),
            Pin("A", "crank", "rod_1"),
            *telescope("rod", "A N", 15000.0, 2.0, density_kg_m=0.3),
            Pin("N", "rod_2", "bar"),
            *flap("check", "take_up", "E S", 0.01, 2.5, 30.0, density_kg_m=0.1),
            Drive("O", inertia=0.002),
            Stop("height", restitution=0.3),
        ),
        touch_deg=touch,
        start_deg=touch - 140.0,
        speed_rpm=300.0,
        closed=("rod", "check"),
        struck="height",
        traced="take_up E",
    )


def ratchet_feed() -> Drawing:
    """A crank-rocker swings a pawl, which a spring holds on its stop."""
    touch = 100.0
    o, d = (0.0, 0.0), (90.0, 0.0)
    a = polar(o, 20.0, touch)
    c = meet(a, 80.0, d, 50.0, left=True)
    return Drawing(
        "ratchet_feed",
        "feed of a planer: rocker with a spring-held pawl",
        {"O": o, "A": a, "C": c, "D": d, "T": (c[0] - 30.0, c[1] + 8.0)},
        (
            Body("crank", "O A"),
            Body("rod", "A C"),
            Body("rocker", "D C"),
            Pin("O", "frame", "crank"),
            Pin("D", "frame", "rocker"),
            Pin("A", "crank", "rod"),
            Pin("C", "rod", "rocker"),
            *flap("pawl", "rocker", "C T", 0.02, 1.5, -20.0),
            Drive("O"),
        ),
        touch_deg=touch,
        start_deg=touch,
        speed_rpm=200.0,
        closed=("pawl",),
        traced="pawl T",
    )


def film_claw() -> Drawing:
    """A coupler point enters the film's holes; the claw on it may tilt."""
    touch = 0.0
    o, d = (0.0, 0.0), (40.0, 20.0)
    a = polar(o, 8.0, touch)
    c = meet(a, 36.0, d, 24.0, left=False)
    e = between(a, c, 1.6, -8.0)
    return Drawing(
        "film_claw",
        "film feed: coupler with a claw that a spring holds",
        {"O": o, "A": a, "C": c, "D": d, "E": e, "T": (e[0] + 14.0, e[1])},
        (
            Body("crank", "O A"),
            Body("coupler", "A C E", 0.3),
            Body("rocker", "D C", 0.3),
            Pin("O", "frame", "crank"),
            Pin("D", "frame", "rocker"),
            Pin("A", "crank", "coupler"),
            Pin("C", "coupler", "rocker"),
            *flap("claw", "coupler", "E T", 0.01, 3.0, 20.0, density_kg_m=0.2),
            Drive("O", inertia=0.002),
        ),
        touch_deg=touch,
        start_deg=touch,
        speed_rpm=600.0,
        closed=("claw",),
        traced="claw T",
    )


FEEDS = (needle_bar, ratchet_feed, film_claw)

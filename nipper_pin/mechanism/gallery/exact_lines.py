"""Linkages that guide a point along an exact straight line, and their relatives."""

from __future__ import annotations

from ..drawing import (
    Body,
    Drawing,
    Drive,
    Pin,
    Slide,
    Stop,
    flap,
    meet,
    polar,
    telescope,
)


def scott_russell() -> Drawing:
    """The crank is half the coupler, whose far end goes straight through the crank's axis."""
    o, b = (0.0, 0.0), polar((0.0, 0.0), 60.0, 40.0)
    c, p = (2.0 * b[0], 0.0), (0.0, 2.0 * b[1])
    r = (0.0, p[1] + 70.0)
    return Drawing(
        "scott_russell",
        "Scott Russell's straight line lifts a slide against a buffer",
        {"O": o, "B": b, "C": c, "P": p, "R": r},
        (
            Body("crank", "O B"),
            Body("coupler", "C B P"),
            Body("block", "C", mass_kg=0.1),
            Body("slider", "R", mass_kg=0.5),
            Pin("O", "frame", "crank"),
            Slide("way", "frame", "block", "C", (1.0, 0.0)),
            Slide("travel", "frame", "slider", "R", (0.0, -1.0)),
            Pin("B", "crank", "coupler"),
            Pin("C", "coupler", "block"),
            Pin("P", "coupler", "rod_1"),
            *telescope("rod", "P R", 8000.0, 6.0),
            Pin("R", "rod_2", "slider"),
            Drive("O", "fourier", {"cosine_rad": [0.3]}),
            Stop("travel", restitution=0.3),
        ),
        touch_deg=-60.0,
        start_deg=-200.0,
        speed_rpm=120.0,
        closed=("rod",),
        struck="travel",
        known="Scott Russell's proportions, coupler twice the crank; size an invention",
        traced="coupler P",
    )


def peaucellier() -> Drawing:
    """The inversor: a circle through the pole becomes an exact straight line."""
    o, e = (0.0, 0.0), (30.0, 0.0)
    p = polar(e, 30.0, 20.0)
    far = 7500.0 / (p[0] ** 2 + p[1] ** 2)
    q = (far * p[0], far * p[1])
    b, c = meet(o, 100.0, p, 50.0, left=True), meet(o, 100.0, p, 50.0, left=False)
    r = (q[0], q[1] + 70.0)
    return Drawing(
        "peaucellier",
        "Peaucellier and Lipkin's inversor lifts a slide against a buffer",
        {"O": o, "E": e, "P": p, "Q": q, "B": b, "C": c, "R": r},
        (
            Body("crank", "E P"),
            Body("long_1", "O B"),
            Body("long_2", "O C"),
            Body("short_1", "P B"),
            Body("short_2", "P C"),
            Body("short_3", "B Q"),
            Body("short_4", "C Q"),
            Body("slider", "R", mass_kg=0.5),
            Pin("E", "frame", "crank"),
            Pin("O", "frame", "long_1"),
            Pin("O", "frame", "long_2"),
            Slide("travel", "frame", "slider", "R", (0.0, -1.0)),
            Pin("P", "crank", "short_1"),
            Pin("P", "crank", "short_2"),
            Pin("B", "long_1", "short_3"),
            Pin("C", "long_2", "short_4"),
            Pin("B", "long_1", "short_1", "B_rhombus"),
            Pin("C", "long_2", "short_2", "C_rhombus"),
            Pin("Q", "short_3", "short_4"),
            Pin("Q", "short_3", "rod_1"),
            *telescope("rod", "Q R", 8000.0, 6.0),
            Pin("R", "rod_2", "slider"),
            Drive("E", "fourier", {"cosine_rad": [0.4]}),
            Stop("travel", restitution=0.3),
        ),
        touch_deg=-60.0,
        start_deg=-200.0,
        speed_rpm=120.0,
        closed=("rod",),
        struck="travel",
        known="the inversor's proportions: crank's axis halfway to the pole; size an invention",
        traced="short_3 Q",
    )


def evans() -> Drawing:
    """Grasshopper: Scott Russell's block replaced by a long rocker."""
    o, b = (0.0, 0.0), polar((0.0, 0.0), 60.0, 35.0)
    c, p = (2.0 * b[0], 0.0), (0.0, 2.0 * b[1])
    return Drawing(
        "evans",
        "Evans' grasshopper carries a spring-held lever",
        {"O": o, "B": b, "C": c, "F": (c[0], -160.0), "P": p, "Q": (30.0, p[1] + 10.0)},
        (
            Body("crank", "O B"),
            Body("beam", "C B P"),
            Body("rocker", "F C"),
            Pin("O", "frame", "crank"),
            Pin("F", "frame", "rocker"),
            Pin("B", "crank", "beam"),
            Pin("C", "beam", "rocker"),
            *flap("lever", "beam", "P Q", 0.1, 0.3, 25.0),
            Drive("O", "fourier", {"cosine_rad": [0.3]}),
        ),
        touch_deg=90.0,
        start_deg=90.0,
        speed_rpm=320.0,
        closed=("lever",),
        known="Evans' proportions, beam twice the crank; sizes an invention",
        traced="beam P",
    )


EXACT_LINES = (scott_russell, peaucellier, evans)

"""Linkages that guide a point along a straight line, exactly or nearly."""

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


def hoeken() -> Drawing:
    """Crank 1, ground 2, rocker and both halves of the coupler 2.5."""
    touch = 35.0
    a, d = (0.0, 0.0), (40.0, 0.0)
    b = polar(a, 20.0, touch)
    c = meet(b, 50.0, d, 50.0, left=True)
    p = between(b, c, 2.0)
    r = on_line(p, 90.0, (40.0, 80.0), (1.0, 0.0), ahead=True)
    return Drawing(
        "hoeken",
        "Hoeken's straight line pushes a slide against a buffer",
        {"A": a, "B": b, "C": c, "D": d, "P": p, "R": r},
        (
            Body("crank", "A B"),
            Body("coupler", "B C P"),
            Body("rocker", "D C"),
            Body("slider", "R", mass_kg=0.5),
            Pin("A", "frame", "crank"),
            Pin("D", "frame", "rocker"),
            Slide("travel", "frame", "slider", "R", (-1.0, 0.0)),
            Pin("B", "crank", "coupler"),
            Pin("C", "coupler", "rocker"),
            Pin("P", "coupler", "rod_1"),
            *telescope("rod", "P R", 8000.0, 6.0),
            Pin("R", "rod_2", "slider"),
            Drive("A"),
            Stop("travel", restitution=0.3),
        ),
        touch_deg=touch,
        start_deg=touch - 150.0,
        speed_rpm=120.0,
        closed=("rod",),
        struck="travel",
        known="Hoeken's proportions 1 : 2 : 2.5 : 2.5, coupler prolonged by 2.5; size an invention",
        traced="coupler P",
    )


def chebyshev() -> Drawing:
    """Crossed: coupler 1, ground 2, rockers 2.5."""
    a, d, b, c, p = (0.0, 0.0), (80.0, 0.0), (60.0, 80.0), (20.0, 80.0), (40.0, 80.0)
    return Drawing(
        "chebyshev",
        "Chebyshev's straight line carries a spring-held lever",
        {"A": a, "D": d, "B": b, "C": c, "P": p, "Q": (40.0, 110.0)},
        (
            Body("input", "A B"),
            Body("output", "D C"),
            Body("coupler", "B P C"),
            Pin("A", "frame", "input"),
            Pin("D", "frame", "output"),
            Pin("B", "input", "coupler"),
            Pin("C", "coupler", "output"),
            *flap("lever", "coupler", "P Q", 0.2, 0.35, 25.0),
            Drive("A", "fourier", {"cosine_rad": [0.15]}),
        ),
        touch_deg=90.0,
        start_deg=90.0,
        speed_rpm=200.0,
        closed=("lever",),
        known="Chebyshev's proportions 1 : 2 : 2.5; size an invention",
        traced="coupler P",
    )


def roberts() -> Drawing:
    """Rockers and sides of the triangle equal, its base half the ground."""
    a, d, p = (0.0, 0.0), (160.0, 0.0), (80.0, 0.0)
    b, c, r = (40.0, 90.0), (120.0, 90.0), (200.0, 0.0)
    return Drawing(
        "roberts",
        "Roberts' straight line pushes a slide against a buffer",
        {"A": a, "D": d, "B": b, "C": c, "P": p, "R": r},
        (
            Body("input", "A B"),
            Body("output", "D C"),
            Body("coupler", "B C P B"),
            Body("slider", "R", mass_kg=0.5),
            Pin("A", "frame", "input"),
            Pin("D", "frame", "output"),
            Slide("travel", "frame", "slider", "R", (-1.0, 0.0)),
            Pin("B", "input", "coupler"),
            Pin("C", "coupler", "output"),
            Pin("P", "coupler", "rod_1"),
            *telescope("rod", "P R", 8000.0, 6.0),
            Pin("R", "rod_2", "slider"),
            Drive("A", "fourier", {"cosine_rad": [0.2]}),
            Stop("travel", restitution=0.3),
        ),
        touch_deg=120.0,
        start_deg=-20.0,
        speed_rpm=120.0,
        closed=("rod",),
        struck="travel",
        known="Roberts' proportions, base of the triangle half the ground; size an invention",
        traced="coupler P",
    )


def watt_line() -> Drawing:
    """Two equal rockers and a short coupler, whose middle goes straight."""
    a, d, b, c = (0.0, 0.0), (200.0, -50.0), (100.0, 0.0), (100.0, -50.0)
    p, r = (100.0, -25.0), (100.0, -110.0)
    return Drawing(
        "watt_line",
        "Watt's straight line guides a piston rod against a buffer",
        {"A": a, "D": d, "B": b, "C": c, "P": p, "R": r},
        (
            Body("input", "A B"),
            Body("output", "D C"),
            Body("coupler", "B P C"),
            Body("piston", "R", mass_kg=0.5),
            Pin("A", "frame", "input"),
            Pin("D", "frame", "output"),
            Slide("height", "frame", "piston", "R", (0.0, 1.0)),
            Pin("B", "input", "coupler"),
            Pin("C", "coupler", "output"),
            Pin("P", "coupler", "rod_1"),
            *telescope("rod", "P R", 8000.0, 6.0),
            Pin("R", "rod_2", "piston"),
            Drive("A", "fourier", {"cosine_rad": [0.2]}),
            Stop("height", restitution=0.3),
        ),
        touch_deg=120.0,
        start_deg=-20.0,
        speed_rpm=120.0,
        closed=("rod",),
        struck="height",
        known="Watt's linkage of equal rockers, 2 : 1 to the coupler; size an invention",
        traced="coupler P",
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


STRAIGHT_LINES = (hoeken, chebyshev, roberts, watt_line, scott_russell, peaucellier, evans)

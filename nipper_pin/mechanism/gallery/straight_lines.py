"""Linkages that guide a point nearly along a straight line."""

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


STRAIGHT_LINES = (hoeken, chebyshev, roberts, watt_line)

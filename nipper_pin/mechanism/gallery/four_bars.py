"""Four-bars of every Grashof class."""

from __future__ import annotations

from ..drawing import Body, Drawing, Drive, Pin, Stop, flap, meet, polar, telescope

_RATIOS = "ratios of the links chosen for its Grashof class; sizes are an invention"


def crank_rocker() -> Drawing:
    """The shortest link is the crank: it turns round, the rocker swings."""
    touch = -15.0
    a, d = (0.0, 0.0), (100.0, 0.0)
    b = polar(a, 30.0, touch)
    c = meet(b, 90.0, d, 60.0, left=True)
    return Drawing(
        "crank_rocker",
        "crank-rocker whose rocker strikes a stop before its end",
        {"A": a, "B": b, "C": c, "D": d},
        (
            Body("crank", "A B"),
            Body("rocker", "D C"),
            Pin("A", "frame", "crank"),
            Pin("D", "frame", "rocker"),
            Pin("B", "crank", "coupler_1"),
            *telescope("coupler", "B C", 5000.0, 6.0),
            Pin("C", "coupler_2", "rocker"),
            Drive("A"),
            Stop("D", restitution=0.3),
        ),
        touch_deg=touch,
        start_deg=touch - 150.0,
        speed_rpm=200.0,
        closed=("coupler",),
        struck="D",
        known=f"crank 30, coupler 90, rocker 60, ground 100 mm: {_RATIOS}",
        traced="rocker C",
    )


def double_crank() -> Drawing:
    """The shortest link is the frame: both cranks turn round, one of them unevenly."""
    touch = 40.0
    a, d = (0.0, 0.0), (30.0, 0.0)
    b = polar(a, 70.0, touch)
    c = meet(b, 60.0, d, 80.0, left=False)
    e = polar(c, 25.0, touch + 60.0)
    return Drawing(
        "double_crank",
        "double crank with a spring-held lever on the uneven crank",
        {"A": a, "B": b, "C": c, "D": d, "E": e},
        (
            Body("crank", "A B"),
            Body("follower", "D C"),
            Body("coupler", "B C"),
            Pin("A", "frame", "crank"),
            Pin("D", "frame", "follower"),
            Pin("B", "crank", "coupler"),
            Pin("C", "coupler", "follower"),
            *flap("lever", "follower", "C E", 0.03, 4.0, 30.0),
            Drive("A"),
        ),
        touch_deg=touch,
        start_deg=touch,
        speed_rpm=250.0,
        closed=("lever",),
        known=f"crank 70, coupler 60, follower 80, ground 30 mm: {_RATIOS}",
        traced="lever E",
    )


def double_rocker() -> Drawing:
    """The shortest link is the coupler: neither rocker turns round, so the input swings."""
    a, d = (0.0, 0.0), (100.0, 0.0)
    b = polar(a, 70.0, 80.0)
    c = meet(b, 40.0, d, 80.0, left=True)
    return Drawing(
        "double_rocker",
        "Grashof double rocker, its input swung by a shaft",
        {"A": a, "B": b, "C": c, "D": d},
        (
            Body("input", "A B"),
            Body("output", "D C"),
            Pin("A", "frame", "input"),
            Pin("D", "frame", "output"),
            Pin("B", "input", "coupler_1"),
            *telescope("coupler", "B C", 8000.0, 4.0),
            Pin("C", "coupler_2", "output"),
            Drive("A", "fourier", {"cosine_rad": [0.25]}),
            Stop("D", restitution=0.3),
        ),
        touch_deg=60.0,
        start_deg=-20.0,
        speed_rpm=150.0,
        closed=("coupler",),
        struck="D",
        known=f"rockers 70 and 80, coupler 40, ground 100 mm: {_RATIOS}",
        traced="output C",
    )


def triple_rocker() -> Drawing:
    """Shortest and longest link are longer than the other two: nothing turns round."""
    a, d = (0.0, 0.0), (90.0, 0.0)
    b = polar(a, 50.0, 75.0)
    c = meet(b, 50.0, d, 60.0, left=True)
    return Drawing(
        "triple_rocker",
        "triple rocker, driven over a part of its range",
        {"A": a, "B": b, "C": c, "D": d},
        (
            Body("input", "A B"),
            Body("output", "D C"),
            Pin("A", "frame", "input"),
            Pin("D", "frame", "output"),
            Pin("B", "input", "coupler_1"),
            *telescope("coupler", "B C", 8000.0, 4.0),
            Pin("C", "coupler_2", "output"),
            Drive("A", "fourier", {"cosine_rad": [0.3]}),
            Stop("D", restitution=0.5),
        ),
        touch_deg=50.0,
        start_deg=-30.0,
        speed_rpm=150.0,
        closed=("coupler",),
        struck="D",
        known=f"rockers 50 and 60, coupler 50, ground 90 mm: {_RATIOS}",
        traced="output C",
    )


FOUR_BARS = (crank_rocker, double_crank, double_rocker, triple_rocker)

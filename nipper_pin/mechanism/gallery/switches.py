"""Switches and bells."""

from __future__ import annotations

from ..drawing import (
    Body,
    Drawing,
    Drive,
    Pin,
    Slide,
    Slot,
    Spring,
    Stop,
    flap,
    meet,
    polar,
    telescope,
)


def circuit_breaker() -> Drawing:
    """A toggle throws the contact arm shut; the contact spring is in its lower link."""
    touch = -50.0
    h, f, d = (-110.0, 60.0), (0.0, 90.0), (60.0, 0.0)
    a = polar(h, 20.0, touch)
    b = (-12.0, 30.0)
    c = (18.0, -28.0)
    return Drawing(
        "circuit_breaker",
        "toggle of a circuit breaker with contact spring and fixed contact",
        {"H": h, "A": a, "F": f, "B": b, "C": c, "D": d, "E": (100.0, 30.0)},
        (
            Body("shaft", "H A"),
            Body("rod", "A B"),
            Body("upper", "F B"),
            Body("arm", "C D E"),
            Pin("H", "frame", "shaft"),
            Pin("F", "frame", "upper"),
            Pin("D", "frame", "arm"),
            Pin("A", "shaft", "rod"),
            Pin("B", "rod", "upper"),
            Pin("B", "upper", "lower_1"),
            *telescope("lower", "B C", 20000.0, 5.0),
            Pin("C", "lower_2", "arm"),
            Drive("H"),
            Stop("D", "upper", restitution=0.3),
        ),
        touch_deg=touch,
        start_deg=touch - 150.0,
        speed_rpm=120.0,
        closed=("lower",),
        struck="D",
        traced="arm E",
    )


def relay() -> Drawing:
    """The armature is pulled and let go; the blade on it bounces on the fixed contact."""
    touch = 50.0
    p, a, e = (0.0, 0.0), (30.0, 0.0), (70.0, 0.0)
    return Drawing(
        "relay",
        "relay: armature, contact blade with its preload, fixed contact",
        {"P": p, "A": a, "E": e, "U": (70.0, 20.0)},
        (
            Body("armature", "P A", 0.5),
            Body("blade", "A E", 0.05),
            Body("contact", "E", mass_kg=0.0005),
            Pin("P", "frame", "armature"),
            Pin("A", "armature", "blade", "blade"),
            Slide("gap", "frame", "contact", "E", (0.0, 1.0)),
            Slot("button", "contact", "blade", "E", (1.0, 0.0), 0.0005),
            Spring("blade", 0.5, 4.0),
            Stop("blade", restitution=0.3),
            Drive("P", "fourier", {"cosine_rad": [0.04, 0.0, -0.004]}, inertia=0.001),
            Stop("gap", restitution=0.5),
        ),
        touch_deg=touch,
        start_deg=touch - 80.0,
        speed_rpm=600.0,
        closed=("blade",),
        struck="gap",
        traced="blade E",
    )


def bell() -> Drawing:
    """The bell is swung; its clapper strikes either side."""
    return Drawing(
        "bell",
        "swinging bell with a clapper between two stops",
        {"O": (0.0, 0.0), "L": (-40.0, -90.0), "R": (40.0, -90.0), "C": (0.0, -15.0),
         "K": (0.0, -85.0)},
        (
            Body("bell", "L O R", 20.0),
            Body("clapper", "C K", 3.0),
            Pin("O", "frame", "bell"),
            Pin("C", "bell", "clapper"),
            Spring("C", 0.005, 0.0),
            Stop("C", "lower", -20.0, 0.4, "left"),
            Stop("C", "upper", 20.0, 0.4, "right"),
            Drive("O", "fourier", {"sine_rad": [0.7]}),
        ),
        touch_deg=0.0,
        start_deg=0.0,
        speed_rpm=60.0,
        struck="right",
        traced="clapper K",
    )  # fmt: skip


def doorbell() -> Drawing:
    """An eccentric swings a lever; the striker on it overshoots its rest and rings."""
    touch = 90.0
    o, p = (0.0, 0.0), (70.0, 0.0)
    a = polar(o, 6.0, touch)
    c = meet(a, 60.0, p, 30.0, left=True)
    return Drawing(
        "doorbell",
        "striker of a bell on a swinging lever, between rest and gong",
        {"O": o, "A": a, "C": c, "P": p, "S": (c[0] + 10.0, c[1] + 50.0)},
        (
            Body("crank", "O A", mass_kg=0.02),
            Body("rod", "A C", 0.3),
            Body("lever", "P C", 0.5),
            Pin("O", "frame", "crank"),
            Pin("P", "frame", "lever"),
            Pin("A", "crank", "rod"),
            Pin("C", "rod", "lever"),
            *flap("striker", "lever", "C S", 0.05, 4.0, 15.0, density_kg_m=0.4),
            Drive("O", inertia=0.01),
        ),
        touch_deg=touch,
        start_deg=touch,
        speed_rpm=400.0,
        closed=("striker",),
        traced="striker S",
    )


SWITCHES = (circuit_breaker, relay, bell, doorbell)

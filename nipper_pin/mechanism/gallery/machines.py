"""Machines that beat, pump and shake."""

from __future__ import annotations

from ..drawing import (
    Body,
    Drawing,
    Drive,
    Pin,
    Slide,
    Spring,
    Stop,
    between,
    flap,
    meet,
    on_line,
    polar,
    telescope,
)


def drop_hammer() -> Drawing:
    """A rod lifts the hammer while it is taut, and hangs slack while the hammer lies."""
    touch = -130.0
    o = (0.0, 0.0)
    a = polar(o, 60.0, touch)
    b = on_line(a, 220.0, o, (0.0, -1.0), ahead=True)
    return Drawing(
        "drop_hammer",
        "drop hammer on a lifting rod that is taut or slack",
        {"O": o, "A": a, "B": b},
        (
            Body("crank", "O A", 2.0),
            Body("hammer", "B", mass_kg=10.0),
            Pin("O", "frame", "crank"),
            Pin("A", "crank", "rod_1"),
            *telescope("rod", "A B", 50.0, 100.0, restitution=0.1),
            Slide("height", "frame", "hammer", "B", (0.0, 1.0)),
            Pin("B", "rod_2", "hammer"),
            Drive("O", inertia=1.0),
            Stop("height", restitution=0.5),
        ),
        touch_deg=touch,
        start_deg=touch - 140.0,
        speed_rpm=60.0,
        closed=("rod",),
        struck="height",
        traced="hammer B",
    )


def pump_jack() -> Drawing:
    """A walking beam pumps through a long, elastic rod; the pump taps its bottom."""
    touch = 60.0
    o, p = (0.0, 0.0), (150.0, 140.0)
    a = polar(o, 45.0, touch)
    c = meet(a, 125.0, p, 150.0, left=True)
    h = between(c, p, 2.0)
    g = on_line(h, 160.0, (h[0], 0.0), (0.0, -1.0), ahead=True)
    return Drawing(
        "pump_jack",
        "pump jack whose plunger taps the bottom of its well",
        {"O": o, "A": a, "C": c, "P": p, "H": h, "G": g},
        (
            Body("crank", "O A", 4.0),
            Body("pitman", "A C"),
            Body("beam", "C P H", 4.0),
            Body("plunger", "G", mass_kg=3.0),
            Pin("O", "frame", "crank"),
            Pin("P", "frame", "beam"),
            Slide("height", "frame", "plunger", "G", (0.0, 1.0)),
            Pin("A", "crank", "pitman"),
            Pin("C", "pitman", "beam"),
            Pin("H", "beam", "rod_1"),
            *telescope("rod", "H G", 5000.0, 5.0),
            Pin("G", "rod_2", "plunger"),
            Drive("O", inertia=0.5),
            Stop("height", restitution=0.3),
        ),
        touch_deg=touch,
        start_deg=touch - 150.0,
        speed_rpm=40.0,
        closed=("rod",),
        struck="height",
        traced="beam H",
    )


def loom_sley() -> Drawing:
    """The sley beats the weft up with a reed that a spring lets give way."""
    touch = 20.0
    o, p = (0.0, 0.0), (120.0, -180.0)
    a = polar(o, 30.0, touch)
    s = meet(a, 110.0, p, 190.0, left=True)
    return Drawing(
        "loom_sley",
        "sley of a loom with a loose reed",
        {"O": o, "A": a, "S": s, "P": p, "R": (s[0], s[1] + 60.0)},
        (
            Body("crank", "O A"),
            Body("rod", "A S"),
            Body("sley", "P S", 2.0),
            Pin("O", "frame", "crank"),
            Pin("P", "frame", "sley"),
            Pin("A", "crank", "rod"),
            Pin("S", "rod", "sley"),
            *flap("reed", "sley", "S R", 0.2, 1.5, 12.0),
            Drive("O"),
        ),
        touch_deg=touch,
        start_deg=touch,
        speed_rpm=160.0,
        closed=("reed",),
        traced="reed R",
    )


def sieve() -> Drawing:
    """A rocker shakes a tray; the box in it knocks at either end."""
    touch = 30.0
    o, d = (0.0, 0.0), (100.0, -120.0)
    a = polar(o, 12.0, touch)
    c = meet(a, 95.0, d, 120.0, left=True)
    t = (c[0] + 40.0, c[1] + 15.0)
    return Drawing(
        "sieve",
        "shaking sieve with a loose box between two stops",
        {"O": o, "A": a, "C": c, "D": d, "T": t, "E": (c[0] + 80.0, c[1])},
        (
            Body("crank", "O A"),
            Body("rod", "A C"),
            Body("tray", "D C E", 2.0),
            Body("box", "T", mass_kg=0.3),
            Pin("O", "frame", "crank"),
            Pin("D", "frame", "tray"),
            Pin("A", "crank", "rod"),
            Pin("C", "rod", "tray"),
            Slide("box", "tray", "box", "T", "C E"),
            Spring("box", 20.0, 0.0),
            Stop("box", "lower", -8.0, 0.4, "rear"),
            Stop("box", "upper", 8.0, 0.4, "front"),
            Drive("O"),
        ),
        touch_deg=touch,
        start_deg=touch,
        speed_rpm=240.0,
        struck="front",
        traced="tray C",
    )


MACHINES = (drop_hammer, pump_jack, loom_sley, sieve)

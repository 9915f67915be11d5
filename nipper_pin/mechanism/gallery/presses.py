"""Toggles: presses, a moulding machine, a stone crusher."""

from __future__ import annotations

from ..drawing import (
    Body,
    Drawing,
    Drive,
    Pin,
    Slide,
    Spring,
    Stop,
    meet,
    on_line,
    polar,
    telescope,
)


def toggle_press() -> Drawing:
    """Two links that a rod straightens press a ram down."""
    touch = -43.0
    f, o = (0.0, 0.0), (-150.0, -80.0)
    a, b = polar(o, 30.0, touch), (-14.0, -((100.0**2 - 14.0**2) ** 0.5))
    r = on_line(b, 100.0, f, (0.0, -1.0), ahead=True)
    return Drawing(
        "toggle_press",
        "toggle press: crank, rod that gives way, two toggle links, ram on an anvil",
        {"F": f, "O": o, "A": a, "B": b, "R": r},
        (
            Body("crank", "O A"),
            Body("upper", "F B", 2.0),
            Body("lower", "B R", 2.0),
            Body("ram", "R", mass_kg=2.0),
            Pin("O", "frame", "crank"),
            Pin("F", "frame", "upper"),
            Pin("B", "upper", "lower"),
            Pin("A", "crank", "rod_1"),
            *telescope("rod", "A B", 20000.0, 8.0),
            Pin("B", "rod_2", "upper"),
            Slide("height", "frame", "ram", "R", (0.0, 1.0)),
            Pin("R", "lower", "ram"),
            Drive("O"),
            Stop("height"),
        ),
        touch_deg=touch,
        start_deg=touch - 150.0,
        speed_rpm=100.0,
        closed=("rod",),
        struck="height",
        traced="upper B",
    )


def knuckle_press() -> Drawing:
    """The knee is pulled straight, by a rod that may get longer."""
    touch = 35.0
    f, o = (0.0, 0.0), (160.0, -120.0)
    b = (-20.0, -((90.0**2 - 20.0**2) ** 0.5))
    a = polar(o, 16.0, touch)
    r = on_line(b, 110.0, f, (0.0, -1.0), ahead=True)
    return Drawing(
        "knuckle_press",
        "knuckle-joint press whose rod pulls the knee straight",
        {"F": f, "O": o, "A": a, "B": b, "R": r},
        (
            Body("crank", "O A"),
            Body("upper", "F B", 2.0),
            Body("lower", "B R", 2.0),
            Body("ram", "R", mass_kg=3.0),
            Pin("O", "frame", "crank"),
            Pin("F", "frame", "upper"),
            Pin("B", "upper", "lower"),
            Pin("A", "crank", "rod_1"),
            *telescope("rod", "A B", 25000.0, 8.0, longer=True),
            Pin("B", "rod_2", "lower"),
            Slide("height", "frame", "ram", "R", (0.0, 1.0)),
            Pin("R", "lower", "ram"),
            Drive("O"),
            Stop("height"),
        ),
        touch_deg=touch,
        start_deg=touch + 150.0,
        speed_rpm=90.0,
        clockwise=True,
        closed=("rod",),
        struck="height",
        traced="upper B",
    )


def moulding_machine() -> Drawing:
    """One half of the five-point double toggle that shuts the mould of a moulding machine."""
    touch = -20.0
    f, o, b, e = (0.0, 120.0), (-100.0, 40.0), (118.0, 100.0), (30.0, 70.0)
    a = polar(o, 40.0, touch)
    h = on_line(e, 70.0, (0.0, 40.0), (1.0, 0.0), ahead=True)
    g = on_line(b, 160.0, (0.0, 110.0), (1.0, 0.0), ahead=True)
    return Drawing(
        "moulding_machine",
        "five-point double toggle of a moulding machine, the upper half, with the give of its bars",
        {"O": o, "A": a, "H": h, "E": e, "F": f, "B": b, "G": g},
        (
            Body("crank", "O A", 2.0),
            Body("rod", "A H", 2.0),
            Body("crosshead", "H", mass_kg=1.0),
            Body("cross_link", "H E", 2.0),
            Body("rear", "F E B", 4.0),
            Body("platen", "G", mass_kg=8.0),
            Pin("O", "frame", "crank"),
            Pin("A", "crank", "rod"),
            Slide("crosshead", "frame", "crosshead", "H", (1.0, 0.0)),
            Pin("F", "frame", "rear"),
            Slide("mould", "frame", "platen", "G", (-1.0, 0.0)),
            Pin("H", "rod", "crosshead"),
            Pin("E", "rear", "cross_link"),
            Pin("H", "cross_link", "crosshead", "H_cross"),
            Pin("B", "rear", "front_1"),
            *telescope("front", "B G", 200000.0, 4.0, density_kg_m=4.0),
            Pin("G", "front_2", "platen"),
            Drive("O"),
            Stop("mould"),
        ),
        touch_deg=touch,
        start_deg=touch - 150.0,
        speed_rpm=40.0,
        closed=("front",),
        struck="mould",
        traced="rear B",
    )


def jaw_crusher() -> Drawing:
    """Blake's crusher: a pitman lifts two toggle plates, which press a jaw against the stone."""
    touch = 25.0
    o, b, f, g, p = (0.0, 220.0), (0.0, 0.0), (-110.0, 30.0), (110.0, 30.0), (130.0, 260.0)
    a = polar(o, 12.0, touch)
    return Drawing(
        "jaw_crusher",
        "Blake jaw crusher with two toggle plates and a return spring",
        {"O": o, "A": a, "B": b, "F": f, "G": g, "P": p},
        (
            Body("eccentric", "O A", mass_kg=2.0),
            Body("rear_plate", "F B", 4.0),
            Body("front_plate", "B G", 4.0),
            Body("jaw", "P G", 20.0),
            Pin("O", "frame", "eccentric"),
            Pin("F", "frame", "rear_plate"),
            Pin("P", "frame", "jaw"),
            Pin("B", "rear_plate", "front_plate"),
            Pin("A", "eccentric", "pitman_1"),
            *telescope("pitman", "A B", 60000.0, 10.0, longer=True, density_kg_m=4.0),
            Pin("B", "pitman_2", "rear_plate"),
            Pin("G", "front_plate", "jaw"),
            Drive("O"),
            Spring("P", 50.0, -5.0),
            Stop("P", "upper", restitution=0.1),
        ),
        touch_deg=touch,
        start_deg=touch - 150.0,
        speed_rpm=150.0,
        closed=("pitman",),
        struck="P",
        traced="jaw G",
    )


def riveter() -> Drawing:
    """A toggle in a rocker's drive: the punch at the end of a lever."""
    touch = 115.0
    o, d = (0.0, 0.0), (120.0, 10.0)
    a = polar(o, 18.0, touch)
    c = meet(a, 110.0, d, 60.0, left=False)
    e = (190.0, 45.0)
    h = on_line(e, 70.0, (205.0, 0.0), (0.0, -1.0), ahead=True)
    return Drawing(
        "riveter",
        "riveter: a bell crank presses a punch on the rivet",
        {"O": o, "A": a, "C": c, "D": d, "E": e, "H": h},
        (
            Body("crank", "O A"),
            Body("bell_crank", "C D E", 3.0),
            Body("link", "E H", 2.0),
            Body("punch", "H", mass_kg=0.7),
            Pin("O", "frame", "crank"),
            Pin("D", "frame", "bell_crank"),
            Slide("height", "frame", "punch", "H", (0.0, 1.0)),
            Pin("E", "bell_crank", "link"),
            Pin("A", "crank", "rod_1"),
            *telescope("rod", "A C", 20000.0, 6.0, longer=True),
            Pin("C", "rod_2", "bell_crank"),
            Pin("H", "link", "punch"),
            Drive("O"),
            Stop("height", restitution=0.4),
        ),
        touch_deg=touch,
        start_deg=touch - 150.0,
        speed_rpm=150.0,
        closed=("rod",),
        struck="height",
        traced="bell_crank E",
    )


PRESSES = (toggle_press, knuckle_press, moulding_machine, jaw_crusher, riveter)

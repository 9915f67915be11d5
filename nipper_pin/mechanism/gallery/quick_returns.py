"""Quick returns: slow on the way out, fast on the way back."""

from __future__ import annotations

from ..drawing import (
    Body,
    Drawing,
    Drive,
    Pin,
    Slide,
    Slot,
    Stop,
    between,
    meet,
    on_line,
    polar,
    telescope,
)


def whitworth() -> Drawing:
    """Quick return: the axis of the slotted arm lies within the circle of the pin."""
    touch = 150.0
    o, p = (0.0, 0.0), (0.0, -20.0)
    a = polar(o, 45.0, touch)
    c = between(p, a, -30.0 / ((a[0] - p[0]) ** 2 + (a[1] - p[1]) ** 2) ** 0.5)
    d = on_line(c, 120.0, p, (1.0, 0.0), ahead=True)
    return Drawing(
        "whitworth",
        "Whitworth quick return with a buffer for the ram",
        {"O": o, "P": p, "A": a, "C": c, "D": d},
        (
            Body("crank", "O A"),
            Body("arm", "A P C"),
            Body("ram", "D", mass_kg=1.0),
            Pin("O", "frame", "crank"),
            Pin("P", "frame", "arm"),
            Slot("slot", "arm", "crank", "A", "P A"),
            Pin("C", "arm", "rod_1"),
            *telescope("rod", "C D", 15000.0, 6.0),
            Slide("travel", "frame", "ram", "D", (-1.0, 0.0)),
            Pin("D", "rod_2", "ram"),
            Drive("O"),
            Stop("travel", restitution=0.3),
        ),
        touch_deg=touch,
        start_deg=touch - 150.0,
        speed_rpm=100.0,
        closed=("rod",),
        struck="travel",
        traced="ram D",
    )


def crank_shaper() -> Drawing:
    """Quick return: the axis of the slotted lever lies outside the circle of the pin."""
    touch = 60.0
    o, p = (0.0, 0.0), (0.0, -100.0)
    a = polar(o, 40.0, touch)
    c = between(p, a, 220.0 / ((a[0] - p[0]) ** 2 + (a[1] - p[1]) ** 2) ** 0.5)
    d = on_line(c, 80.0, (0.0, 110.0), (1.0, 0.0), ahead=True)
    return Drawing(
        "crank_shaper",
        "crank shaper whose tool head meets a stop on its way forward",
        {"O": o, "P": p, "A": a, "C": c, "D": d},
        (
            Body("crank", "O A"),
            Body("lever", "P C"),
            Body("head", "D", mass_kg=1.0),
            Pin("O", "frame", "crank"),
            Pin("P", "frame", "lever"),
            Slot("slot", "lever", "crank", "A", "P A"),
            Pin("C", "lever", "rod_1"),
            *telescope("rod", "C D", 20000.0, 6.0),
            Slide("travel", "frame", "head", "D", (-1.0, 0.0)),
            Pin("D", "rod_2", "head"),
            Drive("O"),
            Stop("travel", restitution=0.3),
        ),
        touch_deg=touch,
        start_deg=touch + 160.0,
        speed_rpm=80.0,
        clockwise=True,
        closed=("rod",),
        struck="travel",
        traced="head D",
    )


def drag_link() -> Drawing:
    """Quick return: a double crank drives a ram."""
    touch = -95.0
    o, p = (0.0, 0.0), (0.0, -25.0)
    a = polar(o, 60.0, touch)
    b = meet(a, 50.0, p, 65.0, left=False)
    c = between(p, b, 40.0 / 65.0)
    d = on_line(c, 130.0, p, (1.0, 0.0), ahead=True)
    return Drawing(
        "drag_link",
        "drag-link quick return with a buffer for the ram",
        {"O": o, "P": p, "A": a, "B": b, "C": c, "D": d},
        (
            Body("crank", "O A"),
            Body("follower", "P C B"),
            Body("link", "A B"),
            Body("ram", "D", mass_kg=1.0),
            Pin("O", "frame", "crank"),
            Pin("P", "frame", "follower"),
            Pin("A", "crank", "link"),
            Pin("B", "link", "follower"),
            Pin("C", "follower", "rod_1"),
            *telescope("rod", "C D", 15000.0, 6.0),
            Slide("travel", "frame", "ram", "D", (-1.0, 0.0)),
            Pin("D", "rod_2", "ram"),
            Drive("O"),
            Stop("travel", restitution=0.3),
        ),
        touch_deg=touch,
        start_deg=touch - 150.0,
        speed_rpm=100.0,
        closed=("rod",),
        struck="travel",
        traced="ram D",
    )


QUICK_RETURNS = (whitworth, crank_shaper, drag_link)

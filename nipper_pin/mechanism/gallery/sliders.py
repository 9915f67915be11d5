"""Slider-cranks and the Scotch yoke."""

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
    on_line,
    polar,
    telescope,
)


def slider_crank() -> Drawing:
    """In line: the ram's path passes through the crank's axis."""
    touch = -125.0
    o = (0.0, 0.0)
    a = polar(o, 25.0, touch)
    b = on_line(a, 113.0, o, (0.0, -1.0), ahead=True)
    return Drawing(
        "slider_crank",
        "slider-crank in line, its rod gives way where the ram meets an anvil",
        {"O": o, "A": a, "B": b},
        (
            Body("crank", "O A"),
            Body("ram", "B", mass_kg=1.5),
            Pin("O", "frame", "crank"),
            Pin("A", "crank", "rod_1"),
            *telescope("rod", "A B", 20000.0, 10.0),
            Slide("height", "frame", "ram", "B", (0.0, 1.0)),
            Pin("B", "rod_2", "ram"),
            Drive("O"),
            Stop("height"),
        ),
        touch_deg=touch,
        start_deg=touch - 145.0,
        speed_rpm=120.0,
        closed=("rod",),
        struck="height",
        traced="ram B",
    )


def slider_crank_offset() -> Drawing:
    """Offset: it goes faster one way than the other."""
    touch = -30.0
    o = (0.0, 0.0)
    a = polar(o, 30.0, touch)
    b = on_line(a, 100.0, (0.0, -25.0), (1.0, 0.0), ahead=True)
    return Drawing(
        "slider_crank_offset",
        "offset slider-crank with a buffer at the far end",
        {"O": o, "A": a, "B": b},
        (
            Body("crank", "O A"),
            Body("slider", "B", mass_kg=0.8),
            Pin("O", "frame", "crank"),
            Pin("A", "crank", "rod_1"),
            *telescope("rod", "A B", 15000.0, 6.0),
            Slide("travel", "frame", "slider", "B", (-1.0, 0.0)),
            Pin("B", "rod_2", "slider"),
            Drive("O"),
            Stop("travel", restitution=0.4),
        ),
        touch_deg=touch,
        start_deg=touch - 150.0,
        speed_rpm=180.0,
        closed=("rod",),
        struck="travel",
        traced="slider B",
    )


def oscillating_cylinder() -> Drawing:
    """Inverted slider-crank: the guide of the rod swings about a pin of the frame."""
    touch = 30.0
    o, p = (0.0, 0.0), (120.0, 0.0)
    a = polar(o, 30.0, touch)
    q = between(a, p, 0.6)
    return Drawing(
        "oscillating_cylinder",
        "oscillating cylinder whose piston meets the bottom",
        {"O": o, "A": a, "Q": q, "P": p},
        (
            Body("crank", "O A"),
            Body("cylinder", "P Q", density_kg_m=3.0),
            Pin("O", "frame", "crank"),
            Pin("P", "frame", "cylinder"),
            Slide("stroke", "cylinder", "rod_1", "Q", "P Q"),
            *telescope("rod", "Q A", 20000.0, 5.0),
            Pin("A", "rod_2", "crank", "crank_pin"),
            Drive("O"),
            Stop("stroke", restitution=0.3),
        ),
        touch_deg=touch,
        start_deg=touch + 150.0,
        speed_rpm=150.0,
        clockwise=True,
        closed=("rod",),
        struck="stroke",
        traced="rod_1 Q",
    )


def scotch_yoke() -> Drawing:
    """A pin in a level slot: the yoke moves as the sine of the angle."""
    touch = -120.0
    o = (0.0, 0.0)
    a = polar(o, 25.0, touch)
    y, r = (0.0, a[1]), (0.0, a[1] - 80.0)
    return Drawing(
        "scotch_yoke",
        "Scotch yoke with a spring-loaded ram",
        {"O": o, "A": a, "Y": y, "R": r, "L": (-35.0, a[1]), "M": (35.0, a[1])},
        (
            Body("crank", "O A"),
            Body("yoke", "L M", density_kg_m=8.0),
            Body("ram", "R", mass_kg=0.6),
            Pin("O", "frame", "crank"),
            Slide("lift", "frame", "yoke", "Y", (0.0, 1.0)),
            Slot("slot", "yoke", "crank", "A", (1.0, 0.0)),
            Pin("Y", "yoke", "rod_1"),
            *telescope("rod", "Y R", 15000.0, 5.0),
            Slide("height", "frame", "ram", "R", (0.0, 1.0)),
            Pin("R", "rod_2", "ram"),
            Drive("O"),
            Stop("height"),
        ),
        touch_deg=touch,
        start_deg=touch - 140.0,
        speed_rpm=150.0,
        closed=("rod",),
        struck="height",
        traced="ram R",
    )


SLIDERS = (slider_crank, slider_crank_offset, oscillating_cylinder, scotch_yoke)

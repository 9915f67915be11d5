"""Valve, door and key."""

from __future__ import annotations

from ..drawing import (
    Body,
    Damper,
    Drawing,
    Drive,
    Pin,
    Slide,
    Slot,
    Spring,
    Stop,
    polar,
    telescope,
)


def valve_train() -> Drawing:
    """Cam lever, push rod that may part, rocker arm, valve on its seat."""
    touch = 40.0
    f, a, b, r, c = (-60.0, 0.0), (-20.0, 0.0), (-20.0, 120.0), (0.0, 120.0), (30.0, 120.0)
    rows = 24
    angles = [360.0 * row / rows for row in range(rows + 1)]
    lift = [0.0 if not 30.0 < x < 150.0 else 0.12 * _smooth((x - 30.0) / 120.0) for x in angles]
    return Drawing(
        "valve_train",
        "valve train: cam lever, push rod that may part, rocker arm, valve and seat",
        {"F": f, "A": a, "B": b, "R": r, "C": c, "V": (30.0, 90.0)},
        (
            Body("follower", "F A"),
            Body("rocker", "B R C", 2.0),
            Body("valve", "C V", 2.0),
            Pin("F", "frame", "follower"),
            Pin("R", "frame", "rocker"),
            Slide("lift", "frame", "valve", "V", (0.0, 1.0)),
            Slot("pad", "valve", "rocker", "C", (1.0, 0.0), 0.005),
            Pin("A", "follower", "push_rod_1"),
            *telescope("push_rod", "A B", 100.0, 5.0, longer=True, density_kg_m=0.5),
            Pin("B", "push_rod_2", "rocker"),
            Spring("lift", 10000.0, -15.0),
            Drive("F", "table", {"cylinder_angle_deg": angles, "coordinate_rad": lift}),
            Stop("lift", "upper", restitution=0.3, name="seat"),
        ),
        touch_deg=touch,
        start_deg=touch - 60.0,
        speed_rpm=400.0,
        closed=("seat",),
        struck="push_rod",
        traced="valve V",
    )


def _smooth(share: float) -> float:
    """Rise and return between 0 and 1, level to the third derivative at both ends."""
    return 256.0 * (share * (1.0 - share)) ** 4


def door_closer() -> Drawing:
    """A crank pushes the door open, a spring and a damper shut it."""
    touch = 150.0
    d, o = (0.0, 0.0), (60.0, -110.0)
    a = polar(o, 25.0, touch)
    p = (60.0, 0.0)
    return Drawing(
        "door_closer",
        "door that is pushed open and shut by a damped spring against its frame",
        {"D": d, "O": o, "A": a, "P": p, "E": (160.0, 0.0)},
        (
            Body("crank", "O A"),
            Body("door", "D P E", mass_kg=2.0),
            Pin("O", "frame", "crank"),
            Pin("D", "frame", "door"),
            Pin("A", "crank", "push_1"),
            *telescope("push", "A P", 20.0, 5.0, longer=True, density_kg_m=0.5),
            Pin("P", "push_2", "door"),
            Spring("D", 2.0, 40.0),
            Damper("D", 0.05),
            Drive("O"),
            Stop("D", restitution=0.4),
        ),
        touch_deg=touch,
        start_deg=touch - 60.0,
        speed_rpm=30.0,
        gravity_m_s2=0.0,
        closed=("push",),
        struck="D",
        traced="door E",
    )


def piano_key() -> Drawing:
    """The key throws the hammer through a rod that only pushes; the hammer meets the string."""
    touch = 0.0
    k, j, b, h = (0.0, 0.0), (-80.0, 0.0), (-80.0, 60.0), (-110.0, 60.0)
    return Drawing(
        "piano_key",
        "piano key that throws a hammer against the string",
        {"K": k, "J": j, "B": b, "H": h, "T": (0.0, 75.0)},
        (
            Body("key", "J K"),
            Body("hammer", "H B T", mass_kg=0.02),
            Pin("K", "frame", "key"),
            Pin("H", "frame", "hammer"),
            Pin("J", "key", "jack_1"),
            *telescope("jack", "J B", 20.0, 10.0, longer=True, density_kg_m=0.1),
            Pin("B", "jack_2", "hammer"),
            Spring("H", 0.02, 10.0),
            Drive("K", "fourier", {"cosine_rad": [0.06]}, inertia=0.01),
            Stop("H", "upper", 19.5, restitution=0.6, name="string"),
        ),
        touch_deg=touch,
        start_deg=touch,
        speed_rpm=700.0,
        closed=("jack",),
        struck="string",
        traced="hammer T",
    )


DEVICES = (valve_train, door_closer, piano_key)

"""Walking legs, and frames of parallel bars."""

from __future__ import annotations

from ..drawing import (
    Body,
    Drawing,
    Drive,
    Pin,
    Slide,
    Slot,
    Stop,
    flap,
    meet,
    polar,
    telescope,
)


def klann() -> Drawing:
    """Klann's leg; the rod between crank and hip gives way where the upper arm meets a stop."""
    touch = 180.0
    o, upper, lower = (0.0, 0.0), (-23.3, 61.6), (-59.0, -17.6)
    a = polar(o, 26.8, touch)
    elbow = meet(a, 59.0, lower, 32.1, left=False)
    knee = meet(a, 110.5, elbow, 52.2, left=False)
    hip = meet(knee, 89.7, upper, 51.8, left=True)
    foot = meet(knee, 89.7, hip, 173.2, left=False)
    toe = (foot[0] - 25.0, foot[1])
    return Drawing(
        "klann",
        "Klann's leg with a spring-held toe",
        {"O": o, "U": upper, "L": lower, "A": a, "E": elbow, "K": knee, "H": hip, "F": foot,
         "T": toe},
        (
            Body("crank", "O A"),
            Body("rod", "A E K A"),
            Body("lower_arm", "L E"),
            Body("upper_arm", "U H"),
            Body("leg", "H K F H"),
            Pin("O", "frame", "crank"),
            Pin("L", "frame", "lower_arm"),
            Pin("U", "frame", "upper_arm"),
            Pin("A", "crank", "rod"),
            Pin("E", "rod", "lower_arm"),
            Pin("K", "rod", "leg"),
            Pin("H", "leg", "upper_arm"),
            *flap("toe", "leg", "F T", 0.03, 3.0, 25.0),
            Drive("O"),
        ),
        touch_deg=touch,
        start_deg=touch,
        speed_rpm=150.0,
        closed=("toe",),
        known="lengths of US patent 6,260,862, its unit taken as 100 mm; the toe is an invention",
        traced="leg F",
    )  # fmt: skip


def jansen() -> Drawing:
    """Jansen's leg with his holy numbers; the upper rod gives way where the arm meets a stop."""
    touch = -95.0
    o, b = (0.0, 0.0), (-38.0, -7.8)
    a = polar(o, 15.0, touch)
    c = meet(b, 41.5, a, 50.0, left=True)
    e = meet(b, 39.3, a, 61.9, left=False)
    d = meet(b, 40.1, c, 55.8, left=True)
    f = meet(d, 39.4, e, 36.7, left=False)
    g = meet(f, 65.7, e, 49.0, left=False)
    return Drawing(
        "jansen",
        "Jansen's leg whose upper arm meets a stop",
        {"O": o, "A": a, "B": b, "C": c, "D": d, "E": e, "F": f, "G": g},
        (
            Body("crank", "O A"),
            Body("arm", "B C D B"),
            Body("knee_link", "B E"),
            Body("lower_rod", "A E"),
            Body("shin_link", "D F"),
            Body("foot", "E F G E"),
            Pin("O", "frame", "crank"),
            Pin("B", "frame", "arm"),
            Pin("B", "frame", "knee_link"),
            Pin("A", "crank", "lower_rod"),
            Pin("E", "knee_link", "foot"),
            Pin("D", "arm", "shin_link"),
            Pin("F", "shin_link", "foot"),
            Pin("E", "lower_rod", "knee_link", "E_rod"),
            Pin("A", "crank", "upper_rod_1"),
            *telescope("upper_rod", "A C", 6000.0, 6.0, longer=True),
            Pin("C", "upper_rod_2", "arm"),
            Drive("O"),
            Stop("B", restitution=0.3),
        ),
        touch_deg=touch,
        start_deg=touch - 150.0,
        speed_rpm=120.0,
        closed=("upper_rod",),
        struck="B",
        known="Jansen's thirteen holy numbers in mm; the stop is an invention",
        traced="foot G",
    )


def pantograph() -> Drawing:
    """Copies twice as large: fixed point, tracer and pen lie on one line."""
    touch = 0.0
    o, k = (0.0, 0.0), (70.0, -10.0)
    q = polar(k, 12.0, touch)
    a = meet(o, 60.0, q, 50.0, left=True)
    b = (2.0 * a[0], 2.0 * a[1])
    p, c = (2.0 * q[0], 2.0 * q[1]), (a[0] + q[0], a[1] + q[1])
    return Drawing(
        "pantograph",
        "pantograph that a crank leads, with a spring-held pen",
        {"O": o, "A": a, "B": b, "C": c, "Q": q, "P": p, "K": k, "T": (p[0] + 20.0, p[1] - 10.0)},
        (
            Body("crank", "K Q"),
            Body("long_1", "O A B"),
            Body("long_2", "B C P"),
            Body("short_1", "A Q"),
            Body("short_2", "C Q"),
            Pin("K", "frame", "crank"),
            Pin("O", "frame", "long_1"),
            Pin("B", "long_1", "long_2"),
            Pin("A", "long_1", "short_1"),
            Pin("C", "long_2", "short_2"),
            Pin("Q", "crank", "short_1"),
            Pin("Q", "crank", "short_2"),
            *flap("pen", "long_2", "P T", 0.02, 2.0, 25.0),
            Drive("K"),
        ),
        touch_deg=touch,
        start_deg=touch,
        speed_rpm=300.0,
        closed=("pen",),
        known="a pantograph of ratio 2; sizes an invention",
        traced="long_2 P",
    )


def scissors_lift() -> Drawing:
    """Two storeys; a crank pushes the lower roller, a buffer stops it."""
    touch = 140.0
    o = (200.0, 0.0)
    c = polar(o, 12.0, touch)
    x, z = 62.0, (90.0**2 - 62.0**2) ** 0.5
    m = {"P": (0.0, 0.0), "S": (x, 0.0), "L1": (0.0, z), "R1": (x, z), "L2": (0.0, 2.0 * z),
         "R2": (x, 2.0 * z), "M1": (0.5 * x, 0.5 * z), "M2": (0.5 * x, 1.5 * z)}  # fmt: skip
    return Drawing(
        "scissors_lift",
        "scissors lift of two storeys, driven by a crank through a rod that gives way",
        {**m, "O": o, "C": c},
        (
            Body("crank", "O C"),
            Body("roller", "S", mass_kg=0.3),
            Body("rising_1", "P M1 R1"),
            Body("falling_1", "S M1 L1"),
            Body("rising_2", "L1 M2 R2"),
            Body("falling_2", "R1 M2 L2"),
            Body("platform", "L2 R2", 4.0),
            Pin("O", "frame", "crank"),
            Slide("travel", "frame", "roller", "S", (1.0, 0.0)),
            Pin("P", "frame", "rising_1"),
            Pin("M1", "rising_1", "falling_1"),
            Pin("R1", "rising_1", "falling_2"),
            Pin("L1", "falling_1", "rising_2"),
            Pin("L2", "falling_2", "platform"),
            Pin("S", "roller", "falling_1"),
            Pin("M2", "rising_2", "falling_2"),
            Slot("groove", "platform", "rising_2", "R2", (1.0, 0.0)),
            Pin("C", "crank", "rod_1"),
            *telescope("rod", "C S", 10000.0, 6.0),
            Pin("S", "rod_2", "roller", "S_rod"),
            Drive("O"),
            Stop("travel", restitution=0.2),
        ),
        touch_deg=touch,
        start_deg=touch - 140.0,
        speed_rpm=40.0,
        closed=("rod",),
        struck="travel",
        traced="platform L2",
    )


def wiper() -> Drawing:
    """A crank-rocker swings two parallel arms; the lip of one blade turns over at each end."""
    touch = 40.0
    m, p1, p2 = (60.0, -30.0), (0.0, 0.0), (160.0, 0.0)
    a = polar(m, 15.0, touch)
    b = polar(p1, 30.0, -100.0)
    e1, e2 = polar(p1, 35.0, -60.0), polar(p2, 35.0, -60.0)
    t1, t2 = polar(p1, 150.0, 80.0), polar(p2, 150.0, 80.0)
    return Drawing(
        "wiper",
        "windscreen wiper of two parallel arms, the lip of one blade between two stops",
        {"M": m, "P1": p1, "P2": p2, "A": a, "B": b, "E1": e1, "E2": e2, "T1": t1, "T2": t2,
         "L": (t1[0], t1[1] + 15.0)},
        (
            Body("crank", "M A"),
            Body("rod", "A B"),
            Body("arm_1", "B P1 E1 P1 T1"),
            Body("arm_2", "E2 P2 T2"),
            Body("tie_rod", "E1 E2"),
            Pin("M", "frame", "crank"),
            Pin("P1", "frame", "arm_1"),
            Pin("P2", "frame", "arm_2"),
            Pin("A", "crank", "rod"),
            Pin("E1", "arm_1", "tie_rod"),
            Pin("B", "rod", "arm_1"),
            Pin("E2", "tie_rod", "arm_2"),
            *flap("lip", "arm_1", "T1 L", 0.005, 2.0, 40.0, density_kg_m=0.3),
            Drive("M"),
        ),
        touch_deg=touch,
        start_deg=touch,
        speed_rpm=100.0,
        closed=("lip",),
        traced="arm_1 T1",
    )  # fmt: skip


LEGS = (klann, jansen, pantograph, scissors_lift, wiper)

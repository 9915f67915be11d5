"""Families of stops on both sides, springs and dampers of every form, and pins in slots."""

from __future__ import annotations

from collections.abc import Callable
from math import atan2, cos, hypot, pi, sin, sqrt
from typing import Any

from .chains import Chain, cranked, spring_table
from .draws import Draft, Generator, changed, log, one_of, restitution, sign, usual, window
from .parts import SHAFT, Place, Source, frame, hinge, link

_BASES = ("none", "swing", "turn", "lift", "yoke")


def _turns(rng: Generator, slowest: float = 20.0, fastest: float = 3000.0) -> dict[str, Any]:
    """A turn or two at any speed and tolerance, of held or inertial shafts."""
    case: dict[str, Any] = {
        "speed_rpm": log(rng, slowest, fastest), "window": "cycle", "start_index": 0.0,
        "cycles": int(rng.integers(1, 3)), "max_collisions": int(rng.integers(10, 120)),
        "drive": "inertial" if rng.random() < 0.3 else "held",
    }  # fmt: skip
    if rng.random() < 0.5:
        case["resolution"] = {"tolerance": log(rng, 1e-12, 1e-3)}
    if rng.random() < 0.1:
        case["rest_rate"] = log(rng, 1e-9, 1e-1)
    return case


def _gravity(rng: Generator) -> float:
    return one_of(rng, 9.81, 9.81, 0.0, rng.uniform(0.0, 100.0))


def _pair(
    rng: Generator, bases: tuple[str, ...] = _BASES, light: float = 0.1, heavy: float = 10.0
) -> Chain:
    """One or two links on a base."""
    machine = Chain()
    machine.add_base(rng, str(rng.choice(bases)))
    for _ in range(int(rng.integers(1, 3))):
        machine.add_link(rng, bool(rng.random() < 0.5), log(rng, light, heavy))
    return machine


def _two_stops(rng: Generator) -> Draft:
    """One or two bodies between two stops, with clearances from one metre to one nanometre."""
    machine = _pair(rng, _BASES[1:], 1e-2, 1e2)
    closed = []
    for joint in machine.joints:
        near, gap = one_of(rng, 0.0, 1.0, rng.uniform()), log(rng, 1e-9, 1.0)
        machine.stop(joint, "lower", -near * gap, restitution(rng))
        machine.stop(joint, "upper", (1.0 - near) * gap, restitution(rng))
        if near in (0.0, 1.0) and rng.random() < 0.5:
            closed.append(f"{joint} {'upper' if near else 'lower'}")
        if rng.random() < 0.3:
            machine.spring(f"s {joint}", joint, log(rng, 1e-3, 1e4), float(rng.normal(0.0, 0.1)))
    return machine.source("two_stops", _gravity(rng), closed), _turns(rng)


def _chain(rng: Generator) -> Draft:
    """A chain of one to five links with one to four stops and elements of all kinds."""
    machine = Chain()
    machine.add_base(rng, str(rng.choice(_BASES)))
    count = int(rng.integers(1, 6))
    for _ in range(count):
        machine.add_link(rng, bool(rng.random() < 0.6), log(rng, 0.2, 5.0))
    tied = str(rng.choice(["none", "none", "links", "slot"])) if count > 1 else "none"
    machine.tie(rng, tied)
    # The loop must close at all positions between the stops.
    widest = 0.05 if tied == "links" else 0.8
    closed = machine.add_stops(rng, int(rng.integers(1, 5)), (1e-3 * widest, widest))
    for joint in machine.joints:
        if rng.random() < 0.7:
            machine.spring(f"s {joint}", joint, log(rng, 1.0, 300.0), float(rng.normal(0.0, 0.3)))
        if rng.random() < 0.3:
            machine.damper(f"d {joint}", joint, log(rng, 1e-3, 10.0))
        if rng.random() < 0.2:
            rows = spring_table(rng, 3.0, log(rng, 0.1, 100.0))
            machine.table(f"t {joint}", joint, rows)
    for number in range(int(rng.integers(0, 3))):
        machine.strut(
            rng, f"strut{number}", log(rng, 1.0, 300.0) if rng.random() < 0.7 else None,
            log(rng, 1e-2, 10.0), log(rng, 1e-3, 1.0),
        )  # fmt: skip
    return machine.source("chain", _gravity(rng), closed), _turns(rng)


def _hard_elements(rng: Generator) -> Draft:
    """Stiffness from 1e-3 to 1e9, damping from none to far above critical, any preload."""
    machine = _pair(rng)
    closed = machine.add_stops(rng, int(rng.integers(1, 4)), (1e-6, 0.3))
    slowest = 60.0
    for joint in machine.joints:
        k = log(rng, 1e-3, 1e9)
        # No more than some hundred swings in a turn.
        slowest = max(slowest, 0.02 * sqrt(k / machine.mass))
        # Deflections that this spring can bear without more energy than a kilojoule.
        most = min(0.3, sqrt(2e3 / k))
        preload = one_of(rng, 0.0, -0.3 * most, most, rng.uniform(-most, most))
        critical = 2.0 * sqrt(k * machine.mass)
        damping = critical * one_of(rng, 0.0, 0.01, 1.0, log(rng, 1e-3, 1e3))
        if rng.random() < 0.5:
            machine.spring(f"s {joint}", joint, k, preload)
            machine.damper(f"d {joint}", joint, damping)
        else:
            machine.strut(rng, f"strut {joint}".replace(" ", "_"), k, damping, log(rng, 1e-2, 1.0))
    return machine.source("hard_elements", _gravity(rng), closed), _turns(rng, slowest, 1e4)


def _spring_tables(rng: Generator) -> Draft:
    """Springs from tables: kinks, walls, steps and snaps, also for a nipper's steeve."""
    if rng.random() < 0.3:
        source = changed(usual(rng))
        stiffness = log(rng, 3.0, 30.0)
        bend, wall = float(rng.uniform(0.5, 25.0)), log(rng, 1.0, 1e4)
        preload = stiffness * float(rng.uniform(2.0, 20.0))
        source.description.pop("shortcuts")
        source.description["springs"]["steeve"] = {
            "joint": "steeve",
            "coordinate_mm": [-10.0, 0.0, bend, bend + log(rng, 1e-3, 1.0), 90.0],
            "force_N": [0.1 * preload, preload, preload + stiffness * bend,
                        preload + stiffness * bend + 1.0, preload + (stiffness + wall) * 90.0],
        }  # fmt: skip
        return source, window(rng, float(rng.uniform(100.0, 900.0)))
    machine = _pair(rng)
    reach = log(rng, 1e-2, 3.0)
    closed = machine.add_stops(rng, int(rng.integers(1, 5)), (1e-3 * reach, 0.3 * reach))
    for number, joint in enumerate(machine.joints):
        for again in range(int(rng.integers(1, 3))):
            rows = spring_table(rng, reach, log(rng, 1e-1, 1e3))
            machine.table(f"t{number} {again}", joint, rows)
        if rng.random() < 0.3:
            machine.damper(f"d {joint}", joint, log(rng, 1e-3, 10.0))
    return machine.source("spring_tables", _gravity(rng), closed), _turns(rng)


def _near_points(rng: Generator) -> Draft:
    """Points of a spring and a damper that come as near to one another as one likes."""
    machine = Chain()
    machine.add_base(rng, str(rng.choice(_BASES[:2])))
    if rng.random() < 0.5:
        for _ in range(int(rng.integers(1, 4))):
            machine.add_link(rng, bool(rng.random() < 0.5), log(rng, 0.1, 10.0))
        stiffness = log(rng, 1e-2, 1e4) if rng.random() < 0.7 else None
        machine.strut(rng, "strut", stiffness, log(rng, 1e-3, 1e2), log(rng, 1e-12, 1e-1))
    else:
        # A pendulum whose end passes an anchor at some distance.
        mass, length = log(rng, 0.1, 10.0), float(rng.uniform(0.1, 0.5))
        parent, (x, z) = machine.links[-1]
        machine.parts += [
            link("b0", mass, 0.1 * mass * length**2, (0.7 * length, 0.0)),
            hinge("j0", parent, "b0", (0.0, 0.0)), frame("end", "b0", (length, 0.0)),
        ]  # fmt: skip
        machine.hung("b0", "j0", True, (x, z), mass)
        angle = -float(rng.uniform(0.1, pi - 0.1))
        far = length + sign(rng) * log(rng, 1e-12, 1e-1)
        machine.parts.append(frame("anchor", "frame", (x + far * cos(angle), z + far * sin(angle))))
        points = {"frame_a": "end", "frame_b": "anchor"}
        machine.tables["springs"]["strut"] = {
            **points, "stiffness_N_per_m": log(rng, 1e-2, 1e4),
            "free_length_mm": 1e3 * length * one_of(rng, 0.0, 0.1, rng.uniform()),
        }  # fmt: skip
        if rng.random() < 0.5:
            machine.tables["dampers"]["strut"] = {**points, "damping_N_s_per_m": log(rng, 0.01, 10)}
    closed = machine.add_stops(rng, int(rng.integers(0, 3)), (1e-2, 3.0))
    return machine.source("near_points", _gravity(rng), closed), _turns(rng, 20.0, 300.0)


def slotted_lever(rng: Generator, radius: float, axis: Place, block: float) -> Chain:
    """A crank pin in the slot of a lever, with a flap hinged to the lever.

    With the lever's axis just inside or outside the circle of the pin the lever turns over in no
    time: the pin passes its axis, which is the dead centre of this machine. At touch the crank of
    this radius [m] points along x; the block has this mass [kg].
    """
    machine = Chain(freedom=1)
    x, z = radius - axis[0], -axis[1]
    machine.parts += [
        *cranked(radius),
        link("lever", 1.0, 0.02, (0.05, 0.0)), hinge("lever_axis", "frame", "lever", axis),
        frame("slot_line", "lever", (0.0, 0.0), atan2(z, x)),
    ]  # fmt: skip
    drive = {"joint": "shaft", "law": "constant_speed", "ratio": 1.0, **SHAFT}
    machine.tables["drives"]["shaft"] = drive
    machine.slot("slot", ("slot_line", "crank_pin"), "x", block)
    machine.links.append(("lever", axis))
    mass = log(rng, 1e-2, 10.0)
    arm = hypot(x, z)
    machine.parts += [
        link("flap", mass, mass * (0.3 * arm) ** 2, (0.5 * arm, 0.1 * arm)),
        hinge("flap", "lever", "flap", (x, z)),
    ]
    machine.hung("flap", "flap", True, (radius, 0.0), mass)
    return machine


def _slots(rng: Generator) -> Draft:
    """A slotted lever whose pin passes the lever's axis at any distance, and its flap."""
    radius, turned = float(rng.uniform(0.02, 0.1)), float(rng.uniform(0.3, 2.0 * pi - 0.3))
    away = radius * (1.0 + sign(rng) * log(rng, 1e-9, 2.0))
    axis = away * cos(turned), away * sin(turned)
    machine = slotted_lever(rng, radius, axis, log(rng, 1e-9, 1e3))
    machine.stop("flap", "lower", -log(rng, 1e-6, 1.0), restitution(rng))
    machine.stop("flap", "upper", log(rng, 1e-6, 1.0), restitution(rng))
    machine.spring("s flap", "flap", log(rng, 1e-2, 1e3), float(rng.normal(0.0, 0.2)))
    if rng.random() < 0.5:
        machine.damper("d flap", "flap", log(rng, 1e-4, 1.0))
    # The block has a coordinate, which may have a spring and a damper.
    machine.joints["slot"] = False
    if rng.random() < 0.3:
        machine.spring("s slot", "slot", log(rng, 1.0, 1e4), float(rng.normal(0.0, 0.1)))
    if rng.random() < 0.3:
        machine.damper("d slot", "slot", log(rng, 1e-2, 1e2))
    return machine.source("slots", _gravity(rng), []), _turns(rng, 20.0, 1000.0)


_NIPPER_POINTS = (
    ("frame", "top_nipper"), ("bottom_nipper", "steeve_upper"), ("rocker", "top_nipper"),
    ("frame", "steeve_lower"), ("pendulum_arm", "rocker_foot"), ("steeve_lower", "rod_head"),
)  # fmt: skip


def _nipper(rng: Generator) -> Draft:
    """A nipper with stops on both sides, dampers on its joints and elements between its points."""
    source = changed(usual(rng))
    stops, springs = source.description["stops"], source.description["springs"]
    dampers: dict[str, Any] = source.description.setdefault("dampers", {})
    stops["jaw"]["restitution"] = restitution(rng)
    if rng.random() < 0.7:
        stops["wide"] = {
            "joint": "jaw", "restitution": restitution(rng), "side": "upper",
            "at_deg": log(rng, 30.0, 90.0) if rng.random() < 0.8 else log(rng, 1e-3, 30.0),
        }  # fmt: skip
    if rng.random() < 0.7:
        stops["bottom"] = {
            "joint": "steeve", "restitution": restitution(rng), "side": "upper",
            "at_mm": log(rng, 1e-3, 40.0),
        }  # fmt: skip
    if rng.random() < 0.2:
        stops["steeve"]["at_mm"] = -log(rng, 1e-6, 3.0)
    if rng.random() < 0.5:
        dampers["jaw"] = {"joint": "jaw", "damping_N_m_s_per_rad": log(rng, 1e-4, 10.0)}
    if rng.random() < 0.5:
        dampers["steeve"] = {"joint": "steeve", "damping_N_s_per_m": log(rng, 1e-1, 1e4)}
    for number in range(int(rng.integers(0, 3))):
        first, second = _NIPPER_POINTS[int(rng.integers(len(_NIPPER_POINTS)))]
        points = {"frame_a": first, "frame_b": second}
        springs[f"strut{number}"] = {
            **points, "stiffness_N_per_m": log(rng, 1e-3, 1e5),
            "free_length_mm": float(rng.uniform(0.0, 300.0)),
        }  # fmt: skip
        dampers[f"strut{number}"] = {**points, "damping_N_s_per_m": log(rng, 1e-2, 1e3)}
    case = window(rng, float(rng.uniform(100.0, 900.0))) | {"max_collisions": 80}
    case["drive"] = "inertial" if rng.random() < 0.25 else "held"
    if rng.random() < 0.5:
        case["resolution"] = {"tolerance": log(rng, 1e-12, 1e-3)}
    return source, case


ELEMENT_FAMILIES: dict[str, Callable[[Generator], tuple[Source, dict[str, Any]]]] = {
    "two stops": _two_stops,
    "chain": _chain,
    "hard elements": _hard_elements,
    "spring tables": _spring_tables,
    "near points": _near_points,
    "slots": _slots,
    "nipper with elements": _nipper,
}
"""The families by name."""

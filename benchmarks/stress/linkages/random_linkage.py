"""Random linkages: a driven crank, one to four dyads, one to three free coordinates, and stops."""

from __future__ import annotations

import copy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from nipper_pin.mechanism.drawing import (
    Body,
    Damper,
    Drawing,
    Drive,
    Part,
    Pin,
    Place,
    Slide,
    Slot,
    Spring,
    Stop,
    Tie,
    drawn_sources,
    write_drawing,
)
from nipper_pin.mechanism.drawing.urdf_text import mass_of

from ..machines.draws import Draft, Generator, log, one_of, sign
from ..machines.parts import Source
from .dyads import KINDS, Growing, add_dyad, crank
from .freedoms import Struck, box_parts, furthest, lever_parts, open_at, rod_parts, struck
from .motion import ANGLES, NoAssemblyError, still

_TRIES = 60


def linkage(rng: Generator) -> Draft:
    """A random linkage, and a turn or two of it with held or inertial shafts."""
    drawing, case = _draft(rng)
    urdf, description = drawn_sources(drawing)
    return Source(drawing.name, urdf, description, "."), case


def write_linkage(seed: int, number: int, folder: str | Path) -> dict[str, Any]:
    """Write the machine of a trial of this family alone as a model folder; return its case.

    Raises:
        InputError: The folder cannot be written or is not empty.
    """
    drawing, case = _draft(np.random.default_rng([seed, number]))
    write_drawing(drawing, folder)
    return case


def _draft(rng: Generator) -> tuple[Drawing, dict[str, Any]]:
    drawing = random_linkage(rng)
    return drawing, {
        "speed_rpm": drawing.speed_rpm, "window": "cycle", "cycles": int(rng.integers(1, 3)),
        "drive": "inertial" if rng.random() < 0.4 else "held", "max_collisions": 200,
    }  # fmt: skip


def random_linkage(rng: Generator) -> Drawing:
    """Draw a linkage that closes over the whole turn of its crank."""
    linkage = _grown(rng)
    step = int(sign(rng))
    freedoms = int(rng.integers(1, 4))
    rods = [(output, output.rod) for output in linkage.outputs if output.rod is not None]
    count = int(rng.integers(0, freedoms + 1))
    chosen = [rods[place] for place in rng.permutation(len(rods))[:count]]
    stops: dict[str, Struck] = {}
    for output, rod in chosen:
        found = struck(rng, output, rod, step)
        if found is not None and open_at([*stops.values(), found]) is not None:
            stops[rod.name] = found
    start = open_at(list(stops.values())) or 0
    # Half of the drawings show a stop that is just being struck, the others where turns start.
    first = next(iter(stops.values()), None)
    touch = start if first is None or rng.random() < 0.5 else first.contact
    speed = log(rng, 30.0, 400.0)
    gravity = one_of(rng, 9.81, 9.81, 0.0)
    pull = gravity + 1e-3 * furthest(linkage) * (speed * np.pi / 30.0) ** 2
    force = _mass(linkage, touch) * pull
    parts: list[Part] = []
    closed = [rod.name for _, rod in chosen]
    linkage.halved.update(closed)
    for name in tuple(closed):
        strong = force * float(rng.uniform(1.0, 5.0))
        parts += rod_parts(rng, linkage, stops.get(name), name, strong)
    for number in range(freedoms - len(chosen)):
        if rng.random() < 0.5:
            parts += lever_parts(rng, linkage, f"flap{number}", pull)
            closed.append(f"flap{number}")
        else:
            box, shut = box_parts(rng, linkage, f"box{number}", pull)
            parts += box
            closed += [f"box{number}"] if shut else []
    parts += _struck_stops(rng, list(stops.values()), touch)
    parts += _elements(rng, linkage, touch, force)
    # A shaft that is heavier than its machine by no more than some hundred times.
    inertia = _mass(linkage, touch) * (1e-3 * linkage.radius) ** 2 * log(rng, 3.0, 300.0)
    parts.append(Drive("O", inertia=inertia, frequency_hz=log(rng, 10.0, 100.0)))
    drawing = _drawing(linkage, parts, touch=touch, start=start, step=step, speed=speed)
    struck_joint = first.output.joint if first else ""
    return replace(drawing, gravity_m_s2=gravity, closed=tuple(closed),
                   struck=struck_joint)  # fmt: skip


def _grown(rng: Generator) -> Growing:
    """A crank with one to four dyads."""
    linkage = crank(rng, log(rng, 0.05, 0.4))
    for _ in range(int(rng.integers(1, 5))):
        for _ in range(_TRIES):
            more = copy.deepcopy(linkage)
            try:
                add_dyad(rng, more, str(rng.choice(KINDS)))
            except NoAssemblyError:
                continue
            linkage = more
            break
    return linkage


def _mass(linkage: Growing, touch: int) -> float:
    """Mass of all bodies [kg]."""
    points = _points(linkage, touch)
    bodies = [linkage.body(name) for name in linkage.bodies]
    return sum(mass_of(body, points).mass for body in bodies if isinstance(body, Body))


def _points(linkage: Growing, touch: int) -> dict[str, Place]:
    return {
        name: (x.real[touch].item(), x.imag[touch].item()) for name, x in linkage.places.items()
    }


def _struck_stops(rng: Generator, stops: list[Struck], touch: int) -> list[Part]:
    found: list[Part] = []
    for stop in stops:
        x, side = stop.output.coordinate, "lower" if stop.lower else "upper"
        away = float(x[stop.contact] - x[touch])
        place = float(np.degrees(away)) if stop.output.hinge else away
        e_N = one_of(rng, 0.0, 0.2, rng.uniform(0.0, 0.8))
        found.append(Stop(stop.output.joint, side, place, e_N))
    return found


def _elements(rng: Generator, linkage: Growing, touch: int, force: float) -> list[Part]:
    """Add springs and dampers that the motion does not need."""
    found: list[Part] = []
    arm = 1e-3 * linkage.size
    for output in linkage.outputs:
        if rng.random() < 0.25:
            k = force * float(rng.uniform(0.02, 0.5))
            preload = float(rng.normal(0.0, 10.0))
            found.append(Spring(output.joint, k * arm if output.hinge else k / arm, preload))
        if rng.random() < 0.15:
            c = force * log(rng, 1e-3, 3e-2)
            found.append(Damper(output.joint, c * arm if output.hinge else c / arm))
    if rng.random() < 0.25:
        body, point = linkage.moving(rng)
        away = linkage.size * float(rng.uniform(1.0, 2.0))
        anchor = complex(linkage.places[point].mean() + away * (0.6 + 0.8j))
        apart = np.abs(linkage.places[point] - anchor)
        if apart.min() > 0.2 * linkage.size:
            linkage.places["Z"] = still(anchor)
            free = float(apart[touch] * rng.uniform(0.4, 1.2))
            found.append(Tie("coil", (f"{body} {point}", "frame Z"),
                             force * float(rng.uniform(0.02, 0.3)) / arm, free))  # fmt: skip
    return found


def _drawing(
    linkage: Growing, parts: list[Part], *, touch: int, start: int, step: int, speed: float
) -> Drawing:
    """The drawing, with no stop closed."""
    bodies = [linkage.body(name) for name in linkage.bodies if name not in linkage.halved]
    joints: list[Part] = [_halved(joint, linkage) for joint in linkage.joints]
    touch_deg, start_deg = (float(np.degrees(ANGLES[place])) for place in (touch, start))
    # Turns begin before the drawing's place, as the crank turns.
    while step * (start_deg - touch_deg) > 0.0:
        start_deg -= 360.0 * step
    return Drawing(
        "linkage",
        "random linkage",
        _points(linkage, touch),
        (*bodies, *joints, *parts),
        touch_deg=touch_deg,
        start_deg=start_deg,
        speed_rpm=speed,
        clockwise=step < 0,
        invented="random numbers",
    )


def _halved(joint: Pin | Slide | Slot, linkage: Growing) -> Part:
    """A joint of a rod that is two halves now: on the half that has its point."""

    def half(link: str, point: str) -> str:
        if link not in linkage.halved:
            return link
        return f"{link}_2" if linkage.on[link][1] == point else f"{link}_1"

    sides = ("slotted", "pinned") if isinstance(joint, Slot) else ("parent", "child")
    point = joint.point if isinstance(joint, Pin) else joint.at
    links: dict[str, Any] = {side: half(getattr(joint, side), point) for side in sides}
    return replace(joint, **links)

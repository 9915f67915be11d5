"""Random linkages: a driven crank, one to four dyads, one to three free coordinates, and stops."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np

from nipper_pin.mechanism.drawing import Drawing, Place
from nipper_pin.mechanism.drawing.layout import BodyTable
from nipper_pin.mechanism.drawing.mass import mass_of
from nipper_pin.mechanism.export import export

from ..machines.draws import Draft, Generator, log, one_of, sign
from ..machines.parts import Source
from .dyads import KINDS, Growing, add_dyad, crank
from .freedoms import Parts, Struck, add_box, add_lever, add_rod, furthest, open_at, struck
from .motion import ANGLES, NoAssemblyError, still

_TRIES = 60


def linkage(rng: Generator) -> Draft:
    """A random linkage, and a turn or two of it with held or inertial shafts."""
    drawing, case = _draft(rng)
    urdf, description = drawing.sources()
    return Source(drawing.name, urdf, description, "."), case


def write_linkage(seed: int, number: int, folder: str | Path) -> dict[str, Any]:
    """Write the machine of a trial of this family alone as a model folder; return its case.

    Raises:
        InputError: The folder cannot be written or is not empty.
    """
    drawing, case = _draft(np.random.default_rng([seed, number]))
    export(drawing.mechanism(), folder)
    return case


def _draft(rng: Generator) -> tuple[Drawing, dict[str, Any]]:
    drawing = random_linkage(rng)
    return drawing, {
        "speed_rpm": drawing.tables["speed_rpm"],
        "window": "cycle",
        "cycles": int(rng.integers(1, 3)),
        "drive": "inertial" if rng.random() < 0.4 else "held",
        "max_collisions": 200,
    }


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
    parts = Parts()
    closed = [rod.name for _, rod in chosen]
    linkage.halved.update(closed)
    for name in tuple(closed):
        strong = force * float(rng.uniform(1.0, 5.0))
        add_rod(rng, linkage, stops.get(name), name, strong, parts)
    for number in range(freedoms - len(chosen)):
        if rng.random() < 0.5:
            add_lever(rng, linkage, f"flap{number}", pull, parts)
            closed.append(f"flap{number}")
        elif add_box(rng, linkage, f"box{number}", pull, parts):
            closed.append(f"box{number}")
    _add_struck_stops(rng, list(stops.values()), touch, parts)
    _add_elements(rng, linkage, touch, force, parts)
    # A shaft that is heavier than its machine by no more than some hundred times.
    inertia = _mass(linkage, touch) * (1e-3 * linkage.radius) ** 2 * log(rng, 3.0, 300.0)
    drive = {
        "joint": "O", "law": "constant_speed", "ratio": 1.0, "reflected_inertia_kg_m2": inertia,
        "shaft_frequency_hz": log(rng, 10.0, 100.0), "shaft_damping_ratio": 0.7,
    }  # fmt: skip
    tables = linkage.tables(_points(linkage, touch))
    touch_deg, start_deg = (float(np.degrees(ANGLES[place])) for place in (touch, start))
    # Turns begin before the drawing's place, as the crank turns.
    while step * (start_deg - touch_deg) > 0.0:
        start_deg -= 360.0 * step
    return Drawing(
        {
            **tables,
            "bodies": {**tables["bodies"], **parts.bodies},
            "joints": [*tables["joints"], *parts.joints],
            "title": "random linkage",
            "invented": "random numbers",
            "speed_rpm": speed,
            "direction": "clockwise" if step < 0 else "counter-clockwise",
            "touch_deg": touch_deg,
            "start_deg": start_deg,
            "gravity_m_s2": gravity,
            "closed": closed,
            "transition_stop": first.output.joint if first else "",
            "drives": {"O": drive},
            "springs": parts.springs,
            "dampers": parts.dampers,
            "stops": parts.stops,
        },
        "linkage",
    )


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
    bodies = [BodyTable(**linkage.body(name)) for name in linkage.bodies]
    return sum(mass_of(body, points).mass for body in bodies)


def _points(linkage: Growing, touch: int) -> dict[str, Place]:
    return {
        name: (x.real[touch].item(), x.imag[touch].item()) for name, x in linkage.places.items()
    }


def _add_struck_stops(rng: Generator, stops: list[Struck], touch: int, parts: Parts) -> None:
    for stop in stops:
        x, side = stop.output.coordinate, "lower" if stop.lower else "upper"
        away = float(x[stop.contact] - x[touch])
        place = float(np.degrees(away)) if stop.output.hinge else away
        e_N = one_of(rng, 0.0, 0.2, rng.uniform(0.0, 0.8))
        parts.stop(stop.output.joint, side, place, e_N, hinge=stop.output.hinge)


def _add_elements(rng: Generator, linkage: Growing, touch: int, force: float, parts: Parts) -> None:
    """Add springs and dampers that the motion does not need."""
    arm = 1e-3 * linkage.size
    for output in linkage.outputs:
        joint, hinge = output.joint, output.hinge
        if rng.random() < 0.25:
            k = force * float(rng.uniform(0.02, 0.5))
            preload = float(rng.normal(0.0, 10.0))
            parts.spring(joint, k * arm if hinge else k / arm, preload, hinge=hinge)
        if rng.random() < 0.15:
            c = force * log(rng, 1e-3, 3e-2)
            key = "damping_N_m_s_per_rad" if hinge else "damping_N_s_per_m"
            parts.dampers[joint] = {"joint": joint, key: c * arm if hinge else c / arm}
    if rng.random() < 0.25:
        body, point = linkage.moving(rng)
        away = linkage.size * float(rng.uniform(1.0, 2.0))
        anchor = complex(linkage.places[point].mean() + away * (0.6 + 0.8j))
        apart = np.abs(linkage.places[point] - anchor)
        if apart.min() > 0.2 * linkage.size:
            linkage.places["Z"] = still(anchor)
            free = float(apart[touch] * rng.uniform(0.4, 1.2))
            parts.springs["coil"] = {
                "ends": [f"{body} {point}", "frame Z"],
                "stiffness_N_per_m": force * float(rng.uniform(0.02, 0.3)) / arm,
                "free_length_mm": free,
            }

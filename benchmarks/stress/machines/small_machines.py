"""Small machines of a stress campaign, written out as the two texts of a model.

They are simple enough that what they ought to do is known, and their numbers go where those of a
comber cannot: a four-bar through its dead centre, flaps that leave their stops together, a mass on
a table that hardly rises.
"""

from __future__ import annotations

import copy
from functools import cache
from math import sqrt

from nipper_pin.mechanism import load

from .parts import SHAFT, SLED, Source, description, frame, hinge, link, robot, slide

_load = cache(load)


def e62() -> Source:
    """The E62-class model of the package, an estimate of that class of machine."""
    machine = _load("e62")
    document = copy.deepcopy(dict(machine.description))
    return Source(machine.name, machine.urdf, document, machine.mesh_folder)


def four_bar(
    ground: float, crank: float, coupler: float, rocker: float, masses: tuple[float, float, float]
) -> Source:
    """A four-bar with a driven crank; at q = 0 the crank points at the rocker's axis.

    With the crank at half a turn its pin is ``ground + crank`` away from that axis, so a coupler
    and a rocker that are as long together stand in their dead centre there. ``ground`` is the
    distance of the axes; lengths are in m, masses are those of crank, coupler and rocker [kg].
    """
    base = ground - crank
    x = (coupler**2 + base**2 - rocker**2) / (2.0 * base)
    z = sqrt(max(coupler**2 - x**2, 0.0))
    first, second, third = masses
    parts = [
        link("crank", first, 1e-4 * first, (0.5 * crank, 0.0)),
        hinge("crank_axis", "frame", "crank", (0.0, 0.0)),
        link("coupler", second, 1e-3 * second, (0.5 * x, 0.5 * z)),
        hinge("crank_pin", "crank", "coupler", (crank, 0.0)),
        frame("coupler_end", "coupler", (x, z)),
        link("rocker", third, 1e-3 * third, (0.5 * (x - base), 0.5 * z)),
        hinge("rocker_axis", "frame", "rocker", (ground, 0.0)),
        frame("rocker_end", "rocker", (x - base, z)),
    ]
    texts = description("four-bar with a driven crank", 1, 9.81)
    texts["drives"] = {
        "crank": {"joint": "crank_axis", "law": "constant_speed", "ratio": 1.0, **SHAFT}
    }
    texts["closures"] = {"coupler_pin": {"frame_a": "coupler_end", "frame_b": "rocker_end"}}
    texts["phases"] = [{"number": 1, "name": "running", "closed": []}]
    return Source("four_bar", robot("four_bar", parts), texts, ".")


def flaps(
    count: int,
    swing: tuple[float, ...],
    restitution: float,
    stiffness: float,
    preload_deg: float,
    gravity: float,
) -> Source:
    """Equal flaps on an arm that swings; each lies on a stop of its own, and all leave it at once.

    The swing is given by cosine coefficients of the arm's angle [rad]; springs of this stiffness
    [N m/rad] press the flaps shut.
    """
    names = [f"flap{number}" for number in range(1, count + 1)]
    parts = [link("arm", 1.0, 1e-3, (0.05, 0.0)), hinge("arm_axis", "frame", "arm", (0.0, 0.0))]
    for name in names:
        parts.append(link(f"{name}_plate", 0.3, 2e-4, (0.04, 0.0)))
        parts.append(hinge(name, "arm", f"{name}_plate", (0.1, 0.0)))
    texts = description("flaps on a swinging arm", 1 + count, gravity)
    texts["drives"] = {
        "arm": {"joint": "arm_axis", "law": "fourier", "cosine_rad": list(swing), **SHAFT}
    }
    texts["springs"] = {
        name: {"joint": name, "stiffness_N_m_per_rad": stiffness, "preload_deg": preload_deg}
        for name in names
    }
    texts["stops"] = {name: {"joint": name, "restitution": restitution} for name in names}
    texts["transition_stop"] = names[0]
    texts["phases"] = [
        {"number": 1, "name": "on the stops", "closed": names},
        {"number": 2, "name": "open", "closed": []},
    ]
    return Source("flaps", robot("flaps", parts), texts, ".")


def bouncing_mass(mass: float, lead_mm: float, restitution: float, gravity: float) -> Source:
    """A mass on a shelf that a table takes off at constant speed; then it bounces on the table.

    The slides that tie it to the shelf have 1e-3 kg; the lead is the rise of the table in a turn.
    """
    parts = [
        link("table", 1.0, 1e-2, (0.0, 0.0)),
        slide("lift", "frame", "table", (0.0, 1.0)),
        link("mass", mass, 1e-2 * mass, (0.0, 0.0)),
        slide("height", "table", "mass", (0.0, 1.0)),
        link("slide", 1e-3, 1e-5, (0.0, 0.0)),
        slide("slide_z", "frame", "slide", (0.0, 1.0)),
        link("carriage", 1e-3, 1e-5, (0.0, 0.0)),
        slide("slide_x", "slide", "carriage", (1.0, 0.0)),
    ]
    texts = description("bouncing mass on a rising table", 2, gravity)
    texts["drives"] = {
        "table": {"joint": "lift", "law": "screw", "lead_mm_per_turn": lead_mm, **SLED}
    }
    texts["stops"] = {
        "table": {"joint": "height", "restitution": restitution},
        "shelf": {"joint": "slide_z", "restitution": 0.0},
    }
    texts["transition_stop"] = "table"
    texts["closures"] = {"tie": {"frame_a": "carriage", "frame_b": "mass"}}
    texts["phases"] = [
        {"number": 1, "name": "on the shelf", "closed": ["shelf"]},
        {"number": 2, "name": "on the table", "closed": ["table"]},
        {"number": 3, "name": "bouncing", "closed": []},
    ]
    return Source("bouncing_mass", robot("bouncing_mass", parts), texts, ".")

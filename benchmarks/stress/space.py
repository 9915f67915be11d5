"""The space of a stress campaign: seeded random and extreme trials, family by family.

A trial depends on the seed of the campaign and on its own number alone, so any one of them can be
made again in any process, and a campaign does not depend on how it is shared out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import degrees
from typing import Any
from xml.etree import ElementTree

import numpy as np

from nipper_pin.errors import UnknownNameError
from nipper_pin.mechanism.files import parse_xml
from nipper_pin.mechanism.mechanism import Mechanism

from .linkages import linkage
from .machines.draws import (
    JAW,
    PRELOAD,
    STEEVE,
    STIFFNESS,
    Draft,
    Generator,
    changed,
    log,
    one_of,
    usual,
    window,
)
from .machines.element_families import ELEMENT_FAMILIES
from .machines.mirror import mirrored
from .machines.parts import Source
from .machines.small_machines import bouncing_mass, e62, flaps, four_bar

_LINKS = (
    "bottom_nipper", "rocker", "top_nipper", "steeve_lower", "steeve_upper", "eccentric",
)  # fmt: skip


@dataclass(frozen=True)
class Trial:
    """One trial: a model, possibly an impossible one, and arguments of :class:`~nipper_pin.Case`.

    Of these ``resolution`` holds those of a Resolution.
    """

    number: int
    seed: int
    family: str
    source: Source
    case: dict[str, Any]

    def mechanism(self) -> Mechanism:
        """Build and validate the mechanism."""
        return self.source.mechanism()

    def mirror_image(self) -> Mechanism | None:
        """Build the mirrored mechanism; None if its model cannot be mirrored."""
        source = mirrored(self.source)
        return None if source is None else source.mechanism()


def trial(seed: int, number: int, families: Sequence[str] = ()) -> Trial:
    """Return the trial of that number; families of the campaign come in turn, all by default.

    Raises:
        UnknownNameError: There is no such family.
    """
    for name in families:
        if name not in FAMILIES:
            raise UnknownNameError(kind="family of trials", name=name, known=FAMILIES)
    names = tuple(families) or tuple(FAMILIES)
    family = names[number % len(names)]
    rng = np.random.default_rng([seed, number])
    source, case = FAMILIES[family](rng)
    resolution = {"tolerance": 1e-12, **case.pop("resolution", {})}
    return Trial(number, seed, family, source, {**case, "resolution": resolution})


def _ordinary(rng: Generator) -> Draft:
    case = window(rng, float(rng.uniform(100.0, 900.0)))
    case["drive"] = "inertial" if rng.random() < 0.25 else "held"
    return changed(usual(rng)), case


def _speed(rng: Generator) -> Draft:
    return changed(usual(rng)), window(rng, log(rng, 1.0, 5000.0))


def _restitution(rng: Generator) -> Draft:
    values = {**usual(rng), JAW: one_of(rng, 0.0, 1e-12, 0.2, 0.999, 1.0, rng.uniform()),
              STEEVE: one_of(rng, 0.0, 1e-12, 0.2, 0.999, 1.0, rng.uniform())}  # fmt: skip
    return changed(values), window(rng, float(rng.uniform(100.0, 900.0)))


def _spring(rng: Generator) -> Draft:
    preload = one_of(rng, 0.0, -5.0, rng.uniform(-50.0, 50.0), rng.uniform(0.0, 20.0))
    values = {**usual(rng), STIFFNESS: log(rng, 1e-3, 1e9), PRELOAD: preload}
    return changed(values), window(rng, float(rng.uniform(100.0, 900.0)))


def _scaled(source: Source, factors: Mapping[str, tuple[float, float]]) -> Source:
    """Scale mass (first factor) and inertia (second one) of links, without their shape."""
    root = parse_xml(source.urdf, f"{source.name}.urdf")
    for link in root.iter("link"):
        if link.get("name") in factors:
            of_mass, of_inertia = factors[str(link.get("name"))]
            for tag, factor in (("mass", of_mass), ("inertia", of_inertia)):
                for item in link.iter(tag):
                    for key, value in item.attrib.items():
                        item.set(key, repr(float(value) * factor))
    urdf = ElementTree.tostring(root, encoding="unicode")
    return Source(source.name, urdf, source.description, source.folder)


def _some_scaled(rng: Generator, *, masses: bool) -> Draft:
    """Moments of inertia of some links by random factors, masses with them or not at all."""
    low, high = (1e-4, 1e4) if masses else (1e-14, 1e-2)
    chosen = rng.permutation(_LINKS)[: int(rng.integers(1, len(_LINKS) + 1))]
    factors = {str(name): log(rng, low, high) for name in chosen}
    case = window(rng, float(rng.uniform(100.0, 900.0)))
    both = {name: (f if masses else 1.0, f) for name, f in factors.items()}
    return _scaled(changed(usual(rng)), both), case


def _reach(rng: Generator) -> Draft:
    values = {
        **usual(rng),
        "drives.pendulum.crank_radius_mm": float(rng.uniform(5.0, 192.0)),
        "drives.tension.ratio": float(rng.uniform(-20.0, 20.0)),
        "cylinder.angle_at_touch_deg": float(rng.uniform(0.0, 360.0)),
    }
    keep = rng.permutation(list(values)[4:])[: int(rng.integers(0, 3))]
    values = {key: value for key, value in values.items() if key not in keep}
    case = window(rng, float(rng.uniform(100.0, 900.0)))
    return changed(values), {**case, "start_index": float(rng.uniform(0.0, 40.0))}


def _dead_centre(rng: Generator) -> Draft:
    distance = float(rng.choice([-1.0, 1.0])) * log(rng, 1e-14, 1e-1)
    ground, crank = 0.10, float(rng.uniform(0.02, 0.045))
    if rng.random() < 0.1:
        distance = 0.0
    both = (ground + crank) * (1.0 + distance)
    coupler = 0.5 * both + float(rng.uniform(-0.2, 0.2)) * (ground - crank)
    masses = (log(rng, 1e-3, 1e3), log(rng, 1e-3, 1e3), log(rng, 1e-3, 1e3))
    case = {"speed_rpm": log(rng, 1.0, 5000.0), "window": "cycle", "start_index": 0.0}
    case["drive"] = "inertial" if rng.random() < 0.3 else "held"
    case["cycles"] = int(rng.integers(1, 3))
    return four_bar(ground, crank, coupler, both - coupler, masses), case


def _grazing(rng: Generator) -> Draft:
    kind = int(rng.integers(3))
    if kind == 0:
        # Near the rear turning point of the pendulum the lips approach as slowly as one likes.
        source = e62()
        drive = source.description["drives"]["pendulum"]
        crank, guide = drive["crank_axis_mm"], drive["guide_axis_mm"]
        away = np.arctan2(guide[1] - crank[1], guide[0] - crank[0])
        lean = np.arccos(drive["crank_radius_mm"] / np.hypot(guide[0] - crank[0],
                                                            guide[1] - crank[1]))  # fmt: skip
        side, near = float(rng.choice([-1.0, 1.0])), log(rng, 1e-12, 1e-1)
        angle = away + side * lean + float(rng.choice([-1.0, 1.0])) * near
        values = {**usual(rng), "cylinder.angle_at_touch_deg": degrees(float(angle))}
        return changed(values), {"speed_rpm": float(rng.uniform(100.0, 900.0))}
    if kind == 1:
        mass = bouncing_mass(0.7, log(rng, 1e-9, 10.0), float(rng.uniform(0.0, 0.9)), 9.81)
        return mass, {"speed_rpm": log(rng, 1.0, 1000.0), "max_collisions": 200}
    # An arm that swings just hard enough to throw the flap, or just not.
    speed = float(rng.uniform(60.0, 600.0))
    swing = 0.3 * float(1.0 + rng.choice([-1.0, 1.0]) * log(rng, 1e-12, 1e-1))
    case = {"speed_rpm": speed, "window": "cycle", "start_index": 0.0, "max_collisions": 200}
    # I q'' of the flap about its axis equals the moment of weight and spring at the top.
    moment = 0.3 * 0.04 * (0.1 + 0.04) + 2e-4
    spring = 0.3 * moment * (speed * 2.0 * np.pi / 60.0) ** 2 - 0.3 * 0.04 * 9.81 * np.cos(0.3)
    stiffness = 5.0
    return flaps(1, (-swing,), float(rng.uniform(0.0, 0.9)), stiffness,
                 degrees(float(spring) / stiffness), 9.81), case  # fmt: skip


def _edges(rng: Generator) -> Draft:
    # The first contact is at the start, at the end of a panel or at that of the cycle.
    source = changed(usual(rng))
    cylinder = source.mechanism().cylinder
    touch = cylinder.index_from_angle(cylinder.angle_at_touch_rad)
    before = 40.0 * float(rng.integers(0, 13)) / 12.0
    off = float(rng.choice([0.0, 0.0, 1.0, -1.0])) * log(rng, 1e-14, 1e-6)
    case = {
        "window": "cycle",
        "cycles": int(rng.integers(1, 4)),
        "start_index": touch - before + off,
    }
    return source, {"speed_rpm": float(rng.uniform(100.0, 900.0)), "max_collisions": 200, **case}


def _together(rng: Generator) -> Draft:
    source = flaps(
        int(rng.integers(2, 4)),
        tuple(float(x) for x in rng.uniform(-0.4, 0.4, int(rng.integers(1, 4)))),
        one_of(rng, 0.0, 0.2, 0.5, 0.9),
        log(rng, 1e-2, 10.0),
        float(rng.uniform(-5.0, 60.0)),
        one_of(rng, 9.81, 0.0),
    )
    case = {"speed_rpm": log(rng, 20.0, 600.0), "window": "cycle", "max_collisions": 100}
    return source, {**case, "start_index": float(rng.uniform(0.0, 40.0))}


def _no_gravity(rng: Generator) -> Draft:
    source = changed({**usual(rng), "gravity_m_s2": one_of(rng, 0.0, 1e-12, 274.0)})
    return source, window(rng, float(rng.uniform(100.0, 900.0)))


def _overlap(rng: Generator) -> Draft:
    values = {**usual(rng), JAW: float(rng.uniform(0.5, 0.98))}
    case = {"window": "cycle", "cycles": int(rng.integers(2, 5)), "max_collisions": 150}
    return changed(values), {"speed_rpm": float(rng.uniform(500.0, 2000.0)), **case}


def _many_cycles(rng: Generator) -> Draft:
    reuse = bool(rng.random() < 0.7)
    cycles = int(log(rng, 10.0, 500.0)) if reuse else int(rng.integers(3, 8))
    if rng.random() < 0.02:
        cycles, reuse = 10_000, True
    case = {"window": "cycle", "cycles": cycles, "reuse_cycles": reuse, "max_collisions": 100}
    values = {**usual(rng), JAW: float(rng.uniform(0.0, 0.2))}
    return changed(values), {"speed_rpm": float(rng.uniform(200.0, 500.0)), **case}


def _tolerance(rng: Generator) -> Draft:
    resolution: dict[str, Any] = {"tolerance": log(rng, 1e-14, 1e-3)}
    if rng.random() < 0.3:
        # Few nodes pay for each digit with many panels.
        nodes = [int(rng.integers(3, 33)) for _ in range(2)]
        resolution = {
            "tolerance": max(resolution["tolerance"], 10.0 ** (1.0 - 0.6 * min(nodes))),
            "flight_nodes": nodes[0],
            "kinematic_nodes": max(nodes[1], 8),
            "panels_per_turn": int(rng.integers(1, 50)),
        }
        resolution["tolerance"] = min(resolution["tolerance"], 1e-3)
    case = window(rng, float(rng.uniform(100.0, 900.0)))
    return changed(usual(rng)), {**case, "resolution": resolution}


def _rough_table(rng: Generator) -> Draft:
    # The pendulum's own motion in a few rows, with noise and kinks between them.
    source = changed(usual(rng))
    description = source.description
    drive = description["drives"]["pendulum"]
    count, noise = int(rng.integers(4, 73)), log(rng, 1e-9, 1e-1)
    angle = np.linspace(0.0, 360.0, count + 1)
    psi = np.radians(angle)
    crank, radius = np.array(drive["crank_axis_mm"]), drive["crank_radius_mm"]
    pin = crank + radius * np.stack([np.cos(psi), np.sin(psi)], axis=1)
    along = pin - np.array(drive["guide_axis_mm"])
    rows = np.unwrap(np.arctan2(along[:, 1], along[:, 0])) + noise * rng.standard_normal(count + 1)
    rows[-1] = rows[0]
    kept = {key: drive[key] for key in ("joint", "reflected_inertia_kg_m2", "shaft_frequency_hz",
                                        "shaft_damping_ratio")}  # fmt: skip
    table = {"cylinder_angle_deg": angle.tolist(), "coordinate_rad": rows.tolist()}
    description["drives"]["pendulum"] = {**kept, "law": "table", **table}
    return source, window(rng, float(rng.uniform(100.0, 900.0)))


def _threshold(rng: Generator) -> Draft:
    case = window(rng, float(rng.uniform(100.0, 900.0)))
    return changed(usual(rng)), {**case, "rest_rate": log(rng, 1e-9, 10.0)}


def _inertial(rng: Generator) -> Draft:
    values = dict(usual(rng))
    for name in ("pendulum", "tension"):
        values[f"drives.{name}.reflected_inertia_kg_m2"] = log(rng, 1e-6, 1e6)
        values[f"drives.{name}.shaft_frequency_hz"] = log(rng, 1e-1, 1e3)
        values[f"drives.{name}.shaft_damping_ratio"] = one_of(rng, 0.0, 0.7, 1.0, 10.0)
    case = window(rng, float(rng.uniform(100.0, 900.0)))
    return changed(values), {**case, "drive": "inertial"}


def _bounce(rng: Generator) -> Draft:
    source = bouncing_mass(
        log(rng, 1e-5, 1e5),
        log(rng, 1e-2, 1e4),
        one_of(rng, 0.0, 1e-12, 0.2, 0.999, 1.0, rng.uniform()),
        one_of(rng, 9.81, 0.0, 1e-6, rng.uniform(0.0, 100.0)),
    )
    case = window(rng, log(rng, 1.0, 5000.0))
    return source, {**case, "drive": "inertial" if rng.random() < 0.2 else "held",
                    "start_index": one_of(rng, 0.0, -1.0)}  # fmt: skip


FAMILIES: dict[str, Callable[[Generator], Draft]] = {
    "ordinary": _ordinary,
    "speed": _speed,
    "restitution": _restitution,
    "spring": _spring,
    "mass ratio": partial(_some_scaled, masses=True),
    "little inertia": partial(_some_scaled, masses=False),
    "reach": _reach,
    "dead centre": _dead_centre,
    "grazing": _grazing,
    "edges": _edges,
    "together": _together,
    "gravity": _no_gravity,
    "overlap": _overlap,
    "many cycles": _many_cycles,
    "tolerance": _tolerance,
    "rough table": _rough_table,
    "threshold": _threshold,
    "inertial drive": _inertial,
    "bouncing mass": _bounce,
    **ELEMENT_FAMILIES,
    "linkage": linkage,
}
"""The families by name; trial n belongs to number n modulo their count."""

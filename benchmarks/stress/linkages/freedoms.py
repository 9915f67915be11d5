"""Freedoms of a random linkage: sprung rods, spring-held levers and boxes, and stops."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nipper_pin.arrays import FloatArray

from ..machines.draws import Generator, log, one_of, sign
from .dyads import Growing, pin, slide
from .motion import ANGLES, Output, Rod, unit

_SHARES = (0.03, 0.4)  # of the reach of a coordinate, from its end to where a stop is put


Table = dict[str, Any]


@dataclass(frozen=True)
class Parts:
    """Parts of a drawing that are added to a linkage, by the tables that they go to."""

    bodies: dict[str, Table] = field(default_factory=dict)
    joints: list[Table] = field(default_factory=list)
    springs: dict[str, Table] = field(default_factory=dict)
    dampers: dict[str, Table] = field(default_factory=dict)
    stops: dict[str, Table] = field(default_factory=dict)

    def spring(self, joint: str, stiffness: float, preload: float, *, hinge: bool) -> None:
        """Add a spring on a joint; a second one is called ``NAME_2``."""
        keys = ("stiffness_N_m_per_rad", "preload_deg") if hinge else (
            "stiffness_N_per_m", "preload_length_mm")  # fmt: skip
        name = joint if joint not in self.springs else f"{joint}_2"
        self.springs[name] = {"joint": joint, keys[0]: stiffness, keys[1]: preload}

    def stop(
        self, joint: str, side: str, place: float, e_N: float, *, hinge: bool, name: str = ""
    ) -> None:
        """Add a stop on a joint; what is the default is not written."""
        found: Table = {"joint": joint, "restitution": e_N}
        if side != "lower":
            found["side"] = side
        if place:
            found["at_deg" if hinge else "at_mm"] = place
        self.stops[name or joint] = found


@dataclass(frozen=True)
class Struck:
    """A lower or an upper stop of an output, met at a place in ``ANGLES``.

    There the rod that moves it has to get longer, or shorter.
    """

    output: Output
    lower: bool
    contact: int
    longer: bool

    @property
    def gap(self) -> FloatArray:
        """Gap of the stop if nothing gave way, shape (angles,) [rad or mm]."""
        sense = 1.0 if self.lower else -1.0
        x = self.output.coordinate
        return np.asarray(sense * (x - x[self.contact]))


def struck(rng: Generator, output: Output, rod: Rod, step: int) -> Struck | None:
    """A stop that an output, moved by a rod, meets on its way, if the rod can give way there.

    The crank turns counter-clockwise if ``step`` is 1, clockwise if it is -1.
    """
    lower = bool(rng.random() < 0.5)
    x = output.coordinate if lower else -output.coordinate
    reach = float(x.max() - x.min())
    place = float(x.min()) + float(rng.uniform(*_SHARES)) * reach
    ahead = np.roll(x, -step)
    meets = np.flatnonzero((x >= place) & (ahead < place) & (np.abs(ahead - x) < 0.3 * reach))
    if not len(meets):
        return None
    contact = int(meets[0])
    held = rod.held(float(output.coordinate[contact]))
    beyond = x < x[contact]
    length = np.abs(held - rod.driving)[beyond] - rod.length
    worst = float(length[np.argmax(np.abs(length))])
    if (length * worst).min() < -1e-3 * worst**2:
        # It would have to give way in both directions.
        return None
    return Struck(output, lower, contact, worst > 0.0)


def add_rod(
    rng: Generator, linkage: Growing, stop: Struck | None, name: str, force: float, parts: Parts
) -> None:
    """A rod as two halves on a spring with this preload [N]; a stop may make it give way."""
    preload = float(rng.uniform(5.0, 20.0))
    first, second = linkage.on[name][:2]
    longer = bool(rng.random() < 0.5) if stop is None else stop.longer
    restitution = one_of(rng, 0.0, 0.2, rng.uniform(0.0, 0.6))
    half, density = f"{first}/{second}", linkage.bodies[name]
    parts.bodies[f"{name}_1"] = {"points": f"{first} {half}", "density_kg_m": density}
    parts.bodies[f"{name}_2"] = {"points": f"{half} {second}", "density_kg_m": density}
    along = f"{first} {second}" if longer else f"{second} {first}"
    parts.joints.append(slide(name, f"{name}_1", f"{name}_2", half, along))
    parts.spring(name, 1e3 * force / preload, preload, hinge=False)
    parts.stop(name, "lower", 0.0, restitution, hinge=False)


def add_lever(rng: Generator, linkage: Growing, name: str, pull: float, parts: Parts) -> None:
    """A lever on one of the links, held by a spring against the first of two stops.

    It feels an acceleration ``pull`` [m/s2]; the linkage gets its end.
    """
    parent, point = linkage.moving(rng)
    end, length = f"{name}_end", linkage.size * float(rng.uniform(0.2, 0.8))
    lean = float(rng.uniform(0.0, 2.0 * np.pi))
    linkage.places[end] = linkage.places[point] + length * unit(lean + linkage.poses[parent].angle)
    density = log(rng, 0.1, 1.0)
    # Moment of its weight in that field, about its hinge [N m].
    moment = 0.5e-6 * density * length**2 * pull
    preload = float(rng.uniform(0.5, 20.0))
    stiffness = float(moment * float(rng.uniform(0.1, 1.5)) / np.radians(preload))
    gap = sign(rng) * float(rng.uniform(3.0, 40.0))
    restitution = one_of(rng, 0.0, 0.3, rng.uniform(0.0, 0.7))
    near, far, sense = ("lower", "upper", 1.0) if gap > 0.0 else ("upper", "lower", -1.0)
    parts.bodies[name] = {"points": f"{point} {end}", "density_kg_m": density}
    parts.joints.append(pin(point, parent, name, name))
    parts.spring(name, stiffness, sense * preload, hinge=True)
    parts.stop(name, near, 0.0, restitution, hinge=True)
    parts.stop(name, far, gap, restitution, hinge=True, name=f"{name}_open")


def add_box(rng: Generator, linkage: Growing, name: str, pull: float, parts: Parts) -> bool:
    """A box on a spring that slides on one of the links between two stops.

    It feels an acceleration ``pull`` [m/s2]. Told is if its first stop is closed as drawn.
    """
    parent, point = linkage.moving(rng)
    lean = float(rng.uniform(0.0, 2.0 * np.pi))
    way = float(np.cos(lean)), float(np.sin(lean))
    mass, gap = log(rng, 0.02, 1.0), log(rng, 2.0, 30.0)
    closed = bool(rng.random() < 0.6)
    below = 0.0 if closed else -gap * float(rng.uniform(0.2, 0.8))
    stiffness = 1e3 * mass * pull / gap * float(rng.uniform(0.1, 2.0))
    preload = gap * float(rng.uniform(0.1, 1.5)) if closed else 0.0
    restitution = one_of(rng, 0.0, 0.3, rng.uniform(0.0, 0.7))
    parts.bodies[name] = {"points": point, "mass_kg": mass}
    parts.joints.append(slide(name, parent, name, point, way))
    parts.spring(name, stiffness, preload, hinge=False)
    parts.stop(name, "lower", below, restitution, hinge=False)
    parts.stop(name, "upper", below + gap, restitution, hinge=False, name=f"{name}_far")
    return closed


def open_at(stops: list[Struck]) -> int | None:
    """Place in ``ANGLES`` where the smallest gap is largest; None if too small everywhere."""
    if not stops:
        return 0
    shares = np.min([stop.gap / np.ptp(stop.output.coordinate) for stop in stops], axis=0)
    best = int(np.argmax(shares))
    return best if shares[best] > 0.05 else None


def furthest(linkage: Growing) -> float:
    """Largest second derivative of a point's place by the crank's angle [mm]."""
    step = float(ANGLES[1] - ANGLES[0])
    return max(
        float(np.abs(np.roll(x, 1) - 2.0 * x + np.roll(x, -1)).max())
        for x in linkage.places.values()
    ) / step**2  # fmt: skip

"""Dyads of random size that a growing linkage takes up, of the five kinds that move in a plane."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nipper_pin.mechanism.drawing import FRAME, Place

from ..machines.draws import Generator, log, sign
from .motion import (
    ANGLES,
    POSES,
    Complex,
    NoAssemblyError,
    Output,
    Pose,
    Rod,
    crossing,
    heading,
    rod_on_line,
    still,
    two_rods,
    unit,
)


@dataclass
class Growing:
    """A linkage as it grows from its crank."""

    radius: float  # of the crank [mm]
    size: float  # of the links [mm]
    least: float  # sine of the angles at which links meet
    poses: dict[str, Pose] = field(default_factory=lambda: dict(POSES))
    places: dict[str, Complex] = field(default_factory=dict)  # motion of every point [mm]
    on: dict[str, list[str]] = field(default_factory=dict)  # points of every body
    bodies: dict[str, float] = field(default_factory=dict)  # density [kg/m]; of blocks mass [kg]
    joints: list[dict[str, Any]] = field(default_factory=list)  # in the order of the tree
    outputs: list[Output] = field(default_factory=list)
    halved: set[str] = field(default_factory=set)  # rods that are two halves by now

    def add(self, name: str, points: str, pose: Pose, mass: float) -> None:
        """Take up a body through points that have places."""
        self.poses[name], self.on[name], self.bodies[name] = pose, points.split(), mass

    def body(self, name: str) -> dict[str, Any]:
        """A body as a drawing has it."""
        points = self.on[name]
        if len(set(points)) == 1:
            return {"points": points[0], "mass_kg": self.bodies[name]}
        return {"points": " ".join(points), "density_kg_m": self.bodies[name]}

    def tables(self, points: dict[str, Place]) -> dict[str, Any]:
        """Points, bodies and joints as a drawing has them; rods that are halves are elsewhere."""
        bodies = {name: self.body(name) for name in self.bodies if name not in self.halved}
        return {"points": points, "bodies": bodies, "joints": list(map(self._halved, self.joints))}

    def _halved(self, joint: dict[str, Any]) -> dict[str, Any]:
        """A joint of a rod that is two halves now: on the half that has its point."""
        point = joint.get("pin") or joint["at"]
        halves = {
            side: f"{joint[side]}_{2 if self.on[joint[side]][1] == point else 1}"
            for side in ("parent", "child")
            if joint[side] in self.halved
        }
        return {**joint, **halves}

    def moving(self, rng: Generator) -> tuple[str, str]:
        """A moving body and a point of it: one that it has, or a new one."""
        bodies = [
            name for name in self.on if len(set(self.on[name])) > 1 and name not in self.halved
        ]
        name = str(rng.choice(bodies))
        there, least = self.on[name], 0.2 * self.radius
        # What hangs on a point that stands still does not move, either; few need be so.
        if rng.random() >= 0.05:
            there = [point for point in there if np.ptp(self.places[point].view(float)) > least]
        if there and rng.random() < 0.6:
            return name, str(rng.choice(there))
        point = f"P{len(self.places)}"
        place = complex(rng.uniform(-0.3, 1.0), rng.uniform(-0.4, 0.4))
        self.places[point] = self.poses[name].at(place * self.size)
        self.on[name].append(point)
        return name, point


def pin(point: str, parent: str, child: str, name: str) -> dict[str, Any]:
    """A hinge."""
    return {"pin": point, "parent": parent, "child": child, "name": name}


def slide(name: str, parent: str, child: str, at: str, along: Place | str) -> dict[str, Any]:
    """A straight guide."""
    return {"slide": name, "parent": parent, "child": child, "at": at, "along": along}


def slot(
    name: str, parent: str, child: str, at: str, along: Place | str, mass: float
) -> dict[str, Any]:
    """A pin of the child in a slot of the parent."""
    return {"slot": name, "parent": parent, "child": child, "at": at, "along": along,
            "block_mass_kg": mass}  # fmt: skip


def crank(rng: Generator, least: float) -> Growing:
    """A driven crank about the origin."""
    radius = float(rng.uniform(10.0, 40.0))
    found = Growing(radius, radius * float(rng.uniform(2.0, 4.0)), least)
    found.places = {"O": still(0j), "A": radius * unit(ANGLES)}
    found.add("crank", "O A", Pose(found.places["O"], ANGLES), 1.0)
    found.joints.append(pin("O", FRAME, "crank", "O"))
    return found


def add_dyad(rng: Generator, linkage: Growing, kind: str) -> None:
    """Join a dyad of one of the :data:`KINDS` to a linkage, half changed if it does not close.

    Raises:
        NoAssemblyError: With these numbers it does not close over the whole turn.
    """
    _DYADS[kind](rng, linkage, str(len(linkage.outputs) + 1))


def _density(rng: Generator) -> float:
    return log(rng, 0.3, 3.0)


def _near(rng: Generator, linkage: Growing, point: str) -> complex:
    """A place at about one size of the links from where a point is on average [mm]."""
    away = float(rng.uniform(0.6, 1.8)) * linkage.size
    turned = away * unit(float(rng.uniform(0.0, 2.0 * np.pi)))
    return complex(linkage.places[point].mean() + turned)


def _rrr(rng: Generator, linkage: Growing, number: str) -> None:
    """A rod and a rocker, about a pin of the frame or of another link."""
    base, q, m, rod, rocker = FRAME, f"Q{number}", f"M{number}", f"rod{number}", f"rocker{number}"
    driver, a = linkage.moving(rng)
    end = linkage.places[a]
    if rng.random() < 0.25 and len(linkage.on) > 1:
        base, q = linkage.moving(rng)
        if base == driver or q == a:
            raise NoAssemblyError
    else:
        linkage.places[q] = still(_near(rng, linkage, a))
    pivot = linkage.places[q]
    apart = np.abs(end - pivot)
    both = float(apart.max() * rng.uniform(1.1, 1.9))
    more = float(apart.min() * rng.uniform(-0.8, 0.8))
    l_rod, l_rocker = 0.5 * (both + more), 0.5 * (both - more)
    tip = two_rods(end, l_rod, pivot, l_rocker, sign(rng), linkage.least)
    linkage.places[m] = tip
    turned = heading(pivot, tip)
    linkage.add(rod, f"{a} {m}", Pose(end, heading(end, tip)), _density(rng))
    linkage.add(rocker, f"{q} {m}", Pose(pivot, turned), _density(rng))
    joint = f"turn{number}"
    linkage.joints += [pin(q, base, rocker, joint), pin(a, driver, rod, f"{rod}_end"),
                       pin(m, rod, rocker, m)]  # fmt: skip
    stands = linkage.poses[base].angle
    moved = Rod(rod, l_rod, end, lambda value: pivot + l_rocker * unit(stands + value))
    linkage.outputs.append(Output(joint, turned - stands, True, moved))


def _rrp(rng: Generator, linkage: Growing, number: str) -> None:
    """A rod and a block on a line of the frame."""
    m, rod, block, joint = f"M{number}", f"rod{number}", f"block{number}", f"slide{number}"
    driver, a = linkage.moving(rng)
    end, at, along = linkage.places[a], _near(rng, linkage, a), float(rng.uniform(0.0, 2.0 * np.pi))
    if rng.random() < 0.3:
        at = complex(linkage.places[a].mean())
    aside = float(np.abs(((end - at) * unit(-along)).imag).max())
    length = aside * float(rng.uniform(1.05, 1.6)) + linkage.size * float(rng.uniform(0.2, 1.5))
    travel = rod_on_line(end, length, at, along, sign(rng), linkage.least)
    linkage.places[m] = at + travel * unit(along)
    linkage.add(rod, f"{a} {m}", Pose(end, heading(end, linkage.places[m])), _density(rng))
    linkage.add(block, m, Pose(linkage.places[m], np.zeros(len(ANGLES))), log(rng, 0.1, 2.0))
    linkage.joints += [slide(joint, FRAME, block, m, _way(along)),
                       pin(a, driver, rod, f"{rod}_end"), pin(m, rod, block, m)]  # fmt: skip
    moved = Rod(rod, length, end, lambda value: complex(at + value * unit(along)))
    linkage.outputs.append(Output(joint, travel, False, moved))


def _rpr(rng: Generator, linkage: Growing, number: str) -> None:
    """A lever about a pin of the frame, in which a pin or a rod of the driver slides."""
    q, lever, joint = f"Q{number}", f"lever{number}", f"turn{number}"
    driver, a = linkage.moving(rng)
    linkage.places[q] = still(_near(rng, linkage, a))
    end, pivot = linkage.places[a], linkage.places[q]
    turned = heading(pivot, end)
    if np.abs(end - pivot).min() < linkage.least * linkage.size:
        raise NoAssemblyError
    far = f"F{number}"
    reach = linkage.size * float(rng.uniform(0.5, 2.0)) * sign(rng)
    linkage.places[far] = pivot + reach * unit(turned)
    linkage.add(lever, f"{q} {far}", Pose(pivot, turned), _density(rng))
    linkage.joints.append(pin(q, FRAME, lever, joint))
    if rng.random() < 0.6:
        block = log(rng, 0.005, 0.2)
        linkage.joints.append(slot(f"slot{number}", lever, driver, a, f"{q} {a}", block))
    else:
        rod = f"rod{number}"
        linkage.add(rod, a, Pose(end, turned), log(rng, 0.05, 1.0))
        linkage.joints += [slide(f"slide{number}", lever, rod, a, f"{q} {a}"),
                           pin(a, driver, rod, f"{rod}_end")]  # fmt: skip
    linkage.outputs.append(Output(joint, turned, True))


def _rpp(rng: Generator, linkage: Growing, number: str) -> None:
    """A yoke on a line of the frame, with a slot for a pin of the driver."""
    yoke, y, joint = f"yoke{number}", f"Y{number}", f"slide{number}"
    driver, a = linkage.moving(rng)
    end, at, along = linkage.places[a], _near(rng, linkage, a), float(rng.uniform(0.0, 2.0 * np.pi))
    lean = along + sign(rng) * float(rng.uniform(0.3, 0.5)) * np.pi
    # A block in a slot of one that slides: with the line through the pin the two ways cross there.
    travel, _ = crossing(still(at), unit(along), end, unit(lean), linkage.least)
    linkage.places[y] = at + travel * unit(along)
    linkage.add(yoke, y, Pose(linkage.places[y], np.zeros(len(ANGLES))), log(rng, 0.1, 2.0))
    block = log(rng, 0.005, 0.2)
    linkage.joints += [slide(joint, FRAME, yoke, y, _way(along)),
                       slot(f"slot{number}", yoke, driver, a, _way(lean), block)]  # fmt: skip
    linkage.outputs.append(Output(joint, travel, False))


def _prp(rng: Generator, linkage: Growing, number: str) -> None:
    """A block on a guide of the driver, pinned to a block on a line of the frame."""
    m, first, second = f"M{number}", f"rider{number}", f"block{number}"
    driver, a = linkage.moving(rng)
    pose = linkage.poses[driver]
    way, along = pose.angle + float(rng.uniform(0.0, np.pi)), float(rng.uniform(0.0, np.pi))
    end = linkage.places[a]
    at = complex(end.mean())
    rides, travel = crossing(end, unit(way), still(at), unit(along), max(linkage.least, 0.2))
    if np.abs(rides).max() > 4.0 * linkage.size:
        raise NoAssemblyError
    linkage.places[m] = at + travel * unit(along)
    linkage.add(first, m, Pose(linkage.places[m], pose.angle), log(rng, 0.1, 1.0))
    linkage.add(second, m, Pose(linkage.places[m], np.zeros(len(ANGLES))), log(rng, 0.1, 2.0))
    # Drawn with the driver at the angle that the turn is begun at: the guide's way is its own.
    linkage.places[f"{m}_way"] = linkage.places[m] + linkage.size * unit(way)
    joint = f"slide{number}"
    linkage.joints += [slide(f"ride{number}", driver, first, m, f"{m} {m}_way"),
                       slide(joint, FRAME, second, m, _way(along)),
                       pin(m, first, second, m)]  # fmt: skip
    linkage.outputs.append(Output(joint, travel, False))


def _way(angle: float) -> Place:
    return float(np.cos(angle)), float(np.sin(angle))


_DYADS = {"RRR": _rrr, "RRP": _rrp, "RPR": _rpr, "RPP": _rpp, "PRP": _prp}
KINDS = tuple(_DYADS)
"""The kinds of dyads; each letter is a pin (R) or a slide (P)."""

"""Random machines with elements of every kind: chains of links, shaken or not, tied or not."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, degrees, pi, sin
from typing import Any

import numpy as np

from .draws import Generator, log, one_of, restitution, sign
from .parts import SHAFT, SLED, Place, Source, description, frame, hinge, link, robot, slide


@dataclass
class Chain:
    """A machine as it grows, link by link; all frames are parallel to the world at touch.

    Parts are those of the URDF, tables those of the TOML document. Joints that move freely are
    hinges or not; links have the places of their origins, from the frame on, the last one a mass.
    """

    parts: list[str] = field(default_factory=list)
    tables: dict[str, dict[str, Any]] = field(
        default_factory=lambda: {
            key: {} for key in ("drives", "springs", "dampers", "stops", "closures")
        }
    )
    freedom: int = 0
    joints: dict[str, bool] = field(default_factory=dict)
    links: list[tuple[str, Place]] = field(default_factory=lambda: [("frame", (0.0, 0.0))])
    mass: float = 1.0

    def add_base(self, rng: Generator, kind: str) -> None:
        """Let what follows hang on a driven link.

        Kinds are "swing" and "turn" (a shaft), "lift" (a screw), "yoke" (a crank pin in the slot of
        a slide), and "none".
        """
        if kind == "none":
            return
        self.freedom += 1
        if kind == "yoke":
            self._add_yoke(rng)
            return
        self.parts.append(link("base", 1.0, 0.01, (0.05, 0.02)))
        if kind == "lift":
            self.parts.append(slide("shaft", "frame", "base", (0.0, 1.0)))
            drive = {"law": "screw", "lead_mm_per_turn": sign(rng) * log(rng, 1e-2, 1e4), **SLED}
        else:
            self.parts.append(hinge("shaft", "frame", "base", (0.0, 0.0)))
            drive = {"law": "constant_speed", "ratio": sign(rng) * log(rng, 1e-2, 3.0), **SHAFT}
            if kind == "swing":
                swing = rng.uniform(-0.4, 0.4, 2).tolist()
                drive = {"law": "fourier", "sine_rad": swing, **SHAFT}
        self.tables["drives"]["shaft"] = {"joint": "shaft", **drive}
        self.links.append(("base", (0.0, 0.0)))

    def _add_yoke(self, rng: Generator) -> None:
        radius, lean = log(rng, 1e-3, 0.2), float(rng.uniform(-1.2, 1.2))
        self.parts += [
            *cranked(radius),
            link("yoke", 1.5, 0.01, (0.0, 0.0)),
            slide("yoke_x", "frame", "yoke", (1.0, 0.0), (radius, 0.0)),
            frame("slot_line", "yoke", (0.0, 0.0), lean),
        ]  # fmt: skip
        law = {"law": "constant_speed", "ratio": sign(rng), **SHAFT}
        self.tables["drives"]["shaft"] = {"joint": "shaft", **law}
        self.slot("slot", ("slot_line", "crank_pin"), "z", log(rng, 1e-4, 10.0))
        self.links.append(("yoke", (radius, 0.0)))

    def add_link(self, rng: Generator, turns: bool, mass: float) -> None:
        """Hang one link more on the last one."""
        number = len(self.joints)
        parent, (x, z) = self.links[-1]
        dx, dz = rng.uniform(-0.4, 0.4, 2).tolist()
        centre = rng.uniform(-0.3, 0.3, 2).tolist()
        name, joint = f"b{number}", f"j{number}"
        inertia = mass * float(rng.uniform(0.03, 0.3)) ** 2
        self.parts.append(link(name, mass, inertia, (centre[0], centre[1])))
        if turns:
            self.parts.append(hinge(joint, parent, name, (dx, dz)))
        else:
            angle = float(rng.uniform(0.0, 2.0 * pi))
            self.parts.append(slide(joint, parent, name, (cos(angle), sin(angle)), (dx, dz)))
        self.hung(name, joint, turns, (x + dx, z + dz), mass)

    def hung(self, name: str, joint: str, turns: bool, place: Place, mass: float) -> None:
        """Go on with a link of this mass [kg], whose free joint has this place."""
        self.joints[joint], self.mass = turns, mass
        self.links.append((name, place))
        self.freedom += 1

    def tie(self, rng: Generator, kind: str) -> None:
        """Tie the end of the chain to the frame.

        Kinds are "links" (two more, which leave it its freedoms), "slot" (a slot in the frame,
        which takes one), and "none".
        """
        if kind == "none":
            return
        name, (x, z) = self.links[-1]
        self.parts.append(frame("tip", name, (0.2, 0.1)))
        if kind == "slot":
            self.parts.append(frame("rail", "frame", (x + 0.2, z + 0.1), float(rng.uniform(0, pi))))
            axis = str(rng.choice(["x", "z"]))
            self.slot("rail", ("rail", "tip"), axis, self.mass * log(rng, 1e-6, 1e2))
            self.freedom -= 1
            self.joints["rail"] = False
            return
        self.parts += [
            link("rocker", 0.7, 0.02, (0.0, 0.0)),
            hinge("rocker_axis", "frame", "rocker", (x + 1.0, z + 0.3)),
            link("coupler", 0.4, 0.01, (0.0, 0.0)),
            hinge("elbow", "rocker", "coupler", (-0.3, -0.9)),
            frame("coupler_end", "coupler", (-0.5, 0.7)),
        ]
        self.tables["closures"]["tie"] = {"frame_a": "tip", "frame_b": "coupler_end"}

    def slot(self, name: str, frames: tuple[str, str], axis: str, block: float) -> None:
        """Let a pin, the second frame, slide with a block [kg] along an axis of the first one."""
        first, second = frames
        self.tables["closures"][name] = {
            "frame_a": first, "frame_b": second, "slot_axis": axis, "block_mass_kg": block,
        }  # fmt: skip

    def stop(self, joint: str, side: str, at: float, e_N: float) -> None:
        """Put a stop on a joint, at a coordinate [rad or m]."""
        key, place = ("at_deg", degrees(at)) if self.joints[joint] else ("at_mm", 1e3 * at)
        self.tables["stops"][f"{joint} {side}"] = {
            "joint": joint, "restitution": e_N, "side": side, key: place,
        }  # fmt: skip

    def add_stops(self, rng: Generator, count: int, room: tuple[float, float]) -> list[str]:
        """Put stops on joints chosen at random, with gaps in this room [rad or m].

        Told are those that are closed at the start, as their joints stand beyond them at touch.
        """
        closed = []
        places = [(joint, side) for joint in self.joints for side in ("lower", "upper")]
        both = rng.random() < 0.5
        order = rng.permutation(len(places)).tolist()
        if both:
            joint = places[order[0]][0]
            order.sort(key=lambda place: places[place][0] != joint)
        for place in order[:count]:
            joint, side = places[place]
            outwards = -1.0 if side == "lower" else 1.0
            at = outwards * log(rng, *room) * float(rng.choice([0.0, 1.0, 1.0, 1.0]))
            self.stop(joint, side, at, restitution(rng))
            if at == 0.0 and rng.random() < 0.5:
                closed.append(f"{joint} {side}")
        pairs = [name for name in self.joints if {f"{name} lower", f"{name} upper"} <= set(
            self.tables["stops"])]  # fmt: skip
        if pairs and rng.random() < 0.25:
            # Both stops on one side of touch: the joint starts on the nearer one.
            joint, away = pairs[0], sign(rng)
            near, far = log(rng, *room), log(rng, *room)
            sides = ("lower", "upper") if away > 0.0 else ("upper", "lower")
            for side, at in zip(sides, (away * near, away * (near + far)), strict=True):
                self.stop(joint, side, at, restitution(rng))
            closed = [name for name in closed if not name.startswith(f"{joint} ")]
            closed.append(f"{joint} {sides[0]}")
        # No two stops of one joint are closed.
        return list({name.split()[0]: name for name in closed}.values())

    def spring(self, name: str, joint: str, stiffness: float, preload: float) -> None:
        """Put a linear spring on a joint: [N/m or N m/rad] and [m or rad]."""
        keys = {"stiffness_N_per_m": stiffness, "preload_length_mm": 1e3 * preload}
        if self.joints[joint]:
            keys = {"stiffness_N_m_per_rad": stiffness, "preload_deg": degrees(preload)}
        self.tables["springs"][name] = {"joint": joint, **keys}

    def table(self, name: str, joint: str, rows: tuple[list[float], list[float]]) -> None:
        """Put a tabulated spring on a joint: coordinates [m or rad] and forces [N or N m]."""
        x, force = rows
        if self.joints[joint]:
            keys = {"coordinate_deg": [degrees(value) for value in x], "torque_N_m": force}
        else:
            keys = {"coordinate_mm": [1e3 * value for value in x], "force_N": force}
        self.tables["springs"][name] = {"joint": joint, **keys}

    def damper(self, name: str, joint: str, damping: float) -> None:
        """Put a damper on a joint [N s/m or N m s/rad]."""
        key = "damping_N_m_s_per_rad" if self.joints[joint] else "damping_N_s_per_m"
        self.tables["dampers"][name] = {"joint": joint, key: damping}

    def strut(
        self, rng: Generator, name: str, stiffness: float | None, damping: float | None, near: float
    ) -> None:
        """Put a spring [N/m] and a damper [N s/m], or one, between points of two links.

        At touch the points are ``near`` to each other [m].
        """
        one, other = (int(k) for k in rng.permutation(len(self.links))[:2])
        (first, place), (second, there) = self.links[one], self.links[other]
        x, z = rng.uniform(-0.3, 0.3, 2).tolist()
        angle = float(rng.uniform(0.0, 2.0 * pi))
        at = x + near * cos(angle), z + near * sin(angle)
        self.parts.append(frame(f"{name}_a", first, (x, z)))
        relative = at[0] + place[0] - there[0], at[1] + place[1] - there[1]
        self.parts.append(frame(f"{name}_b", second, relative))
        points = {"frame_a": f"{name}_a", "frame_b": f"{name}_b"}
        if stiffness is not None:
            # A free length in tension, one in compression, or zero.
            free = near * one_of(rng, 0.0, 1.0, rng.uniform(0.0, 2.0))
            self.tables["springs"][name] = {
                **points, "stiffness_N_per_m": stiffness, "free_length_mm": 1e3 * free
            }  # fmt: skip
        if damping is not None:
            self.tables["dampers"][name] = {**points, "damping_N_s_per_m": damping}

    def source(self, name: str, gravity: float, closed: list[str]) -> Source:
        """The model; its first stop is the transition stop."""
        texts = description(f"random machine: {name}", self.freedom, gravity)
        texts |= {key: table for key, table in self.tables.items() if table}
        texts["transition_stop"] = next(iter(self.tables["stops"]), "")
        texts["phases"] = [{"number": 1, "name": "start", "closed": sorted(closed)}]
        return Source(name, robot(name, self.parts), texts, ".")


def cranked(radius: float) -> list[str]:
    """A crank on the shaft with its pin."""
    return [
        link("crank", 2.0, 0.01, (0.01, 0.0)), hinge("shaft", "frame", "crank", (0.0, 0.0)),
        frame("crank_pin", "crank", (radius, 0.0)),
    ]  # fmt: skip


def spring_table(rng: Generator, reach: float, force: float) -> tuple[list[float], list[float]]:
    """Rows of a spring with kinks, steep ends, level or falling parts, or narrow rows.

    Coordinates go about as far as ``reach`` on both sides [m or rad]; forces are of this size.
    """
    count = int(rng.integers(2, 9))
    x = np.sort(rng.uniform(-1.0, 1.0, count)) * reach
    x[0], x[-1] = -reach * float(rng.uniform(1.0, 2.0)), reach * float(rng.uniform(1.0, 2.0))
    kind = int(rng.integers(5))
    if kind == 0:
        # Rising with kinks: slopes over many decades.
        rise = np.diff(x) * np.array([log(rng, 1e-3, 1e3) for _ in range(count - 1)])
        y = np.concatenate([[0.0], np.cumsum(rise)]) / reach - float(rng.uniform(-0.5, 0.5))
    elif kind == 1:
        # Nearly level, and a wall at either end.
        wall = log(rng, 1e-6, 1e-1) * reach
        x = np.array([x[0] - wall, x[0], 0.0, x[-1], x[-1] + wall])
        steep = log(rng, 1.0, 1e6)
        y = np.array([-steep, -0.1, 0.0, 0.1, steep])
    elif kind == 2:
        y = np.full(count, float(rng.uniform(-1.0, 1.0)))
    elif kind == 3:
        y = rng.uniform(-1.0, 1.0, count)
    else:
        # A step of force within a narrow row.
        narrow = log(rng, 1e-6, 1e-2) * reach
        x = np.array([x[0], -0.5 * narrow, 0.5 * narrow, x[-1]])
        y = np.array([-1.5, -1.0, 1.0, 1.5]) * sign(rng)
    return x.tolist(), (force * y).tolist()

"""What a run must show, read off it in another way than the package does.

Only the raw run is used: events with their states, and the nodes of its motion. Masses, forces and
impulses come from the texts of the model by planar geometry (`planar_tree`): impulses from the jump
of momentum, energies from 1/2 v'Mv, forces from the motion in the free directions of the closures;
places from Pinocchio's own reading of the URDF. Nothing of the package computes here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
from scipy.interpolate import BarycentricInterpolator
from scipy.linalg import null_space
from scipy.optimize import minimize_scalar

from benchmarks.stress.mechanics.planar_tree import PlanarTree
from nipper_pin import Event, Mechanism, Solution, load

Array = Any
# Machines that several rooms of tests look at.
MACHINES = Path(__file__).parent / "studies" / "machines"


def press() -> Mechanism:
    """A sled on a screw; on it a flap with a stop at its hinge, and a ball on an inclined slide."""
    return load(MACHINES / "press" / "small")


@dataclass(frozen=True)
class StopData:
    """A stop as the document has it.

    Attributes:
        column: Place of its coordinate.
        turns: Whether that is an angle.
        sense: 1 for a lower limit.
        at: Its place [rad or m].
        restitution: e_N.
        lever: Arm of the contact force about the hinge [m]; None without a contact point.
    """

    column: int
    turns: bool
    sense: float
    at: float
    restitution: float
    lever: float | None


class Judge:
    """Reads one run."""

    def __init__(self, solution: Solution) -> None:
        """Read the texts of its model."""
        self.run = solution
        mechanism = solution.mechanism
        self.document: Any = mechanism.description
        self.names = [joint.name for joint in mechanism.joints]
        self.model = pin.buildModelFromXML(mechanism.urdf)
        self.data = self.model.createData()
        joints = [self.model.joints[self.model.getJointId(name)] for name in self.names]
        self._q = [joint.idx_q for joint in joints]
        self._circles = [joint.nq == 2 for joint in joints]
        self.tree = PlanarTree.of(mechanism)
        self.turning = [not slides for slides in self.tree.slides]
        self.stops = {name: self._stop(name) for name in self.document.get("stops", {})}
        drives = self.document.get("drives", {})
        self.drives = {name: self.names.index(drives[name]["joint"]) for name in drives}
        forward = self.document["cylinder"]["direction"] == "counter-clockwise"
        self.omega = (1.0 if forward else -1.0) * math.tau * solution.case.speed_rpm / 60.0

    def _stop(self, name: str) -> StopData:
        item = self.document["stops"][name]
        column = self.names.index(item["joint"])
        turns = self.turning[column]
        at = math.radians(item.get("at_deg") or 0.0) if turns else 1e-3 * (item.get("at_mm") or 0.0)
        found = self.run.mechanism.stop(name)
        lever = None
        if found.contact is not None:
            pin.forwardKinematics(self.model, self.data, self.full(np.zeros(len(self.names))))
            axis = self.data.oMi[self.model.getJointId(item["joint"])].translation
            arm, normal = found.contact.point - axis, found.contact.normal
            lever = abs(float(arm[0] * normal[2] - arm[2] * normal[0]))
        sense = -1.0 if item.get("side") == "upper" else 1.0
        return StopData(column, turns, sense, at, item["restitution"], lever)

    def full(self, q: Array) -> Array:
        """Configuration of the URDF model."""
        out = np.empty(self.model.nq)
        for value, place, circle in zip(q, self._q, self._circles, strict=True):
            if circle:
                out[place : place + 2] = math.cos(value), math.sin(value)
            else:
                out[place] = value
        return out

    def kinetic(self, q: Array, v: Array) -> float:
        """1/2 v'Mv [J]."""
        return float(self.tree.kinetic_energy(q, v))

    def closure(self, q: Array) -> float:
        """Largest distance of two frames that a cut pin holds together [m]."""
        still = np.zeros_like(q)
        return float(np.abs(self.tree.closure(q, still, still, world=True)[0]).max(initial=0.0))

    def places(self, q: Array) -> dict[str, tuple[float, float, float]]:
        """By link: where its joint stands (x, z) [m], and its rotation counter-clockwise [rad]."""
        found = {}
        for name, pose in self._poses(q).items():
            turned = math.atan2(pose.rotation[2, 0], pose.rotation[0, 0])
            found[name] = (float(pose.translation[0]), float(pose.translation[2]), turned)
        return found

    def point(self, link: str, at: Array, q: Array, moved: Array) -> Array:
        """Where the point of a link that is at (x, z) in one configuration is in another [m]."""
        before, after = self._poses(q)[link], self._poses(moved)[link]
        there = after.act(before.actInv(np.array([at[0], 0.0, at[1]])))
        return there[[0, 2]]

    def _poses(self, q: Array) -> dict[str, Any]:
        pin.forwardKinematics(self.model, self.data, self.full(q))
        return {
            child: self.data.oMi[self.model.getJointId(joint)].copy()
            for joint, child in self._children.items()
        }

    @cached_property
    def _children(self) -> dict[str, str]:
        """Links by the names of their joints."""
        joints = ElementTree.fromstring(self.run.mechanism.urdf).iter("joint")
        named = {str(item.get("name")): item.find("child") for item in joints}
        return {name: str(named[name].get("link")) for name in self.names}  # type: ignore[union-attr]

    def unit(self, column: int) -> Array:
        """Row that picks one coordinate."""
        return np.eye(len(self.names))[column]

    def free(self, q: Array) -> Array:
        """Directions that the closures leave."""
        return null_space(self.tree.closure_jacobian(q)) if self.tree.closures else np.eye(len(q))

    # Momentum and forces in the directions that the closures leave.

    def impulses(self, event: Event) -> tuple[dict[str, float], float]:
        """Impulses along the gaps of the stops [N s or N m s], and the energy lost [J]."""
        before, after, q = event.v_before, event.v_after, event.q
        struck = [
            name for name, item in self.stops.items()
            if (name in event.stops or name in event.closed_before)
            and math.isclose(
                self.rate(name, after), -item.restitution * self.rate(name, before),
                rel_tol=1e-9, abs_tol=1e-9 * float(np.abs(before).max()),
            )
        ]  # fmt: skip
        pushes = [self.stops[name].sense * self.unit(self.stops[name].column) for name in struck]
        shafts = [self.unit(column) for column in self.drives.values()]
        free = self.free(q)
        jump = free.T @ self.tree.mass_matrix(q) @ (after - before)
        found = np.linalg.lstsq(free.T @ np.array([*pushes, *shafts]).T, jump, rcond=None)[0]
        work = float(found[len(struck) :] @ [0.5 * (before + after) @ row for row in shafts])
        lost = self.kinetic(q, before) - self.kinetic(q, after) + work
        return dict(zip(struck, found.tolist(), strict=False)), lost

    def forces(self, t: float, closed: frozenset[str], *, left: bool) -> dict[str, float]:
        """Force at the contact of each stop and of each drive, in the free directions."""
        q, v, a = self.state(t, left=left)
        wanted = self.tree.inverse_dynamics(q, v, a) - self.springs(q)
        free = self.free(q)
        held = sorted(closed)
        rows = [self.stops[name].sense * self.unit(self.stops[name].column) for name in held]
        rows += [self.unit(column) for column in self.drives.values()]
        solved = np.linalg.lstsq(free.T @ np.array(rows).T, free.T @ wanted, rcond=None)[0]
        found = dict.fromkeys([*self.stops, *self.drives], 0.0)
        found |= dict(zip([*held, *self.drives], solved.tolist(), strict=True))
        return {
            name: value / (self.stops[name].lever or 1.0) if name in self.stops else value
            for name, value in found.items()
        }

    def springs(self, q: Array) -> Array:
        """Generalised forces of the linear springs on joints."""
        found = np.zeros(len(q))
        for item in self.document.get("springs", {}).values():
            column = self.names.index(item["joint"])
            if self.turning[column]:
                k, p = item["stiffness_N_m_per_rad"], math.radians(item["preload_deg"])
            else:
                k, p = item["stiffness_N_per_m"], 1e-3 * item["preload_length_mm"]
            found[column] -= k * (p + q[column])
        return found

    # Gaps, times, states.

    def gap(self, name: str, q: Array) -> float:
        """g_N [rad or m]."""
        item = self.stops[name]
        return item.sense * (float(q[item.column]) - item.at)

    def rate(self, name: str, v: Array) -> float:
        """g_N_dot."""
        return self.stops[name].sense * float(v[self.stops[name].column])

    def state(self, t: float, *, left: bool) -> tuple[Array, Array, Array]:
        """q, v, a by interpolation between the nodes of the run."""
        segments = [item for item in self.run.segments if item.t_start <= t <= item.t_end]
        segments = [item for item in segments if item.t_end > item.t_start]
        segment = segments[0] if left else segments[-1]
        panels = [p for p in segment.panels if p.t <= t <= p.t + p.h * (1.0 + 1e-12)]
        panel = panels[0] if left else panels[-1]
        sigma = 0.5 * (1.0 - np.cos(np.pi * np.arange(len(panel.q)) / (len(panel.q) - 1)))
        place = (t - panel.t) / panel.h
        near = np.flatnonzero(np.abs(sigma - place) < 1e-13)
        if len(near):
            return panel.q[near[0]], panel.v[near[0]], panel.a[near[0]]
        curves = BarycentricInterpolator(sigma, np.stack([panel.q, panel.v, panel.a], axis=1))
        q, v, a = curves(place)
        return q, v, a

    def angle(self, t: float) -> float:
        """psi [rad], as the shaft turns evenly from its angle at time zero."""
        return float(self.run.shaft.angle(0.0)) + self.omega * t

    def index(self, t: float) -> float:
        """Index of the comber, 40 to a turn."""
        table = self.document["cylinder"]
        reference = math.radians(table.get("reference_angle_deg") or 0.0)
        if table.get("reference_drive"):
            reference = self._extreme(self.document["drives"][table["reference_drive"]])
        turns = math.copysign(1.0, self.omega) * (self.angle(t) - reference) / math.tau
        return (float(table["reference_index"]) + 40.0 * turns) % 40.0

    def _extreme(self, law: Any) -> float:
        """Crank angle at which the guide bar stands lowest."""
        r = law["crank_radius_mm"]
        x, z = np.subtract(law["crank_axis_mm"], law["guide_axis_mm"])

        def bar(psi: float) -> float:
            return math.atan2(z + r * math.sin(psi), x + r * math.cos(psi))

        start = min(np.linspace(0.0, math.tau, 721), key=bar)
        found = minimize_scalar(bar, bracket=(start - 0.02, start, start + 0.02), tol=1e-12)
        return float(found.x)

    def following(self, event: Event, name: str) -> Event | None:
        """Next event of a stop."""
        later = (item for item in self.run.events[event.number :] if name in item.stops)
        return next(later, None)

    def rebound(self, event: Event, name: str) -> tuple[float, float] | None:
        """Largest gap until the next event of the stop, and the time until then."""
        after = self.following(event, name)
        if after is None:
            return None
        if after.kind.value == "rest":
            # The series is geometric there, and its flights are parabolas.
            time = (1.0 - self.stops[name].restitution) * (after.t - event.t)
            return 0.25 * self.rate(name, event.v_after) * time, time
        t = np.linspace(event.t, min(after.t, self.run.segments[-1].t_end), 201)
        gaps = [self.gap(name, self.state(float(x), left=True)[0]) for x in t[1:]]
        top = int(np.argmax(gaps))
        if top in (0, len(gaps) - 1):
            return max(gaps), after.t - event.t
        left, middle, right = gaps[top - 1 : top + 2]
        peak = middle + (right - left) ** 2 / (8.0 * (2.0 * middle - left - right))
        return peak, after.t - event.t

    def bounces(self, closed: frozenset[str], begin: float, end: float) -> bool:
        """False for a phase without closed stops in which the transition stop is not struck."""
        stop = self.document["transition_stop"]
        return bool(closed) or any(
            stop in event.stops and begin <= event.t < end for event in self.hits
        )

    @property
    def hits(self) -> list[Event]:
        """Collisions."""
        return [item for item in self.run.events if item.kind.value == "collision"]

    @property
    def phases(self) -> list[tuple[frozenset[str], float, float]]:
        """Closed stops, beginning and end of every phase [s]."""
        number = self.document["initial_phase"]
        closed = next(p["closed"] for p in self.document["phases"] if p["number"] == number)
        marks = [(0.0, frozenset(closed))]
        marks += [(event.t, event.closed_after) for event in self.run.events]
        marks.append((self.run.segments[-1].t_end, frozenset()))
        joined: list[tuple[frozenset[str], float, float]] = []
        for (begin, now), (end, _) in pairwise(marks):
            if joined and joined[-1][0] == now:
                joined[-1] = (now, joined[-1][1], end)
            elif end > begin:
                joined.append((now, begin, end))
        return joined

"""A model folder as bodies, constraints, springs, stops and drives; nothing is computed here."""

from __future__ import annotations

import csv
import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .laws import Law, extreme, read_laws
from .links import Array, Links, read_links, vector


class Pin(NamedTuple):
    """Two points that coincide, by their numbers."""

    name: str
    first: int
    second: int


class Line(NamedTuple):
    """Point ``second`` on a line that is fixed to the body of point ``first`` [m]."""

    name: str
    first: int
    second: int
    direction: Array
    offset: float


class Stop(NamedTuple):
    """A stop on a coordinate: gap = sense (coordinate - at)."""

    name: str
    coordinate: int
    restitution: float
    sense: float
    at: float


class Drive(NamedTuple):
    """A driven coordinate; inertia, frequency [rad/s] and damping count where it is inertial."""

    name: str
    coordinate: int
    law: Law
    at_touch: float
    inertia: float
    frequency: float
    damping: float


class Spring(NamedTuple):
    """Force against a coordinate: stiffness (preload + x) + damping x_dot, or that of a table."""

    coordinate: int
    stiffness: float = 0.0
    preload: float = 0.0
    damping: float = 0.0
    table: Any = None


class Strut(NamedTuple):
    """Tension between two points: stiffness (l - free) + damping l_dot."""

    first: int
    second: int
    stiffness: float
    free: float
    damping: float


@dataclass
class Machine:
    """Everything of a model that moves or pushes."""

    links: Links
    document: Mapping[str, Any]
    places: list[tuple[int, Array]] = field(default_factory=list)
    pins: list[Pin] = field(default_factory=list)
    lines: list[Line] = field(default_factory=list)
    locks: list[tuple[int, int]] = field(default_factory=list)
    # A coordinate is a hinge (the two bodies) or the number of a line.
    coordinates: dict[str, tuple[int, int] | int] = field(default_factory=dict)
    stops: list[Stop] = field(default_factory=list)
    drives: list[Drive] = field(default_factory=list)
    springs: list[Spring] = field(default_factory=list)
    struts: list[Strut] = field(default_factory=list)
    initial: frozenset[str] = frozenset()
    touch: float = 0.0
    sense: float = 1.0
    reference: tuple[float, float] = (0.0, 0.0)

    def point(self, body: int, place: Array) -> int:
        """Number of a point of a body, by its place in the drawing."""
        self.places.append((body, place))
        return len(self.places) - 1

    def number(self, coordinate: str) -> int:
        """Place of a coordinate among all."""
        return list(self.coordinates).index(coordinate)

    def turns(self, coordinate: str) -> bool:
        """Whether a coordinate is an angle."""
        return isinstance(self.coordinates[coordinate], tuple)

    def start_angle(self, index: float) -> float:
        """Angle psi of an index of the scale, 40 to a turn."""
        angle, there = self.reference
        return angle + self.sense * 2.0 * math.pi * (index - there) / 40.0


def read_machine(folder: Path | str, name: str = "") -> Machine:
    """Read a model folder; ``name`` if its files are not called as the folder is."""
    folder = Path(folder)
    stem = name or folder.resolve().name
    text = (folder / f"{stem}.urdf").read_text(encoding="utf-8")
    document = tomllib.loads((folder / f"{stem}.toml").read_text(encoding="utf-8"))
    return build(text, document, folder)


def build(text: str, document: Mapping[str, Any], folder: Path | str = ".") -> Machine:
    """Build a machine from the text of its URDF and its TOML document."""
    machine = Machine(read_links(text), document)
    _joints(machine)
    for name, item in document.get("closures", {}).items():
        _closure(machine, name, item)
    for name in machine.links.damping:
        machine.springs.append(Spring(machine.number(name), damping=machine.links.damping[name]))
    for kind in ("springs", "dampers"):
        for item in document.get(kind, {}).values():
            _element(machine, item, Path(folder))
    for name, item in document.get("stops", {}).items():
        angle = math.radians(item.get("at_deg", 0.0))
        at = angle if machine.turns(item["joint"]) else item.get("at_mm", 0.0) / 1000.0
        sense = -1.0 if item.get("side") == "upper" else 1.0
        number = machine.number(item["joint"])
        machine.stops.append(Stop(name, number, item["restitution"], sense, at))
    _shaft(machine, Path(folder))
    first = document["initial_phase"]
    machine.initial = frozenset(
        name for item in document["phases"] if item["number"] == first for name in item["closed"]
    )
    return machine


def _joints(machine: Machine) -> None:
    for joint in machine.links.joints.values():
        first = machine.point(joint.parent, joint.place)
        second = machine.point(joint.child, joint.place)
        if joint.hinge:
            machine.pins.append(Pin(joint.name, first, second))
            machine.coordinates[joint.name] = (joint.parent, joint.child)
        else:
            machine.coordinates[joint.name] = len(machine.lines)
            machine.lines.append(Line(joint.name, first, second, joint.direction, 0.0))
            machine.locks.append((joint.parent, joint.child))


def _closure(machine: Machine, name: str, item: Mapping[str, Any]) -> None:
    """A cut pin, or a pin in a slot: the block is a point of mass at the pin."""
    one, other = machine.links.frames[item["frame_a"]], machine.links.frames[item["frame_b"]]
    first, second = machine.point(one.body, one.place), machine.point(other.body, other.place)
    if "slot_axis" not in item:
        machine.pins.append(Pin(name, first, second))
        return
    direction = vector(one.axes * (1.0 if item["slot_axis"] == "x" else 1.0j))
    offset = float(direction @ (other.place - one.place))
    machine.coordinates[name] = len(machine.lines)
    machine.lines.append(Line(name, first, second, direction, offset))
    if other.body:
        machine.links.bodies[other.body].add(item["block_mass_kg"], other.place)


def _columns(item: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
    """An entry with the columns of its CSV file."""
    if "file" not in item:
        return item
    with (folder / item["file"]).open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream, skipinitialspace=True))
    return {**item, **{key: [float(row[key]) for row in rows] for key in rows[0]}}


def _element(machine: Machine, item: Mapping[str, Any], folder: Path) -> None:
    """A spring or a damper."""
    item = _columns(item, folder)
    if "frame_a" in item:
        ends = [machine.links.frames[item[key]] for key in ("frame_a", "frame_b")]
        points = [machine.point(frame.body, frame.place) for frame in ends]
        free = item.get("free_length_mm", 0.0) / 1000.0
        stiffness, damping = item.get("stiffness_N_per_m", 0.0), item.get("damping_N_s_per_m", 0.0)
        machine.struts.append(Strut(points[0], points[1], stiffness, free, damping))
        return
    number, turns = machine.number(item["joint"]), machine.turns(item["joint"])
    if turns:
        k, c = item.get("stiffness_N_m_per_rad", 0.0), item.get("damping_N_m_s_per_rad", 0.0)
        preload = math.radians(item.get("preload_deg", 0.0))
        columns = [np.radians(item.get("coordinate_deg", ())), item.get("torque_N_m", ())]
    else:
        k, c = item.get("stiffness_N_per_m", 0.0), item.get("damping_N_s_per_m", 0.0)
        preload = item.get("preload_length_mm", 0.0) / 1000.0
        columns = [np.array(item.get("coordinate_mm", ())) / 1000.0, item.get("force_N", ())]
    table = None
    if len(columns[0]):
        from scipy.interpolate import PchipInterpolator

        table = PchipInterpolator(columns[0], np.array(columns[1], dtype=float))
    machine.springs.append(Spring(number, k, preload, c, table))


def _shaft(machine: Machine, folder: Path) -> None:
    """The input shaft and what it drives."""
    shaft = machine.document["cylinder"]
    machine.touch = math.radians(shaft["angle_at_touch_deg"])
    machine.sense = -1.0 if shaft["direction"] == "clockwise" else 1.0
    items = {n: _columns(item, folder) for n, item in machine.document.get("drives", {}).items()}
    laws = read_laws(items)
    if shaft.get("reference_drive"):
        angle = extreme(laws[shaft["reference_drive"]], shaft.get("reference_extreme", "minimum"))
    else:
        angle = math.radians(shaft["reference_angle_deg"])
    machine.reference = angle, shaft["reference_index"]
    for name, item in items.items():
        law = laws[name]
        inertia = item.get("reflected_inertia_kg_m2", item.get("reflected_mass_kg", 0.0))
        frequency = 2.0 * math.pi * item.get("shaft_frequency_hz", 0.0)
        machine.drives.append(
            Drive(name, machine.number(item["joint"]), law, law.motion(machine.touch)[0],
                  inertia, frequency, item.get("shaft_damping_ratio", 0.0))
        )  # fmt: skip

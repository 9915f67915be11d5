"""What a drawing of a mechanism shows, as names and places in the touch configuration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ...arrays import FloatArray
from ...mechanism import Joint, Mechanism, Stop, joint_axis, joint_placements
from ...mechanism.parts import Closure
from ..scene.arrows import arrow_body
from ..scene.solids import guide

# A joint may have the name of a link.
_LINK = pin.FrameType.BODY


@dataclass(frozen=True)
class Link:
    """A moving link.

    Attributes:
        body: Its place in ``mechanism.joints``.
        points: Where something is joined to it or touches it, shape (K, 2) [m].
    """

    name: str
    body: int
    points: FloatArray


@dataclass(frozen=True)
class Node:
    """A joint.

    Attributes:
        kind: "pin", "slide", "slot" or "cut pin": a pin that the tree leaves open and a closure
            closes.
        body: Place in ``mechanism.joints`` of the link that carries it.
        place: Its place, shape (2,) [m].
        along: Direction of a slide or slot, shape (2,); zero for a pin.
        ground: Whether one of its links is the frame.
        driven: Name of the drive that moves it; empty without one.
        spring: Names of the springs on it; empty without one.
    """

    name: str
    kind: str
    body: int
    place: FloatArray
    along: FloatArray
    ground: bool
    driven: str = ""
    spring: str = ""


@dataclass(frozen=True)
class Mark:
    """A stop.

    Attributes:
        body: Place in ``mechanism.joints`` of the link that carries it; ``FIXED`` for the frame.
        place: Its place, shape (2,) [m].
        along: Direction in which the stop opens, shape (2,); zero for a hinge without contact.
    """

    name: str
    body: int
    place: FloatArray
    along: FloatArray


@dataclass(frozen=True)
class Sketch:
    """Everything that a drawing shows.

    Attributes:
        nodes: Joints of the tree, then closures.
        struts: Springs and dampers between two points: name, and both ends, shape (2, 2) [m].
        crank: Axis of the cylinder's crank and its radius [m]; None if no drive has one.
    """

    title: str
    links: tuple[Link, ...]
    nodes: tuple[Node, ...]
    stops: tuple[Mark, ...]
    struts: tuple[tuple[str, FloatArray], ...]
    crank: tuple[FloatArray, float] | None


def sketch(mechanism: Mechanism) -> Sketch:
    """Names and places of all parts with every coordinate at zero."""
    model = mechanism.model
    world = joint_placements(model)
    origins = [item.translation[[0, 2]] for item in world[1:]]
    nodes = [_tree_node(mechanism, joint, world) for joint in mechanism.joints]
    nodes += [_cut_node(mechanism, closure, world) for closure in mechanism.closures]
    stops = tuple(_mark(mechanism, stop, world) for stop in mechanism.stops)
    links = []
    for body, joint in enumerate(mechanism.joints):
        points = [origins[body]]
        points += [at for at, parent in zip(origins, model.parents[1:], strict=True)
                   if parent == body + 1]  # fmt: skip
        for closure in mechanism.closures:
            for frame in (closure.frame_a, closure.frame_b):
                if model.frames[model.getFrameId(frame, _LINK)].parentJoint == body + 1:
                    points.append(_frame(model, frame, world))
        for stop, mark in zip(mechanism.stops, stops, strict=True):
            hinge = mechanism.joints[stop.index]
            if stop.contact is not None and joint.child in (hinge.parent, hinge.child):
                points.append(mark.place)
        if len(points) == 1:
            # A link that carries nothing reaches to its centre of mass, as in the viewer.
            lever = world[body + 1].act(model.inertias[body + 1].lever)
            points.append(lever[[0, 2]])
        links.append(Link(joint.child, body, np.array(points)))
    struts = tuple(
        (item.name, np.array([_frame(model, name, world) for name in (item.frame_a, item.frame_b)]))
        for item in mechanism.struts
    )
    law = guide(mechanism)
    crank = None if law is None else (np.array(law.crank_axis), law.crank_radius_m)
    title = mechanism.title or mechanism.name
    return Sketch(title, tuple(links), tuple(nodes), stops, struts, crank)


def _tree_node(mechanism: Mechanism, joint: Joint, world: list[pin.SE3]) -> Node:
    """A joint of the tree."""
    along, at = np.zeros(2), world[joint.index + 1].translation[[0, 2]]
    if joint.kind == "prismatic":
        along, at = _slide(mechanism, joint.index, world)
    names = [item.name for item in mechanism.springs if item.index == joint.index]
    names += [item.name for item in mechanism.tabulated_springs if item.index == joint.index]
    return Node(
        joint.name,
        "pin" if joint.kind == "revolute" else "slide",
        joint.index,
        at,
        along,
        mechanism.model.parents[joint.index + 1] == 0,
        next((item.name for item in mechanism.drives if item.index == joint.index), ""),
        ", ".join(names),
    )


def _cut_node(mechanism: Mechanism, closure: Closure, world: list[pin.SE3]) -> Node:
    """A joint that closes a loop."""
    model = mechanism.model
    frames = (closure.frame_a, closure.frame_b)
    parents = [model.frames[model.getFrameId(name, _LINK)].parentJoint for name in frames]
    along, kind = np.zeros(2), "cut pin"
    if closure.slot_frame is not None:
        kind = "slot"
        frame = model.frames[model.getFrameId(closure.slot_frame, _LINK)]
        rotation = (world[frame.parentJoint] * frame.placement).rotation
        along = rotation[[0, 2], 0 if closure.slot_axis == "x" else 2]
    body = next(item for item in parents if item) - 1
    at = _frame(model, closure.frame_a, world)
    return Node(closure.name, kind, body, at, along, 0 in parents)


def _mark(mechanism: Mechanism, stop: Stop, world: list[pin.SE3]) -> Mark:
    """A stop at its contact point, or at its joint."""
    body = arrow_body(mechanism, stop)
    if stop.contact is not None:
        return Mark(stop.name, body, stop.contact.point[[0, 2]], stop.contact.normal[[0, 2]])
    if mechanism.joints[stop.index].kind == "prismatic":
        along, at = _slide(mechanism, stop.index, world)
        return Mark(stop.name, body, at, stop.sense * along)
    return Mark(stop.name, body, world[stop.index + 1].translation[[0, 2]], np.zeros(2))


def _slide(mechanism: Mechanism, place: int, world: list[pin.SE3]) -> tuple[FloatArray, FloatArray]:
    """Direction of a slide and where it is drawn: half-way to the joint of the link before it."""
    along = joint_axis(mechanism.model, world, place + 1)[[0, 2]]
    at = world[place + 1].translation[[0, 2]]
    before = mechanism.model.parents[place + 1]
    if before:
        at = at + 0.5 * float((world[before].translation[[0, 2]] - at) @ along) * along
    return along, at


def _frame(model: pin.Model, name: str, world: list[pin.SE3]) -> FloatArray:
    frame = model.frames[model.getFrameId(name, _LINK)]
    return np.asarray((world[frame.parentJoint] * frame.placement).translation[[0, 2]])

"""Interference: the smallest distances between links that should not touch, over a motion."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from ..arrays import FloatArray
from ..hybrid import Solution
from ..mechanism import Mechanism, collision_model
from ..tolerances.study import OVERLAP_M

# Pairs further apart than this are clear, whatever their exact distance.
_FAR_M = 0.02


@dataclass(frozen=True)
class Clearance:
    """Smallest distance between two links over a motion.

    Attributes:
        link_a: First link.
        shape_a: Its collision shape that comes nearest.
        link_b: Second link.
        shape_b: Its collision shape.
        distance_m: Distance [m]; negative where the shapes overlap.
        index: Index at which it occurs.
        may_touch: True for the two sides of a stop, which meet on purpose.
    """

    link_a: str
    shape_a: str
    link_b: str
    shape_b: str
    distance_m: float
    index: float
    may_touch: bool

    @property
    def interferes(self) -> bool:
        """True if the links overlap."""
        return self.distance_m < -OVERLAP_M


@dataclass(frozen=True)
class _Shape:
    link: str
    name: str
    joint: int
    placement: pin.SE3
    geometry: Any
    center: FloatArray
    radius: float


def clearances(solution: Solution, samples: int = 240) -> tuple[Clearance, ...]:
    """Walk a motion and find the smallest distance of every pair of links.

    Links that share a joint, a cut one too, are passed over.

    Args:
        solution: The motion; a whole cycle to be of use.
        samples: Configurations looked at, equally spaced in time; every event is added.

    Returns:
        One clearance for each pair of links that comes nearer than 20 mm, the smallest first.
    """
    mechanism = solution.mechanism
    shapes, adjacent = _shapes(mechanism), _adjacent(mechanism)
    pairs = [
        (a, b)
        for a, b in combinations(range(len(shapes)), 2)
        if shapes[a].link != shapes[b].link
        and frozenset((shapes[a].link, shapes[b].link)) not in adjacent
    ]
    if not pairs:
        return ()
    lips = _lips(mechanism)
    start, end = solution.trajectory.span
    events = [event.t for event in solution.events if start <= event.t <= end]
    times = np.unique(np.concatenate([np.linspace(start, end, samples), events]))
    motion = solution.trajectory.evaluate(times)
    near_by: dict[tuple[str, str], list[Clearance]] = {}
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    first, second = np.array(pairs, dtype=int).T
    radii = np.array([shape.radius for shape in shapes])
    for row, psi in enumerate(motion.cylinder_angle):
        links = [pin.SE3.Identity(), *solution.system.body.placements(motion.q[row])]
        places = [links[shape.joint] * shape.placement for shape in shapes]
        centers = np.array(
            [place.act(shape.center) for place, shape in zip(places, shapes, strict=True)]
        )
        apart = np.linalg.norm(centers[first] - centers[second], axis=1)
        near = np.flatnonzero(apart - radii[first] - radii[second] < _FAR_M)
        transforms = [coal.Transform3s(place.rotation, place.translation) for place in places]
        index = mechanism.cylinder.index_from_angle(float(psi))
        for number in near:
            a, b = shapes[first[number]], shapes[second[number]]
            result.clear()
            distance = coal.distance(
                a.geometry, transforms[first[number]], b.geometry, transforms[second[number]],
                request, result,
            )  # fmt: skip
            if distance < _FAR_M:
                touching = frozenset((a.link, b.link)) in lips
                near_by.setdefault((a.link, b.link), []).append(
                    Clearance(a.link, a.name, b.link, b.name, float(distance), index, touching)
                )
    return tuple(sorted(map(_smallest, near_by.values()), key=lambda item: item.distance_m))


def _smallest(places: list[Clearance]) -> Clearance:
    """The smallest distance, at the first place that the tolerance does not tell from it."""
    least = min(item.distance_m for item in places)
    first = next(item for item in places if item.distance_m <= least + OVERLAP_M)
    return replace(first, distance_m=least)


def _shapes(mechanism: Mechanism) -> list[_Shape]:
    geometry, names = collision_model(mechanism)
    links = {shape: link for link, shapes in names.items() for shape in shapes}
    order = [mechanism.model.getJointId(joint.name) for joint in mechanism.joints]
    found = []
    for item in geometry.geometryObjects:
        item.geometry.computeLocalAABB()
        found.append(
            _Shape(
                link=_moving_link(mechanism, item.parentJoint, links[item.name]),
                name=item.name,
                joint=order.index(item.parentJoint) + 1 if item.parentJoint else 0,
                placement=item.placement,
                geometry=item.geometry,
                center=np.array(item.geometry.aabb_center),
                radius=float(item.geometry.aabb_radius),
            )
        )
    return found


def _moving_link(mechanism: Mechanism, joint: int, link: str) -> str:
    name = mechanism.model.names[joint]
    return next((item.child for item in mechanism.joints if item.name == name), link)


def _adjacent(mechanism: Mechanism) -> set[frozenset[str]]:
    pairs = {frozenset((joint.parent, joint.child)) for joint in mechanism.joints}
    frames = mechanism.model.frames
    for closure in mechanism.closures:
        sides = [
            frames[mechanism.model.getFrameId(name, pin.FrameType.BODY)]
            for name in (closure.frame_a, closure.frame_b)
        ]
        root = mechanism.joints[0].parent
        if closure.slot_frame is not None:
            # The block has no shape: what meets is the slot's link and the pin's.
            sides[0] = frames[mechanism.model.getFrameId(closure.slot_frame, pin.FrameType.BODY)]
        pairs.add(frozenset(_moving_link(mechanism, side.parentJoint, root) for side in sides))
    # The two sides of a lip share the jaw joint, but their meeting is what the stop is about.
    return pairs - _lips(mechanism)


def _lips(mechanism: Mechanism) -> set[frozenset[str]]:
    return {
        frozenset((joint.parent, joint.child))
        for stop in mechanism.stops
        if stop.contact is not None
        for joint in mechanism.joints
        if joint.index == stop.index
    }

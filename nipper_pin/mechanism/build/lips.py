"""Where two lips touch: the gap between them, its normal, and the middle of what lies together.

At a distance of about zero the search for nearest points finds the normal with either sign, and
meshes that overlap have no distance at all. So lips with faces are looked at a little apart: the
joint opens them until the side is known; then the upper lip is lifted along the normal from where
the stop is closed, which keeps parallel faces parallel, and the lift is taken off the distance.
Any point of two faces that lie together is a nearest one. The outermost on either side is found by
tilting the upper lip, and the contact is in the middle between them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import coal
import numpy as np
import pinocchio as pin

from ...arrays import FloatArray
from ...tolerances.mechanics import PARALLEL_FACES, TOUCH_STEP

_ACROSS = np.array([0.0, 1.0, 0.0])
# By the largest gap that counts as none: how far lips are lifted, at least.
_LIFT = 8.0
# The part of a lift that remains of it at the deepest overlap that it resolves.
_LEFT = 0.25
_GROWTH = 4.0
_OPENINGS = 20
_ITERATIONS = 12


@dataclass(frozen=True)
class Shape:
    """A collision shape and its world placement at q = 0."""

    solid: coal.CollisionGeometry
    placement: pin.SE3


@dataclass(frozen=True)
class Gap:
    """Signed distance of two bodies, the nearest points [m] and the normal from the first on."""

    distance: float
    first: FloatArray
    second: FloatArray
    normal: FloatArray


@dataclass(frozen=True)
class Lips:
    """Two bodies, and the joint that moves the upper one.

    Attributes:
        lower: Shapes of the body that stands.
        upper: Shapes of the body that moves.
        slides: Whether the joint is a slide.
        origin: A point of the axis at q = 0 [m].
        axis: Its direction in world axes.
        unit_m: The size of the machine [m].
        accuracy_m: Accuracy asked of distances [m].
        within_m: Largest gap or overlap that counts as none [m].
    """

    lower: Sequence[Shape]
    upper: Sequence[Shape]
    slides: bool
    origin: FloatArray
    axis: FloatArray
    unit_m: float
    accuracy_m: float
    within_m: float

    @property
    def round(self) -> bool:
        """Whether they touch in one point of the plane, and a radius keeps what is searched apart.

        Distances of such lips are exact to round-off at any gap.
        """
        return len(self.lower) == len(self.upper) == 1 and any(
            isinstance(item.solid, (coal.Sphere, coal.Capsule))
            for item in (*self.lower, *self.upper)
        )

    def motion(self, coordinate: float) -> pin.SE3:
        """World motion of the upper body when the joint stands at a coordinate."""
        if self.slides:
            return pin.SE3(np.eye(3), coordinate * self.axis)
        return _turned(coordinate * self.axis, self.origin)

    def velocity(self, point: FloatArray) -> FloatArray:
        """Velocity of a point of the upper body per unit rate of the joint."""
        return self.axis if self.slides else np.cross(self.axis, point - self.origin)

    def nearest(self, motion: pin.SE3) -> Gap:
        """Least signed distance of both bodies, the upper one being moved."""
        request = coal.DistanceRequest()
        request.gjk_tolerance = request.epa_tolerance = self.accuracy_m
        request.gjk_max_iterations = 1000
        request.epa_max_iterations = 1000
        best = Gap(math.inf, np.zeros(3), np.zeros(3), np.zeros(3))
        for one in self.lower:
            for other in self.upper:
                found = _distance(one, other, motion, request, best.distance)
                best = best if found is None else found
        return best


@dataclass(frozen=True)
class Meeting:
    """How lips meet.

    Attributes:
        distance: Their signed distance where the stop is closed, -inf if it is unknown how much
            they overlap [m].
        closing: Coordinate at which they touch, NaN if the motion does not part or join them.
        point: Where they do, shape (3,) [m].
        normal: From the lower to the upper one, shape (3,).
    """

    distance: float
    closing: float
    point: FloatArray
    normal: FloatArray


def farthest(shapes: Sequence[Shape]) -> float:
    """Largest distance from the origin that a part of a shape may have [m]."""
    balls = [_ball(item) for item in shapes]
    return max(float(np.linalg.norm(place)) + radius for place, radius in balls)


def meet(lips: Lips, at: float, sense: float) -> Meeting:
    """Find where lips touch.

    Args:
        at: Coordinate at which the stop is closed [rad or m].
        sense: 1 if the bodies part with a growing coordinate, -1 with a falling one.
    """
    start = lips.nearest(lips.motion(at))
    if lips.round:
        closing, gap = _close(lips, at, sense, start)
        return Meeting(start.distance, closing, 0.5 * (gap.first + gap.second), gap.normal)
    unknown = Meeting(start.distance, math.nan, start.first, start.normal)
    apart = _opened(lips, at, sense)
    met = None if apart is None else _touching(lips, at, apart.normal)
    if met is None or met.distance < -_LIFT * lips.within_m <= start.distance:
        return unknown
    if abs(met.distance) > lips.within_m:
        closing, _ = _close(lips, at, sense, met)
        return replace(unknown, distance=met.distance, closing=closing)
    point = _middle(lips, at, met)
    rate = float(met.normal @ lips.velocity(point))
    closing = at - met.distance / rate if sense * rate > 0.0 else math.nan
    return Meeting(met.distance, closing, point, met.normal)


def _close(lips: Lips, at: float, sense: float, start: Gap) -> tuple[float, Gap]:
    """Move the upper body until it touches: Newton's method on the signed distance.

    Returns:
        Closing coordinate, NaN if the motion does not part or join the bodies, and the gap there.
    """
    coordinate, gap = at, start
    last = TOUCH_STEP * (lips.unit_m if lips.slides else 1.0)
    for _ in range(_ITERATIONS):
        slope = float(gap.normal @ lips.velocity(gap.second))
        if not sense * slope > 0.0:
            return math.nan, gap
        step = -gap.distance / slope
        coordinate += step
        there = _lifted(lips, coordinate, gap.normal)
        if there is None:
            return math.nan, gap
        gap = there
        if abs(step) < last:
            break
    return coordinate, gap


def _opened(lips: Lips, at: float, sense: float) -> Gap | None:
    """The gap where the joint has opened it just so far that its side is known.

    Returns:
        None if they do not part while the joint moves the upper one by as much as they are large.
    """
    size, least = _size(lips), 0.5 * _LIFT * lips.within_m
    arm = 1.0 if lips.slides else max(size, _arm(lips))
    travels = _LIFT * lips.within_m * _GROWTH ** np.arange(_OPENINGS)
    for travel in (0.0, *travels[travels < size].tolist()):
        gap = lips.nearest(lips.motion(at + sense * travel / arm))
        if gap.distance >= least:
            return gap
    return None


def _lifted(lips: Lips, coordinate: float, normal: FloatArray) -> Gap | None:
    """The gap at a coordinate, looked at along a normal that is nearly its own.

    Returns:
        None if the bodies overlap by more than they are large.
    """
    motion = lips.motion(coordinate)
    if lips.round:
        return lips.nearest(motion)
    lift, size = _LIFT * lips.within_m, _size(lips)
    while lift < _GROWTH * size:
        gap = lips.nearest(pin.SE3(np.eye(3), lift * normal) * motion)
        if gap.distance >= _LEFT * lift:
            return replace(gap, distance=gap.distance - lift, second=gap.second - lift * normal)
        lift *= _GROWTH
    return None


def _touching(lips: Lips, coordinate: float, normal: FloatArray) -> Gap | None:
    """The gap at a coordinate along its own normal, which is found from one nearby."""
    gap = _lifted(lips, coordinate, normal)
    for _ in range(_ITERATIONS):
        if gap is None or np.array_equal(gap.normal, normal):
            break
        normal = gap.normal
        gap = _lifted(lips, coordinate, normal)
    return gap


def _middle(lips: Lips, coordinate: float, gap: Gap) -> FloatArray:
    """Middle between the outermost points in which lips touch, shape (3,) [m]."""
    pivot = 0.5 * (gap.first + gap.second)
    ends = [_end(lips, coordinate, gap, pivot, turn) for turn in (-1.0, 1.0)]
    along: FloatArray = np.cross(_ACROSS, gap.normal)
    offset: FloatArray = along * float(along @ (0.5 * (ends[0] + ends[1]) - pivot))
    return pivot + offset


def _end(lips: Lips, coordinate: float, gap: Gap, pivot: FloatArray, turn: float) -> FloatArray:
    """The outermost point on one side in which lips touch within the gap that counts as none.

    Faces count as parallel up to a small angle, but not if it opens more than that gap.
    """
    size, angle = _size(lips), PARALLEL_FACES
    while True:
        tilt = _turned(turn * angle * _ACROSS, pivot)
        lift = (_LIFT * lips.within_m + 2.0 * angle * size) * gap.normal
        found = lips.nearest(pin.SE3(np.eye(3), lift) * tilt * lips.motion(coordinate))
        upper = np.asarray(tilt.inverse() * (found.second - lift))
        apart = float(gap.normal @ (upper - found.first)) - gap.distance
        if found.distance > 0.0 and apart <= 2.0 * lips.within_m:
            # Either a corner of the lower body or the foot of one of the upper on its face: lifting
            # does not shift it.
            return found.first
        if angle * size <= lips.within_m:
            return pivot
        angle /= _GROWTH


def _distance(
    one: Shape, other: Shape, motion: pin.SE3, request: coal.DistanceRequest, below: float
) -> Gap | None:
    """Signed distance of two shapes; None if it is not below a bound."""
    result = coal.DistanceResult()
    moved = motion * other.placement
    distance = coal.distance(
        one.solid,
        coal.Transform3s(one.placement.rotation, one.placement.translation),
        other.solid,
        coal.Transform3s(moved.rotation, moved.translation),
        request,
        result,
    )
    if not distance < below:
        return None
    first, second = np.array(result.getNearestPoint1()), np.array(result.getNearestPoint2())
    normal = np.array(result.normal)
    if isinstance(one.solid, coal.BVHModelBase) and isinstance(other.solid, coal.BVHModelBase):
        # Of two meshes Coal sets no normal, and no distance below zero.
        if distance <= 0.0:
            return Gap(-math.inf, first, second, np.zeros(3))
        normal = (second - first) / distance
    return Gap(float(distance), first, second, normal)


def _turned(angle: FloatArray, about: FloatArray) -> pin.SE3:
    """Turn about a point, by a vector of rotation [rad]."""
    rotation = pin.exp3(angle)
    return pin.SE3(rotation, about - rotation @ about)


def _size(lips: Lips) -> float:
    """Size of the smaller body, which bounds what lies together [m]."""
    return min(_extent(lips.lower), _extent(lips.upper))


def _extent(shapes: Sequence[Shape]) -> float:
    """Diameter of a ball about a body [m]."""
    balls = [_ball(item) for item in shapes]
    centre = np.mean([place for place, _ in balls], axis=0)
    return 2.0 * max(float(np.linalg.norm(place - centre)) + radius for place, radius in balls)


def _ball(shape: Shape) -> tuple[FloatArray, float]:
    """Centre and radius of a ball about a shape [m]."""
    shape.solid.computeLocalAABB()
    return np.asarray(shape.placement * shape.solid.aabb_center), float(shape.solid.aabb_radius)


def _arm(lips: Lips) -> float:
    """Distance of the upper body from the hinge [m]."""
    arms = [np.cross(lips.axis, _ball(item)[0] - lips.origin) for item in lips.upper]
    return float(np.linalg.norm(np.mean(arms, axis=0)))

"""Links of a URDF as rigid bodies of the side view, x forward and z up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from benchmarks.stress.mechanics import model_text

Array = np.ndarray


def vector(place: complex) -> Array:
    """The vector of x + i z."""
    return np.array([place.real, place.imag])


@dataclass
class Body:
    """One rigid body; ``centre`` is its centre of mass in the drawing (touch) [m]."""

    mass: float
    inertia: float
    centre: Array

    def add(self, mass: float, place: Array) -> None:
        """Fix a point of mass to the body."""
        share = mass / (self.mass + mass)
        apart = place - self.centre
        self.inertia += self.mass * share * float(apart @ apart)
        self.centre = self.centre + share * apart
        self.mass += mass


class Frame(NamedTuple):
    """A link's frame: its body, its place and the direction of its x axis in the drawing."""

    body: int
    place: Array
    axes: complex


class TreeJoint(NamedTuple):
    """A moving joint between two bodies, at a place and along a direction of the drawing."""

    name: str
    hinge: bool
    parent: int
    child: int
    place: Array
    direction: Array


@dataclass
class Links:
    """All bodies (0 is the frame), the frames of all links and the moving joints.

    ``steepness`` is the part of gravity that acts in the plane.
    """

    bodies: list[Body]
    frames: dict[str, Frame]
    steepness: float
    joints: dict[str, TreeJoint]
    damping: dict[str, float]


def read_links(text: str) -> Links:
    """Read a URDF, as the campaign's judge does, and draw its links in the touch configuration."""
    read = model_text.read_links(text)
    frames = {
        name: Frame(item.body + 1, vector(read.touch(item)), item.axes)
        for name, item in read.frames.items()
    }
    found = Links([Body(0.0, 0.0, np.zeros(2))], frames, read.steepness, {}, {})
    for number, link in enumerate(read.links):
        joint = read.touch(model_text.Frame(number, 0j, 1.0))
        found.bodies.append(Body(link.mass, link.inertia, vector(joint + link.com)))
        hinge, direction = link.slide is None, vector(link.slide or 0j)
        found.joints[link.joint] = TreeJoint(
            link.joint, hinge, link.parent + 1, number + 1, vector(joint), direction
        )
        if link.damping:
            found.damping[link.joint] = link.damping
    return found

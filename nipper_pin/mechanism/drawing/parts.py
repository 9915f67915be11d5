"""Parts of a drawing of a machine: bodies through points, joints, drives, springs, stops.

The drawing shows the touch configuration, where all coordinates are zero. Points are (x, z) in mm,
x to the right and z upwards; hinges turn counter-clockwise. The name of two points with a stroke
between them, ``A/B``, is the point halfway.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

Place = tuple[float, float]
"""(x, z) of a point, or a direction [mm]."""

FRAME = "frame"
"""Name of the link that does not move."""


@dataclass(frozen=True)
class Body:
    """A moving link: rods from each of its points to the next, or a disc about its only point.

    Attributes:
        name: Name of the link.
        points: Names of its points, separated by spaces.
        density_kg_m: Mass of the rods by their length [kg/m].
        mass_kg: Mass, in place of what the density gives [kg].
        radius_mm: Of the disc of a body with one point [mm].
        centre_mm: Centre of mass, in place of that of the rods.
        inertia_kg_m2: About the centre of mass, in place of that of the rods [kg m2].
    """

    name: str
    points: str
    density_kg_m: float = 1.0
    mass_kg: float | None = None
    radius_mm: float = 15.0
    centre_mm: Place | None = None
    inertia_kg_m2: float | None = None


@dataclass(frozen=True)
class Pin:
    """A hinge. The first joint that leads to a body carries it; any other one closes a loop.

    Attributes:
        point: Where it is; also its name, unless another pin at the point came before.
        parent: One link.
        child: The other one, whose angle against the parent is the coordinate.
        name: Name of the joint, if it is not that of the point.
    """

    point: str
    parent: str
    child: str
    name: str = ""


@dataclass(frozen=True)
class Slide:
    """A straight guide; it always carries its child.

    Attributes:
        name: Name of the joint.
        parent: Link with the guide.
        child: Link that slides.
        at: Point where the guide is drawn.
        along: Direction in which the coordinate grows; or two points, from the first to the second.
    """

    name: str
    parent: str
    child: str
    at: str
    along: Place | str


@dataclass(frozen=True)
class Slot:
    """A pin in a straight slot; it always closes a loop.

    Attributes:
        name: Name of the closure, and of the joint of the block in the slot.
        slotted: Link with the slot.
        pinned: Link with the pin.
        at: Where the pin is.
        along: Direction of the slot, in which the travel of the block grows; or two points.
        block_kg: Mass of the block [kg].
    """

    name: str
    slotted: str
    pinned: str
    at: str
    along: Place | str
    block_kg: float = 0.02


@dataclass(frozen=True)
class Drive:
    """A driven joint, of the same name in the tables of the model.

    Attributes:
        law: Name of the law.
        keys: Keys of the law.
        inertia: Of shaft and drive train, seen at the joint [kg m2 or kg].
        frequency_hz: Of the elastic drive train [Hz].
    """

    joint: str
    law: str = "constant_speed"
    keys: Mapping[str, Any] = field(default_factory=lambda: {"ratio": 1.0})
    inertia: float = 0.1
    frequency_hz: float = 50.0
    damping_ratio: float = 0.7


@dataclass(frozen=True)
class Spring:
    """A linear spring on a joint; it pushes the coordinate down.

    In the model it is called as its joint is, and a second one ``NAME_2``; dampers likewise.

    Attributes:
        stiffness: Stiffness [N/m; N m/rad on a hinge].
        preload: Deflection at zero [mm; deg on a hinge].
    """

    joint: str
    stiffness: float
    preload: float = 0.0


@dataclass(frozen=True)
class Tie:
    """A spring between points of two links.

    Attributes:
        ends: Link and point of either end, as in ``"jaw E"``.
        stiffness: Stiffness [N/m].
        free_mm: Length without force [mm].
    """

    name: str
    ends: tuple[str, str]
    stiffness: float
    free_mm: float


@dataclass(frozen=True)
class Damper:
    """A linear damper on a joint.

    Attributes:
        damping: Damping [N s/m; N m s/rad on a hinge].
    """

    joint: str
    damping: float


@dataclass(frozen=True)
class Force:
    """A force element with a registered law on a joint; in the model it is called as a spring is.

    Attributes:
        law: Name of the law.
        keys: Keys of the law.
    """

    joint: str
    law: str
    keys: Mapping[str, Any]


@dataclass(frozen=True)
class Start:
    """Initial position of a joint without a drive.

    Attributes:
        at: Coordinate [mm; deg on a hinge].
        rate: Its rate [mm/s; rad/s on a hinge].
    """

    joint: str
    at: float
    rate: float = 0.0


@dataclass(frozen=True)
class Stop:
    """A stop on a joint.

    Attributes:
        side: "lower" or "upper".
        at: Coordinate at which it is closed [mm; deg on a hinge].
        restitution: Coefficient of restitution.
        name: Its name, if it is not that of the joint.
        law: Restitution law with its keys; None if the restitution is constant.
        adjusted: How the place is adjusted, with its keys; in place of ``at``.
    """

    joint: str
    side: str = "lower"
    at: float = 0.0
    restitution: float = 0.2
    name: str = ""
    law: Mapping[str, Any] | None = None
    adjusted: Mapping[str, Any] | None = None


Joint = Pin | Slide | Slot
Part = Body | Pin | Slide | Slot | Drive | Spring | Tie | Damper | Force | Start | Stop


@dataclass(frozen=True)
class Drawing:
    """A machine in its touch configuration.

    Attributes:
        name: Name of the machine.
        title: What it is, in a few words.
        points: Places by name [mm].
        parts: Its parts; joints in the order in which a tree is grown from the frame.
        touch_deg: Angle of the input shaft as drawn [deg].
        start_deg: Angle at index 24, where turns start; counted on from ``touch_deg`` [deg].
        speed_rpm: Rated speed [r/min].
        clockwise: Sense of rotation.
        closed: Stops that are closed at the start.
        struck: The stop whose bouncing is the transition; the first one if empty.
        gravity_m_s2: Along -z.
        known: Where the dimensions come from.
        invented: What is an invention.
        traced: Link and point whose path is drawn, as in ``"coupler P"``.
        tables: Further drives, springs, stops and so on, as a model's TOML file has them. Springs
            and dampers between points may have ``ends`` in the place of their frames.
    """

    name: str
    title: str
    points: Mapping[str, Place]
    parts: tuple[Part, ...]
    touch_deg: float
    start_deg: float
    speed_rpm: float
    clockwise: bool = False
    closed: tuple[str, ...] = ()
    struck: str = ""
    gravity_m_s2: float = 9.81
    known: str = ""
    invented: str = "invention: a plausible machine of its kind"
    traced: str = ""
    tables: Mapping[str, Any] = field(default_factory=dict)

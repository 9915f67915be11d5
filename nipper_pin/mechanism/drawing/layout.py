"""Layout of a drawing's file: points, bodies and joints in mm; other tables are a model's."""

from __future__ import annotations

from typing import Literal

from msgspec import field

from ..files.description import Name, NotNegative, PlanePoint, Positive, TomlTable

FRAME = "frame"
"""Name of the link that does not move."""
MADE = ("format", "degrees_of_freedom", "cylinder", "closures")
"""Of a model's file, these follow from the drawing."""


class PointTable(TomlTable, frozen=True, kw_only=True):
    """How a point is found from others; the keys of one way.

    Attributes:
        centre: A point that this one lies around.
        radius_mm: Distance from it [mm].
        angle_deg: Angle seen from it, counter-clockwise from x [deg].
        line: A point of the line on which this one lies, or where it is [mm].
        along: Direction of that line.
        meet: Two points around which this one lies.
        radii_mm: Distances from them [mm].
        between: Two points; this one lies on their line, or left of it.
        share: Share of the way from the first to the second.
        left_mm: Distance to the left of that way [mm].
        beside: A point from which the next two are counted.
        right_mm: Distance along x [mm].
        up_mm: Distance along z [mm].
        side: Which of two points it is.
    """

    centre: Name | None = None
    radius_mm: NotNegative | None = None
    angle_deg: float | None = None
    line: PlanePoint | str | None = None
    along: PlanePoint | None = None
    meet: tuple[Name, Name] | None = None
    radii_mm: tuple[NotNegative, NotNegative] | None = None
    between: tuple[Name, Name] | None = None
    share: float | None = None
    left_mm: float | None = None
    beside: Name | None = None
    right_mm: float | None = None
    up_mm: float | None = None
    side: Literal["left", "right", "ahead", "behind"] | None = None


STEEL_KG_M3 = 7850.0
"""Density of a plate without one."""


class BodyTable(TomlTable, frozen=True, kw_only=True):
    """A moving link: rods from point to point, flat bars, a plate, or a disc.

    Attributes:
        points: Names of its points, separated by spaces; ``A/B`` is halfway from A to B.
        density_kg_m: Mass of the rods from point to point by their length [kg/m].
        thickness_mm: Of a plate whose corners are the points; with a width of bars [mm].
        width_mm: Of the bars from point to point [mm].
        density_kg_m3: Of plate, bars or disc, 7850 if not given [kg/m3].
        mass_kg: Mass, in place of what the density gives [kg].
        radius_mm: Of the disc of a body with one point [mm].
        centre_mm: Centre of mass, in place of that of the shape [mm].
        inertia_kg_m2: About the centre of mass, in place of that of the shape [kg m2].
    """

    points: Name
    density_kg_m: Positive = 1.0
    thickness_mm: Positive | None = None
    width_mm: Positive | None = None
    density_kg_m3: Positive | None = None
    mass_kg: Positive | None = None
    radius_mm: Positive = 15.0
    centre_mm: PlanePoint | None = None
    inertia_kg_m2: Positive | None = None


class JointTable(TomlTable, frozen=True, kw_only=True):
    """A joint: a pin at a point, a slide, or a pin of the child in a slot of the parent.

    Attributes:
        pin: Point of a hinge.
        slide: Name of a straight guide.
        slot: Name of a pin in a straight slot.
        parent: Link that carries the joint.
        child: Link that turns or slides in it.
        name: Name of a hinge, if it is not that of its point.
        at: Point where guide or pin are.
        along: Direction in which the coordinate grows, or two points.
        block_mass_kg: Mass of the block in a slot [kg].
        follows: Joint whose coordinate this one is a multiple of, as gears make it.
        ratio: The multiple, of a hinge that follows a hinge or a slide that follows a slide.
        lead_mm_per_turn: Travel of a slide by a turn of the hinge that it follows [mm/turn].
    """

    pin: Name | None = None
    slide: Name | None = None
    slot: Name | None = None
    parent: Name
    child: Name
    name: Name | None = None
    at: Name | None = None
    along: PlanePoint | str | None = None
    block_mass_kg: Positive | None = None
    follows: Name | None = None
    ratio: float | None = None
    lead_mm_per_turn: float | None = None

    @property
    def point(self) -> str:
        """Point where it is."""
        return self.pin or self.at or ""


class ShapeTable(TomlTable, frozen=True, kw_only=True):
    """A shape of a body that stops and clearances know: a box, or a cylinder seen from its end.

    Attributes:
        body: The body, or the frame.
        at: Its middle: a point, or where it is [mm].
        radius_mm: Radius of the cylinder [mm].
        box_mm: Edges of the box, along and across [mm].
        angle_deg: Direction of the edge along, counter-clockwise from x [deg].
        depth_mm: Extent across the plane [mm].
    """

    body: Name
    at: PlanePoint | str
    radius_mm: Positive | None = None
    box_mm: tuple[Positive, Positive] | None = None
    angle_deg: float = 0.0
    depth_mm: Positive = 20.0


class DrawingTable(TomlTable, frozen=True, kw_only=True):
    """The tables of a drawing that a model's file has not.

    Attributes:
        drawing: Layout version, 1.
        title: What the machine is, in a few words.
        speed_rpm: Rated speed [r/min].
        direction: Sense of rotation of the input shaft.
        touch_deg: Angle of the input shaft as drawn [deg].
        start_deg: Angle at which turns start; that of the drawing if not given [deg].
        closed: Stops that are closed at the start.
        transition_stop: The stop whose bouncing is the transition; the first one if not given.
        gravity_m_s2: Gravity along -z [m/s2].
        known: Where the dimensions come from.
        invented: What is an invention.
        traced: Link and point whose path is drawn.
        points: Places by name [mm].
        bodies: Moving links by name.
        shapes: Shapes of bodies by name, above all those that meet at a stop.
        joints: Joints, in the order in which a tree is grown from the frame.
    """

    drawing: Literal[1]
    title: Name
    speed_rpm: Positive
    direction: Literal["clockwise", "counter-clockwise"] = "counter-clockwise"
    touch_deg: float = 0.0
    start_deg: float | None = None
    closed: tuple[Name, ...] = ()
    transition_stop: str = ""
    gravity_m_s2: float = 9.81
    known: str = ""
    invented: str = "invention: a plausible machine of its kind"
    traced: str = ""
    points: dict[Name, PlanePoint | PointTable]
    bodies: dict[Name, BodyTable]
    joints: tuple[JointTable, ...]
    shapes: dict[Name, ShapeTable] = field(default_factory=dict)

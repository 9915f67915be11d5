"""Shapes of a mechanism: the visuals of its URDF, or substitutes for them; springs and stops.

Two conventions tie visuals to what the URDF cannot say. A visual of the root link named
``cylinder_...`` turns with the cylinder, whose axis is the crank axis of an oscillating guide. A
mesh named ``spring_<name>...`` is one unit long in z, scaled to its length at q = 0, and is drawn
shorter by the coordinate of the spring of that name. Springs and stops along joints, which the
shapes of a URDF seldom show, are coils, plates and pegs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...mechanism import Joint, Mechanism, Stop, joint_axis, joint_placements, own_frame
from ...mechanism.drives import OscillatingGuide
from ...mechanism.files import (
    mesh_path,
    origin,
    parse_xml,
    path_inside,
    rotation_from_rpy,
    shape_sizes,
)
from .colours import SPRING, STOP, channels, link_colour
from .meshes import mesh_of

Colour = tuple[float, float, float]
FIXED = -1
CYLINDER = -2
"""Bodies that are no links: what stands, and the cylinder. Those of links are their places in
``mechanism.joints``; Pinocchio counts the same joints from 1, and 0 is what stands."""
THICK = 0.02
"""Radius of a bar, by the extent of the mechanism."""
# Lengths by the size of the picture.
_WIRE, _AROUND, _COIL = 0.022, 0.028, 0.25
_PLATE, _PEG = (0.11, 0.04, 0.015), (0.012, 0.06)
_BAR = 0.016  # half of the width of a link
_ALONG = 0.999  # cosine of the largest angle between a slide and a rod that it lengthens
_STRUCK = 0.6  # place of a peg along its link


@dataclass(frozen=True)
class Solid:
    """One drawn shape.

    Attributes:
        name: Name, unique in its body.
        body: Place of the moving link in ``mechanism.joints``, ``FIXED`` or ``CYLINDER``.
        kind: "mesh", "box", "cylinder", "sphere" or "coil", which is one unit long.
        sizes: Box: edges; cylinder: radius and length; sphere and coil: radius [m].
        path: Mesh file, or None.
        placement: In the frame of the body, shape (4, 4) [m].
        scale: Of a mesh or coil, shape (3,).
        colour: Red, green, blue, 0 to 1.
        spring: Place in q of the spring whose length the solid shows, or None.
        stretch: Rate of that length by the coordinate.
    """

    name: str
    body: int
    kind: str
    sizes: tuple[float, ...]
    path: Path | None
    placement: FloatArray
    scale: FloatArray
    colour: Colour
    spring: int | None = None
    stretch: float = -1.0

    @cached_property
    def mesh(self) -> tuple[FloatArray, NDArray[np.intp]]:
        """Its corners and faces as :func:`~.meshes.mesh_of` has them, read once."""
        return mesh_of(self.kind, self.sizes, self.path)

    @cached_property
    def corners(self) -> FloatArray:
        """Its corners in the axes of its body, shape (N, 3) [m]."""
        turned = (self.mesh[0] * self.scale) @ self.placement[:3, :3].T
        return np.asarray(turned + self.placement[:3, 3])


def guide(mechanism: Mechanism) -> OscillatingGuide | None:
    """The law of a drive that tells where the crank of the cylinder is; None if none does."""
    laws = (drive.law for drive in mechanism.drives)
    return next((law for law in laws if isinstance(law, OscillatingGuide)), None)


def across_plane(mechanism: Mechanism) -> list[float]:
    """Place of each link's origin across the plane [m], which no motion changes."""
    return [float(item.translation[1]) for item in joint_placements(mechanism.model)[1:]]


def solids(mechanism: Mechanism) -> tuple[Solid, ...]:
    """Everything that a mechanism is drawn with.

    A link whose visuals are missing, or whose mesh files are, is drawn by its collision shapes.
    Bars go to those of its joints that no shape reaches; to all of a link without any shape. Of a
    frame without shapes the pins are drawn.

    Raises:
        ModelError: A shape of the URDF cannot be read.
    """
    robot = parse_xml(mechanism.urdf, f"{mechanism.name}.urdf")
    colours = {
        item.get("name", ""): _colour(colour)
        for item in robot.findall("material")
        if (colour := item.find("color")) is not None
    }
    found: list[Solid] = []
    for link in robot.findall("link"):
        for tag in ("visual", "collision"):
            shapes = list(_shapes(mechanism, link, tag, colours))
            if shapes:
                found += shapes
                break
    thick = THICK * extent(mechanism)
    for body in range(len(mechanism.joints)):
        own = [item for item in found if item.body == body]
        # A mesh is taken for the whole link.
        if all(item.path is None for item in own):
            found += _bars(mechanism, body, own, thick)
    if all(item.body >= 0 for item in found):
        found += _pins(mechanism, thick)
    return tuple(found)


def _shapes(
    mechanism: Mechanism, link: ElementTree.Element, tag: str, colours: dict[str, Colour]
) -> Iterator[Solid]:
    file, folder = f"{mechanism.name}.urdf", Path(mechanism.mesh_folder)
    springs = {f"spring_{spring.name}": spring.index for spring in mechanism.springs}
    frame = own_frame(mechanism.model, link.get("name", ""))
    body = int(frame.parentJoint) - 1
    for place, element in enumerate(link.findall(tag)):
        name = element.get("name") or f"{link.get('name')}_{place}"
        key = f"link {link.get('name')} {tag} {name}"
        shape = next(item for item in element.iterfind("geometry/*") if isinstance(item.tag, str))
        path, sizes, scale = None, shape_sizes(shape, key, file), np.ones(3)
        if shape.tag == "mesh":
            filename = shape.get("filename", "")
            if not (folder / path_inside(filename, key, file)).is_file():
                continue
            path = mesh_path(filename, folder, key, file)
            scale, sizes = np.array(sizes), []
        xyz, rpy = origin(element, key, file)
        local = np.eye(4)
        local[:3, :3], local[:3, 3] = rotation_from_rpy(rpy), xyz
        turns = body == FIXED and name.startswith("cylinder_") and guide(mechanism)
        yield Solid(
            name=name,
            body=CYLINDER if turns else body,
            kind=shape.tag,
            sizes=tuple(sizes),
            path=path,
            placement=frame.placement.homogeneous @ local,
            scale=scale,
            colour=_material(element, colours, body),
            spring=next((springs[item] for item in springs if name.startswith(item)), None)
            if shape.tag == "mesh"
            else None,
        )


def _bars(mechanism: Mechanism, body: int, shapes: Sequence[Solid], thick: float) -> list[Solid]:
    """Bars from the joint of a link to all that hangs on it, or to its centre of mass.

    Args:
        shapes: Those that are drawn of the link; where they are there is no need of a bar.
        thick: Radius of a bar [m].
    """
    joint = body + 1
    # What slides has no pin at the origin of its joint.
    ends = _ends(mechanism, joint, slides=not shapes)
    if not (ends or shapes):
        ends = [mechanism.model.inertias[joint].lever]
    hinged = mechanism.joints[body].kind == "revolute"
    far = [(end, thick) for end in ends if np.linalg.norm(end) > thick]
    far = [item for item in far if not any(holds(solid, item[0], thick) for solid in shapes)]
    if shapes and hinged and not any(holds(item, np.zeros(3), thick) for item in shapes):
        near = min(shapes, key=lambda item: np.linalg.norm(item.placement[:3, 3]))
        # Its end stays inside the shape: a lip would be thicker than it is.
        slim = 0.5 * _half(near)[np.abs(near.placement[1, :3]) < 0.9].min()
        far.append((near.placement[:3, 3], min(thick, slim)))
    elif shapes and not far:
        return []
    one, colour = np.ones(3), shapes[0].colour if shapes else link_colour(body)
    own = "own_" if shapes else ""  # no other shape of the link may have the name of a bar
    # A block without any bar is no larger than one is wide.
    ball = (1.6 if far else 1.0) * thick
    bars = [Solid(f"{own}joint", body, "sphere", (ball,), None, np.eye(4), one, colour)]
    for place, (end, radius) in enumerate(far):
        length = float(np.linalg.norm(end))
        along = end / length
        matrix = np.eye(4)
        matrix[:3, 2], matrix[:3, 1] = along, (0.0, 1.0, 0.0)
        matrix[:3, 0] = np.cross(matrix[:3, 1], along)
        matrix[:3, 3] = 0.5 * end
        name, sizes = f"{own}bar_{place}", (radius, length)
        bars.append(Solid(name, body, "cylinder", sizes, None, matrix, one, colour))
    return bars


def _pins(mechanism: Mechanism, thick: float) -> Iterator[Solid]:
    """Pins of the frame, along the hinges."""
    for place, at in enumerate(_ends(mechanism, 0, slides=False)):
        matrix = np.eye(4)
        matrix[:3, :3] = rotation_from_rpy(np.array([0.5 * np.pi, 0.0, 0.0]))
        matrix[:3, 3] = at
        sizes = (1.2 * thick, 6.0 * thick)
        yield Solid(f"pin_{place}", FIXED, "cylinder", sizes, None, matrix, np.ones(3),
                    link_colour(FIXED))  # fmt: skip


def extent(mechanism: Mechanism) -> float:
    """Larger extent of pins, centres of mass and named places, all coordinates at zero [m]."""
    world = joint_placements(mechanism.model)
    places = [place.act(end)[[0, 2]] for joint, place in enumerate(world)
              for end in _ends(mechanism, joint, slides=True)]  # fmt: skip
    places += [world[joint].act(body.lever)[[0, 2]]
               for joint, body in enumerate(mechanism.model.inertias) if joint]  # fmt: skip
    # A machine of one place has the size of its slides' travels.
    return float(np.ptp(places, axis=0).max()) or mechanism.reach_m


def _ends(mechanism: Mechanism, joint: int, *, slides: bool) -> list[FloatArray]:
    """Places where something hangs on a link, or on the frame (joint 0), in its own axes [m]."""
    model = mechanism.model
    ends = [
        np.array(model.jointPlacements[place].translation)
        for place, item in enumerate(mechanism.joints, start=1)
        if model.parents[place] == joint and (slides or item.kind == "revolute")
    ]
    named = {name for item in mechanism.closures for name in (item.frame_a, item.frame_b)}
    named |= {name for item in mechanism.struts for name in (item.frame_a, item.frame_b)}
    return ends + [
        np.array(frame.placement.translation)
        for frame in model.frames
        if frame.parentJoint == joint and frame.name in named
    ]


def holds(solid: Solid, place: FloatArray, near: float = 0.0) -> bool:
    """Whether a place is in one of the plain shapes, or near it, in side view."""
    local = np.abs(solid.placement[:3, :3].T @ (place - solid.placement[:3, 3]))
    # Across the plane links stand beside one another.
    across = np.abs(solid.placement[1, :3])
    return bool(np.all((local <= _half(solid) + near) | (across > 0.9)))


def _half(solid: Solid) -> FloatArray:
    """Half of its extents along its own axes, shape (3,) [m]; of a mesh infinite."""
    sizes = solid.sizes or (np.inf,)
    return {
        "mesh": np.full(3, np.inf),
        "box": 0.5 * np.array(sizes),
        "sphere": np.full(3, sizes[0]),
        "cylinder": np.array([sizes[0], sizes[0], 0.5 * sizes[-1]]),
    }[solid.kind]


def _material(element: ElementTree.Element, colours: dict[str, Colour], body: int) -> Colour:
    material = element.find("material")
    if material is None:
        return link_colour(body)
    if (colour := material.find("color")) is not None:
        return _colour(colour)
    return colours.get(material.get("name", ""), link_colour(body))


def _colour(colour: ElementTree.Element) -> Colour:
    red, green, blue, *_ = (float(part) for part in colour.get("rgba", "").split())
    # Some files count to 255 in place of one.
    largest = 255.0 if max(red, green, blue) > 1.0 else 1.0
    return red / largest, green / largest, blue / largest


def pictured(mechanism: Mechanism) -> tuple[Solid, ...]:
    """Everything that a mechanism is drawn with: its solids, springs on joints, and stops.

    Raises:
        ModelError: A shape of the URDF cannot be read.
    """
    found = solids(mechanism)
    size = _size(mechanism, found)
    # A shape of the URDF that is called like one of these stands for it.
    shown = {(solid.body, solid.name) for solid in found}
    added = (*_coils(mechanism, found, size), *_marks(mechanism, found, size))
    return (*found, *(solid for solid in added if (solid.body, solid.name) not in shown))


def _coils(mechanism: Mechanism, found: Sequence[Solid], size: float) -> Iterator[Solid]:
    """A coil for each joint with springs, unless a shape of the URDF shows one of them."""
    shown = {solid.spring for solid in found}
    named = {spring.index: spring.name for spring in mechanism.springs}
    named |= {spring.index: spring.name for spring in mechanism.tabulated_springs}
    for joint in mechanism.joints:
        if joint.index in named and joint.index not in shown:
            coil = _around if joint.kind == "revolute" else _along
            yield coil(mechanism, joint, f"spring_{named[joint.index]}", size)


def _around(mechanism: Mechanism, joint: Joint, name: str, size: float) -> Solid:
    """A coil around a hinge."""
    parent, at, _ = _carried(mechanism, joint)
    long, across = 4.0 * _AROUND * size, np.array([0.0, 1.0, 0.0])
    place = _placed(at.translation - 0.75 * long * across, across)
    scale = np.array([1.0, 1.0, long])
    return Solid(name, parent, "coil", (_AROUND * size,), None, place, scale, channels(SPRING))


def _along(mechanism: Mechanism, joint: Joint, name: str, size: float) -> Solid:
    """A coil that ends at the link that slides.

    It begins at the joint of the link before it where this one is its rod; else it stands where the
    coordinate grows, as a spring that pushes it down.
    """
    parent, at, axis = _carried(mechanism, joint)
    long, side = float(at.translation @ axis), -1.0
    if parent < 0 or abs(long) <= _ALONG * np.linalg.norm(at.translation[[0, 2]]):
        long = -_COIL * size
    if long > 0.0:
        side = 1.0
    place, scale = _placed(at.translation - long * axis, side * axis), np.ones(3)
    scale[2] = abs(long)
    return Solid(name, parent, "coil", (_WIRE * size,), None, place, scale, channels(SPRING),
                 joint.index, side)  # fmt: skip


def _marks(mechanism: Mechanism, found: Sequence[Solid], size: float) -> Iterator[Solid]:
    """A plate at the end of a slide, a peg beside a link on a hinge; lips have their shapes."""
    for stop in mechanism.stops:
        if stop.contact is None:
            joint = mechanism.joints[stop.index]
            own = [item for item in found if item.body == stop.index]
            mark = _peg if joint.kind == "revolute" else _plate
            yield mark(mechanism, stop, joint, own, size)


def _plate(
    mechanism: Mechanism, stop: Stop, joint: Joint, own: Sequence[Solid], size: float
) -> Solid:
    """A plate across a slide, at the smallest of the link's shapes that holds its origin."""
    parent, at, axis = _carried(mechanism, joint)
    back, edges = -stop.sense * axis, size * np.array(_PLATE)
    reaches = [float((item.corners @ at.rotation.T @ back).max())
               for item in own if item.path is None and holds(item, np.zeros(3))]  # fmt: skip
    far = min((reach for reach in reaches if reach > 0.0), default=0.0) + 0.5 * edges[2]
    place = _placed(at.translation + stop.at * axis + far * back, axis)
    return Solid(f"stop_{stop.name}", parent, "box", tuple(edges.tolist()), None, place, np.ones(3),
                 channels(STOP))  # fmt: skip


def _peg(
    mechanism: Mechanism, stop: Stop, joint: Joint, own: Sequence[Solid], size: float
) -> Solid:
    """A peg across the plane that touches the side of a link when its stop is closed."""
    parent, at, _ = _carried(mechanism, joint)
    corners = np.concatenate([item.corners for item in own])
    far = corners[np.argmax(np.hypot(corners[:, 0], corners[:, 2]))][[0, 2]]
    turn = stop.at * joint.sense + math.atan2(at.rotation[2, 0], at.rotation[0, 0])
    x, z = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]]) @ far
    # Towards the side to which the link turns as its stop closes.
    side = -stop.sense * joint.sense * (_BAR + _PEG[0]) * size / math.hypot(x, z)
    place = [_STRUCK * x - side * z, corners[:, 1].mean(), _STRUCK * z + side * x]
    sizes = _PEG[0] * size, _PEG[1] * size
    return Solid(
        f"stop_{stop.name}", parent, "cylinder", sizes, None,
        _placed(at.translation + place, np.array([0.0, 1.0, 0.0])), np.ones(3), channels(STOP),
    )  # fmt: skip


def _size(mechanism: Mechanism, found: Sequence[Solid]) -> float:
    """Larger extent of places and plain shapes, all coordinates at zero [m]."""
    moved = joint_placements(mechanism.model)[1:]
    corners = [item.corners if item.body < 0 else
               item.corners @ moved[item.body].rotation.T + moved[item.body].translation
               for item in found if item.path is None]  # fmt: skip
    extents = np.ptp(np.concatenate(corners)[:, [0, 2]], axis=0).tolist() if corners else []
    return float(max([extent(mechanism), *extents]))


def _carried(mechanism: Mechanism, joint: Joint) -> tuple[int, pin.SE3, FloatArray]:
    """Link before a joint, placement of the joint in its axes at q = 0, direction of a slide."""
    model, number = mechanism.model, joint.index + 1
    parent = int(model.parents[number])
    world = joint_placements(model)
    axis = world[parent].rotation.T @ joint_axis(model, world, number)[:3]
    return parent - 1, model.jointPlacements[number], axis


def _placed(at: FloatArray, along: FloatArray) -> FloatArray:
    """Placement whose z axis has a direction in the plane, or across it, shape (4, 4)."""
    place = np.eye(4)
    aside = np.array([0.0, 1.0, 0.0]) if abs(along[1]) < 0.5 else np.array([1.0, 0.0, 0.0])
    place[:3, 2], place[:3, 1] = along, aside
    place[:3, 0] = np.cross(aside, along)
    place[:3, 3] = at
    return place

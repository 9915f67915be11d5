"""Dimensions, masses and every other number of a model's URDF by path.

* ``points.<hinge or frame>.x_mm`` and ``.z_mm``: place of a pin in the world at touch; everything
  that meets in the pin moves with it (:mod:`.points`);
* ``points.<hinge or frame>.radius_mm`` and ``.angle_deg``: the same, seen from the hinge of the
  link that carries the point: the length of a link, an eccentricity and its angle (from x, ccw);
* ``links.<link>.mass_kg`` and ``.inertia_kg_m2`` (across the plane, through the centre of mass);
* ``links.<link>.com_x_mm`` and ``.com_z_mm``: centre of mass in the world at touch;
* ``links.<link>.gyration_mm``: radius of gyration about it, sqrt(inertia / mass); with it the
  inertia goes with the mass, as that of a body of one shape does;
* ``urdf. ...``: one number of the file in its own words (:mod:`.paths`), nothing else moves.

Points are changed first, then raw numbers, then links, so that a given centre of mass is exact.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any
from xml.etree import ElementTree

import numpy as np

from ...arrays import FloatArray
from ...errors import AssemblyError, ModelError, UnknownNameError
from ...tolerances.mechanics import ASSEMBLY_TOLERANCE_M, IN_PLANE_RAD, ROUNDED_SHARE
from ...units import M_PER_MM, MM_PER_M
from ..files.urdf_values import origin, rotation_from_rpy
from ..scale import written
from .paths import UrdfValue, find_value, steps_of
from .points import Layout, move_points, read_layout, write_origin

HEADS = ("points", "links", "urdf")
"""First steps of the paths that lead into the URDF."""

_CARTESIAN = ("x_mm", "z_mm")
_POLAR = ("radius_mm", "angle_deg")
_COM = {"com_x_mm": 0, "com_z_mm": 2}
_GYRATION = "gyration_mm"
_MASS = ("mass_kg", "inertia_kg_m2")
_ALONG = ("ixx", "iyy", "izz")
# The reach, which decides what is closed, is less than this times the sum of all origins.
_SEEN = 4.0
_LINK = (*_MASS, *_COM, _GYRATION)


def change_dimensions(
    root: ElementTree.Element,
    document: Mapping[str, object],
    values: Mapping[str, float],
    file: str,
) -> dict[str, object]:
    """Change numbers of a URDF; moved points leave the model assembled.

    Args:
        root: The ``robot`` element, changed in place.
        document: The TOML document, known to be well-formed.

    Returns:
        The document with the axes of guides and cranks where their pins have gone.

    Raises:
        UnknownNameError: A path leads nowhere.
        ModelError: Paths contradict one another, or there is no number to change.
        AssemblyError: A closure is opened.
    """
    points: dict[str, dict[str, float]] = {}
    links: dict[str, dict[str, float]] = {}
    for path, value in values.items():
        head = steps_of(path)[0]
        if head == "points":
            name, key = _split(path, (*_CARTESIAN, *_POLAR), "coordinate")
            points.setdefault(name, {})[key] = value
        elif head == "links":
            name, key = _split(path, _LINK, "value of a link")
            links.setdefault(name, {})[key] = value
    changed = dict(document)
    found = read_layout(root, document, file)
    open_before = found.gaps(document)
    if points:
        changed = move_points(found, document, _places(found, points))
    for path, value in values.items():
        if steps_of(path)[0] == "urdf":
            find_value(root, path).write(value, path, file)
    if len(links) < len(values):
        found = read_layout(root, document, file)
        _check_closed(open_before, found, document)
    for link, new in links.items():
        _change_link(found, link, new)
    return changed


def _check_closed(
    before: Mapping[str, FloatArray], found: Layout, document: Mapping[str, Any]
) -> None:
    """Refuse changes that open a closure by so little that it would be closed as if by rounding.

    What a change opens by more is refused where the mechanism is built.
    """
    origins = (origin(joint, "", found.file)[0] for joint in found.order)
    size = sum(float(np.linalg.norm(xyz)) for xyz in origins) or 1.0
    within_m, seen_m = ASSEMBLY_TOLERANCE_M * written(size), _SEEN * ROUNDED_SHARE * size
    for name, gap in found.gaps(document).items():
        opened, was = float(np.linalg.norm(gap)), float(np.linalg.norm(before[name]))
        if was + within_m < opened < seen_m:
            x, z = MM_PER_M * gap
            ends = document["closures"][name]
            raise AssemblyError(
                file=found.file,
                key=f"closures.{name}",
                value=f"a gap of {MM_PER_M * opened:.6g} mm (x {x:.6g}, z {z:.6g}) from "
                f"{ends['frame_a']} to {ends['frame_b']}",
                allowed=f"dimensions that leave it as it was, {MM_PER_M * was:.3g} mm, within "
                f"{MM_PER_M * within_m:g} mm: only what a file's own numbers leave is closed",
            )


def read_dimension(found: Layout, path: str) -> float:
    """Read a number of a URDF by a path whose first step is one of ``HEADS``.

    Raises:
        UnknownNameError: The path leads nowhere.
        ModelError: There is no number.
    """
    head = steps_of(path)[0]
    if head == "urdf":
        return find_value(found.root, path).read(path, found.file)
    if head == "points":
        name, key = _split(path, (*_CARTESIAN, *_POLAR), "coordinate")
        if key in _POLAR:
            return _polar(found, name)[_POLAR.index(key)]
        return found.point_mm(name)[_CARTESIAN.index(key)]
    name, key = _split(path, _LINK, "value of a link")
    inertial = found.inertial(name, path)
    if key in _COM:
        xyz, _ = origin(inertial, path, found.file)
        world = found.place[name] + found.turn[name] @ xyz
        return float(MM_PER_M * world[_COM[key]])
    if key == _GYRATION:
        mass, inertia = (_inertia(found, name, item, path).read(path, found.file) for item in _MASS)
        return MM_PER_M * math.sqrt(inertia / mass)
    return _inertia(found, name, key, path).read(path, found.file)


def _split(path: str, known: Sequence[str], kind: str) -> tuple[str, str]:
    """Split ``<head>.<name>.<key>``; the name may hold dots."""
    _, _, rest = path.partition(".")
    name, _, key = rest.rpartition(".")
    if not name or key not in known:
        raise UnknownNameError(
            kind=kind, name=key if name else "", known=known, where=f"path {path}"
        )
    return name, key


def _places(
    found: Layout, points: Mapping[str, Mapping[str, float]]
) -> dict[str, tuple[float, float]]:
    """New places of points; polar coordinates count from the new place of the hinge."""
    places: dict[str, tuple[float, float]] = {}
    waiting = []
    for name, new in points.items():
        if set(new) <= set(_CARTESIAN):
            x, z = found.point_mm(name)
            places[name] = new.get("x_mm", x), new.get("z_mm", z)
        elif set(new) <= set(_POLAR):
            waiting.append(name)
        else:
            known = (*_CARTESIAN, *_POLAR)
            steps = " and ".join(sorted(new))
            where = f"points.{name}: x_mm with z_mm, or radius_mm with angle_deg"
            raise UnknownNameError(kind="pair of coordinates", name=steps, known=known, where=where)
    # From the frame outwards: a hinge that is itself given in polar coordinates has gone before
    # whatever is seen from it.
    rank = {link: place for place, link in enumerate(found.place)}
    for name in sorted(waiting, key=lambda item: rank.get(found.points.get(item, ""), 0)):
        hinge = found.hinge_below(name)
        x, z = next(
            (places[other] for other in found.meeting[hinge] if other in places),
            found.point_mm(hinge),
        )
        old_radius, old_angle = _polar(found, name)
        radius = points[name].get("radius_mm", old_radius)
        angle = math.radians(points[name].get("angle_deg", old_angle))
        places[name] = x + radius * math.cos(angle), z + radius * math.sin(angle)
    return places


def _polar(found: Layout, name: str) -> tuple[float, float]:
    """Radius [mm] and angle [deg, 0 to 360] of a point seen from its link's hinge."""
    hinge_x, hinge_z = found.point_mm(found.hinge_below(name))
    x, z = found.point_mm(name)
    angle = math.degrees(math.atan2(z - hinge_z, x - hinge_x)) % 360.0
    return math.hypot(x - hinge_x, z - hinge_z), angle


def _change_link(found: Layout, link: str, new: Mapping[str, float]) -> None:
    """Write mass, inertia and centre of mass of a link."""
    inertial = found.inertial(link, f"links.{link}.{next(iter(new))}")
    if _GYRATION in new and "inertia_kg_m2" in new:
        allowed = f"one of {_GYRATION} and inertia_kg_m2"
        value = new[_GYRATION]
        raise ModelError(file=found.file, key=f"links.{link}", value=value, allowed=allowed)
    if set(_COM) & set(new):
        xyz, _ = origin(inertial, f"link {link} inertial", found.file)
        world = found.place[link] + found.turn[link] @ xyz
        for key, axis in _COM.items():
            world[axis] = M_PER_MM * new[key] if key in new else world[axis]
        write_origin(inertial, found.turn[link].T @ (world - found.place[link]), None)
    for key in _MASS:
        if key in new:
            path = f"links.{link}.{key}"
            _inertia(found, link, key, path).write(new[key], path, found.file)
    if _GYRATION in new:
        path = f"links.{link}.{_GYRATION}"
        mass = _inertia(found, link, "mass_kg", path).read(path, found.file)
        inertia = mass * (M_PER_MM * new[_GYRATION]) ** 2
        _inertia(found, link, "inertia_kg_m2", path).write(inertia, path, found.file)


def _inertia(found: Layout, link: str, key: str, path: str) -> UrdfValue:
    """Where mass or inertia of a link stand."""
    inertial = found.inertial(link, path)
    tag = "mass" if key == "mass_kg" else "inertia"
    element = inertial.find(tag)
    if element is None:
        allowed = f"the link has no <{tag}>"
        raise ModelError(file=found.file, key=path, value=None, allowed=allowed)
    if tag == "mass":
        return UrdfValue(element, "value", None)
    _, rpy = origin(inertial, path, found.file)
    # The axis across the plane in those of the inertia, which may be turned in the plane.
    across = np.abs((found.turn[link] @ rotation_from_rpy(rpy))[1])
    place = int(np.argmax(across))
    if across[place] < math.cos(IN_PLANE_RAD):
        allowed = "an inertia whose axes are in the plane or across it; urdf. paths change others"
        raise ModelError(file=found.file, key=path, value=rpy.tolist(), allowed=allowed)
    element.attrib.setdefault(_ALONG[place], "0")
    return UrdfValue(element, _ALONG[place], None)

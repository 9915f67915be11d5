"""Numbers of a model by path: what may be free in an identification or a sensitivity.

Beside the paths that ``--set`` knows, a path can be

* ``points.<hinge or frame>.x_mm`` and ``.z_mm``: place of a pin at touch (:mod:`.geometry`);
* ``points.<frame>.radius_mm`` and ``.angle_deg``: the same, seen from the hinge of the link that
  carries the frame (an eccentricity and its angle, counter-clockwise from x);
* ``links.<link>.com_x_mm`` and ``.com_z_mm``: centre of mass in the world at touch;
* ``links.<link>.gyration_mm``: radius of gyration about it, sqrt(inertia / mass); with it free the
  inertia goes with the mass, as that of a body of one shape does.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from xml.etree import ElementTree

from ...errors import ModelError, UnknownNameError
from ...mechanism.overrides import apply_overrides
from ...mechanism.urdf_values import origin
from .geometry import Layout, Sources, layout, moved

_CARTESIAN = ("x_mm", "z_mm")
_POLAR = ("radius_mm", "angle_deg")
_COM = {"com_x_mm": 0, "com_z_mm": 2}
_GYRATION = "gyration_mm"
_MASS = {"mass_kg": ("mass", "value"), "inertia_kg_m2": ("inertia", "iyy")}


def read_values(sources: Sources, paths: Sequence[str]) -> tuple[float, ...]:
    """Values that a model has at some paths.

    Args:
        sources: The model's texts.
        paths: Paths of numbers.

    Raises:
        UnknownNameError: A path leads nowhere.
        ModelError: There is no number.
    """
    found = layout(sources)
    return tuple(_read(sources, found, path) for path in paths)


def with_values(sources: Sources, values: Mapping[str, float]) -> Sources:
    """Change numbers of a model; it stays assembled.

    Args:
        sources: The model's texts.
        values: New values by path.

    Returns:
        Texts of the changed model.

    Raises:
        UnknownNameError: A path leads nowhere.
        ModelError: A value cannot be used.
    """
    points: dict[str, dict[str, float]] = {}
    centres: dict[str, dict[str, float]] = {}
    radii: dict[str, float] = {}
    others: dict[str, object] = {}
    for path, value in values.items():
        steps = path.split(".")
        if steps[0] == "points" and len(steps) == 3:
            points.setdefault(steps[1], {})[steps[2]] = value
        elif steps[0] == "links" and steps[-1] in _COM and len(steps) == 3:
            centres.setdefault(steps[1], {})[steps[2]] = value
        elif steps[0] == "links" and steps[-1] == _GYRATION and len(steps) == 3:
            radii[steps[1]] = value
        else:
            others[path] = value
    if points:
        sources = moved(sources, _places(layout(sources), points))
    if centres:
        sources = _with_centres(sources, centres)
    if radii:
        found = layout(sources)
        for link, radius in radii.items():
            if f"links.{link}.inertia_kg_m2" in others:
                allowed = f"one of {_GYRATION} and inertia_kg_m2"
                raise ModelError(
                    file=f"{sources.name}.urdf", key=f"links.{link}", value=radius, allowed=allowed
                )
            path = f"links.{link}.mass_kg"
            mass = values.get(path, _read(sources, found, path))
            others[f"links.{link}.inertia_kg_m2"] = mass * (1e-3 * radius) ** 2
    document, urdf = apply_overrides(
        sources.document, sources.urdf, others, f"{sources.name}.toml", f"{sources.name}.urdf"
    )
    return Sources(name=sources.name, urdf=urdf, document=document, folder=sources.folder)


def _places(
    found: Layout, points: Mapping[str, Mapping[str, float]]
) -> dict[str, tuple[float, float]]:
    """New places of points; polar ones are seen from where their hinge goes."""
    places = {}
    for name, new in points.items():
        if set(new) <= set(_CARTESIAN):
            x, z = found.point_mm(name)
            places[name] = new.get("x_mm", x), new.get("z_mm", z)
        elif not set(new) <= set(_POLAR):
            known = (*_CARTESIAN, *_POLAR)
            steps = " and ".join(sorted(new))
            where = f"points.{name}: x_mm with z_mm, or radius_mm with angle_deg"
            raise UnknownNameError(kind="pair of coordinates", name=steps, known=known, where=where)
    for name, new in points.items():
        if set(new) & set(_POLAR):
            hinge = found.hinge_below(name)
            x, z = places.get(hinge, found.point_mm(hinge))
            old_radius, old_angle = _polar(found, name)
            radius = new.get("radius_mm", old_radius)
            angle = math.radians(new.get("angle_deg", old_angle))
            places[name] = x + radius * math.cos(angle), z + radius * math.sin(angle)
    return places


def _polar(found: Layout, name: str) -> tuple[float, float]:
    """Radius [mm] and angle [deg, 0 to 360] of a point seen from its link's hinge."""
    hinge_x, hinge_z = found.point_mm(found.hinge_below(name))
    x, z = found.point_mm(name)
    angle = math.degrees(math.atan2(z - hinge_z, x - hinge_x)) % 360.0
    return math.hypot(x - hinge_x, z - hinge_z), angle


def _read(sources: Sources, found: Layout, path: str) -> float:
    steps = path.split(".")
    if steps[0] == "points":
        return _read_point(found, steps, path)
    if steps[0] == "links":
        return _read_link(sources, found, steps, path)
    value: object = sources.document
    for step in steps:
        if not isinstance(value, Mapping) or step not in value:
            known = value if isinstance(value, Mapping) else ()
            raise UnknownNameError(kind="key", name=step, known=known, where=f"path {path}")
        value = value[step]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ModelError(
            file=f"{sources.name}.toml", key=path, value=value, allowed="the path of one number"
        )
    return float(value)


def _read_point(found: Layout, steps: Sequence[str], path: str) -> float:
    known = (*_CARTESIAN, *_POLAR)
    if len(steps) != 3 or steps[2] not in known:
        name = ".".join(steps[2:])
        raise UnknownNameError(kind="coordinate", name=name, known=known, where=f"path {path}")
    if steps[2] in _POLAR:
        return _polar(found, steps[1])[_POLAR.index(steps[2])]
    return found.point_mm(steps[1])[_CARTESIAN.index(steps[2])]


def _read_link(sources: Sources, found: Layout, steps: Sequence[str], path: str) -> float:
    known = (*_MASS, *_COM, _GYRATION)
    if len(steps) != 3 or steps[2] not in known:
        name = ".".join(steps[2:])
        raise UnknownNameError(kind="link value", name=name, known=known, where=f"path {path}")
    inertial = _inertial(found.root, steps[1], path)
    if steps[2] in _COM:
        xyz, _ = origin(inertial, path, f"{sources.name}.urdf")
        world = found.place[steps[1]] + found.turn[steps[1]] @ xyz
        return float(1e3 * world[_COM[steps[2]]])
    if steps[2] == _GYRATION:
        inertia, mass = (_number(inertial, *_MASS[key]) for key in ("inertia_kg_m2", "mass_kg"))
        return 1e3 * math.sqrt(inertia / mass)
    return _number(inertial, *_MASS[steps[2]])


def _number(inertial: ElementTree.Element, tag: str, attribute: str) -> float:
    element = inertial.find(tag)
    return float("nan" if element is None else element.get(attribute, "nan"))


def _with_centres(sources: Sources, centres: Mapping[str, Mapping[str, float]]) -> Sources:
    """Write centres of mass, given in the world at touch, into the link frames."""
    found = layout(sources)
    for link, new in centres.items():
        inertial = _inertial(found.root, link, f"links.{link}")
        xyz, _ = origin(inertial, f"link {link} inertial", f"{sources.name}.urdf")
        world = found.place[link] + found.turn[link] @ xyz
        for key, value in new.items():
            world[_COM[key]] = 1e-3 * value
        local = found.turn[link].T @ (world - found.place[link])
        where = inertial.find("origin")
        if where is None:
            where = ElementTree.SubElement(inertial, "origin")
        where.set("xyz", " ".join(repr(float(part)) for part in local))
    return Sources(
        name=sources.name,
        urdf=ElementTree.tostring(found.root, encoding="unicode"),
        document=sources.document,
        folder=sources.folder,
    )


def _inertial(root: ElementTree.Element, link: str, path: str) -> ElementTree.Element:
    known = {
        item.get("name", ""): part
        for item in root.findall("link")
        if (part := item.find("inertial")) is not None
    }
    if link not in known:
        where = f"path {path}"
        raise UnknownNameError(kind="link with a mass", name=link, known=known, where=where)
    return known[link]

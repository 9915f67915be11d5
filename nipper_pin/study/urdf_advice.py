"""What most often goes wrong in a URDF: limits that nothing enforces, and units of another kind."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from ..hybrid import Solution
from ..mechanism import Joint, Mechanism
from ..mechanism.files import parse_xml, toml
from ..units import DEG_PER_RAD, MM_PER_M, coordinate_text
from .masses import link_masses
from .urdf_unread import unread

# A limit of half a turn or more, or of ten times the size of the machine, is written where the
# format asks for one.
_WIDE_RAD, _WIDE_REACHES = 3.1, 10.0
# No machine of this size weighs so little by its length: a wire of steel of 4 mm. And one of the
# largest size is a building.
_LARGE_M, _LIGHT_KG_PER_M, _LARGEST_M = 5.0, 0.1, 100.0
# Radius of gyration by the extent of a link, of a bar 0.6 and of a ring 1; extent of a link at
# least, by that of the machine.
_WIDE_GYRATION, _LINK_SHARE = 3.0, 1.0 / 3.0
_SAMPLES = 240
_STOP_PLACES = {"prismatic": ("at_mm", MM_PER_M), "revolute": ("at_deg", DEG_PER_RAD)}


@dataclass(frozen=True)
class UrdfAdvice:
    """Advice on a URDF.

    Attributes:
        sentences: What is probably not meant, one sentence each.
        stops: TOML text of the stops that would enforce the limits of joints; empty without any.
    """

    sentences: tuple[str, ...] = ()
    stops: str = ""


def urdf_advice(solution: Solution) -> UrdfAdvice:
    """Look for what a URDF holds and the simulation does not.

    Args:
        solution: A whole cycle of the machine.
    """
    mechanism = solution.mechanism
    root = parse_xml(mechanism.urdf, f"{mechanism.name}.urdf")
    limits = tuple(_limits(root, solution))
    sentences = [
        *unread(root),
        *_large(mechanism),
        *_heavy_turning(root, mechanism),
        *_without_room(root, mechanism),
        *_unenforced(limits),
    ]
    return UrdfAdvice(tuple(sentences), _stops(limits, mechanism))


@dataclass(frozen=True)
class _Limit:
    """A limit of a joint that no stop enforces.

    Attributes:
        side: Side of the stop that would enforce it.
        at: The limit [rad or m].
        passed: Whether the cycle passes it.
    """

    joint: Joint
    side: str
    at: float
    passed: bool

    @property
    def text(self) -> str:
        """The limit in the unit of people."""
        return coordinate_text(self.at, self.joint.kind)


def _limited(
    root: ElementTree.Element, mechanism: Mechanism
) -> Iterator[tuple[Joint, dict[str, float]]]:
    """Joints that forces move, each with the limits that its element has, by side [rad or m]."""
    written = {item.get("name"): item for item in root.findall("joint")}
    driven = {drive.index for drive in mechanism.drives}
    for joint in mechanism.joints:
        element = written.get(joint.name)
        if element is None or joint.index in driven or element.get("type") == "continuous":
            continue
        limit = element.find("limit")
        if limit is not None:
            found = {side: _number(limit.get(side)) for side in ("lower", "upper")}
            yield joint, {side: at for side, at in found.items() if at is not None}


def _no_room(places: dict[str, float]) -> bool:
    """Whether no coordinate lies between both limits."""
    return len(places) == 2 and not places["lower"] < places["upper"]


def _without_room(root: ElementTree.Element, mechanism: Mechanism) -> Iterator[str]:
    """Limits that would let a joint stand at most, and that no stops can be."""
    for joint, places in _limited(root, mechanism):
        if _no_room(places):
            low, high = (_Limit(joint, side, at, False).text for side, at in places.items())
            exchanged = ": exchange the two" if places["lower"] > places["upper"] else ""
            yield (
                f"limits of joint {joint.name} in the URDF (lower {low} and upper {high}) leave it "
                f"no room, and nothing enforces them{exchanged}; where nothing limits, leave them "
                "out"
            )


def _limits(root: ElementTree.Element, solution: Solution) -> Iterator[_Limit]:
    """Limits that mean something, on joints that forces move."""
    mechanism = solution.mechanism
    q = solution.trajectory.evaluate(np.linspace(*solution.trajectory.span, _SAMPLES)).q
    for joint, places in _limited(root, mechanism):
        if _no_room(places):
            continue
        stops = [stop for stop in mechanism.stops if stop.index == joint.index]
        x = q[:, joint.index]
        for side, at in places.items():
            sense = 1.0 if side == "lower" else -1.0
            if any(stop.sense == sense for stop in stops):
                continue
            passed = bool((sense * (x - at)).min() < 0.0)
            if abs(at) < _widest(joint, mechanism) and (passed or not stops):
                yield _Limit(joint, side, at, passed)


def _widest(joint: Joint, mechanism: Mechanism) -> float:
    return _WIDE_RAD if joint.kind == "revolute" else _WIDE_REACHES * mechanism.reach_m


def _unenforced(limits: tuple[_Limit, ...]) -> Iterator[str]:
    for name in dict.fromkeys(limit.joint.name for limit in limits):
        own = [limit for limit in limits if limit.joint.name == name]
        bounds = " and ".join(f"{limit.side} {limit.text}" for limit in own)
        passed = [limit.side for limit in own if limit.passed]
        seen = f", and this cycle passes the {' and the '.join(passed)} one" if passed else ""
        yield (
            f"limits of joint {name} in the URDF ({bounds}) are not enforced{seen}: if they are "
            "meant, add the stops below to the TOML file"
        )


def _stops(limits: tuple[_Limit, ...], mechanism: Mechanism) -> str:
    """The stops as a part of a TOML file."""
    tables = {}
    for limit in limits:
        key, factor = _STOP_PLACES[limit.joint.kind]
        tables[f"{limit.joint.name}_{limit.side}"] = {
            "joint": limit.joint.name,
            "side": limit.side,
            key: float(f"{factor * limit.at:.9g}"),
            "restitution": 0.2,
        }
    if not tables:
        return ""
    # A file may have the heading of all stops already.
    text = toml({"stops": tables}).replace("[stops]\n", "").strip() + "\n"
    if mechanism.transition_stop:
        return text
    line = toml({"transition_stop": next(iter(tables))})
    return f"# Above the first [table]:\n{line}\n# At the end:\n{text}"


def _large(mechanism: Mechanism) -> Iterator[str]:
    """Lengths of a whole machine that look like millimetres."""
    size = mechanism.reach_m
    mass = sum(item.mass_kg for item in link_masses(mechanism))
    light = size > _LARGE_M and mass < _LIGHT_KG_PER_M * size
    if size > _LARGEST_M or light:
        yield (
            f"from joint to joint the URDF measures {size:.4g} m, and its links weigh "
            f"{mass:.4g} kg together: are its lengths in mm? A URDF has m, kg and kg m2"
        )


def _heavy_turning(root: ElementTree.Element, mechanism: Mechanism) -> Iterator[str]:
    """Inertias that no body of such a size has."""
    extents, turning = _extents(root), _turning(mechanism)
    for link in root.findall("link"):
        name, inertial = link.get("name", ""), link.find("inertial")
        if inertial is None or name not in turning:
            continue
        mass = _part(inertial, "mass", "value") or math.inf
        inertia = max(_part(inertial, "inertia", key) or 0.0 for key in ("ixx", "iyy", "izz"))
        extent = max(extents.get(name, 0.0), _LINK_SHARE * mechanism.reach_m)
        gyration = math.sqrt(max(inertia, 0.0) / mass)
        if gyration > _WIDE_GYRATION * extent:
            yield (
                f"link {name} has an inertia of {inertia:.4g} kg m2 and {mass:.4g} kg, as a ring "
                f"of {gyration:.3g} m radius, and is no larger than some {extent:.2g} m: is the "
                "inertia in other units, or left at a default?"
            )


def _turning(mechanism: Mechanism) -> set[str]:
    """Links that turn: no other has an inertia that counts."""
    found: set[str] = set()
    for joint in mechanism.joints:
        if joint.kind == "revolute" or joint.parent in found:
            found.add(joint.child)
    return found


def _extents(root: ElementTree.Element) -> dict[str, float]:
    """How far joints, centre of mass and shapes of each link are from its origin [m]."""
    found: dict[str, float] = {}
    for joint in root.findall("joint"):
        parent = joint.find("parent")
        if parent is not None:
            _far(found, parent.get("link", ""), joint.find("origin"))
    for link in root.findall("link"):
        for part in link.iter("origin"):
            _far(found, link.get("name", ""), part)
        for solid in link.iterfind(".//geometry/*"):
            sizes = [
                _number(word) or 0.0
                for key in ("size", "radius", "length")
                for word in solid.get(key, "").split()
            ]
            name = link.get("name", "")
            found[name] = max(found.get(name, 0.0), *sizes, 0.0)
    return found


def _far(found: dict[str, float], name: str, origin: ElementTree.Element | None) -> None:
    words = "" if origin is None else origin.get("xyz", "")
    length = math.hypot(*(_number(word) or 0.0 for word in words.split()))
    found[name] = max(found.get(name, 0.0), length)


def _part(element: ElementTree.Element, tag: str, key: str) -> float | None:
    part = element.find(tag)
    return None if part is None else _number(part.get(key))


def _number(text: str | None) -> float | None:
    """A number of the URDF; None for what is none, which the reading has refused or ignores."""
    try:
        value = float(text or "")
    except ValueError:
        return None
    return value if math.isfinite(value) else None

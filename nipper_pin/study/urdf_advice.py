"""What most often goes wrong in a URDF: limits that nothing enforces, and units of another kind."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from ..hybrid import Solution
from ..mechanism import Mechanism
from ..mechanism.files import parse_xml, toml
from ..mechanism.limits import Limit, joint_limits, number, without_room
from .masses import link_masses
from .urdf_unread import unread

# No machine of this size weighs so little by its length: a wire of steel of 4 mm. And one of the
# largest size is a building.
_LARGE_M, _LIGHT_KG_PER_M, _LARGEST_M = 5.0, 0.1, 100.0
# Radius of gyration by the extent of a link, of a bar 0.6 and of a ring 1; extent of a link at
# least, by that of the machine.
_WIDE_GYRATION, _LINK_SHARE = 3.0, 1.0 / 3.0
_SAMPLES = 240


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


def _without_room(root: ElementTree.Element, mechanism: Mechanism) -> Iterator[str]:
    """Limits that would let a joint stand at most, and that no stops can be."""
    for limits in joint_limits(root, mechanism):
        if without_room(limits):
            low, high = limits
            exchanged = ": exchange the two" if low.at > high.at else ""
            yield (
                f"limits of joint {low.joint.name} in the URDF (lower {low.text} and upper "
                f"{high.text}) leave it no room, and nothing enforces them{exchanged}; where "
                "nothing limits, leave them out"
            )


def _limits(root: ElementTree.Element, solution: Solution) -> Iterator[tuple[Limit, bool]]:
    """Limits that mean something and have no stop, and whether the cycle passes them."""
    mechanism = solution.mechanism
    q = solution.trajectory.evaluate(np.linspace(*solution.trajectory.span, _SAMPLES)).q
    for limits in joint_limits(root, mechanism):
        for limit in limits if not without_room(limits) else ():
            stops = [stop for stop in mechanism.stops if stop.index == limit.joint.index]
            if any(stop.sense == limit.sense for stop in stops):
                continue
            x = q[:, limit.joint.index]
            passed = bool((limit.sense * (x - limit.at)).min() < 0.0)
            if limit.narrow(mechanism) and (passed or not stops):
                yield limit, passed


def _unenforced(limits: Sequence[tuple[Limit, bool]]) -> Iterator[str]:
    for name in dict.fromkeys(limit.joint.name for limit, _ in limits):
        own = [(limit, passed) for limit, passed in limits if limit.joint.name == name]
        bounds = " and ".join(f"{limit.side} {limit.text}" for limit, _ in own)
        passed = [limit.side for limit, passes in own if passes]
        seen = f", and this cycle passes the {' and the '.join(passed)} one" if passed else ""
        yield (
            f"limits of joint {name} in the URDF ({bounds}) are not enforced{seen}: if they are "
            "meant, add the stops below to the TOML file"
        )


def _stops(limits: Sequence[tuple[Limit, bool]], mechanism: Mechanism) -> str:
    """The stops as a part of a TOML file."""
    tables = dict(limit.stop() for limit, _ in limits)
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
                number(word) or 0.0
                for key in ("size", "radius", "length")
                for word in solid.get(key, "").split()
            ]
            name = link.get("name", "")
            found[name] = max(found.get(name, 0.0), *sizes, 0.0)
    return found


def _far(found: dict[str, float], name: str, origin: ElementTree.Element | None) -> None:
    words = "" if origin is None else origin.get("xyz", "")
    length = math.hypot(*(number(word) or 0.0 for word in words.split()))
    found[name] = max(found.get(name, 0.0), length)


def _part(element: ElementTree.Element, tag: str, key: str) -> float | None:
    part = element.find(tag)
    return None if part is None else number(part.get(key))

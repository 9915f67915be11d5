"""The same machine seen from behind: left and right are exchanged, and nothing else.

Every place and direction (x, z) becomes (-x, z). Angles change their sign, so lower stops of hinges
become upper ones, tables are read backwards and shafts turn the other way; coordinates of slides
stay what they are. The same motion has to come out, by code that sees other signs.
"""

from __future__ import annotations

import copy
from typing import Any
from xml.etree import ElementTree

from nipper_pin.mechanism.files import parse_xml

from .parts import Source

_OTHER_SIDE = {"lower": "upper", "upper": "lower"}
_OTHER_EXTREME = {"minimum": "maximum", "maximum": "minimum"}
# Numbers of a drive that change their sign on a hinge; those of a slide do not.
_TURNING = {
    "constant_speed": ("ratio",), "fourier": ("mean_rad", "cosine_rad", "sine_rad"),
    "table": ("coordinate_rad",), "cam": ("lift_deg",), "screw": (), "geared": (),
}  # fmt: skip
# Places and directions of slides, and angles of frames, of a URDF: what is negated of each.
_ACROSS = (
    (".//origin", "xyz", 0), (".//origin", "rpy", 1), (".//joint[@type='prismatic']/axis", "xyz", 0)
)  # fmt: skip


def mirrored(source: Source) -> Source | None:
    """The mirror image of a model; None if it has shapes or drives of another kind."""
    description = copy.deepcopy(source.description)
    drives = description.get("drives", {})
    if any(drive["law"] not in _TURNING for drive in drives.values()):
        return None
    if any("contact" in stop for stop in description.get("stops", {}).values()):
        return None
    root = parse_xml(source.urdf, f"{source.name}.urdf")
    turned = {
        joint.get("name", "") for joint in root.iter("joint")
        if joint.get("type") in ("continuous", "revolute")
    }  # fmt: skip
    # The x axis of a mirrored frame points the other way, and blocks count along it.
    turned |= {
        name for name, item in description.get("closures", {}).items()
        if item.get("slot_axis") == "x"
    }  # fmt: skip
    for drive in drives.values():
        _turn(drive, _TURNING[drive["law"]])
    cylinder = description.get("cylinder", {})
    if drives.get(cylinder.get("reference_drive"), {}).get("joint") in turned:
        extreme = cylinder.get("reference_extreme", "minimum")
        cylinder["reference_extreme"] = _OTHER_EXTREME[extreme]
    for stop in description.get("stops", {}).values():
        if stop["joint"] in turned:
            stop["side"] = _OTHER_SIDE[stop.get("side", "lower")]
            _turn(stop, ("at_deg", "at_mm"))
    for joint, start in description.get("initial", {}).items():
        if joint in turned:
            _turn(start, ("at_deg", "at_mm", "rate_rad_per_s", "rate_mm_per_s"))
    for spring in description.get("springs", {}).values():
        if spring.get("joint") in turned:
            _turn(spring, ("preload_deg", "preload_length_mm"))
            for key in ("coordinate_deg", "torque_N_m", "coordinate_mm", "force_N"):
                if key in spring:
                    spring[key] = [-value for value in reversed(spring[key])]
    _mirror(root)
    urdf = ElementTree.tostring(root, encoding="unicode")
    return Source(source.name, urdf, description, source.folder)


def _turn(entry: dict[str, Any], keys: tuple[str, ...]) -> None:
    """Change the sign of those of the keys that are there."""
    for key in keys:
        if key in entry:
            value = entry[key]
            entry[key] = [-x for x in value] if isinstance(value, list) else -value


def _mirror(root: ElementTree.Element) -> None:
    """Mirror a URDF in place."""
    for path, key, place in _ACROSS:
        for item in root.iterfind(path):
            if key in item.attrib:
                numbers = [float(number) for number in item.attrib[key].split()]
                numbers[place] = -numbers[place]
                item.set(key, " ".join(map(repr, numbers)))

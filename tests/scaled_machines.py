"""The same machine in another size, with the same masses and the same course in time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from xml.etree import ElementTree

from nipper_pin import Mechanism
from nipper_pin.mechanism import from_sources

# Powers of the length in the units of keys; masses, times and angles stay.
_POWERS = {
    "_kg_m2": 2, "_N_m_per_rad": 2, "_N_m_s_per_rad": 2, "_N_per_m": 0, "_N_s_per_m": 0,
    "_N_s2_per_m2": -1, "_N_m": 2, "_N": 1, "_mm_per_s": 1, "_mm": 1, "_m_s2": 1,
}  # fmt: skip
_PLACES = ("radius", "length", "size", "scale")


def scaled(mechanism: Mechanism, factor: float) -> Mechanism:
    """A mechanism whose lengths are ``factor`` times as long.

    Powers of two change no digit of any length, so the same course in time has to come out.

    Args:
        mechanism: The mechanism, without meshes that collide.
        factor: The factor.
    """
    root = ElementTree.fromstring(mechanism.urdf)
    for item in root.iter():
        _multiply(item, "xyz", factor if item.tag == "origin" else 1.0)
        for key in _PLACES:
            _multiply(item, key, factor)
        for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
            _multiply(item, key, factor**2)
    for joint in root.iter("joint"):
        if joint.get("type") != "prismatic":
            for dynamics in joint.iter("dynamics"):
                _multiply(dynamics, "damping", factor**2)
    urdf = ElementTree.tostring(root, encoding="unicode")
    description = _scaled(mechanism.description, 1.0, factor)
    return from_sources(mechanism.name, urdf, description, mechanism.mesh_folder)


def _multiply(item: ElementTree.Element, key: str, factor: float) -> None:
    if key in item.attrib:
        item.set(key, " ".join(repr(factor * float(word)) for word in item.attrib[key].split()))


def _scaled(value: Any, by: float, factor: float) -> Any:
    if isinstance(value, Mapping):
        return {
            key: _scaled(item, factor ** _power(key, value), factor) for key, item in value.items()
        }
    if isinstance(value, list | tuple):
        return [_scaled(item, by, factor) for item in value]
    return value if by == 1.0 or not isinstance(value, float | int) else by * value


def _power(key: str, table: Mapping[str, Any]) -> int:
    if table.get("law") == "falling" and key == "scale":
        # Of the stop of a slide; no hinge of these machines has such a law.
        return 1
    return next((power for unit, power in _POWERS.items() if key.endswith(unit)), 0)

"""From springs, dampers and force elements of a model file to those in SI units, keys checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pinocchio as pin

from ...errors import InputError, ModelError, looked_up
from ...tolerances.mechanics import COINCIDENT_M
from ...units import M_PER_MM, RAD_PER_DEG
from ..elements import Characteristic, Damper, Strut, TabulatedSpring
from ..files.description import DamperDescription, Description, SpringDescription
from ..files.law_tables import built
from ..files.urdf_parts import Urdf
from ..forces import ForceTable, JointForce
from ..parts import Joint, Spring
from ..scale import reach, unit_of
from .placements import joint_placements


@dataclass(frozen=True)
class _Keys:
    """Keys on one kind of joint, and the factor from the unit of its coordinate to the SI unit."""

    linear: tuple[str, str]
    table: tuple[str, str]
    damper: str
    scale: float


_OF_JOINT = {
    "prismatic": _Keys(
        ("stiffness_N_per_m", "preload_length_mm"),
        ("coordinate_mm", "force_N"),
        "damping_N_s_per_m",
        M_PER_MM,
    ),
    "revolute": _Keys(
        ("stiffness_N_m_per_rad", "preload_deg"),
        ("coordinate_deg", "torque_N_m"),
        "damping_N_m_s_per_rad",
        RAD_PER_DEG,
    ),
}
DYNAMICS = "<dynamics> of "
"""Prefix of the name of a damper from the URDF; the name of its joint follows."""

_Entry = SpringDescription | DamperDescription
_POINTS = ("frame_a", "frame_b")
_OF_POINTS = {
    "spring": (*_POINTS, "stiffness_N_per_m", "free_length_mm"),
    "damper": (*_POINTS, "damping_N_s_per_m"),
}
_TABLES = tuple(key for keys in _OF_JOINT.values() for key in keys.table)


FIELDS: dict[type, str] = {
    Spring: "springs",
    TabulatedSpring: "tabulated_springs",
    Damper: "dampers",
    Strut: "struts",
}
"""Fields of a mechanism that springs and dampers stand in, by their class."""


def build_elements(
    description: Description,
    joints: Mapping[str, Joint],
    urdf: Urdf,
    model: pin.Model,
    file: str,
) -> dict[str, tuple[Any, ...]]:
    """Build springs and dampers, as ``FIELDS`` of a mechanism."""
    given: list[tuple[str, _Entry]] = [*description.springs.items(), *description.dampers.items()]
    found = [
        *(build_element(item, name, joints, model, file) for name, item in given),
        *(
            Damper(name=f"{DYNAMICS}{name}", index=joint.index, damping=urdf.joints[name].damping)
            for name, joint in joints.items()
            if urdf.joints[name].damping
        ),
    ]
    return {
        field: tuple(item for item in found if type(item) is kind) for kind, field in FIELDS.items()
    }


def build_element(
    entry: _Entry,
    name: str,
    joints: Mapping[str, Joint],
    model: pin.Model,
    file: str,
) -> Spring | TabulatedSpring | Damper | Strut:
    """Build one spring or damper."""
    where = f"{'springs' if isinstance(entry, SpringDescription) else 'dampers'}.{name}"
    if entry.frame_a is not None or entry.frame_b is not None:
        return _strut(name, entry, model, where, file)
    joint = _joint(entry, joints, where, file)
    if isinstance(entry, SpringDescription):
        return _spring(name, entry, joint, where, file)
    key = _OF_JOINT[joint.kind].damper
    _check_keys(entry, ("joint", key), joint, where, file)
    return Damper(name=name, index=joint.index, damping=getattr(entry, key))


def _spring(
    name: str, spring: SpringDescription, joint: Joint, where: str, file: str
) -> Spring | TabulatedSpring:
    """A linear spring or a table on a joint."""
    keys = _OF_JOINT[joint.kind]
    if any(getattr(spring, key) for key in _TABLES):
        _check_keys(spring, ("joint", *keys.table), joint, where, file)
        rows = _characteristic(spring, keys, where, file)
        return TabulatedSpring(name=name, index=joint.index, characteristic=rows)
    _check_keys(spring, ("joint", *keys.linear), joint, where, file)
    stiffness, preload = (getattr(spring, key) for key in keys.linear)
    return Spring(name=name, index=joint.index, stiffness=stiffness, preload=keys.scale * preload)


def _joint(entry: _Entry, joints: Mapping[str, Joint], where: str, file: str) -> Joint:
    """The joint that an element acts on."""
    key = f"{where}.joint"
    if entry.joint is None:
        allowed = "the name of a joint, or frame_a and frame_b for an element between two points"
        raise ModelError(file=file, key=key, value=None, allowed=allowed)
    return looked_up("joint", entry.joint, joints, f"{file}: {key}")


def _check_keys(
    entry: _Entry, wanted: Sequence[str], joint: Joint | None, where: str, file: str
) -> None:
    """Refuse an element with a key too many or too few."""
    noun = where.partition("s.")[0]
    place = f"on the {joint.kind} joint {joint.name}" if joint else "between two points"
    keys = [key for key in wanted if key != "joint"]
    only = "key" if len(keys) == 1 else "keys"
    listed = " and ".join([", ".join(keys[:-1]), keys[-1]] if keys[:-1] else keys)
    for key in entry.__struct_fields__:
        value = getattr(entry, key)
        if key == "interpolation" and keys[0] in _TABLES:
            continue
        if value == ():
            value = None
        if (value is None) == (key in wanted):
            allowed = f"a {noun} {place} has the {only} {listed}, and no others"
            if joint and noun == "spring" and keys[0] not in _TABLES:
                table = " and ".join(_OF_JOINT[joint.kind].table)
                allowed += f" (or, for a table, file or {table})"
            raise ModelError(file=file, key=f"{where}.{key}", value=value, allowed=allowed)


def _characteristic(
    spring: SpringDescription, keys: _Keys, where: str, file: str
) -> Characteristic:
    """Rows of a table in SI units."""
    coordinates, forces = (getattr(spring, key) for key in keys.table)
    key = f"{where}.{keys.table[0]}"
    try:
        rows = Characteristic(
            coordinate=tuple(keys.scale * value for value in coordinates),
            force=forces,
            interpolation=spring.interpolation,
        )
    except InputError as error:
        value = f"{len(coordinates)} rows"
        raise ModelError(file=file, key=key, value=value, allowed=error.message) from error
    low, high = rows.ends
    if not low <= 0.0 <= high:
        allowed = "rows on both sides of 0, the coordinate at touch, or one of them there"
        value = f"rows from {coordinates[0]:g} to {coordinates[-1]:g}"
        raise ModelError(file=file, key=key, value=value, allowed=allowed)
    return rows


def _strut(name: str, entry: _Entry, model: pin.Model, where: str, file: str) -> Strut:
    """An element between two points that can move and do not coincide at touch."""
    kind: Literal["spring", "damper"] = (
        "spring" if isinstance(entry, SpringDescription) else "damper"
    )
    _check_keys(entry, _OF_POINTS[kind], None, where, file)
    strut = Strut(
        name=name,
        kind=kind,
        frame_a=entry.frame_a or "",
        frame_b=entry.frame_b or "",
        stiffness=getattr(entry, "stiffness_N_per_m", 0.0),
        free_length=M_PER_MM * getattr(entry, "free_length_mm", 0.0),
        damping=getattr(entry, "damping_N_s_per_m", 0.0),
    )
    links = {frame.name: frame for frame in model.frames if frame.type == pin.FrameType.BODY}
    frames = [
        looked_up("frame", getattr(strut, side), links, f"{file}: {where}.{side}")
        for side in _POINTS
    ]
    key, value = f"{where}.frame_b", strut.frame_b
    if frames[0].parentJoint == frames[1].parentJoint:
        allowed = f"a point of another link than {strut.frame_a}: on one link nothing moves"
        raise ModelError(file=file, key=key, value=value, allowed=allowed)
    world = joint_placements(model)
    first, second = (
        world[frame.parentJoint].act(frame.placement.translation)[[0, 2]] for frame in frames
    )
    nothing = COINCIDENT_M * unit_of(reach(model, (), ()))
    if strut.directed and np.hypot(*(second - first)) < nothing:
        allowed = (
            f"a point away from {strut.frame_a} at touch: between points that coincide a force "
            "has no direction"
        )
        raise ModelError(file=file, key=key, value=value, allowed=allowed)
    return strut


def build_forces(
    tables: Mapping[str, ForceTable], joints: Mapping[str, Joint], file: str
) -> tuple[JointForce, ...]:
    """Build the force elements."""
    found = []
    for name, table in tables.items():
        where, kind = f"forces.{name}", str(type(table).__struct_config__.tag)
        joint = looked_up("joint", table.joint, joints, f"{file}: {where}.joint")
        if joint.kind not in table.acts_on:
            allowed = f"{kind} acts on a joint that is {' or '.join(table.acts_on)}"
            raise ModelError(file=file, key=f"{where}.joint", value=table.joint, allowed=allowed)
        law = built(table.build, joint.kind, table, where, file)
        found.append(JointForce(name=name, kind=kind, index=joint.index, law=law))
    return tuple(found)

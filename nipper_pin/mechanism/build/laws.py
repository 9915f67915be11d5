"""From drive descriptions to drive laws, and the reference position on the cylinder."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np

from ...errors import InputError, ModelError, looked_up
from ...tolerances.mechanics import DRIVE_REPEATS
from ..cylinder import Cylinder
from ..drives import DriveLaw, DriveTable, GearedDrive, OscillatingGuide
from ..files.description import CylinderDescription, Description
from ..files.register import DRIVES
from ..parts import Joint
from ..scale import written

OF_SHAFT = {"revolute": "reflected_inertia_kg_m2", "prismatic": "reflected_mass_kg"}
"""Key of the inertia of a drive train seen at a joint, by its kind."""


def check_drive(name: str, drive: DriveTable, joint: Joint, file: str) -> None:
    """Refuse a law that cannot move a joint of this kind, or has the keys of the other kind."""
    where = f"drives.{name}"
    if joint.kind not in drive.moves:
        raise ModelError(
            file=file, key=f"{where}.joint", value=drive.joint, allowed=_joints_of_laws()
        )
    hinge, slide = drive.hinge_keys, drive.slide_keys
    own, other = (slide, hinge) if joint.kind == "prismatic" else (hinge, slide)
    foreign = OF_SHAFT["revolute" if joint.kind == "prismatic" else "prismatic"]
    for key in (*other, foreign):
        value = getattr(drive, key, None)
        if value not in (None, 0.0, ()):
            keys = f"{', '.join(own)} and " if own else ""
            allowed = f"{keys}{OF_SHAFT[joint.kind]} for the {joint.kind} joint {joint.name}"
            raise ModelError(file=file, key=f"{where}.{key}", value=value, allowed=allowed)
    for key in own:
        value = getattr(drive, key)
        if key in drive.not_zero and not value:
            law = type(drive).__struct_config__.tag
            allowed = f"{law} moves the {joint.kind} joint {joint.name} with a {key} other than 0"
            raise ModelError(file=file, key=f"{where}.{key}", value=value, allowed=allowed)


def _joints_of_laws() -> str:
    """Return as a sentence which laws move which joints."""
    laws: dict[tuple[str, ...], list[str]] = defaultdict(list)
    for tag, kind in DRIVES.tables().items():
        laws[kind.moves].append(tag)
    words: dict[tuple[str, ...], str] = {
        ("prismatic",): "a slide (prismatic joint)",
        ("revolute",): "a hinge",
    }
    return "; ".join(
        f"{', '.join(sorted(tags))}: {words.get(moves, 'a hinge or a slide')}"
        for moves, tags in sorted(laws.items())
    )


def build_laws(
    drives: Mapping[str, DriveTable], joints: Mapping[str, Joint], file: str
) -> dict[str, DriveLaw]:
    """Build the law of every drive."""
    geared = {name: drive for name, drive in drives.items() if isinstance(drive, GearedDrive)}
    own = [name for name in drives if name not in geared]
    laws = {name: _law(name, drives[name], joints, file) for name in own}
    hint = "(a joint that follows one without a drive has a <mimic> in the URDF)"
    for name, drive in geared.items():
        looked_up("drive", drive.of, drives, f"{file}: drives.{name}.of {hint}")
    while waiting := {name: drive for name, drive in geared.items() if name not in laws}:
        ready = {name: drive for name, drive in waiting.items() if drive.of in laws}
        if not ready:
            name, drive = waiting.popitem()
            allowed = "a chain of gears must start at a drive that is not geared"
            raise ModelError(file=file, key=f"drives.{name}.of", value=drive.of, allowed=allowed)
        laws |= {name: drive.build_on(laws[drive.of]) for name, drive in ready.items()}
    return {name: laws[name] for name in drives}


def _law(name: str, drive: DriveTable, joints: Mapping[str, Joint], file: str) -> DriveLaw:
    """The law of a drive that follows no other one."""
    try:
        law = drive.build()
    except InputError as error:
        key, value = drive.culprit()
        raise ModelError(
            file=file, key=f"drives.{name}.{key}", value=value, allowed=error.message
        ) from error
    joint = joints.get(drive.joint)
    if isinstance(law, OscillatingGuide) and joint is not None and joint.sense < 0.0:
        # Its angle is one of the drawing; other laws give the coordinate itself.
        law = replace(law, sense=-1.0)
    return law


def extreme_angle(law: DriveLaw, kind: Literal["minimum", "maximum"]) -> float | None:
    """Cylinder angle in [0, 2 pi) at which a periodic law is smallest or largest over a turn.

    Returns:
        The angle [rad], or None if the law has no extreme inside a turn.
    """
    sign = 1.0 if kind == "minimum" else -1.0
    grid = np.linspace(0.0, math.tau, 721)
    values = sign * law.evaluate(grid)[0]
    drift = abs(values[-1] - values[0])
    travel = float(np.ptp(values))
    if drift > DRIVE_REPEATS * written(travel) or travel <= DRIVE_REPEATS * np.abs(values).max():
        return None
    best = int(np.argmin(values))
    low, high = grid[best] - grid[1], grid[best] + grid[1]
    # Bisection on the rate is safe next to an extreme; its speed does not matter while loading.
    for _ in range(64):
        middle = 0.5 * (low + high)
        if sign * float(law.evaluate(np.array([middle]))[1][0]) < 0.0:
            low = middle
        else:
            high = middle
    return float(0.5 * (low + high) % math.tau)


def build_cylinder(description: Description, laws: Mapping[str, DriveLaw], file: str) -> Cylinder:
    """Build the input shaft with its index scale.

    Raises:
        ModelError: The reference is not given exactly once, or the drive has no extreme.
        UnknownNameError: The reference names a drive that does not exist.
    """
    cylinder = description.cylinder
    return Cylinder(
        angle_at_touch_rad=math.radians(cylinder.angle_at_touch_deg),
        sense=-1 if cylinder.direction == "clockwise" else 1,
        rated_speed_rpm=cylinder.rated_speed_rpm,
        reference_angle_rad=_reference(cylinder, laws, file),
        reference_index=cylinder.reference_index,
    )


def _reference(cylinder: CylinderDescription, laws: Mapping[str, DriveLaw], file: str) -> float:
    """Cylinder angle at the reference index."""
    drive, angle_deg = cylinder.reference_drive, cylinder.reference_angle_deg
    if drive is None and angle_deg is not None:
        return math.radians(angle_deg)
    if drive is None or angle_deg is not None:
        raise ModelError(
            file=file,
            key="cylinder.reference_drive",
            value=drive,
            allowed="exactly one of reference_drive and reference_angle_deg",
        )
    law = looked_up("drive", drive, laws, f"{file}: cylinder.reference_drive")
    angle = extreme_angle(law, cylinder.reference_extreme)
    if angle is None:
        allowed = "a drive that swings to and fro once a turn; else use reference_angle_deg"
        raise ModelError(file=file, key="cylinder.reference_drive", value=drive, allowed=allowed)
    return angle

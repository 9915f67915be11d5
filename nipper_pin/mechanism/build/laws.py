"""From drive descriptions to drive laws, and the reference position on the cylinder."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

import numpy as np

from ...errors import InputError, ModelError, UnknownNameError
from ...units import M_PER_MM
from ..cylinder import Cylinder
from ..drives import ConstantSpeed, DriveLaw, Fourier, Geared, OscillatingGuide, Table
from ..files.description import (
    CamDrive,
    ConstantSpeedDrive,
    CylinderDescription,
    Description,
    DriveDescription,
    FourierDrive,
    GearedDrive,
    OscillatingGuideDrive,
    ScrewDrive,
    TableDrive,
)


def build_laws(drives: Mapping[str, DriveDescription], file: str) -> dict[str, DriveLaw]:
    """Build the law of every drive.

    Args:
        drives: Descriptions by name.
        file: Name of the TOML file, for messages.

    Raises:
        ModelError: A law cannot be built from its values.
        UnknownNameError: A geared drive names a drive that does not exist.
    """
    laws: dict[str, DriveLaw] = {}
    for name in drives:
        _build(name, drives, laws, (), file)
    return {name: laws[name] for name in drives}


def _build(
    name: str,
    drives: Mapping[str, DriveDescription],
    laws: dict[str, DriveLaw],
    above: tuple[str, ...],
    file: str,
) -> DriveLaw:
    """Build one law, after the law it is geared to."""
    if name in laws:
        return laws[name]
    drive = drives[name]
    where = f"drives.{name}"
    if isinstance(drive, GearedDrive):
        if drive.of not in drives:
            raise UnknownNameError(
                kind="drive", name=drive.of, known=drives, where=f"{file}: {where}.of"
            )
        if drive.of in (*above, name):
            allowed = "a chain of gears must start at a drive that is not geared"
            raise ModelError(file=file, key=f"{where}.of", value=drive.of, allowed=allowed)
        of = _build(drive.of, drives, laws, (*above, name), file)
        laws[name] = Geared(of=of, ratio=drive.ratio)
        return laws[name]
    try:
        laws[name] = _basic(drive)
    except InputError as error:
        key, value = _culprit(drive)
        raise ModelError(
            file=file, key=f"{where}.{key}", value=value, allowed=error.message
        ) from error
    return laws[name]


def _basic(drive: DriveDescription) -> DriveLaw:
    """Build a law that stands on its own."""
    if isinstance(drive, OscillatingGuideDrive):
        return OscillatingGuide(
            crank_radius_m=M_PER_MM * drive.crank_radius_mm,
            crank_axis=(M_PER_MM * drive.crank_axis_mm[0], M_PER_MM * drive.crank_axis_mm[1]),
            guide_axis=(M_PER_MM * drive.guide_axis_mm[0], M_PER_MM * drive.guide_axis_mm[1]),
            guide_offset_m=M_PER_MM * drive.guide_offset_mm,
        )
    if isinstance(drive, ConstantSpeedDrive):
        return ConstantSpeed(ratio=drive.ratio)
    if isinstance(drive, ScrewDrive):
        return ConstantSpeed(ratio=M_PER_MM * drive.lead_mm_per_turn / math.tau)
    if isinstance(drive, FourierDrive):
        # The keys of one unit are empty: those of the other kind of joint.
        return Fourier(
            mean=drive.mean_rad + M_PER_MM * drive.mean_mm,
            cosine=drive.cosine_rad or _metres(drive.cosine_mm),
            sine=drive.sine_rad or _metres(drive.sine_mm),
        )
    if isinstance(drive, TableDrive):
        angles = tuple(math.radians(angle) for angle in drive.cylinder_angle_deg)
        rows = drive.coordinate_rad or _metres(drive.coordinate_mm)
        return Table(cylinder_angle_rad=angles, coordinate=rows)
    if isinstance(drive, CamDrive):
        # Few machines have one.
        from ..cams import Cam

        return Cam(
            motion=drive.motion,
            lift=math.radians(drive.lift_deg or 0.0) + M_PER_MM * (drive.lift_mm or 0.0),
            start_rad=math.radians(drive.start_deg),
            rise_rad=math.radians(drive.rise_deg),
            dwell_rad=math.radians(drive.dwell_deg),
            return_rad=math.radians(drive.return_deg),
        )
    message = f"there is no drive law for {type(drive).__name__}"
    raise InputError(message)


def _metres(values: tuple[float, ...]) -> tuple[float, ...]:
    """Millimetres in metres."""
    return tuple(M_PER_MM * value for value in values)


def _culprit(drive: DriveDescription) -> tuple[str, object]:
    """Key and value to name when a law refuses its values."""
    if isinstance(drive, OscillatingGuideDrive):
        distance = math.dist(drive.crank_axis_mm, drive.guide_axis_mm)
        if drive.crank_radius_mm < distance:
            return "guide_offset_mm", drive.guide_offset_mm
        return "crank_radius_mm", drive.crank_radius_mm
    if isinstance(drive, CamDrive):
        return "dwell_deg", drive.dwell_deg
    return "cylinder_angle_deg", f"{len(getattr(drive, 'cylinder_angle_deg', ()))} rows"


def extreme_angle(law: DriveLaw, kind: Literal["minimum", "maximum"]) -> float | None:
    """Cylinder angle in [0, 2 pi) at which a periodic law is smallest or largest over a turn.

    Args:
        law: The drive law.
        kind: Which extreme.

    Returns:
        The angle [rad], or None if the law has no extreme inside a turn.
    """
    sign = 1.0 if kind == "minimum" else -1.0
    grid = np.linspace(0.0, math.tau, 721)
    values = sign * law.evaluate(grid)[0]
    drift = abs(values[-1] - values[0])
    if drift > 1e-9 or np.ptp(values) < 1e-9:
        return None
    best = int(np.argmin(values))
    low, high = grid[best] - grid[1], grid[best] + grid[1]
    # Bisection on the rate: safe next to an extreme, and a load is not a hot loop.
    for _ in range(64):
        middle = 0.5 * (low + high)
        if sign * float(law.evaluate(np.array([middle]))[1][0]) < 0.0:
            low = middle
        else:
            high = middle
    return float(0.5 * (low + high) % math.tau)


def build_cylinder(description: Description, laws: Mapping[str, DriveLaw], file: str) -> Cylinder:
    """Build the input shaft with its index scale.

    Args:
        description: The TOML file.
        laws: Drive laws by name.
        file: Name of the TOML file, for messages.

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
    if drive not in laws:
        raise UnknownNameError(
            kind="drive", name=drive, known=laws, where=f"{file}: cylinder.reference_drive"
        )
    angle = extreme_angle(laws[drive], cylinder.reference_extreme)
    if angle is None:
        allowed = "a drive that swings to and fro once a turn; else use reference_angle_deg"
        raise ModelError(file=file, key="cylinder.reference_drive", value=drive, allowed=allowed)
    return angle

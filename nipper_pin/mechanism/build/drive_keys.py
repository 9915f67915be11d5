"""Which laws move which kind of joint, and in which unit."""

from __future__ import annotations

from ...errors import ModelError
from ..files.description import CamDrive, DriveDescription, FourierDrive, ScrewDrive, TableDrive
from ..mechanism import Joint

# Keys of a hinge, and those of a slide.
_KEYS: dict[type, tuple[tuple[str, ...], tuple[str, ...]]] = {
    FourierDrive: (
        ("mean_rad", "cosine_rad", "sine_rad"),
        ("mean_mm", "cosine_mm", "sine_mm"),
    ),
    TableDrive: (("coordinate_rad",), ("coordinate_mm",)),
    CamDrive: (("lift_deg",), ("lift_mm",)),
}
_REFLECTED = ("reflected_inertia_kg_m2", "reflected_mass_kg")


def check_drive(name: str, drive: DriveDescription, joint: Joint, file: str) -> None:
    """Refuse a law that cannot move a joint of this kind, or has the keys of the other kind.

    Args:
        name: Name of the drive.
        drive: Its description.
        joint: The joint that it moves.
        file: Name of the TOML file, for messages.

    Raises:
        ModelError: It does not fit the joint.
    """
    slides = joint.kind == "prismatic"
    where, both = f"drives.{name}", _KEYS.get(type(drive))
    if both is None:
        if isinstance(drive, ScrewDrive) != slides:
            allowed = (
                "a screw drives a slide (prismatic joint); constant_speed, geared and "
                "oscillating_guide turn a hinge; cam, fourier and table move either"
            )
            raise ModelError(file=file, key=f"{where}.joint", value=drive.joint, allowed=allowed)
        return
    own, other = both[slides], both[not slides]
    for key in (*other, _REFLECTED[not slides]):
        value = getattr(drive, key)
        if value not in (None, 0.0, ()):
            allowed = (
                f"{', '.join(own)} and {_REFLECTED[slides]} for the {joint.kind} joint {joint.name}"
            )
            raise ModelError(file=file, key=f"{where}.{key}", value=value, allowed=allowed)
    if isinstance(drive, CamDrive) and not getattr(drive, own[0]):
        allowed = f"a cam that moves the {joint.kind} joint {joint.name} has a lift other than 0"
        raise ModelError(
            file=file, key=f"{where}.{own[0]}", value=getattr(drive, own[0]), allowed=allowed
        )

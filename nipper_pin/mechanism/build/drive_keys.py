"""Drive laws by kind of joint, and their units."""

from __future__ import annotations

from collections import defaultdict

from ...errors import ModelError
from ..drives import DriveTable
from ..files.register import DRIVES
from ..parts import Joint

_REFLECTED = {"revolute": "reflected_inertia_kg_m2", "prismatic": "reflected_mass_kg"}


def check_drive(name: str, drive: DriveTable, joint: Joint, file: str) -> None:
    """Refuse a law that cannot move a joint of this kind, or has the keys of the other kind.

    Raises:
        ModelError: It does not fit the joint.
    """
    where = f"drives.{name}"
    if joint.kind not in drive.moves:
        raise ModelError(
            file=file, key=f"{where}.joint", value=drive.joint, allowed=_joints_of_laws()
        )
    hinge, slide = drive.hinge_keys, drive.slide_keys
    own, other = (slide, hinge) if joint.kind == "prismatic" else (hinge, slide)
    foreign = _REFLECTED["revolute" if joint.kind == "prismatic" else "prismatic"]
    for key in (*other, foreign):
        value = getattr(drive, key, None)
        if value not in (None, 0.0, ()):
            keys = f"{', '.join(own)} and " if own else ""
            allowed = f"{keys}{_REFLECTED[joint.kind]} for the {joint.kind} joint {joint.name}"
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

"""Common keys of the tables of drives in a model file."""

from __future__ import annotations

from typing import ClassVar

from ..files.description import Name, NotNegative, Positive, TomlTable
from .law import DriveLaw

HINGE, SLIDE = "revolute", "prismatic"


class DriveTable(TomlTable, frozen=True, kw_only=True, tag_field="law"):
    """Keys of every drive; those of its shaft are needed for inertial drives only.

    Attributes:
        joint: Driven joint.
        shaft_frequency_hz: Natural frequency of the elastic drive train [Hz].
        shaft_damping_ratio: Its damping ratio [-].
    """

    joint: Name
    shaft_frequency_hz: Positive | None = None
    shaft_damping_ratio: NotNegative | None = None

    moves: ClassVar[tuple[str, ...]] = (HINGE, SLIDE)
    """Kinds of joints that the law moves."""
    hinge_keys: ClassVar[tuple[str, ...]] = ()
    """Keys that only a hinge has, for example those in degrees."""
    slide_keys: ClassVar[tuple[str, ...]] = ()
    """Keys that only a slide has, for example those in millimetres."""
    not_zero: ClassVar[tuple[str, ...]] = ()
    """Those of both whose value of zero would leave the joint unmoved."""

    def build(self) -> DriveLaw:
        """Return the law in SI units.

        Raises:
            InputError: The values make no law.
        """
        raise NotImplementedError

    def culprit(self) -> tuple[str, object]:
        """Return the key, with its value, to name when the values make no law."""
        return "law", type(self).__struct_config__.tag


class ShaftTable(DriveTable, frozen=True, kw_only=True):
    """Keys of every drive of a hinge.

    Attributes:
        reflected_inertia_kg_m2: Inertia of shaft and drive train seen at the joint [kg m2].
    """

    reflected_inertia_kg_m2: Positive | None = None

    moves: ClassVar[tuple[str, ...]] = (HINGE,)


class AnyTable(DriveTable, frozen=True, kw_only=True):
    """Keys of every drive of either kind of joint.

    Attributes:
        reflected_inertia_kg_m2: Inertia of shaft and drive train seen at a hinge [kg m2].
        reflected_mass_kg: The same seen at a slide [kg].
    """

    reflected_inertia_kg_m2: Positive | None = None
    reflected_mass_kg: Positive | None = None


class FollowingTable(ShaftTable, frozen=True, kw_only=True):
    """Keys of every drive that follows another one.

    Attributes:
        of: Name of the other drive.
    """

    of: Name

    def build_on(self, other: DriveLaw) -> DriveLaw:
        """Return the law in SI units.

        Raises:
            InputError: The values make no law.
        """
        raise NotImplementedError

"""Common keys of the tables of a model file that name a law, and what they give."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar, TypeVar

from ...errors import InputError, ModelError
from ..laws import DriveLaw, ForceLaw, RestitutionLaw
from .description import Name, NotNegative, Positive, TomlTable

HINGE, SLIDE = "revolute", "prismatic"
_T = TypeVar("_T")


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


class ForceTable(TomlTable, frozen=True, kw_only=True, tag_field="law"):
    """Keys of every force element.

    Attributes:
        joint: Joint it acts on.
    """

    joint: Name

    acts_on: ClassVar[tuple[str, ...]] = (HINGE, SLIDE)
    """Kinds of joints that it acts on."""

    def build(self, kind: str) -> ForceLaw:
        """Return the law in SI units.

        Args:
            kind: Kind of the joint, ``revolute`` or ``prismatic``.

        Raises:
            InputError: The values make no law; its evidence ``key`` names the key to change.
        """
        raise NotImplementedError


class RestitutionTable(TomlTable, frozen=True, kw_only=True, tag_field="law"):
    """Restitution that depends on the rate of approach."""

    def build(self, kind: str) -> RestitutionLaw:
        """Return the law in SI units; argument and errors as of :meth:`ForceTable.build`."""
        raise NotImplementedError


class StopTable(TomlTable, frozen=True, kw_only=True, tag_field="law"):
    """Coordinate at which a stop is closed, from its adjustment."""

    def place(self, kind: str) -> float:
        """Return that coordinate [m or rad]; argument and errors as of :meth:`ForceTable.build`."""
        raise NotImplementedError


def built(build: Callable[[str], _T], kind: str, table: TomlTable, where: str, file: str) -> _T:
    """What a table with a law gives on a joint of a kind, in SI units.

    Raises:
        ModelError: The values of the table make nothing; names the law if that names no key.
    """
    try:
        return build(kind)
    except InputError as error:
        key = str(error.evidence.get("key", "law"))
        value = getattr(table, key, table.__struct_config__.tag)
        raise ModelError(
            file=file, key=f"{where}.{key}", value=value, allowed=error.message
        ) from error

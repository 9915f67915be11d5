"""Typed description of a model's TOML file: its layout, with the unit in every field name."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta, field

from ...given import LARGEST as LARGEST
from ..elements import Interpolation
from ..parts import Simultaneous

Positive = Annotated[float, Meta(gt=0.0)]
NotNegative = Annotated[float, Meta(ge=0.0)]
# "instead" ends the refusal of another number.
_FALLING = {"instead": "a force that does not rise is given by the rows of a table on a joint"}
Stiffness = Annotated[float, Meta(gt=0.0, le=LARGEST, extra=_FALLING)]
Damping = Annotated[float, Meta(ge=0.0, le=LARGEST)]
Length = Annotated[float, Meta(ge=0.0, le=LARGEST)]
Restitution = Annotated[float, Meta(ge=0.0, le=1.0)]
# Round-off of an angle grows with it: after ten turns it is still below 1e-14 of a turn.
ShaftAngle = Annotated[float, Meta(ge=-3600.0, le=3600.0)]
Index = Annotated[float, Meta(ge=0.0, lt=40.0)]
Name = Annotated[str, Meta(min_length=1)]
PlanePoint = tuple[float, float]


class TomlTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A TOML table whose keys are all known."""


class CylinderDescription(TomlTable, frozen=True, kw_only=True):
    """The input shaft. The reference is given by its angle, or by the extreme of a drive.

    Attributes:
        rated_speed_rpm: Rated speed [r/min].
        direction: Sense of rotation in the side view.
        angle_at_touch_deg: Cylinder angle in the touch configuration [deg].
        reference_index: Index at the reference, 0 to 40.
        reference_drive: Drive whose extreme over a turn is the reference.
        reference_extreme: Which extreme.
        reference_angle_deg: Cylinder angle at the reference [deg].
    """

    rated_speed_rpm: Positive
    direction: Literal["clockwise", "counter-clockwise"]
    angle_at_touch_deg: ShaftAngle
    reference_index: Index
    reference_drive: Name | None = None
    reference_extreme: Literal["minimum", "maximum"] = "minimum"
    reference_angle_deg: ShaftAngle | None = None


class SpringDescription(TomlTable, frozen=True, kw_only=True):
    """A spring: linear on a joint, from a table on a joint, or between two points.

    Attributes:
        joint: Joint it acts on, unless it has two points.
        stiffness_N_per_m: Stiffness on a prismatic joint or between two points [N/m].
        preload_length_mm: Deflection at coordinate zero of a prismatic joint [mm].
        stiffness_N_m_per_rad: Torsional stiffness on a hinge [N m/rad].
        preload_deg: Deflection at coordinate zero of a hinge [deg].
        file: CSV file with the columns of a table.
        coordinate_mm: Rising coordinates of a table on a prismatic joint [mm].
        force_N: Force against the coordinate at each of them [N].
        coordinate_deg: Rising coordinates of a table on a hinge [deg].
        torque_N_m: Torque against the coordinate at each of them [N m].
        interpolation: How the rows of a table are joined, "smooth" if not given.
        frame_a: URDF link whose origin is the first point.
        frame_b: URDF link whose origin is the second point.
        free_length_mm: Distance of the two points without force [mm].
    """

    joint: Name | None = None
    stiffness_N_per_m: Stiffness | None = None
    preload_length_mm: float | None = None
    stiffness_N_m_per_rad: Stiffness | None = None
    preload_deg: float | None = None
    file: Name | None = None
    coordinate_mm: tuple[float, ...] = ()
    force_N: tuple[float, ...] = ()
    coordinate_deg: tuple[float, ...] = ()
    torque_N_m: tuple[float, ...] = ()
    interpolation: Interpolation | None = None
    frame_a: Name | None = None
    frame_b: Name | None = None
    free_length_mm: Length | None = None


class DamperDescription(TomlTable, frozen=True, kw_only=True):
    """A linear damper on a joint or between two points.

    Attributes:
        joint: Joint it acts on, unless it has two points.
        damping_N_s_per_m: Damping on a prismatic joint or between two points [N s/m].
        damping_N_m_s_per_rad: Torsional damping on a hinge [N m s/rad].
        frame_a: URDF link whose origin is the first point.
        frame_b: URDF link whose origin is the second point.
    """

    joint: Name | None = None
    damping_N_s_per_m: Damping | None = None
    damping_N_m_s_per_rad: Damping | None = None
    frame_a: Name | None = None
    frame_b: Name | None = None


class ContactDescription(TomlTable, frozen=True, kw_only=True):
    """Two bodies that meet at a stop.

    Attributes:
        lower: Link or collision element that the joint does not move.
        upper: Link or collision element that the joint moves.
    """

    lower: Name
    upper: Name


class StopDescription(TomlTable, frozen=True, kw_only=True):
    """A unilateral stop on a joint; one joint may have a lower and an upper one.

    Attributes:
        joint: Joint it limits.
        restitution: Coefficient of restitution, 0 to 1; with a law, that of a vanishing rate.
        adjusted: How its place is adjusted, in place of at_mm and at_deg.
        restitution_law: How it depends on the rate of approach, by a law.
        side: Whether it limits the joint's coordinate from below or from above.
        at_mm: Coordinate of a slide at which the stop is closed, 0 if not given [mm].
        at_deg: Coordinate of a hinge at which the stop is closed, 0 if not given [deg].
        contact: The bodies that meet, unless the stop acts along the joint itself.
    """

    joint: Name
    restitution: Restitution
    side: Literal["lower", "upper"] = "lower"
    at_mm: float | None = None
    at_deg: float | None = None
    contact: ContactDescription | None = None
    adjusted: Any = None
    restitution_law: Any = None


class InitialDescription(TomlTable, frozen=True, kw_only=True):
    """Initial position and rate of a joint that nothing prescribes.

    Attributes:
        at_mm: Coordinate of a slide, 0 if not given [mm].
        at_deg: Coordinate of a hinge, 0 if not given [deg].
        rate_mm_per_s: Rate of a slide, 0 if not given [mm/s].
        rate_rad_per_s: Rate of a hinge, 0 if not given [rad/s].
    """

    at_mm: float | None = None
    at_deg: float | None = None
    rate_mm_per_s: float | None = None
    rate_rad_per_s: float | None = None


class ClosureDescription(TomlTable, frozen=True, kw_only=True):
    """A cut joint: a pin, or a pin in a slot.

    Attributes:
        frame_a: URDF link whose origin is the first side, or that carries the slot.
        frame_b: URDF link whose origin is the second side: the pin.
        slot_axis: Axis of frame_a along which the pin slides, for a pin in a slot.
        block_mass_kg: Mass of the block in the slot that carries the pin [kg].
    """

    frame_a: Name
    frame_b: Name
    slot_axis: Literal["x", "z"] | None = None
    block_mass_kg: Positive | None = None


class PhaseDescription(TomlTable, frozen=True, kw_only=True):
    """A working phase.

    Attributes:
        number: Number used in tables.
        name: What happens in it.
        closed: Names of the closed stops.
    """

    number: Annotated[int, Meta(ge=1)]
    name: Name
    closed: tuple[Name, ...]


class Description(TomlTable, frozen=True, kw_only=True):
    """The whole TOML file.

    Attributes:
        format: Layout version, 1.
        title: What the model is, in a few words.
        degrees_of_freedom: Mobility with all stops open, drives counted.
        gravity_m_s2: Gravity along -z [m/s2].
        simultaneous: Law of impacts at several stops that touch: all at once by Newton's law, or in
            a sequence from contact to contact.
        transition_stop: Stop whose bouncing is the transition; may be missing without stops.
        initial_phase: Phase at the start of a cycle.
        cylinder: The input shaft.
        drives: Driven joints, each moved by a law.
        springs: Springs.
        dampers: Dampers.
        forces: Force elements on joints, each with a law of its own.
        stops: Unilateral stops.
        closures: Cut joints.
        initial: Where joints start that nothing prescribes, by joint.
        phases: Working phases.
        shortcuts: Short command-line names to value paths.
        provenance: Where the numbers come from, by path prefix.
    """

    format: Literal[1]
    title: Name
    degrees_of_freedom: Annotated[int, Meta(ge=1)]
    gravity_m_s2: NotNegative
    simultaneous: Simultaneous = "newton"
    transition_stop: str = ""
    initial_phase: int
    cylinder: CylinderDescription
    phases: Annotated[tuple[PhaseDescription, ...], Meta(min_length=1)]
    drives: dict[str, Any] = field(default_factory=dict)
    stops: dict[str, StopDescription] = field(default_factory=dict)
    springs: dict[str, SpringDescription] = field(default_factory=dict)
    dampers: dict[str, DamperDescription] = field(default_factory=dict)
    forces: dict[str, Any] = field(default_factory=dict)
    closures: dict[str, ClosureDescription] = field(default_factory=dict)
    initial: dict[str, InitialDescription] = field(default_factory=dict)
    shortcuts: dict[str, str] = field(default_factory=dict)
    provenance: dict[str, Name] = field(default_factory=dict)

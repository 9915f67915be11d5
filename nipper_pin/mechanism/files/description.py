"""Typed description of a model's TOML file: its layout, with the unit in every field name."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec
from msgspec import Meta

Positive = Annotated[float, Meta(gt=0.0)]
NotNegative = Annotated[float, Meta(ge=0.0)]
# What is larger belongs to no machine, and its products and squares leave the range of a float.
Stiffness = Annotated[float, Meta(gt=0.0, le=1e15)]
Damping = Annotated[float, Meta(ge=0.0, le=1e15)]
Length = Annotated[float, Meta(ge=0.0, le=1e15)]
Restitution = Annotated[float, Meta(ge=0.0, le=1.0)]
Index = Annotated[float, Meta(ge=0.0, lt=40.0)]
Name = Annotated[str, Meta(min_length=1)]
PlanePoint = tuple[float, float]


class _Table(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A TOML table whose keys are all known."""


class CylinderDescription(_Table, frozen=True, kw_only=True):
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
    angle_at_touch_deg: float
    reference_index: Index
    reference_drive: Name | None = None
    reference_extreme: Literal["minimum", "maximum"] = "minimum"
    reference_angle_deg: float | None = None


class _DriveTable(_Table, frozen=True, kw_only=True, tag_field="law"):
    """What every drive has; the numbers of its shaft are only needed where drives are inertial.

    Attributes:
        joint: Driven joint.
        shaft_frequency_hz: Natural frequency of the elastic drive train [Hz].
        shaft_damping_ratio: Its damping ratio [-].
    """

    joint: Name
    shaft_frequency_hz: Positive | None = None
    shaft_damping_ratio: NotNegative | None = None


class _ShaftTable(_DriveTable, frozen=True, kw_only=True):
    """What every drive of a hinge has.

    Attributes:
        reflected_inertia_kg_m2: Inertia of shaft and drive train seen at the joint [kg m2].
    """

    reflected_inertia_kg_m2: Positive | None = None


class OscillatingGuideDrive(_ShaftTable, frozen=True, kw_only=True, tag="oscillating_guide"):
    """A crank pin on the cylinder that slides in a guide bar fixed to the driven link.

    Attributes:
        crank_radius_mm: Distance of the pin from the cylinder axis [mm].
        crank_axis_mm: Cylinder axis (x, z) [mm].
        guide_axis_mm: Axis of the driven shaft (x, z) [mm].
        guide_offset_mm: Distance of the bar's line from the guide axis, positive to the left of
            the direction towards the pin [mm].
    """

    crank_radius_mm: Positive
    crank_axis_mm: PlanePoint
    guide_axis_mm: PlanePoint
    guide_offset_mm: float = 0.0


class GearedDrive(_ShaftTable, frozen=True, kw_only=True, tag="geared"):
    """A shaft geared to another drive.

    Attributes:
        of: Name of the other drive.
        ratio: Turns of this shaft per turn of the other, negative in opposite sense [-].
    """

    of: Name
    ratio: float


class ConstantSpeedDrive(_ShaftTable, frozen=True, kw_only=True, tag="constant_speed"):
    """A shaft that turns in proportion to the cylinder.

    Attributes:
        ratio: Turns of this shaft per turn of the cylinder [-].
    """

    ratio: float


class ScrewDrive(_DriveTable, frozen=True, kw_only=True, tag="screw"):
    """A slide that a screw moves in proportion to the cylinder.

    Attributes:
        lead_mm_per_turn: Travel per turn of the cylinder [mm].
        reflected_mass_kg: Inertia of the drive train seen at the slide [kg].
    """

    lead_mm_per_turn: float
    reflected_mass_kg: Positive | None = None


class _AnyTable(_DriveTable, frozen=True, kw_only=True):
    """What every drive of either kind of joint has.

    Attributes:
        reflected_inertia_kg_m2: Inertia of shaft and drive train seen at a hinge [kg m2].
        reflected_mass_kg: The same seen at a slide [kg].
    """

    reflected_inertia_kg_m2: Positive | None = None
    reflected_mass_kg: Positive | None = None


class FourierDrive(_AnyTable, frozen=True, kw_only=True, tag="fourier"):
    """A Fourier series in the cylinder angle; coefficient n belongs to n turns per turn.

    Attributes:
        mean_rad: Mean value of a hinge [rad].
        cosine_rad: Coefficients of cos psi, cos 2 psi, ... of a hinge [rad].
        sine_rad: Coefficients of sin psi, sin 2 psi, ... of a hinge [rad].
        mean_mm: Mean value of a slide [mm].
        cosine_mm: Coefficients of cos psi, cos 2 psi, ... of a slide [mm].
        sine_mm: Coefficients of sin psi, sin 2 psi, ... of a slide [mm].
    """

    mean_rad: float = 0.0
    cosine_rad: tuple[float, ...] = ()
    sine_rad: tuple[float, ...] = ()
    mean_mm: float = 0.0
    cosine_mm: tuple[float, ...] = ()
    sine_mm: tuple[float, ...] = ()


class TableDrive(_AnyTable, frozen=True, kw_only=True, tag="table"):
    """A table over one turn, from a CSV file in the model folder or written out here.

    Attributes:
        file: CSV file with the columns cylinder_angle_deg and coordinate_rad or coordinate_mm.
        cylinder_angle_deg: Cylinder angles, rising over exactly one turn [deg].
        coordinate_rad: Coordinate of a hinge at each angle [rad].
        coordinate_mm: Coordinate of a slide at each angle [mm].
    """

    file: Name | None = None
    cylinder_angle_deg: tuple[float, ...] = ()
    coordinate_rad: tuple[float, ...] = ()
    coordinate_mm: tuple[float, ...] = ()


class CamDrive(_AnyTable, frozen=True, kw_only=True, tag="cam"):
    """A cam with dwell: rise, dwell, return, and rest for what is left of the turn.

    Attributes:
        motion: How it rises and returns.
        lift_mm: Lift of a slide [mm].
        lift_deg: Lift of a hinge [deg].
        start_deg: Cylinder angle at which the rise begins [deg].
        rise_deg: Cylinder angle of the rise [deg].
        dwell_deg: Cylinder angle for which the follower stays up [deg].
        return_deg: Cylinder angle of the return [deg].
    """

    motion: Literal["cycloidal", "modified_sine", "polynomial_345", "polynomial_4567"]
    rise_deg: Positive
    return_deg: Positive
    dwell_deg: NotNegative = 0.0
    start_deg: float = 0.0
    lift_mm: float | None = None
    lift_deg: float | None = None


DriveDescription = (
    OscillatingGuideDrive
    | GearedDrive
    | ConstantSpeedDrive
    | ScrewDrive
    | FourierDrive
    | TableDrive
    | CamDrive
)


class SpringDescription(_Table, frozen=True, kw_only=True):
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
    frame_a: Name | None = None
    frame_b: Name | None = None
    free_length_mm: Length | None = None


class DamperDescription(_Table, frozen=True, kw_only=True):
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


class ContactDescription(_Table, frozen=True, kw_only=True):
    """Two bodies that meet at a stop.

    Attributes:
        lower: Link or collision element that the joint does not move.
        upper: Link or collision element that the joint moves.
    """

    lower: Name
    upper: Name


class StopDescription(_Table, frozen=True, kw_only=True):
    """A unilateral stop on a joint; one joint may have a lower and an upper one.

    Attributes:
        joint: Joint it limits.
        restitution: Coefficient of restitution, 0 to 1.
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


class InitialDescription(_Table, frozen=True, kw_only=True):
    """Where a joint that nothing prescribes starts, and how fast it moves there.

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


class ClosureDescription(_Table, frozen=True, kw_only=True):
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


class PhaseDescription(_Table, frozen=True, kw_only=True):
    """A working phase.

    Attributes:
        number: Number used in tables.
        name: What happens in it.
        closed: Names of the closed stops.
    """

    number: Annotated[int, Meta(ge=1)]
    name: Name
    closed: tuple[Name, ...]


class Description(_Table, frozen=True, kw_only=True):
    """The whole TOML file.

    Attributes:
        format: Layout version, 1.
        title: What the model is, in a few words.
        degrees_of_freedom: Mobility with all stops open, drives counted.
        gravity_m_s2: Gravity along -z [m/s2].
        transition_stop: Stop whose bouncing is the transition; may be missing without stops.
        initial_phase: Phase at the start of a cycle.
        cylinder: The input shaft.
        drives: Driven joints.
        springs: Springs.
        dampers: Dampers.
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
    transition_stop: str = ""
    initial_phase: int
    cylinder: CylinderDescription
    phases: Annotated[tuple[PhaseDescription, ...], Meta(min_length=1)]
    drives: dict[str, DriveDescription] = {}
    stops: dict[str, StopDescription] = {}
    springs: dict[str, SpringDescription] = {}
    dampers: dict[str, DamperDescription] = {}
    closures: dict[str, ClosureDescription] = {}
    initial: dict[str, InitialDescription] = {}
    shortcuts: dict[str, str] = {}
    provenance: dict[str, Name] = {}

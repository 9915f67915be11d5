"""The immutable description of a mechanism that every later room reads.

A mechanism is planar: side view, x forward, z up, y into the page. Angles are positive
counter-clockwise in that view, but for coordinates of hinges whose axis is +y in it. All
coordinates are zero in the *touch configuration*, where the lips just meet and the spring-loaded
joint stands on its stop.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Literal, SupportsFloat

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ..errors import ImpactError, InputError, UnknownNameError
from .cylinder import Cylinder
from .drives.law import DriveLaw, Geared
from .elements import Damper, Strut, TabulatedSpring
from .scale import reach, unit_of, units_of

if TYPE_CHECKING:
    # Few machines have them.
    from .forces.law import JointForce
    from .restitution.law import RestitutionLaw

FloatArray = NDArray[np.float64]
Simultaneous = Literal["newton", "sequential"]
"""Laws of impacts at several stops that touch."""


@dataclass(frozen=True, kw_only=True)
class Joint:
    """One tree joint with one coordinate.

    Attributes:
        name: Joint name in the URDF.
        kind: "revolute" (rad) or "prismatic" (m).
        parent: Parent link.
        child: Child link.
        index: Place of its coordinate in q and v.
        sense: 1 if a hinge turns counter-clockwise in the side view as its coordinate grows, -1 if
            clockwise, as the axis of the URDF says; 1 of a slide.
    """

    name: str
    kind: Literal["revolute", "prismatic"]
    parent: str
    child: str
    index: int
    sense: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Closure:
    """A cut planar pin: the origins of two named frames coincide (two rows, x and z).

    Attributes:
        name: Name of the cut joint.
        frame_a: Frame on the first side; of a pin in a slot the block that slides in it.
        frame_b: Frame on the second side.
        slot_frame: URDF frame that carries the slot, None for a plain pin.
        slot_axis: Axis of that frame along which the pin slides: the direction of the prismatic
            joint that has the closure's name.
        gap_m: What the frames miss one another by in the files, b minus a along x and z in the
            touch configuration, where rounded numbers leave it; the frames of ``model`` are moved
            so that they meet [m].
    """

    name: str
    frame_a: str
    frame_b: str
    slot_frame: str | None = None
    slot_axis: Literal["x", "z"] | None = None
    gap_m: tuple[float, float] = (0.0, 0.0)

    @property
    def first_side(self) -> str:
        """What the pin of frame b meets, in words."""
        if self.slot_frame is None:
            return self.frame_a
        return f"the slot along {self.slot_axis} of {self.slot_frame}"


@dataclass(frozen=True, kw_only=True)
class Coupling:
    """A coordinate that is a multiple of another: q[index] = multiplier * q[of].

    Attributes:
        name: Name of the joint that follows.
        index: Place of its coordinate in q and v.
        of: Place of the coordinate that it follows.
        multiplier: Its coordinate by the other [1, m/rad or rad/m].
    """

    name: str
    index: int
    of: int
    multiplier: float


@dataclass(frozen=True, kw_only=True)
class Drive:
    """A joint driven from the cylinder.

    Attributes:
        name: Name of the drive.
        index: Place of the driven coordinate in q and v.
        law: Coordinate as a function of the cylinder angle.
        law_at_touch: Value of the law at the touch configuration [rad or m]; the joint coordinate
            is ``law(psi) - law_at_touch``.
        reflected_inertia: Inertia of shaft and drive train seen at the joint, used when the
            shafts are free to change speed in an impact [kg m^2 or kg].
        shaft_frequency_hz: Natural frequency of that inertia on the elastic drive train [Hz].
        shaft_damping_ratio: Damping ratio of the same [-].
        missing: Keys of these three that the model file does not give, which are zero then: the
            drive can only be held.
    """

    name: str
    index: int
    law: DriveLaw
    law_at_touch: float
    reflected_inertia: float
    shaft_frequency_hz: float
    shaft_damping_ratio: float
    missing: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Spring:
    """A linear spring acting on one coordinate x: force -stiffness * (preload + x).

    Attributes:
        name: Name of the spring.
        index: Place of the coordinate in q and v.
        stiffness: [N/m] or [N m/rad].
        preload: Deflection already in the spring at x = 0 [m] or [rad].
    """

    name: str
    index: int
    stiffness: float
    preload: float


@dataclass(frozen=True, kw_only=True)
class Contact:
    """Contact of two lips, found from their collision shapes in the touch configuration.

    Attributes:
        point: Contact point in world axes [m], shape (3,).
        normal: Unit normal, pointing from the lower to the opening lip, shape (3,).
        lever_m: Rate of normal separation at the contact point per unit rate of the stop's
            coordinate [m/rad], the arm of the contact force about the joint.
        closing_coordinate: Coordinate at which the shapes touch [rad]; zero up to the tolerance
            of the load check.
    """

    point: FloatArray = field(compare=False)
    normal: FloatArray = field(compare=False)
    lever_m: float
    closing_coordinate: float


@dataclass(frozen=True, kw_only=True)
class Stop:
    """A unilateral stop on one coordinate: gap g_N = sense (q[index] - at) >= 0.

    The difference is exact near the stop, and a coordinate that stands at ``at`` has the gap zero
    to the last bit. Small flights keep full relative precision because they are followed from
    there by their rate, not by differences of coordinates.

    Attributes:
        name: Name of the stop.
        index: Place of the coordinate in q and v.
        restitution: e_N, 0 to 1; of a vanishing rate where a law makes it depend on the rate.
        contact: Contact of the two bodies away from the joint, or None for a stop that acts along
            the joint itself.
        sense: 1 for a lower limit, -1 for an upper one: the direction W_N in which it pushes.
        at: Coordinate at which the stop is closed [rad or m].
        law: How the restitution depends on the rate of approach; None if it does not.
        leader: Stop that closes together with it and is followed for both; empty if none is.
        ratio: Rate of its gap by that of the leader's [1, m/rad or rad/m].
    """

    name: str
    index: int
    restitution: float
    contact: Contact | None
    sense: float = 1.0
    at: float = 0.0
    law: RestitutionLaw | None = None
    leader: str = ""
    ratio: float = 1.0

    @property
    def lever(self) -> float:
        """Normal gap rate at the contact per rate of the gap: [m/rad], or 1 along the joint."""
        return 1.0 if self.contact is None else self.contact.lever_m

    @property
    def plain(self) -> bool:
        """True for a lower stop at coordinate zero, whose gap is the coordinate itself."""
        return self.sense == 1.0 and self.at == 0.0

    def coefficient(self, rate: float) -> float:
        """Return e_N of an approach with a rate of the gap, which is negative [rad/s or m/s].

        Raises:
            ImpactError: A law returns what is no coefficient.
        """
        if self.law is None or rate >= 0.0:
            return self.restitution
        found = self.law.coefficient(self.restitution, -rate)
        if isinstance(found, SupportsFloat) and 0.0 <= float(found) <= 1.0:
            return float(found)
        kind = type(self.law).__name__
        message = (
            f"the restitution law {kind} of stop {self.name!r} returns {found!r} at a rate of "
            f"approach of {-rate:.6g} m/s (rad/s of a hinge), and a coefficient of restitution is "
            "a number from 0 to 1: more would make energy; mend the law or its numbers"
        )
        raise ImpactError(message, stops=self.name, law=kind, coefficient=found, rate=-rate)

    def rebound_slope(self, rate: float) -> float:
        """Return -d(rate after)/d(rate before) = e_N + |rate| de_N/d|rate|; as `coefficient`."""
        e_N = self.coefficient(rate)
        if self.law is None or rate >= 0.0:
            return e_N
        return e_N - rate * self.law.slope(self.restitution, -rate)

    def gap(self, q: FloatArray) -> float:
        """g_N [rad or m] of one configuration, shape (nv,)."""
        return self.sense * (float(q[self.index]) - self.at)

    def gaps(self, q: FloatArray) -> FloatArray:
        """g_N [rad or m], shape (N,), of configurations, shape (N, nv)."""
        return self.sense * (q[:, self.index] - self.at)

    def rate(self, v: FloatArray) -> float:
        """g_N_dot of one velocity, shape (nv,), or g_N_ddot of one acceleration."""
        return self.sense * float(v[self.index])

    def rates(self, v: FloatArray) -> FloatArray:
        """g_N_dot, shape (N,), of velocities, shape (N, nv), or g_N_ddot of accelerations."""
        return self.sense * v[:, self.index]


@dataclass(frozen=True, kw_only=True)
class Start:
    """Initial position and rate of a joint that nothing prescribes, at the start of whole turns.

    Attributes:
        joint: Name of the joint.
        index: Place of its coordinate in q and v.
        at: Coordinate [rad or m].
        rate: Its rate [rad/s or m/s].
    """

    joint: str
    index: int
    at: float
    rate: float


@dataclass(frozen=True, kw_only=True)
class Phase:
    """A working phase: the set of closed stops.

    Attributes:
        number: Number used in tables.
        name: What happens in it.
        closed: Names of the stops that are closed.
    """

    number: int
    name: str
    closed: frozenset[str]


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Mechanism:
    """A validated planar mechanism with closures, drives, springs and stops; equal to itself only.

    Attributes:
        name: Model name.
        title: What the model is, in a few words.
        joints: Tree joints in the order of their coordinates.
        closures: Cut joints.
        couplings: Joints that follow others.
        drives: Driven joints.
        springs: Linear springs on coordinates.
        tabulated_springs: Springs on coordinates whose force comes from a table.
        dampers: Linear dampers on coordinates.
        struts: Springs and dampers between two points.
        forces: Force elements on coordinates, each with a law of its own.
        stops: Unilateral stops.
        phases: Working phases.
        simultaneous: Law of impacts at several stops that touch: "newton", all at once, or
            "sequential", from contact to contact.
        transition_stop: Stop whose bouncing is "the transition".
        initial_phase: Phase at the start of a cycle.
        starts: Joints whose coordinate and rate at that start are given.
        cylinder: The input shaft.
        gravity_m_s2: Gravity along -z, as far as it acts in the plane.
        shortcuts: Short command-line names to value paths, for example "stiffness".
        provenance: Where the numbers come from, by path prefix.
        urdf: The URDF text.
        description: The TOML document as plain data, overrides applied.
        mesh_folder: Folder that relative mesh paths of the URDF start from.
        side_view: How the URDF was turned into the side view; empty where it stands in it.
        model: Pinocchio model of the tree; read only.
    """

    name: str
    title: str
    joints: tuple[Joint, ...]
    closures: tuple[Closure, ...]
    couplings: tuple[Coupling, ...]
    drives: tuple[Drive, ...]
    springs: tuple[Spring, ...]
    tabulated_springs: tuple[TabulatedSpring, ...]
    dampers: tuple[Damper, ...]
    struts: tuple[Strut, ...]
    forces: tuple[JointForce, ...]
    stops: tuple[Stop, ...]
    phases: tuple[Phase, ...]
    simultaneous: Simultaneous
    transition_stop: str
    initial_phase: int
    starts: tuple[Start, ...]
    cylinder: Cylinder
    gravity_m_s2: float
    shortcuts: Mapping[str, str]
    provenance: Mapping[str, str]
    urdf: str
    description: Mapping[str, object]
    mesh_folder: str
    side_view: str
    model: pin.Model = field(repr=False, compare=False)

    def __repr__(self) -> str:
        """One line."""
        from .summary import line

        return line(self)

    def _repr_html_(self) -> str:
        from .summary import page

        return page(self)

    @property
    def degrees_of_freedom(self) -> int:
        """Mobility with every stop open, drives counted."""
        return len(self.joints) - self.closure_rows

    @property
    def closure_rows(self) -> int:
        """Number of equations that couple coordinates: two a cut joint, one a coupling."""
        return 2 * len(self.closures) + len(self.couplings)

    @property
    def closing(self) -> str:
        """What was closed of loops that rounded numbers leave open; empty if all meet."""
        from .summary import closing

        return closing(self)

    @property
    def curves(self) -> str:
        """Which tables of springs bend away from the lines between their rows; empty if none does.

        A table that says how its rows are joined is not among them.
        """
        from .summary import curves

        return curves(self)

    @cached_property
    def coupling_rows(self) -> FloatArray:
        """Jacobian of the couplings, shape (couplings, joints); as closures, in metres."""
        rows = np.zeros((len(self.couplings), len(self.joints)))
        for row, coupling in zip(rows, self.couplings, strict=True):
            kind = self.joints[coupling.index].kind
            row[coupling.index] = size = 1.0 if kind == "prismatic" else self.reach_m
            row[coupling.of] -= size * coupling.multiplier
        return rows

    @cached_property
    def reach_m(self) -> float:
        """Length that the round-off of a closure gap is proportional to [m]."""
        return reach(self.model, self.joints, (*self.stops, *self.starts))

    @cached_property
    def unit_m(self) -> float:
        """The reach as a power of two [m]."""
        return unit_of(self.reach_m)

    @cached_property
    def units(self) -> NDArray[np.float64]:
        """Of each coordinate: a radian, or ``unit_m`` of a slide, shape (nv,)."""
        return units_of(self.joints, self.unit_m)

    @cached_property
    def extents(self) -> NDArray[np.float64]:
        """The reach in units of each coordinate, shape (nv,)."""
        return self.reach_m / self.unit_m * self.units

    @cached_property
    def drive_trains(self) -> tuple[tuple[DriveLaw, NDArray[np.float64]], ...]:
        """Laws that stand on their own, each with the ratios of all drives to it, (1, drives)."""
        trains: list[tuple[DriveLaw, NDArray[np.float64]]] = []
        for column, drive in enumerate(self.drives):
            law: DriveLaw = drive.law
            ratio = 1.0
            while isinstance(law, Geared):
                ratio *= law.ratio
                law = law.of
            ratios = next((item for other, item in trains if other is law), None)
            if ratios is None:
                ratios = np.zeros((1, len(self.drives)))
                trains.append((law, ratios))
            ratios[0, column] = ratio
        return tuple(trains)

    @cached_property
    def drive_offsets(self) -> NDArray[np.float64]:
        """Offsets that make all driven coordinates zero at touch, shape (3, 1, drives).

        First axis: coordinate, rate and acceleration, the latter two being zero.
        """
        offsets = np.zeros((3, 1, len(self.drives)))
        offsets[0, 0] = [-drive.law_at_touch for drive in self.drives]
        return offsets

    @cached_property
    def drive_knots_rad(self) -> NDArray[np.float64]:
        """Cylinder angles at which a higher derivative of a law jumps [rad]."""
        return np.array([knot for law, _ in self.drive_trains for knot in law.knots_rad])

    @property
    def links(self) -> tuple[str, ...]:
        """Names of the moving links, in the order of their joints."""
        return tuple(joint.child for joint in self.joints)

    @cached_property
    def knots(self) -> tuple[tuple[int, tuple[float, ...]], ...]:
        """Coordinates on which a force is only piecewise smooth, each with where pieces meet.

        A force law may also have a kink where its rate changes sign.
        """
        tables = ((item.index, item.characteristic.coordinate) for item in self.tabulated_springs)
        laws = ((item.index, item.law.knots) for item in self.forces)
        return (*tables, *laws)

    def stop(self, name: str) -> Stop:
        """Return the stop of that name.

        Raises:
            UnknownNameError: No stop has this name.
            InputError: The name is empty, as that of the transition stop of a machine without one.
        """
        if not name:
            message = f"{self.name} has no stop, so nothing bounces: give it one ([stops.NAME])"
            raise InputError(message, model=self.name)
        for stop in self.stops:
            if stop.name == name:
                return stop
        raise UnknownNameError(
            kind="stop", name=name, known=(stop.name for stop in self.stops), where=self.name
        )

    def phase(self, number: int) -> Phase:
        """Return the phase of that number.

        Raises:
            UnknownNameError: No phase has this number.
        """
        for phase in self.phases:
            if phase.number == number:
                return phase
        known = (str(phase.number) for phase in self.phases)
        raise UnknownNameError(kind="phase", name=str(number), known=known, where=self.name)

    def phase_of(self, closed: frozenset[str]) -> Phase | None:
        """Return the phase with exactly these closed stops, or None if it has no name."""
        for phase in self.phases:
            if phase.closed == closed:
                return phase
        return None

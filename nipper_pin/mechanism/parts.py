"""The parts of a mechanism: joints, closures, drives, springs, stops, phases.

A mechanism is planar: side view, x forward, z up, y into the page. Angles are positive
counter-clockwise in that view, but for coordinates of hinges whose axis is +y in it. All
coordinates are zero in the *touch configuration*, where the lips just meet and the spring-loaded
joint stands on its stop.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, SupportsFloat

from ..arrays import FloatArray
from ..errors import ImpactError
from .laws import DriveLaw, RestitutionLaw

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

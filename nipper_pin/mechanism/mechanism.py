"""The immutable description of a mechanism that every later room reads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pinocchio as pin

from ..arrays import FloatArray
from ..errors import InputError, looked_up
from ..notebook import html
from ..terms.shown import counted
from ..tolerances.mechanics import CURVE_DEPARTURE
from ..units import MM_PER_M
from .cylinder import Cylinder
from .elements import Damper, Strut, TabulatedSpring
from .laws import DriveLaw, Geared, JointForce
from .parts import Closure, Coupling, Drive, Joint, Phase, Simultaneous, Spring, Start, Stop
from .scale import reach, unit_of, units_of


class Shared:
    """Stands for what machines have in common that only differ in numbers of forces and impacts."""


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
        urdf_as_read: The URDF text, but for ``masses``.
        masses: Masses of links that are not those of that text [kg].
        description: The TOML document as plain data, overrides applied.
        mesh_folder: Folder that relative mesh paths of the URDF start from.
        side_view: How the URDF was turned into the side view; empty where it stands in it.
        model: Pinocchio model of the tree; read only.
        inertias: Inertia of each link that has one of its own, in its frame.
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
    urdf_as_read: str
    masses: Mapping[str, float]
    description: Mapping[str, object]
    mesh_folder: str
    side_view: str
    model: pin.Model = field(repr=False, compare=False)
    inertias: Mapping[str, pin.Inertia] = field(repr=False, compare=False)

    def __repr__(self) -> str:
        """One line."""
        stops = ", ".join(stop.name for stop in self.stops)
        parts = {"joint": self.joints, "closure": self.closures, "drive": self.drives}
        counts = ", ".join(counted(len(items), noun) for noun, items in parts.items())
        return (
            f"<Mechanism {self.name}: {counts}, stops {stops or 'none'}, "
            f"mobility {self.degrees_of_freedom}>"
        )

    def _repr_html_(self) -> str:
        facts = {
            "links": ", ".join(self.links),
            "closures": ", ".join(item.name for item in self.closures) or "none",
            "drives": ", ".join(item.name for item in self.drives) or "none",
            "stops": ", ".join(f"{item.name} (e_N {item.restitution:g})" for item in self.stops)
            or "none",
            "mobility": self.degrees_of_freedom,
            "rated speed [r/min]": self.cylinder.rated_speed_rpm,
        }
        joints = [(item.name, item.kind, item.parent, item.child) for item in self.joints]
        title = f"{self.name}: {self.title}" if self.title else self.name
        return html(title, facts, ("joint", "kind", "parent", "child"), joints)

    @cached_property
    def urdf(self) -> str:
        """The URDF text."""
        if not self.masses:
            return self.urdf_as_read
        from .edit import apply_overrides

        masses = {f"links.{link}.mass_kg": mass for link, mass in self.masses.items()}
        return apply_overrides(self.description, self.urdf_as_read, masses, self.name)[1]

    @cached_property
    def shared(self) -> Shared:
        """Stands for all that other numbers of forces and impacts leave as it is."""
        return Shared()

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
        words = []
        for closure in self.closures:
            x, z = (MM_PER_M * value for value in closure.gap_m)
            if x or z:
                length = float(np.hypot(x, z))
                words.append(
                    f"closure {closure.name} by {length:.3g} mm (x {x:.3g}, z {z:.3g}) from "
                    f"{closure.first_side} to {closure.frame_b}, "
                    f"{length / MM_PER_M / self.reach_m:.2g} of the machine's reach"
                )
        if not words:
            return ""
        return (
            "loops that rounded numbers of the URDF leave open are closed at touch by moving the "
            f"frames that meet: {'; '.join(words)}"
        )

    @property
    def curves(self) -> str:
        """Which tables of springs bend away from the lines between their rows; empty if none does.

        A table that says how its rows are joined is not among them.
        """
        told = (
            f"the smooth curve of spring {item.name} leaves the straight line after row {row} by "
            f'{100.0 * share:.0f} % of the range of its forces: interpolation = "linear" joins '
            "rows by lines, more rows beside a kink keep the curve near them, and "
            'interpolation = "smooth" says that it is meant so'
            for item in self.tabulated_springs
            if item.characteristic.interpolation is None
            for share, row in [item.characteristic.departure]
            if share > CURVE_DEPARTURE
        )
        return "; ".join(told)

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
    def units(self) -> FloatArray:
        """Of each coordinate: a radian, or ``unit_m`` of a slide, shape (nv,)."""
        return units_of(self.joints, self.unit_m)

    @cached_property
    def extents(self) -> FloatArray:
        """The reach in units of each coordinate, shape (nv,)."""
        return self.reach_m / self.unit_m * self.units

    @cached_property
    def drive_trains(self) -> tuple[tuple[DriveLaw, FloatArray], ...]:
        """Laws that stand on their own, each with the ratios of all drives to it, (1, drives)."""
        trains: list[tuple[DriveLaw, FloatArray]] = []
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
    def drive_offsets(self) -> FloatArray:
        """Offsets that make all driven coordinates zero at touch, shape (3, 1, drives).

        First axis: coordinate, rate and acceleration, the latter two being zero.
        """
        offsets = np.zeros((3, 1, len(self.drives)))
        offsets[0, 0] = [-drive.law_at_touch for drive in self.drives]
        return offsets

    @cached_property
    def drive_knots_rad(self) -> FloatArray:
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
        return looked_up("stop", name, {stop.name: stop for stop in self.stops}, self.name)

    def phase(self, number: int) -> Phase:
        """Return the phase of that number.

        Raises:
            UnknownNameError: No phase has this number.
        """
        known = {str(phase.number): phase for phase in self.phases}
        return looked_up("phase", str(number), known, self.name)

    def phase_of(self, closed: frozenset[str]) -> Phase | None:
        """Return the phase with exactly these closed stops, or None if it has no name."""
        return next((phase for phase in self.phases if phase.closed == closed), None)

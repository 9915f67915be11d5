"""Assembly of a mechanism from its parts, with checks of the names that refer to one another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from ...errors import InputError, ModelError, UnknownNameError
from ...units import M_PER_MM, RAD_PER_DEG
from ..drives import DriveLaw
from ..files.describe import describe
from ..files.description import Description, StopDescription
from ..files.urdf import Urdf, check_urdf, flatten, parse_xml
from ..mechanism import Closure, Drive, Joint, Mechanism, Phase, Stop
from .contact import find_contact
from .drive_keys import check_drive
from .elements import build_elements
from .laws import build_cylinder, build_laws
from .slots import block_of, check_frames, with_blocks
from .starts import build_starts
from .touch_checks import check_assembly
from .tree import build_model, collision_geometry, joint_placements, tree_joints

if TYPE_CHECKING:
    from ..forces.law import JointForce
    from ..restitution.law import RestitutionLaw

_STOP_PLACES = {"prismatic": ("at_mm", M_PER_MM), "revolute": ("at_deg", RAD_PER_DEG)}
_REFLECTED = {"prismatic": "reflected_mass_kg", "revolute": "reflected_inertia_kg_m2"}
_ELASTIC = ("shaft_frequency_hz", "shaft_damping_ratio")


def build_mechanism(
    name: str, urdf_text: str, data: Mapping[str, object], mesh_folder: Path
) -> Mechanism:
    """Build and validate a mechanism.

    Args:
        name: Model name.
        urdf_text: The URDF.
        data: The TOML document, overrides applied and tables written out.
        mesh_folder: Folder that mesh files must lie in.

    Raises:
        UnknownNameError: A name in the data does not exist.
        ModelError: A value in the data cannot be used.
    """
    file, urdf_file = f"{name}.toml", f"{name}.urdf"
    description = describe(data, file)
    root = parse_xml(urdf_text, urdf_file)
    urdf = check_urdf(root, urdf_file, mesh_folder)
    if flatten(root):
        urdf_text = ElementTree.tostring(root, encoding="unicode")
    check_frames(description.closures, urdf, file)
    tree_text, urdf = with_blocks(urdf_text, urdf, description.closures, urdf_file)
    model = build_model(tree_text, description.gravity_m_s2, urdf_file)
    joints = tree_joints(model, urdf)
    by_name = {joint.name: joint for joint in joints}
    placements = joint_placements(model)
    laws = build_laws(description.drives, file)
    cylinder = build_cylinder(description, laws, file)
    closures = _closures(description)
    drives = _drives(description, laws, by_name, cylinder.angle_at_touch_rad, file)
    elements = build_elements(description, by_name, urdf, model, file)
    phases = _phases(description, file)
    geometry = None
    if any(stop.contact for stop in description.stops.values()):
        geometry = collision_geometry(model, urdf_text, urdf, mesh_folder, urdf_file)
    stops = _stops(description, by_name, model, placements, urdf, geometry, file, urdf_file)
    for key, path in description.shortcuts.items():
        _check_shortcut(key, path, data, urdf, file)
    check_assembly(
        closures,
        drives,
        stops,
        phases,
        joints=joints,
        urdf=urdf,
        model=model,
        placements=placements,
        degrees_of_freedom=description.degrees_of_freedom,
        file=file,
    )
    return Mechanism(
        name=name,
        title=description.title,
        joints=joints,
        closures=closures,
        drives=drives,
        springs=elements.springs,
        tabulated_springs=elements.tabulated_springs,
        dampers=elements.dampers,
        struts=elements.struts,
        forces=_forces(description, by_name, file),
        stops=stops,
        phases=phases,
        transition_stop=description.transition_stop,
        initial_phase=description.initial_phase,
        starts=build_starts(description.initial, by_name, drives, stops, file),
        cylinder=cylinder,
        gravity_m_s2=description.gravity_m_s2,
        shortcuts=dict(description.shortcuts),
        provenance=dict(description.provenance),
        urdf=urdf_text,
        description=dict(data),
        mesh_folder=str(mesh_folder),
        model=model,
    )


def _joint(name: str, joints: Mapping[str, Joint], where: str) -> Joint:
    """Look a tree joint up."""
    if name not in joints:
        raise UnknownNameError(kind="joint", name=name, known=joints, where=where)
    return joints[name]


def _closures(description: Description) -> tuple[Closure, ...]:
    """Cut joints; the pin of a slot is on its block."""
    return tuple(
        Closure(name=name, frame_a=closure.frame_a, frame_b=closure.frame_b)
        if closure.slot_axis is None
        else Closure(
            name=name,
            frame_a=block_of(name),
            frame_b=closure.frame_b,
            slot_frame=closure.frame_a,
            slot_axis=closure.slot_axis,
        )
        for name, closure in description.closures.items()
    )


def _drives(
    description: Description,
    laws: Mapping[str, DriveLaw],
    joints: Mapping[str, Joint],
    angle_at_touch_rad: float,
    file: str,
) -> tuple[Drive, ...]:
    """Driven joints, each driven once."""
    drives: list[Drive] = []
    for name, drive in description.drives.items():
        key = f"drives.{name}.joint"
        joint = _joint(drive.joint, joints, f"{file}: {key}")
        check_drive(name, drive, joint, file)
        if any(other.index == joint.index for other in drives):
            allowed = "a joint has one drive only"
            raise ModelError(file=file, key=key, value=drive.joint, allowed=allowed)
        shaft = {key: getattr(drive, key) for key in (_REFLECTED[joint.kind], *_ELASTIC)}
        inertia, frequency, ratio = (value or 0.0 for value in shaft.values())
        drives.append(
            Drive(
                name=name,
                index=joint.index,
                law=laws[name],
                law_at_touch=float(laws[name].evaluate(np.array([angle_at_touch_rad]))[0][0]),
                reflected_inertia=inertia,
                shaft_frequency_hz=frequency,
                shaft_damping_ratio=ratio,
                missing=tuple(key for key, value in shaft.items() if value is None),
            )
        )
    return tuple(drives)


def _stops(
    description: Description,
    joints: Mapping[str, Joint],
    model: pin.Model,
    placements: list[pin.SE3],
    urdf: Urdf,
    geometry: pin.GeometryModel | None,
    file: str,
    urdf_file: str,
) -> tuple[Stop, ...]:
    """Stops on joints that no drive moves, at most two to a joint, contacts found."""
    stops: list[Stop] = []
    driven = {drive.joint for drive in description.drives.values()}
    for name, stop in description.stops.items():
        key = f"stops.{name}.joint"
        joint = _joint(stop.joint, joints, f"{file}: {key}")
        if stop.joint in driven:
            allowed = "a joint without a drive"
            raise ModelError(file=file, key=key, value=stop.joint, allowed=allowed)
        sense = 1.0 if stop.side == "lower" else -1.0
        place = _stop_place(name, stop, joint, file)
        contact = None
        if stop.contact is not None:
            contact = find_contact(
                stop.contact,
                urdf.joints[stop.joint],
                model,
                placements,
                urdf,
                geometry,
                key=f"stops.{name}.contact",
                file=file,
                urdf_file=urdf_file,
                sense=sense,
                at=place,
            )
        found = Stop(
            name=name,
            index=joint.index,
            restitution=stop.restitution,
            law=_restitution_law(name, stop, joint, file),
            contact=contact,
            sense=sense,
            at=place,
        )
        _check_opposite(found, [item for item in stops if item.index == joint.index], joint, file)
        stops.append(found)
    if description.stops and not description.transition_stop:
        allowed = (
            "the stop whose bouncing is the transition, where there is any: "
            f"{', '.join(description.stops)}"
        )
        raise ModelError(file=file, key="transition_stop", value=None, allowed=allowed)
    if description.stops and description.transition_stop not in description.stops:
        raise UnknownNameError(
            kind="stop",
            name=description.transition_stop,
            known=description.stops,
            where=f"{file}: transition_stop",
        )
    return tuple(stops)


def _forces(
    description: Description, joints: Mapping[str, Joint], file: str
) -> tuple[JointForce, ...]:
    """Build the force elements with a registered law."""
    if not description.forces:
        return ()
    from .forces import build_forces

    return build_forces(description.forces, joints, file)


def _restitution_law(
    name: str, stop: StopDescription, joint: Joint, file: str
) -> RestitutionLaw | None:
    """Return the restitution law of a stop by the rate; None for a constant."""
    if stop.restitution_law is None:
        return None
    try:
        law: RestitutionLaw = stop.restitution_law.build(joint.kind)
    except InputError as error:
        key = str(error.evidence.get("key", "law"))
        value = getattr(stop.restitution_law, key, None)
        where = f"stops.{name}.restitution_law.{key}"
        raise ModelError(file=file, key=where, value=value, allowed=error.message) from error
    return law


def _stop_place(name: str, stop: StopDescription, joint: Joint, file: str) -> float:
    """Coordinate at which a stop is closed [rad or m]."""
    key, scale = _STOP_PLACES[joint.kind]
    for other, _ in _STOP_PLACES.values():
        value = getattr(stop, other)
        if other != key and value is not None:
            allowed = f"the place of a stop on the {joint.kind} joint {joint.name} is {key}"
            raise ModelError(file=file, key=f"stops.{name}.{other}", value=value, allowed=allowed)
    if stop.adjusted is None:
        return scale * (getattr(stop, key) or 0.0)
    where = f"stops.{name}.adjusted"
    if getattr(stop, key) is not None:
        allowed = f"either {key} or adjusted: a stop has one place"
        raise ModelError(
            file=file, key=f"stops.{name}.{key}", value=getattr(stop, key), allowed=allowed
        )
    try:
        place: float = stop.adjusted.place(joint.kind)
    except InputError as error:
        key = str(error.evidence.get("key", "law"))
        value = getattr(stop.adjusted, key, None)
        raise ModelError(
            file=file, key=f"{where}.{key}", value=value, allowed=error.message
        ) from error
    return place


def _check_opposite(stop: Stop, others: Sequence[Stop], joint: Joint, file: str) -> None:
    """Refuse two stops of a joint of which the lower one is not below the upper one."""
    for other in others:
        allowed = ""
        if other.sense == stop.sense:
            allowed = (
                f"one lower and one upper stop on a joint; {other.name!r} is on this side of "
                f"{joint.name} already"
            )
        elif stop.sense * (other.at - stop.at) <= 0.0:
            allowed = (
                f"the lower stop below the upper one: {joint.name} has no room to move between "
                f"{stop.name!r} and {other.name!r}"
            )
        if allowed:
            raise ModelError(
                file=file,
                key=f"stops.{stop.name}",
                value=f"{'lower' if stop.sense > 0.0 else 'upper'} stop at {stop.at:g}",
                allowed=allowed,
            )


def _phases(description: Description, file: str) -> tuple[Phase, ...]:
    """Return the phases; numbers and sets of closed stops must differ."""
    phases: list[Phase] = []
    for place, phase in enumerate(description.phases):
        key = f"phases[{place}]"
        for stop in phase.closed:
            if stop not in description.stops:
                raise UnknownNameError(
                    kind="stop", name=stop, known=description.stops, where=f"{file}: {key}.closed"
                )
        if any(other.number == phase.number for other in phases):
            allowed = "each phase has a number of its own"
            raise ModelError(file=file, key=f"{key}.number", value=phase.number, allowed=allowed)
        closed = frozenset(phase.closed)
        if any(other.closed == closed for other in phases):
            allowed = "each phase is a different set of closed stops"
            raise ModelError(file=file, key=f"{key}.closed", value=sorted(closed), allowed=allowed)
        phases.append(Phase(number=phase.number, name=phase.name, closed=closed))
    numbers = [phase.number for phase in phases]
    if description.initial_phase not in numbers:
        allowed = f"the number of a phase: {', '.join(map(str, numbers))}"
        raise ModelError(
            file=file, key="initial_phase", value=description.initial_phase, allowed=allowed
        )
    return tuple(phases)


def _check_shortcut(key: str, path: str, data: Mapping[str, object], urdf: Urdf, file: str) -> None:
    """Refuse a shortcut that is not the path of a number."""
    value: object = data
    steps = path.split(".")
    if steps[0] == "links" and len(steps) == 3 and steps[1] in urdf.links:
        return
    for step in steps:
        if not isinstance(value, Mapping) or step not in value:
            known = value if isinstance(value, Mapping) else ()
            raise UnknownNameError(
                kind="key", name=step, known=known, where=f"{file}: shortcuts.{key} = {path!r}"
            )
        value = value[step]
    if isinstance(value, bool) or not isinstance(value, int | float):
        allowed = "the path of a number"
        raise ModelError(file=file, key=f"shortcuts.{key}", value=path, allowed=allowed)

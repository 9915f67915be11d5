"""Assembly of a mechanism from its parts, with checks of the names that refer to one another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from ...errors import ModelError, UnknownNameError, looked_up
from ..drives import DriveLaw
from ..files.describe import describe
from ..files.description import Description
from ..files.toml_text import need_plain_text
from ..files.urdf import check_urdf
from ..files.urdf_parts import Urdf, side_view_text
from ..files.xml_text import parse_xml
from ..mechanism import Mechanism
from ..parallel import together
from ..parts import Closure, Coupling, Drive, Joint, Phase, Stop
from .closures import block_of, check_frames, close_gaps, with_blocks
from .elements import build_elements, build_forces
from .laws import OF_SHAFT, build_cylinder, build_laws, check_drive
from .parallel import with_leaders
from .placements import joint_placements
from .stops import build_starts, build_stops
from .touch_checks import check_assembly, held_by
from .tree import Tree, build_model, collision_geometry, tree_joints

_ELASTIC = ("shaft_frequency_hz", "shaft_damping_ratio")


def build_mechanism(
    name: str, urdf_text: str, data: Mapping[str, object], mesh_folder: Path
) -> Mechanism:
    """Build and validate a mechanism.

    Args:
        data: The TOML document, overrides applied and tables written out.
    """
    file = f"{name}.toml"
    need_plain_text(name, file, "name of the model")
    need_plain_text(data, file)
    description = describe(data, file)
    tree = _tree(name, urdf_text, description, mesh_folder)
    by_name = {joint.name: joint for joint in tree.joints}
    laws = build_laws(description.drives, by_name, file)
    cylinder = build_cylinder(description, laws, file)
    drives = _drives(description, laws, by_name, cylinder.angle_at_touch_rad, file)
    elements = build_elements(description, by_name, tree.urdf, tree.model, file)
    couplings = _couplings(tree.urdf, by_name)
    stops = build_stops(description, by_name, tree)
    _check_shortcuts(description.shortcuts, data, tree.urdf, file)
    closures = close_gaps(_closures(description), stops, tree)
    held = with_leaders(held_by(tree, closures, couplings, drives, stops))
    phases = _phases(description, held.stops, file)
    check_assembly(tree, held, phases, description.degrees_of_freedom)
    return Mechanism(
        name=name,
        title=description.title,
        joints=tree.joints,
        closures=closures,
        couplings=couplings,
        drives=drives,
        **elements,
        forces=build_forces(description.forces, by_name, file),
        stops=held.stops,
        phases=phases,
        simultaneous=description.simultaneous,
        transition_stop=description.transition_stop,
        initial_phase=description.initial_phase,
        starts=build_starts(description.initial, by_name, drives, stops, file),
        cylinder=cylinder,
        gravity_m_s2=description.gravity_m_s2 * tree.urdf.plane.steepness,
        shortcuts=dict(description.shortcuts),
        provenance=dict(description.provenance),
        urdf_as_read=urdf_text,
        masses={},
        description=dict(data),
        mesh_folder=str(mesh_folder),
        side_view=side_view_text(tree.urdf),
        model=tree.model,
        inertias=_inertias(tree.urdf, closures),
    )


def _tree(name: str, urdf_text: str, description: Description, mesh_folder: Path) -> Tree:
    """Build the tree."""
    file, urdf_file = f"{name}.toml", f"{name}.urdf"
    urdf = check_urdf(parse_xml(urdf_text, urdf_file), urdf_file, mesh_folder)
    check_frames(description.closures, urdf, file)
    urdf = with_blocks(urdf, description.closures)
    model = build_model(urdf, description.gravity_m_s2 * urdf.plane.steepness, urdf_file)
    model.name = name
    geometry = pin.GeometryModel()
    if any(stop.contact for stop in description.stops.values()):
        geometry = collision_geometry(model, urdf, urdf_file)
    joints, placements = tree_joints(model, urdf), joint_placements(model)
    return Tree(model, joints, placements, urdf, geometry, file, urdf_file)


def _inertias(urdf: Urdf, closures: Sequence[Closure]) -> dict[str, pin.Inertia]:
    """Inertias of the links of the file; the blocks of slots are none of them."""
    blocks = {block_of(item.name) for item in closures if item.slot_frame}
    return {
        name: link.inertia
        for name, link in urdf.links.items()
        if link.inertia is not None and name not in blocks
    }


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


def _couplings(urdf: Urdf, joints: Mapping[str, Joint]) -> tuple[Coupling, ...]:
    """Joints that follow others."""
    return tuple(
        Coupling(name=name, index=joint.index, of=joints[mimic[0]].index, multiplier=mimic[1])
        for name, joint in joints.items()
        if (mimic := urdf.joints[name].mimic) is not None
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
        joint = looked_up("joint", drive.joint, joints, f"{file}: {key}")
        check_drive(name, drive, joint, file)
        if any(other.index == joint.index for other in drives):
            allowed = "a joint has one drive only"
            raise ModelError(file=file, key=key, value=drive.joint, allowed=allowed)
        shaft = {key: getattr(drive, key) for key in (OF_SHAFT[joint.kind], *_ELASTIC)}
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


def _phases(description: Description, stops: Sequence[Stop], file: str) -> tuple[Phase, ...]:
    """Return the phases; numbers and sets of closed stops must differ.

    What closes together with a stop of a phase belongs to it.
    """
    phases: list[Phase] = []
    for place, phase in enumerate(description.phases):
        key = f"phases[{place}]"
        for stop in phase.closed:
            looked_up("stop", stop, description.stops, f"{file}: {key}.closed")
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
    return tuple(replace(item, closed=together(stops, item.closed)) for item in phases)


def _check_shortcuts(
    shortcuts: Mapping[str, str], data: Mapping[str, object], urdf: Urdf, file: str
) -> None:
    """Refuse shortcuts that are not paths of numbers."""
    for key, path in shortcuts.items():
        steps = path.split(".")
        if steps[0] == "links" and len(steps) == 3 and steps[1] in urdf.links:
            continue
        value: object = data
        for step in steps:
            if not isinstance(value, Mapping) or step not in value:
                known = value if isinstance(value, Mapping) else ()
                where = f"{file}: shortcuts.{key} = {path!r}"
                raise UnknownNameError(kind="key", name=step, known=known, where=where)
            value = value[step]
        if isinstance(value, bool) or not isinstance(value, int | float):
            allowed = "the path of a number"
            raise ModelError(file=file, key=f"shortcuts.{key}", value=path, allowed=allowed)

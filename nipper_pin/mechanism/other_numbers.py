"""Numbers of a mechanism by path: read, and changed.

What other numbers do not touch is kept, with all that was built of it.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import pinocchio as pin

from ..errors import AssemblyError
from .load import from_sources, with_advice
from .mechanism import Mechanism

if TYPE_CHECKING:
    from .edit import Layout

# Numbers on which neither the tree nor its closures and places of stops depend.
_OF_FORCES = {
    "springs": (
        "stiffness_N_per_m",
        "stiffness_N_m_per_rad",
        "preload_length_mm",
        "preload_deg",
        "free_length_mm",
    ),
    "dampers": ("damping_N_s_per_m", "damping_N_m_s_per_rad"),
    "stops": ("restitution",),
}
_BODY = pin.FrameType.BODY


def number_of(mechanism: Mechanism, path: str) -> float:
    """A number of a mechanism by its path; see :func:`numbers_of`."""
    return numbers_of(mechanism, [path])[0]


def numbers_of(mechanism: Mechanism, paths: Iterable[str]) -> tuple[float, ...]:
    """Numbers of a mechanism by their paths, in the units of its files.

    Args:
        paths: The paths, as overrides take them.

    Raises:
        UnknownNameError: A path leads nowhere.
        ModelError: There is no number.
    """
    from .edit import HEADS, number_at, read_dimension

    layout = None
    found = []
    for path in paths:
        if path.partition(".")[0] in HEADS:
            layout = layout or layout_of(mechanism)
            found.append(read_dimension(layout, path))
        else:
            found.append(number_at(mechanism.description, path, f"{mechanism.name}.toml"))
    return tuple(found)


def layout_of(mechanism: Mechanism) -> Layout:
    """Where links and points of a mechanism stand at touch."""
    from .edit import read_layout
    from .files import parse_xml

    file = f"{mechanism.name}.urdf"
    return read_layout(parse_xml(mechanism.urdf, file), mechanism.description, file)


def changed(mechanism: Mechanism, values: Mapping[str, object]) -> Mechanism:
    """The mechanism with other numbers; itself is left as it is.

    Numbers of springs and dampers, restitutions and masses take some 0.03 ms; but for masses, runs
    with them share what is built for the tree. With others the mechanism is built again from its
    own texts.

    Args:
        mechanism: The mechanism; one of a saved run needs no model folder for it.
        values: New values by path or shortcut, as in `load`.

    Returns:
        The mechanism that `load` gives with these overrides, its description among it.

    Raises:
        UnknownNameError: A path leads nowhere.
        ModelError: A value cannot be used.
        AssemblyError: The closures do not meet at touch.
    """
    from .edit import apply_overrides, by_path

    name, data = mechanism.name, mechanism.description
    paths = by_path(values, data, f"{name}.toml")
    masses = _masses(mechanism, paths)
    others = {path: value for path, value in paths.items() if path not in masses}
    entries = _entries_of_forces(mechanism, others)
    if entries is not None:
        made = _with_forces(mechanism, others, entries)
        return _with_masses(made, dict(masses.values())) if masses else made
    try:
        document, urdf = apply_overrides(data, mechanism.urdf, paths, name)
        return from_sources(name, urdf, document, mechanism.mesh_folder)
    except AssemblyError as error:
        raise with_advice(error, paths) from None


def retuned(
    mechanism: Mechanism,
    *,
    restitution: Mapping[str, float] | None = None,
    stiffness: Iterable[float] | None = None,
    preload: Iterable[float] | None = None,
) -> Mechanism:
    """The mechanism with other restitutions and linear springs; its description is not changed.

    Args:
        restitution: e_N of stops by their names; the others keep theirs.
        stiffness: Of its springs, in their order [N/m or N m/rad].
        preload: Deflections in them at zero [m or rad].
    """
    e_N, springs = restitution or {}, mechanism.springs
    rates = [spring.stiffness for spring in springs] if stiffness is None else stiffness
    bent = [spring.preload for spring in springs] if preload is None else preload
    return _sharing(
        mechanism,
        springs=tuple(
            replace(spring, stiffness=float(k), preload=float(p))
            for spring, k, p in zip(springs, rates, bent, strict=True)
        ),
        stops=tuple(
            replace(stop, restitution=e_N[stop.name]) if stop.name in e_N else stop
            for stop in mechanism.stops
        ),
    )


def _entries_of_forces(
    mechanism: Mechanism, paths: Mapping[str, object]
) -> list[tuple[str, str]] | None:
    """Section and name of each spring, damper and stop; None if a path leads to anything else."""
    from .edit.paths import steps_of

    found = []
    for path in paths:
        steps = steps_of(path)
        if len(steps) != 3 or steps[2] not in _OF_FORCES.get(steps[0], ()):
            return None
        section, name, _ = steps
        entries = mechanism.description.get(section)
        if not (isinstance(entries, Mapping) and name in entries):
            return None
        # Which of the stops that close together leads them depends on their restitutions.
        if section == "stops" and any(stop.leader for stop in mechanism.stops):
            return None
        found.append((section, name))
    return found


def _with_forces(
    mechanism: Mechanism, paths: Mapping[str, object], entries: Iterable[tuple[str, str]]
) -> Mechanism:
    """The mechanism with other numbers of springs, dampers and stops."""
    from .build.elements import FIELDS, build_element
    from .edit.paths import replace_value
    from .files.describe import describe_entry

    file = f"{mechanism.name}.toml"
    document: dict[str, Any] = dict(mechanism.description)
    for section, name in entries:
        document[section] = {**document[section], name: dict(document[section][name])}
    for path, value in paths.items():
        replace_value(document, path, value, file)
    joints = {joint.name: joint for joint in mechanism.joints}
    parts: dict[str, tuple[Any, ...]] = {}
    for section, name in dict.fromkeys(entries):
        entry = describe_entry(document, section, name, file)
        new: Any
        if section == "stops":
            field, new = section, replace(mechanism.stop(name), restitution=entry.restitution)
        else:
            new = build_element(entry, name, joints, mechanism.model, file)
            field = FIELDS[type(new)]
        known = parts.get(field, getattr(mechanism, field))
        parts[field] = tuple(new if _is_one(item, new) else item for item in known)
    return _sharing(mechanism, description=document, **parts)


def _masses(mechanism: Mechanism, paths: Mapping[str, object]) -> dict[str, tuple[str, float]]:
    """Links and their masses [kg] by the paths that give such; what cannot be one is left out."""
    from .edit import LARGEST
    from .edit.paths import number_from

    found = {}
    for path, value in paths.items():
        head, _, rest = path.partition(".")
        link, _, key = rest.rpartition(".")
        if (head, key) == ("links", "mass_kg") and link in mechanism.inertias:
            mass = number_from(value, path, f"{mechanism.name}.urdf")
            if 0.0 < mass <= LARGEST:
                found[path] = link, mass
    return found


def _with_masses(mechanism: Mechanism, masses: Mapping[str, float]) -> Mechanism:
    """The mechanism with other masses of links, their centres and inertias as they were."""
    model, inertias = mechanism.model.copy(), dict(mechanism.inertias)
    for link, mass in masses.items():
        before = inertias[link]
        inertias[link] = pin.Inertia(mass, before.lever, before.inertia)
    places = [item for item in model.frames if item.name in inertias and item.type == _BODY]
    # Links that are fixed to one another are one body, added up as where the tree is built.
    for body in {item.parentJoint for item in places if item.name in masses}:
        whole = pin.Inertia.Zero()
        for place in places:
            if place.parentJoint == body:
                whole += place.placement.act(inertias[place.name])
        model.inertias[body] = whole
    made = copy.copy(mechanism)
    for known in ("urdf", "shared"):
        vars(made).pop(known, None)
    vars(made).update(model=model, inertias=inertias, masses={**mechanism.masses, **masses})
    return made


def _is_one(item: Any, new: Any) -> bool:
    """Whether two parts of one field are the same, with other numbers; struts are of two kinds."""
    return item.name == new.name and getattr(item, "kind", "") == getattr(new, "kind", "")


def _sharing(mechanism: Mechanism, **parts: object) -> Mechanism:
    """The mechanism with other parts on the same tree, with which all that is known of it stays."""
    # Looked up before the copy, which then has the same one.
    _ = mechanism.shared
    made = copy.copy(mechanism)
    vars(made).update(parts)
    return made

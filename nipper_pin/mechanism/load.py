"""From model files to a validated mechanism.

Parsers and schemas are imported by the functions that read a model: together they take as long as
a load itself, so importing the package alone does not import them.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin

from ..errors import AssemblyError, InputError, ModelError
from .mechanism import Mechanism
from .model_files import find_files, read_model_text


def load(model: str | Path = "e62", overrides: Mapping[str, object] | None = None) -> Mechanism:
    """Load a model.

    Args:
        model: Name of a model that comes with the package; or a folder that holds
            ``<folder>.urdf`` and ``<folder>.toml``, or one URDF and one TOML file of any names; or
            the path of the TOML file. A TOML file that draws the machine needs no URDF.
        overrides: New values by path, for example ``{"stops.jaw.restitution": 0.1}``,
            ``{"links.top_nipper.mass_kg": 1.3}`` or ``{"points.rod_pin.x_mm": -20.0}``
            or by the model's shortcuts, ``{"restitution": 0.1}``; strings are
            converted.

    Returns:
        The validated mechanism.

    Raises:
        UnknownNameError: The model, or a name in it or in an override, does not exist.
        ModelError: A value in a file or override cannot be used.
        AssemblyError: The closures do not meet at touch.
    """
    from .build.mechanism import build_mechanism
    from .files.csv_tables import inline_tables
    from .files.describe import in_known_units
    from .files.toml_text import read_toml
    from .files.xml_text import as_unicode, encoding_of

    found = find_files(model)
    folder, name = found.folder, found.name
    urdf_file, toml_file = f"{name}.urdf", f"{name}.toml"
    try:
        data = read_toml(read_model_text(found.toml), toml_file)
        if found.urdf is not None and "drawing" in data:
            allowed = f"one of them: {toml_file} draws a machine, {urdf_file} is another"
            raise ModelError(file=toml_file, key="drawing", value=data["drawing"], allowed=allowed)
        if found.urdf is None:
            from .drawing.document import drawn_sources

            urdf, data = drawn_sources(data, name)
        else:
            urdf = as_unicode(read_model_text(found.urdf, encoding_of))
            data = in_known_units(data, toml_file)
        if overrides:
            from .edit import apply_overrides, by_path, with_tables

            data, others = with_tables(data, by_path(overrides, data, toml_file), folder, toml_file)
            data, urdf = apply_overrides(data, urdf, others, name)
        else:
            data = inline_tables(data, folder, toml_file)
        return build_mechanism(name, urdf, data, folder)
    except InputError as error:
        raise found.named(with_advice(error, overrides or {})) from None


def need_mechanism(value: object, call: str) -> None:
    """Refuse what is no mechanism, above all a model's name.

    Args:
        call: Its public name, for the message.

    Raises:
        InputError: It is no mechanism.
    """
    if isinstance(value, Mechanism):
        return
    if isinstance(value, str | Path):
        name = str(value)
        message = f"{call} takes a loaded model: {call}(nip.load({name!r}), ...), not {name!r}"
        raise InputError(message, value=name)
    message = f"{call} takes what nip.load gives, and this is of type {type(value).__name__}"
    raise InputError(message, value=value)


def from_sources(
    name: str, urdf: str, description: Mapping[str, object], mesh_folder: str | Path
) -> Mechanism:
    """Rebuild a mechanism from its plain data, for saved runs and worker processes.

    Raises:
        UnknownNameError: A name in the data does not exist.
        ModelError: A value in the data cannot be used.
    """
    from .build.mechanism import build_mechanism
    from .files.csv_tables import inline_tables

    folder = Path(mesh_folder)
    data = inline_tables(copy.deepcopy(dict(description)), folder, f"{name}.toml")
    return build_mechanism(name, urdf, data, folder)


def need_as_written(mechanism: Mechanism) -> None:
    """Refuse a mechanism that is not the one of its own texts, which are what is saved of it.

    Raises:
        InputError: Parts of it were replaced; names them.
    """
    name = mechanism.name
    written = from_sources(name, mechanism.urdf, mechanism.description, mechanism.mesh_folder)
    replaced = [
        item.name
        for item in fields(mechanism)
        # Two parts of one text.
        if item.name not in ("urdf_as_read", "masses")
        and not _alike(getattr(mechanism, item.name), getattr(written, item.name))
    ]
    if replaced:
        message = (
            f"{', '.join(replaced)} of this mechanism {'is' if len(replaced) == 1 else 'are'} not "
            "what its texts say, and these are what is saved: change numbers by their paths, "
            f'nip.load({name!r}, {{"springs.NAME.stiffness_N_per_m": 9000.0}}), and simulate that'
        )
        raise InputError(message, replaced=replaced)


def _alike(one: object, other: object) -> bool:
    """Whether two parts of a mechanism are equal; laws that cannot tell are if of one class."""
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_alike, one, other))
    if type(one) is not type(other):
        return False
    if is_dataclass(one):
        names = [item.name for item in fields(one) if item.compare]
        return all(_alike(getattr(one, key), getattr(other, key)) for key in names)
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return np.array_equal(one, other)
    return type(one).__eq__ is object.__eq__ or bool(one == other)


def with_advice(error: InputError, overrides: Mapping[str, object]) -> InputError:
    """Say how a dimension is changed without opening a pin, if one of the overrides may have."""
    raw = [path for path in overrides if path.startswith("urdf.joint.")]
    if not (raw and isinstance(error, AssemblyError)):
        return error
    advice = (
        f"{', '.join(raw)} moves one side of a pin only: points.<hinge or frame>.x_mm, z_mm, "
        "radius_mm and angle_deg move everything that meets in it"
    )
    evidence = error.evidence
    return AssemblyError(**{**evidence, "allowed": f"{evidence['allowed']}; {advice}"})


def collision_model(mechanism: Mechanism) -> tuple[pin.GeometryModel, dict[str, tuple[str, ...]]]:
    """Collision shapes of a mechanism, for checks of clearance.

    Returns:
        Geometry model without any collision pairs, its objects named like the collision elements
        of the URDF, and these names by link.
    """
    # The URDF is read again here, and a run that looks at no shape needs no parser.
    from .build.tree import collision_geometry
    from .files import parse_xml
    from .files.urdf import check_urdf

    file, folder = f"{mechanism.name}.urdf", Path(mechanism.mesh_folder)
    urdf = check_urdf(parse_xml(mechanism.urdf, file), file, folder)
    geometry = collision_geometry(mechanism.model, urdf, file)
    return geometry, dict(urdf.shapes)

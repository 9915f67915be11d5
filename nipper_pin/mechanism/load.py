"""From model files to a validated mechanism.

Parsers and schemas are imported by the functions that read a model: together they take as long as
a load itself, so importing the package alone does not import them.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from pathlib import Path

from ..errors import AssemblyError, InputError, ModelError, UnknownNameError
from ..texts import MOST_TEXT, read_text
from .mechanism import Mechanism


def load(model: str | Path = "e62", overrides: Mapping[str, object] | None = None) -> Mechanism:
    """Load a model.

    Args:
        model: Name of a model that comes with the package, or a folder ``<name>`` that holds
            ``<name>.urdf`` and ``<name>.toml``, or the path of that TOML file.
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
    from .files.toml_text import read_toml
    from .files.xml_text import as_unicode, encoding_of

    folder = find_model(model)
    name = folder.name
    urdf_file, toml_file = f"{name}.urdf", f"{name}.toml"
    urdf = as_unicode(_read(folder / urdf_file, encoding_of))
    data = read_toml(_read(folder / toml_file), toml_file)
    if overrides:
        from .edit.overrides import apply_overrides, by_path, with_tables

        data, others = with_tables(data, by_path(overrides, data, toml_file), folder, toml_file)
        data, urdf = apply_overrides(data, urdf, others, toml_file, urdf_file)
    else:
        data = inline_tables(data, folder, toml_file)
    try:
        return build_mechanism(name, urdf, data, folder)
    except AssemblyError as error:
        raise _with_advice(error, overrides or {}) from None


def number_of(mechanism: Mechanism, path: str) -> float:
    """A number of a mechanism by its path, in the unit of its file.

    Args:
        mechanism: The mechanism.
        path: The path, as overrides take it.

    Raises:
        UnknownNameError: The path leads nowhere.
        ModelError: There is no number.
    """
    from .edit.dimensions import HEADS, read_dimension
    from .edit.layout import read_layout
    from .edit.toml_paths import number_at
    from .files.urdf import parse_xml

    if path.partition(".")[0] not in HEADS:
        return number_at(mechanism.description, path, f"{mechanism.name}.toml")
    file = f"{mechanism.name}.urdf"
    layout = read_layout(parse_xml(mechanism.urdf, file), mechanism.description, file)
    return read_dimension(layout, path, file)


def need_mechanism(value: object, call: str) -> None:
    """Refuse what is no mechanism, above all a model's name.

    Args:
        value: What a function was given.
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

    Args:
        name: Model name.
        urdf: The URDF text.
        description: The TOML document as plain data.
        mesh_folder: Folder that relative mesh paths of the URDF start from.

    Raises:
        UnknownNameError: A name in the data does not exist.
        ModelError: A value in the data cannot be used.
    """
    from .build.mechanism import build_mechanism
    from .files.csv_tables import inline_tables

    folder = Path(mesh_folder)
    data = inline_tables(copy.deepcopy(dict(description)), folder, f"{name}.toml")
    return build_mechanism(name, urdf, data, folder)


def with_numbers(mechanism: Mechanism, overrides: Mapping[str, object]) -> Mechanism:
    """The same mechanism with other numbers, built again from its own texts.

    Args:
        mechanism: The mechanism; one of a saved run needs no model folder for it.
        overrides: New values by path or shortcut, as in :func:`load`.

    Raises:
        UnknownNameError: A path leads nowhere.
        ModelError: A value cannot be used.
        AssemblyError: The closures do not meet at touch.
    """
    from .edit.overrides import apply_overrides, by_path

    name, data = mechanism.name, mechanism.description
    toml_file, urdf_file = f"{name}.toml", f"{name}.urdf"
    values = by_path(overrides, data, toml_file)
    changed, urdf = apply_overrides(data, mechanism.urdf, values, toml_file, urdf_file)
    try:
        return from_sources(name, urdf, changed, mechanism.mesh_folder)
    except AssemblyError as error:
        raise _with_advice(error, values) from None


def _with_advice(error: AssemblyError, overrides: Mapping[str, object]) -> AssemblyError:
    """Say how a dimension is changed without opening a pin, if one of the overrides may have."""
    raw = [path for path in overrides if path.startswith("urdf.joint.")]
    if not raw:
        return error
    advice = (
        f"{', '.join(raw)} moves one side of a pin only: points.<hinge or frame>.x_mm, z_mm, "
        "radius_mm and angle_deg move everything that meets in it"
    )
    evidence = error.evidence
    return AssemblyError(**{**evidence, "allowed": f"{evidence['allowed']}; {advice}"})


def known_models() -> dict[str, Path]:
    """Folders of the models that come with the package, by name."""
    package = Path(__file__).resolve().parent.parent
    # Packaged, the models lie inside the package; in a source checkout they lie beside it.
    for home in (package / "models", package.parent / "models"):
        if home.is_dir():
            return {
                item.name: item
                for item in sorted(home.iterdir())
                if (item / f"{item.name}.toml").is_file()
            }
    return {}


def model_folder(name: str, planned: str | Path) -> Path:
    """Folder of a model that was saved; on another machine that of the model which comes with it.

    Args:
        name: Model name.
        planned: Its folder where it was saved.
    """
    folder = Path(planned)
    return folder if folder.is_dir() else known_models().get(name, folder)


def find_model(model: str | Path) -> Path:
    """Folder of a model.

    Args:
        model: Name of a known model, or path of a folder or of the TOML file in it.

    Raises:
        UnknownNameError: There is no such model or folder.
        ModelError: The folder lacks one of the two files, or is not called like its TOML file.
    """
    known = known_models()
    if isinstance(model, str) and model in known:
        return known[model]
    try:
        folder = Path(model).resolve()
        if folder.suffix == ".toml" and folder.is_file():
            folder = _folder_of(folder)
        found = folder.is_dir()
    except (OSError, RuntimeError, ValueError) as error:
        # Links in a circle, or a name that no file can have.
        raise UnknownNameError(
            kind="model or model folder", name=str(model), known=known, where=str(error)
        ) from error
    if not found:
        raise UnknownNameError(kind="model or model folder", name=str(model), known=known)
    for suffix in (".urdf", ".toml"):
        if not (folder / f"{folder.name}{suffix}").is_file():
            inside = ", ".join(sorted(item.name for item in folder.iterdir())) or "nothing"
            raise ModelError(
                file=str(folder),
                key=f"{folder.name}{suffix}",
                value=None,
                allowed=f"a model folder holds <name>.urdf and <name>.toml, <name> being the name "
                f"of the folder; found {inside}",
            )
    return folder


def _folder_of(file: Path) -> Path:
    """The model folder that a TOML file lies in, which has its name.

    Raises:
        ModelError: It has another one, so that the file would not be the one that is read.
    """
    if file.stem != file.parent.name:
        raise ModelError(
            file=str(file),
            key="folder",
            value=file.parent.name,
            allowed=f"a folder called {file.stem}, with {file.stem}.urdf beside the TOML file",
        )
    return file.parent


def _read(path: Path, encoding: str | Callable[[bytes], str] = "utf-8-sig") -> str:
    """Read a text file."""
    try:
        return read_text(path, MOST_TEXT, encoding)
    except (OSError, UnicodeError, LookupError) as error:
        allowed = "a readable UTF-8 file"
        if not isinstance(encoding, str):
            allowed = "a readable file in the encoding that its first line declares, or in UTF-8"
        raise ModelError(file=path.name, key="text", value=str(error), allowed=allowed) from error

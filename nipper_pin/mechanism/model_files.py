"""Folders of models: where the two files are, and writing them complete or not at all."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from ..errors import InputError, ModelError, UnknownNameError, with_words
from ..texts import MOST_TEXT, followed, no_file, read_text

# Drawings of the working directory that are named where a model is not there.
_MOST = 20


@dataclass(frozen=True)
class ModelFiles:
    """The files of a model.

    Attributes:
        name: Name of the model: that of its folder, or of a TOML file that was asked for.
        urdf: The URDF; None if the TOML file draws the machine.
        toml: The TOML file.
    """

    name: str
    urdf: Path | None
    toml: Path

    @property
    def folder(self) -> Path:
        """The folder that both lie in, and meshes and tables with them."""
        return self.toml.parent

    def named(self, error: InputError) -> InputError:
        """The error with the files called by their names."""
        names = {f"{self.name}.toml": self.toml.name}
        if self.urdf is not None:
            names[f"{self.name}.urdf"] = self.urdf.name
        return with_words(error, names)


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
        planned: Its folder where it was saved.
    """
    folder = Path(planned)
    return folder if folder.is_dir() else known_models().get(name, folder)


def find_files(model: str | Path) -> ModelFiles:
    """Files of a model.

    Args:
        model: Name of a known model, or path of a folder or of a TOML file in it.

    Raises:
        UnknownNameError: There is no such model or folder.
        ModelError: The folder lacks one of the two files, or holds several of a kind.
    """
    known = known_models()
    if isinstance(model, str) and model in known:
        return _in_folder(known[model], model)
    try:
        path = followed(model)
        if path.suffix == ".toml" and path.is_file():
            return _with_toml(path)
        found = path.is_dir()
    except (OSError, ValueError) as error:
        # Links in a circle, or a name that no file can have.
        raise UnknownNameError(
            kind="model or model folder", name=str(model), known=known, where=str(error)
        ) from error
    if not found:
        _need_file(Path(model))
        if path.is_file():
            allowed = "a folder with a URDF and a TOML file, or the TOML file of one"
            raise ModelError(file=str(path.parent), key="model", value=path.name, allowed=allowed)
        drawings = [item.name for item in sorted(Path().glob("*.toml"))[:_MOST] if _draws(item)]
        names = [*known, *drawings]
        raise UnknownNameError(kind="model or model folder", name=str(model), known=names)
    return _in_folder(path, path.name)


def find_model(model: str | Path) -> Path:
    """Folder of a model; arguments and errors as of :func:`find_files`."""
    return find_files(model).folder


def _in_folder(folder: Path, name: str) -> ModelFiles:
    """The model of a folder: its files have its name, or are the only ones there."""
    urdf, toml = folder / f"{name}.urdf", folder / f"{name}.toml"
    for path in (urdf, toml):
        _need_file(path)
    if urdf.is_file() and toml.is_file():
        return ModelFiles(name, urdf, toml)
    documents = [toml] if toml.is_file() else [*folder.glob("*.toml")]
    if len(documents) == 1 and not any(folder.glob("*.urdf")) and _draws(documents[0]):
        return ModelFiles(name, None, documents[0])
    return ModelFiles(name, _only(folder, ".urdf", name), _only(folder, ".toml", name))


def _with_toml(toml: Path) -> ModelFiles:
    """The model of a TOML file: its URDF has its name, or is the only one; a drawing needs none."""
    urdf = toml.with_suffix(".urdf")
    _need_file(urdf)
    if urdf.is_file():
        return ModelFiles(toml.stem, urdf, toml)
    drawn = _draws(toml)
    return ModelFiles(toml.stem, None if drawn else _only(toml.parent, ".urdf", toml.stem), toml)


def read_model_text(path: Path, encoding: str | Callable[[bytes], str] = "utf-8-sig") -> str:
    """The text of a file of a model.

    Raises:
        ModelError: It cannot be read.
        InputError: It is too large.
    """
    try:
        return read_text(path, MOST_TEXT, encoding)
    except (OSError, UnicodeError, LookupError) as error:
        allowed = "a readable UTF-8 file"
        if not isinstance(encoding, str):
            allowed = "a readable file in the encoding that its first line declares, or in UTF-8"
        raise ModelError(file=path.name, key="text", value=str(error), allowed=allowed) from error


def _draws(toml: Path) -> bool:
    """Whether a TOML file draws its machine, by the key ``drawing`` above its first table."""
    try:
        text = read_model_text(toml)
    except ModelError:
        # What reads the file says what is wrong with it.
        return False
    return re.search(r"^\s*drawing\s*=", text.split("\n[")[0], re.MULTILINE) is not None


def _need_file(path: Path) -> None:
    """Refuse a file of a model that is a folder, a pipe or a link to nothing; it may be missing."""
    kind = no_file(path)
    if kind:
        allowed = "a file, or a link to one"
        raise ModelError(file=str(path.parent), key=path.name, value=kind, allowed=allowed)


def _only(folder: Path, suffix: str, name: str) -> Path:
    """The only file of a kind in a folder; if there are several, one of a name would be taken.

    Raises:
        ModelError: There is none, or there are several.
    """
    inside = sorted(item for item in folder.iterdir() if not item.name.startswith("."))
    called = [item for item in inside if item.suffix.lower() == suffix]
    found = [item for item in called if item.is_file()]
    if len(found) == 1:
        return found[0]
    for item in called if not found else ():
        _need_file(item)
    listed = ", ".join(item.name for item in found or inside) or "nothing"
    one = f"a model folder holds one {suffix[1:].upper()} file, or one called {name}{suffix}"
    by_path = "name the TOML file that counts, or rename it"
    choice = by_path if suffix == ".toml" else "rename the one that counts"
    which = f"several; {choice}: {listed}"
    raise ModelError(
        file=str(folder),
        key=f"{name}{suffix}",
        value=None,
        allowed=f"{one}; found {which if found else listed}",
    )


_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")


def check_model_folder(folder: str | Path) -> Path:
    """Refuse a folder whose name cannot be that of a new model.

    Returns:
        The folder, resolved.

    Raises:
        InputError: The name cannot be a model's, or belongs to one that comes with the package.
    """
    target = followed(folder)
    name = target.name
    if not _NAME.fullmatch(name):
        message = f"{name!r} cannot name a model: a letter, then letters, digits, _ and -"
        raise InputError(message, folder=str(folder))
    if name in known_models():
        message = f"{name} is a model that comes with the package; give yours another name"
        raise InputError(message, folder=str(folder))
    return target


def check_new_folder(folder: str | Path) -> Path:
    """Refuse a folder that holds something already.

    Returns:
        The folder, resolved.

    Raises:
        InputError: It is a file, is not empty, or cannot be looked at.
    """
    target = followed(folder)
    try:
        occupied = target.exists() and (not target.is_dir() or any(target.iterdir()))
    except OSError as error:
        message = f"{target} cannot be written: {error.strerror}; name another folder"
        raise InputError(message, folder=str(target)) from error
    if occupied:
        message = f"{target} is there already and is not empty; name a new folder"
        raise InputError(message, folder=str(target))
    return target


@contextmanager
def new_folder(folder: str | Path) -> Iterator[Path]:
    """Give a folder of the same name elsewhere that takes its place only if nothing fails.

    Yields:
        An empty folder to write into; folders above it are made.

    Raises:
        InputError: The folder is occupied or cannot be written.
    """
    # Whoever loads a model writes no folder.
    from ..outputs import complete_folder

    with complete_folder(check_new_folder(folder), ()) as partial:
        yield partial


def new_model(target: str | Path, text: str) -> Path:
    """Write a drawing: one TOML file, alone or in a folder of its name, with a schema for editors.

    Args:
        target: ``NAME.toml``, or a folder to write; its name becomes the model's.

    Returns:
        The file or folder, resolved.

    Raises:
        InputError: The name cannot be a model's, or it is there or cannot be written.
    """
    from ..outputs import complete_file
    from .files.schema import write_document

    if Path(target).suffix != ".toml":
        folder = check_model_folder(target)
        with new_folder(folder) as partial:
            write_document(partial / f"{folder.name}.toml", text, "drawing")
        return folder
    file = check_model_folder(Path(target).with_suffix("")).with_suffix(".toml")
    if file.exists():
        message = f"{file} is there already; name a new file"
        raise InputError(message, file=str(file))
    with complete_file(file) as partial:
        partial.write_text(text, encoding="utf-8")
    return file

"""Files of studies: reading, the model they start from, and errors with file and key."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn, TypeVar

import msgspec

from ..errors import InputError, ModelError, SimulationError
from ..mechanism import Mechanism, changed, find_model, load, numbers_of
from ..mechanism.files import Refusal, first_refusal, member_of, need_plain_text, read_toml
from ..mechanism.files.describe import allowed_values
from ..texts import MOST_TEXT, read_text

TableT = TypeVar("TableT", bound=msgspec.Struct)


class Table(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A TOML table whose keys are all known."""


class Bounds(Table, frozen=True, kw_only=True):
    """A range of a number, in the unit of its name."""

    low: float
    high: float


def read_table(file: Path, kind: type[TableT]) -> TableT:
    """Read a TOML file into its tables.

    Raises:
        ModelError: The file is no readable TOML.
        InputError: A key or value in it cannot be used.
    """
    try:
        text = read_text(file, MOST_TEXT)
    except FileNotFoundError as error:
        message = f"{file}: there is no such file; nipper-pin new --study writes one"
        raise InputError(message, file=str(file)) from error
    except (OSError, UnicodeDecodeError) as error:
        allowed = "a readable TOML file"
        raise ModelError(file=file.name, key="file", value=str(error), allowed=allowed) from error
    document = read_toml(text, file.name)
    need_plain_text(document, file.name)
    try:
        return msgspec.convert(document, kind)
    except msgspec.ValidationError as error:
        refusal = first_refusal(document, kind, str(error))
        key = refusal.key or "document"
        found = f" = {refusal.value!r}" if isinstance(refusal.value, str | int | float) else ""
        message = f"{file.name}: {key}{found} cannot be used: {_reason(refusal)}"
        raise InputError(message, file=str(file), key=key) from error


def _reason(refusal: Refusal) -> str:
    """What is wrong, or what may stand there."""
    if refusal.unknown is not None:
        known = ", ".join(field.encode_name for field in msgspec.structs.fields(refusal.kind))
        return f"unknown key `{refusal.unknown}`; known here: {known}"
    if refusal.missing is not None:
        return f"the key `{refusal.missing}` is missing"
    if isinstance(refusal.value, list) and member_of(refusal.kind, {}):
        whole = refusal.path == ("parameters",)
        form = "[parameters.NAME] with" if whole else "a table with"
        return f"no list; write {form} low and high"
    # A number that is its only choice tells nothing by itself.
    choices = allowed_values(refusal.kind)
    return f"only {choices} is known" if choices.isdecimal() else choices or refusal.text


def base_mechanism(model: str, changes: Mapping[str, object], file: Path) -> Mechanism:
    """The mechanism that a study starts from, with everything that is fixed.

    Args:
        model: A model's name, or a folder beside the file.
        changes: New values by path or shortcut.
        file: The file of the study.

    Raises:
        InputError: There is no such model, path or value.
    """
    with at_key(file.name, "model"):
        found = model_beside(model, file.parent)
        mechanism = load(found)
    if not changes:
        return mechanism
    with at_key(file.name, "set"):
        return load(found, changes)


def model_beside(model: str, folder: Path) -> str | Path:
    """A model's folder beside a file, or its name if there is none."""
    beside = folder / model
    try:
        return find_model(beside) if beside.is_dir() else model
    except OSError:
        # No file can have this name; what loads the model says so.
        return model


@contextmanager
def at_key(file: str, key: str) -> Iterator[None]:
    """Prefix a model's errors with the study's file and key."""
    try:
        yield
    except InputError as error:
        message = f"{file}: {key}: {error.message}"
        raise InputError(message, **{**error.evidence, "key": key}) from error


def refuse(file: str, key: str, value: object, allowed: str) -> NoReturn:
    """Refuse a value of a study.

    Raises:
        ModelError: Always.
    """
    raise ModelError(file=file, key=key, value=value, allowed=allowed)


def check_paths(paths: Iterable[str], mechanism: Mechanism) -> None:
    """Write a model's own numbers back: paths that lead nowhere or contradict one another fail.

    Raises:
        UnknownNameError: A path leads nowhere.
        ModelError: There is no number, or paths contradict one another.
    """
    asked = tuple(paths)
    changed(mechanism, dict(zip(asked, numbers_of(mechanism, asked), strict=True)))


def no_machine(tried: str, own: str) -> SimulationError:
    """The error of numbers none of which makes a machine that can be simulated.

    Args:
        tried: What was tried, in words.
        own: Why the model's own numbers make none, wherever its bounds are; empty if they do.
    """
    found = f"none of {tried} is a machine that can be simulated"
    if own:
        message = f"{found}, nor is the model as it is: {own}; change that first"
        return SimulationError(message, why=own)
    return SimulationError(f"{found}; the model as it is can: put its numbers within the bounds")

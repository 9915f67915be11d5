"""Drive laws that a model file may name: those of the package, and those that a user adds."""

from __future__ import annotations

import typing
from typing import Any, TypeVar

from ...errors import InputError
from .cam import CamDrive
from .fourier import FourierDrive
from .geared import GearedDrive
from .law import DriveTable
from .oscillating_guide import OscillatingGuideDrive
from .proportional import ConstantSpeedDrive, ScrewDrive
from .table import TableDrive

BuiltInDrive = (
    OscillatingGuideDrive
    | GearedDrive
    | ConstantSpeedDrive
    | ScrewDrive
    | FourierDrive
    | TableDrive
    | CamDrive
)
"""Tables of the laws of this package, in the order of the schema."""

_added: dict[str, type[DriveTable]] = {}
_T = TypeVar("_T", bound=type[DriveTable])


def register_drive(kind: _T) -> _T:
    """Let model files name a drive law of the user's; a decorator of its table.

    A worker process of a study knows a law only if it imports the module that registers it.

    Args:
        kind: Subclass of :class:`.law.DriveTable` with ``tag="name_of_the_law"``.

    Returns:
        The same class.

    Raises:
        InputError: It is no such class, or its name belongs to another law.
    """
    tag = getattr(getattr(kind, "__struct_config__", None), "tag", None)
    if not (isinstance(kind, type) and issubclass(kind, DriveTable) and isinstance(tag, str)):
        message = (
            f"{kind!r} is no table of a drive law: derive it from DriveTable, ShaftTable or "
            'AnyTable, with frozen=True, kw_only=True and tag="name_of_the_law"'
        )
        raise InputError(message, kind=kind)
    other = known_laws().get(tag)
    if other is not None and other.__qualname__ != kind.__qualname__:
        message = f"a drive law {tag!r} exists already ({other.__name__}); choose another tag"
        raise InputError(message, tag=tag)
    _added[tag] = kind
    return kind


def drive_tables() -> Any:
    """Return the union of the tables of all laws, for reading a model file."""
    union: Any = BuiltInDrive
    for kind in _added.values():
        union = union | kind
    return union


def known_laws() -> dict[str, type[DriveTable]]:
    """Return the tables of all laws by the name that a model file gives as ``law``."""
    return {str(item.__struct_config__.tag): item for item in typing.get_args(drive_tables())}

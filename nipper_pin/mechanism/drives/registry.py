"""Drive laws that a model file may name: those of the package, and those that a user adds."""

from __future__ import annotations

import typing
from typing import TypeVar

from ..files.register import Register
from .cam import CamDrive
from .fourier import FourierDrive
from .geared import GearedDrive
from .oscillating_guide import OscillatingGuideDrive
from .proportional import ConstantSpeedDrive, ScrewDrive
from .table import TableDrive
from .tables import DriveTable

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

DRIVES: Register[DriveTable] = Register("drive law", DriveTable, typing.get_args(BuiltInDrive))
"""All that are known."""

_T = TypeVar("_T", bound=type[DriveTable])


def register_drive(kind: _T) -> _T:
    """Let model files name a drive law of the user's; a decorator of its table.

    A worker process of a study knows the law only if it imports the module that registers it, as
    it does with an installed package that has an entry point ``nipper_pin.extensions``.

    Args:
        kind: Subclass of :class:`.law.DriveTable` with ``tag="name_of_the_law"``.

    Returns:
        The same class.

    Raises:
        InputError: It is no such class, or its name belongs to another law.
    """
    DRIVES.add(kind)
    return kind

"""Drive laws: the coordinate of a driven joint as a function of the cylinder angle.

Each module has a law and the table of the model file that it is built from. A new one is a module
here and a name in :data:`.registry.BuiltInDrive`, or a class in a user's own program that
:func:`register_drive` makes known.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .cam import Cam, CamDrive
    from .fourier import Fourier, FourierDrive
    from .geared import GearedDrive
    from .law import DriveLaw, Evaluation, Geared
    from .oscillating_guide import OscillatingGuide, OscillatingGuideDrive
    from .proportional import ConstantSpeed, ConstantSpeedDrive, ScrewDrive
    from .registry import DRIVES, BuiltInDrive, register_drive
    from .table import Table, TableDrive, check_table
    from .tables import AnyTable, DriveTable, FollowingTable, ShaftTable
else:
    # The tables bring the parser of model files, which whoever has a mechanism does without.
    _PLACES = {
        "cam": ("Cam", "CamDrive"),
        "fourier": ("Fourier", "FourierDrive"),
        "geared": ("GearedDrive",),
        "law": ("DriveLaw", "Evaluation", "Geared"),
        "oscillating_guide": ("OscillatingGuide", "OscillatingGuideDrive"),
        "proportional": ("ConstantSpeed", "ConstantSpeedDrive", "ScrewDrive"),
        "registry": ("DRIVES", "BuiltInDrive", "register_drive"),
        "table": ("Table", "TableDrive", "check_table"),
        "tables": ("AnyTable", "DriveTable", "FollowingTable", "ShaftTable"),
    }
    _PLACE_OF = {name: place for place, names in _PLACES.items() for name in names}

    def __getattr__(name: str) -> object:
        """Import what is behind a name when it is first asked for."""
        if name not in _PLACE_OF:
            message = f"module {__name__!r} has no attribute {name!r}"
            raise AttributeError(message)
        value = getattr(import_module(f".{_PLACE_OF[name]}", __name__), name)
        globals()[name] = value
        return value


__all__ = [
    "DRIVES",
    "AnyTable",
    "BuiltInDrive",
    "Cam",
    "CamDrive",
    "ConstantSpeed",
    "ConstantSpeedDrive",
    "DriveLaw",
    "DriveTable",
    "Evaluation",
    "FollowingTable",
    "Fourier",
    "FourierDrive",
    "Geared",
    "GearedDrive",
    "OscillatingGuide",
    "OscillatingGuideDrive",
    "ScrewDrive",
    "ShaftTable",
    "Table",
    "TableDrive",
    "check_table",
    "register_drive",
]

"""Drive laws: the coordinate of a driven joint as a function of the cylinder angle.

Each module has a law and the table of the model file that it is built from. A new one is a module
here, named like the law, or a class in a user's own program, registered by `register_drive`.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..files.register import DRIVES
    from .cam import Cam, CamDrive
    from .constant_speed import ConstantSpeed, ConstantSpeedDrive
    from .fourier import Fourier, FourierDrive
    from .geared import GearedDrive
    from .law import DriveLaw, Evaluation, Geared
    from .oscillating_guide import OscillatingGuide, OscillatingGuideDrive
    from .screw import ScrewDrive
    from .table import Table, TableDrive, check_table
    from .tables import AnyTable, DriveTable, FollowingTable, ShaftTable

    register_drive = DRIVES.add
else:
    # The tables import the parser of model files, which a built mechanism does not need.
    _PLACES = {
        "cam": ("Cam", "CamDrive"),
        "fourier": ("Fourier", "FourierDrive"),
        "geared": ("GearedDrive",),
        "law": ("DriveLaw", "Evaluation", "Geared"),
        "oscillating_guide": ("OscillatingGuide", "OscillatingGuideDrive"),
        "constant_speed": ("ConstantSpeed", "ConstantSpeedDrive"),
        "screw": ("ScrewDrive",),
        "table": ("Table", "TableDrive", "check_table"),
        "tables": ("AnyTable", "DriveTable", "FollowingTable", "ShaftTable"),
    }
    _PLACE_OF = {name: place for place, names in _PLACES.items() for name in names}

    def __getattr__(name: str) -> object:
        """Import the module of a public name at its first use."""
        if name == "register_drive":
            return import_module("..files.register", __name__).DRIVES.add
        if name not in _PLACE_OF:
            message = f"module {__name__!r} has no attribute {name!r}"
            raise AttributeError(message)
        value = getattr(import_module(f".{_PLACE_OF[name]}", __name__), name)
        globals()[name] = value
        return value


__all__ = [
    "AnyTable",
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

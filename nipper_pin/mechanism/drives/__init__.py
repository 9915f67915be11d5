"""Drive laws: the coordinate of a driven joint as a function of the cylinder angle.

Each module has a law and the table of the model file that it is built from. A new one is a module
here, named like the law, or a class in a user's own program, registered by `register_drive`.
"""

from typing import TYPE_CHECKING

from ...first_use import at_first_use

if TYPE_CHECKING:
    from ..files.register import register_drive
    from .cam import Cam, CamDrive
    from .constant_speed import ConstantSpeed, ConstantSpeedDrive
    from .fourier import Fourier, FourierDrive
    from .geared import GearedDrive
    from .law import DriveLaw, Evaluation, Geared
    from .oscillating_guide import OscillatingGuide, OscillatingGuideDrive
    from .screw import ScrewDrive
    from .table import Table, TableDrive
    from .tables import AnyTable, DriveTable, FollowingTable, ShaftTable
else:
    # The tables import the parser of model files, which a built mechanism does not need.
    _PLACES = {
        ".files.register": ("register_drive",),
        "cam": ("Cam", "CamDrive"),
        "fourier": ("Fourier", "FourierDrive"),
        "geared": ("GearedDrive",),
        "law": ("DriveLaw", "Evaluation", "Geared"),
        "oscillating_guide": ("OscillatingGuide", "OscillatingGuideDrive"),
        "constant_speed": ("ConstantSpeed", "ConstantSpeedDrive"),
        "screw": ("ScrewDrive",),
        "table": ("Table", "TableDrive"),
        "tables": ("AnyTable", "DriveTable", "FollowingTable", "ShaftTable"),
    }
    __getattr__ = at_first_use(__name__, _PLACES)


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
    "register_drive",
]

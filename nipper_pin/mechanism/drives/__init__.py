"""Drive laws: the coordinate of a driven joint as a function of the cylinder angle.

Each module has a law and the table of the model file that it is built from. A new one is a module
here and a name in :data:`.registry.BuiltInDrive`, or a class in a user's own program that
:func:`register_drive` makes known.
"""

from .cam import Cam, CamDrive
from .fourier import Fourier, FourierDrive
from .geared import Geared, GearedDrive
from .law import AnyTable, DriveLaw, DriveTable, Evaluation, FollowingTable, ShaftTable
from .oscillating_guide import OscillatingGuide, OscillatingGuideDrive
from .proportional import ConstantSpeed, ConstantSpeedDrive, ScrewDrive
from .registry import DRIVES, BuiltInDrive, register_drive
from .table import Table, TableDrive, check_table

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

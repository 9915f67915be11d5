"""Drive laws: the coordinate of a driven joint as a function of the cylinder angle.

Each module has a law and the table of the model file that it is built from. A new one is a module
here, named like the law, or a class in a user's own program, registered by `register_drive`.
"""

from ..files.law_tables import AnyTable, DriveTable, ShaftTable
from ..files.register import register_drive
from ..laws import DriveLaw, Evaluation, Geared
from .cam import Cam
from .constant_speed import ConstantSpeed
from .fourier import Fourier
from .geared import GearedDrive
from .oscillating_guide import OscillatingGuide
from .table import Table

__all__ = [
    "AnyTable",
    "Cam",
    "ConstantSpeed",
    "DriveLaw",
    "DriveTable",
    "Evaluation",
    "Fourier",
    "Geared",
    "GearedDrive",
    "OscillatingGuide",
    "ShaftTable",
    "Table",
    "register_drive",
]

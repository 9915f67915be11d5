"""What a sweep leaves on disk: its folder, the files in it, and what they say together."""

from .store import Store
from .table import SweepTable, read_sweep
from .tally import Tally

__all__ = ["Store", "SweepTable", "Tally", "read_sweep"]

"""What a sweep leaves on disk: its folder, the files in it, and what they say together."""

from .store import Store, need_pyarrow
from .table import SweepTable, read_sweep
from .tally import Tally

__all__ = ["Store", "SweepTable", "Tally", "need_pyarrow", "read_sweep"]

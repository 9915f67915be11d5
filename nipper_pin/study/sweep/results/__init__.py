"""Results of a sweep on disk: its folder, its files, and their summary."""

from .store import Store, need_pyarrow
from .table import SweepTable, read_sweep
from .tally import Tally

__all__ = ["Store", "SweepTable", "Tally", "need_pyarrow", "read_sweep"]

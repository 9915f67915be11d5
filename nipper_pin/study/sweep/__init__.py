"""Sweeps: many scenarios of a model, planned in a file, computed in chunks, kept as they finish."""

from .plan import Plan
from .report import SweepReport
from .results import SweepTable, read_sweep
from .run import sweep
from .study_file import read_plan

__all__ = ["Plan", "SweepReport", "SweepTable", "read_plan", "read_sweep", "sweep"]

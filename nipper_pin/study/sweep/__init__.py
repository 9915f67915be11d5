"""Sweeps: many scenarios of a model, planned in a file, computed in chunks, kept as they finish."""

from .plan import Plan, read_plan
from .report import SweepReport
from .results import SweepTable, read_sweep
from .run import run_sweep

__all__ = ["Plan", "SweepReport", "SweepTable", "read_plan", "read_sweep", "run_sweep"]

"""Sweeps: many scenarios of a model, planned in a file, computed in chunks, kept as they finish."""

from .plan import Plan, read_plan
from .run import SweepReport, run_sweep
from .store import SweepTable, read_sweep

__all__ = ["Plan", "SweepReport", "SweepTable", "read_plan", "read_sweep", "run_sweep"]

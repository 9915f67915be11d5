"""One run: its tables, plots and files; what needs Matplotlib is imported from its own module."""

from .csv_tables import tables
from .table import print_solution

__all__ = ["print_solution", "tables"]

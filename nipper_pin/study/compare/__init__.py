"""Two runs side by side: their quantities, and what differs in machine and setting."""

from .changes import Change
from .comparison import Comparison, Row, compare

__all__ = ["Change", "Comparison", "Row", "compare"]

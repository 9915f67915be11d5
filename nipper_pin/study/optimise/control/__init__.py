"""The control of an optimum by simulated turns, which shares nothing with the search."""

from .compare import Control, Row, control

__all__ = ["Control", "Row", "control"]

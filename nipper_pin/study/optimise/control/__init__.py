"""The control of an optimum by turns that the direct engine simulates."""

from .compare import Control, Row, control

__all__ = ["Control", "Row", "control"]

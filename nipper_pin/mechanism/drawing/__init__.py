"""Machines drawn as points, bodies and joints."""

from .drawing import Drawing
from .layout import FRAME
from .points import Place

__all__ = ["FRAME", "Drawing", "Place"]

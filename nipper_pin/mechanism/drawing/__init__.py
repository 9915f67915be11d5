"""Machines drawn as points, bodies and joints."""

from .drawing import Drawing
from .layout import FRAME
from .places import Place, between, direction, distance, meet, on_line, polar

__all__ = [
    "FRAME",
    "Drawing",
    "Place",
    "between",
    "direction",
    "distance",
    "meet",
    "on_line",
    "polar",
]

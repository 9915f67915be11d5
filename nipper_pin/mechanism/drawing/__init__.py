"""Machines drawn as points, bodies and joints, which become model folders."""

from .compound import flap, telescope
from .parts import (
    FRAME,
    Body,
    Damper,
    Drawing,
    Drive,
    Force,
    Part,
    Pin,
    Place,
    Slide,
    Slot,
    Spring,
    Start,
    Stop,
    Tie,
)
from .places import between, direction, distance, meet, on_line, polar
from .read import drawing_of, read_drawing
from .tables import drawn_sources
from .write import drawn_mechanism, write_drawing

__all__ = [
    "FRAME",
    "Body",
    "Damper",
    "Drawing",
    "Drive",
    "Force",
    "Part",
    "Pin",
    "Place",
    "Slide",
    "Slot",
    "Spring",
    "Start",
    "Stop",
    "Tie",
    "between",
    "direction",
    "distance",
    "drawing_of",
    "drawn_mechanism",
    "drawn_sources",
    "flap",
    "meet",
    "on_line",
    "polar",
    "read_drawing",
    "telescope",
    "write_drawing",
]

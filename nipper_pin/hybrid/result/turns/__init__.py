"""Quantities of one turn, read off a run of whole turns."""

from .quantities import INDICES, TURN, TURN_STOP, is_of_drive, of_turn, read_of, turn_names
from .turn import Turn, reported_turn

__all__ = [
    "INDICES",
    "TURN",
    "TURN_STOP",
    "Turn",
    "is_of_drive",
    "of_turn",
    "read_of",
    "reported_turn",
    "turn_names",
]

"""Quantities of one turn, read off a run of whole turns."""

from .quantities import TURN, TURN_STOP, of_turn, turn_names
from .turn import StopTurn, Turn, reported_turn

__all__ = ["TURN", "TURN_STOP", "StopTurn", "Turn", "of_turn", "reported_turn", "turn_names"]

"""Whole turns: phases without freedom, flights, collisions at every stop, rests and releases."""

from .model import TurnModel, build_turns
from .results import ReducedTurns, TurnStatus
from .turn import turn_model, turns

__all__ = ["ReducedTurns", "TurnModel", "TurnStatus", "build_turns", "turn_model", "turns"]

"""Whole turns: phases without freedom, flights, collisions at every stop, rests and releases."""

from ..results import TURN_REASONS, ReducedTurns, TurnStatus
from .model import TurnModel, build_turns
from .quantities import TurnQuantities, turn_quantities
from .turn import turn_model, turns

__all__ = [
    "TURN_REASONS",
    "ReducedTurns",
    "TurnModel",
    "TurnQuantities",
    "TurnStatus",
    "build_turns",
    "turn_model",
    "turn_quantities",
    "turns",
]

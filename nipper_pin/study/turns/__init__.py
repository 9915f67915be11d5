"""Turns of many cases of one mechanism, each by the engine that suits it.

The reduced engine follows a turn a hundred times faster than the direct one, but has to sample its
tables first and follows only turns inside them. The direct engine follows the others, case by case,
and the result says which engine computed what.
"""

from __future__ import annotations

from .engine_choice import MOST_TURNS, TURNS, TURNS_PAY_FROM, turn_table, turns_of
from .run import TurnSettings
from .table import TurnTable

__all__ = [
    "MOST_TURNS",
    "TURNS",
    "TURNS_PAY_FROM",
    "TurnSettings",
    "TurnTable",
    "turn_table",
    "turns_of",
]

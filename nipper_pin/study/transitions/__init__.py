"""Transitions of many cases of one mechanism, each by the engine that suits it.

The reduced engine solves a transition a hundred times faster than the direct one, but has to sample
its tables first and solves only cases inside them. The direct engine solves the others, case by
case, and the result says which engine computed what.
"""

from __future__ import annotations

from .engine_choice import REDUCED_PAYS_FROM, TURNS_PAY_FROM, table_of, transition_table
from .table import FAILED, REDUCED, REDUCED_TURN, TURN, TransitionTable

__all__ = [
    "FAILED",
    "REDUCED",
    "REDUCED_PAYS_FROM",
    "REDUCED_TURN",
    "TURN",
    "TURNS_PAY_FROM",
    "TransitionTable",
    "table_of",
    "transition_table",
]

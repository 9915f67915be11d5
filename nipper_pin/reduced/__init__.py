"""The engine of one degree of freedom: tables of its equation of motion, solved compiled."""

from .model import ReducedModel
from .results import ReducedTransition, Status, TransitionBatch
from .sampling import build, reduced_model, unfit
from .transition import transition, transitions

__all__ = [
    "ReducedModel",
    "ReducedTransition",
    "Status",
    "TransitionBatch",
    "build",
    "reduced_model",
    "transition",
    "transitions",
    "unfit",
]

"""The one degree of freedom that held drives leave, sampled from Pinocchio and solved compiled."""

from .kept import reduced_model
from .model import ReducedModel
from .results import ReducedTransition, Status, TransitionBatch
from .sampling import build, unfit
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

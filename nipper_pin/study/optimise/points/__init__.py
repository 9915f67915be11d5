"""Quantities of one design: by the engines, by kinematics, and by a simulated turn if need be."""

from .evaluate import Evaluator, evaluator
from .point import Point

__all__ = ["Evaluator", "Point", "evaluator"]

"""Simulation of impact mechanisms on Pinocchio: the nipper of a comber and its bouncing jaw.

This module is the one public door; everything else may move.
"""

from .dynamics.system import DriveMode
from .errors import (
    AssemblyError,
    ConvergenceError,
    ImpactError,
    InputError,
    ModelError,
    NipperError,
    SimulationError,
    SingularConfigurationError,
    UnknownNameError,
)
from .hybrid.case import Case, Resolution, Window
from .hybrid.collisions import Collision, PhaseInterval, Transition
from .hybrid.event import Event, EventKind
from .hybrid.record import record
from .hybrid.simulate import simulate
from .hybrid.solution import Outcome, Solution
from .hybrid.storage import load_case, load_solution, save, save_case
from .hybrid.trajectory import Motion, Reactions
from .mechanism import Mechanism, load

__version__ = "0.1.0"

__all__ = [
    "AssemblyError",
    "Case",
    "Collision",
    "ConvergenceError",
    "DriveMode",
    "Event",
    "EventKind",
    "ImpactError",
    "InputError",
    "Mechanism",
    "ModelError",
    "Motion",
    "NipperError",
    "Outcome",
    "PhaseInterval",
    "Reactions",
    "Resolution",
    "SimulationError",
    "SingularConfigurationError",
    "Solution",
    "Transition",
    "UnknownNameError",
    "Window",
    "load",
    "load_case",
    "load_solution",
    "record",
    "save",
    "save_case",
    "simulate",
]

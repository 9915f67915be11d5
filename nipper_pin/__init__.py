"""Simulation of impact mechanisms on Pinocchio: the nipper of a comber and its bouncing jaw.

This module is the one public door; everything else may move.
"""

from typing import TYPE_CHECKING

from .dynamics.system import DriveMode
from .errors import (
    AssemblyError,
    ConvergenceError,
    ElementError,
    ImpactError,
    InfeasibleError,
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
from .mechanism import Mechanism, load

__version__ = "0.1.0"

if TYPE_CHECKING:
    from .hybrid.storage import load_case, load_solution, save, save_case
    from .hybrid.trajectory import Motion, Reactions
    from .study.transitions import transition_table
else:
    # Archives, JSON and tables of many runs are a part of the time of the import, and most runs
    # need none. Type checkers read the lines above instead: with this function they would accept
    # any name.
    def __getattr__(name: str) -> object:
        """Import what few runs need when it is first asked for (PEP 562)."""
        if name in ("load_case", "load_solution", "save", "save_case"):
            from .hybrid import storage

            return getattr(storage, name)
        if name in ("Motion", "Reactions"):
            from .hybrid import trajectory

            return getattr(trajectory, name)
        if name == "transition_table":
            from .study.transitions import transition_table

            return transition_table
        message = f"module {__name__!r} has no attribute {name!r}"
        raise AttributeError(message)

    def __dir__() -> list[str]:
        """Names that are there already, and those that come when they are asked for."""
        return sorted({*globals(), *__all__})


__all__ = [
    "AssemblyError",
    "Case",
    "Collision",
    "ConvergenceError",
    "DriveMode",
    "ElementError",
    "Event",
    "EventKind",
    "ImpactError",
    "InfeasibleError",
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
    "transition_table",
]

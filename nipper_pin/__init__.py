"""Simulation of impact mechanisms on Pinocchio: the nipper of a comber and its bouncing jaw.

All public names are here; other modules may change. What they need, Pinocchio and numpy
included, is imported when it is first asked for (PEP 562): a worker that only waits for work, or a
command that only says how it is used, does without.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from .errors import (
    AssemblyError,
    ConvergenceError,
    ElementError,
    ImpactError,
    InfeasibleError,
    InputError,
    ModelError,
    NipperError,
    SelfCheckError,
    SimulationError,
    SingularConfigurationError,
    UnknownNameError,
)
from .first_use import at_first_use

__version__ = "0.1.0"

if TYPE_CHECKING:
    from .dynamics import DriveMode
    from .hybrid import (
        Case,
        Collision,
        Event,
        EventKind,
        Outcome,
        PhaseInterval,
        Resolution,
        Solution,
        Transition,
        Window,
        simulate,
    )
    from .hybrid.files.npz import load_case, load_solution, save, save_case
    from .hybrid.result.json_document import record
    from .hybrid.result.trajectory import Impulses, Motion, Reactions
    from .mechanism import Mechanism, changed, load
    from .mechanism.drawing import Drawing
    from .mechanism.export import export
    from .study.check import check
    from .study.compare import Comparison, compare
    from .study.identify import identify
    from .study.optimise import optimise
    from .study.sweep import read_sweep, sweep
    from .study.transitions import TransitionTable, transition_table
    from .study.turns import TurnTable, turn_table
    from .view.run.plots import figures
    from .view.show import view
else:
    # Type checkers read the lines above instead: with this function they would accept any name.
    _PLACES = {
        "dynamics.system": ("DriveMode",),
        "hybrid.case": ("Case", "Resolution", "Window"),
        "hybrid.result.tables": ("Collision", "PhaseInterval", "Transition"),
        "hybrid.history": ("Event", "EventKind", "Outcome"),
        "hybrid.result.json_document": ("record",),
        "hybrid.simulation": ("simulate",),
        "hybrid.result.solution": ("Solution",),
        "hybrid.files.npz": ("load_case", "load_solution", "save", "save_case"),
        "hybrid.result.trajectory": ("Impulses", "Motion", "Reactions"),
        "mechanism": ("Mechanism", "changed", "load"),
        "mechanism.drawing": ("Drawing",),
        "mechanism.export": ("export",),
        "study.check": ("check",),
        "study.compare": ("Comparison", "compare"),
        "study.identify": ("identify",),
        "study.optimise": ("optimise",),
        "study.sweep": ("read_sweep", "sweep"),
        "study.transitions": ("TransitionTable", "transition_table"),
        "study.turns": ("TurnTable", "turn_table"),
        "view.run.plots": ("figures",),
    }
    # Public functions with the name of a subpackage, which an import would put in their place.
    _ROOMS = ("view",)
    _public = at_first_use(__name__, _PLACES)

    def __getattr__(name: str) -> object:
        """Import the module of a public name at its first use."""
        if name in _ROOMS:
            return import_module(f".{name}", __name__)
        return _public(name)

    def __dir__() -> list[str]:
        """Return the public names, imported already or not."""
        return sorted([*__all__, "__version__"])


__all__ = [
    "AssemblyError",
    "Case",
    "Collision",
    "Comparison",
    "ConvergenceError",
    "Drawing",
    "DriveMode",
    "ElementError",
    "Event",
    "EventKind",
    "ImpactError",
    "Impulses",
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
    "SelfCheckError",
    "SimulationError",
    "SingularConfigurationError",
    "Solution",
    "Transition",
    "TransitionTable",
    "TurnTable",
    "UnknownNameError",
    "Window",
    "changed",
    "check",
    "compare",
    "export",
    "figures",
    "identify",
    "load",
    "load_case",
    "load_solution",
    "optimise",
    "read_sweep",
    "record",
    "save",
    "save_case",
    "simulate",
    "sweep",
    "transition_table",
    "turn_table",
    "view",
]

"""Motion with changing contacts: events, phases and whole runs."""

from .case import FASTEST_RPM, START_INDEX, Case, Resolution, Window
from .error_estimate.event_errors import EventError
from .history import Event, EventKind, Outcome, Segment, State
from .result.json_document import need_sound
from .result.solution import Solution
from .result.tables import Collision, PhaseInterval, Transition
from .run.windows import comes_back, initial_state
from .simulation import simulate

__all__ = [
    "FASTEST_RPM",
    "START_INDEX",
    "Case",
    "Collision",
    "Event",
    "EventError",
    "EventKind",
    "Outcome",
    "PhaseInterval",
    "Resolution",
    "Segment",
    "Solution",
    "State",
    "Transition",
    "Window",
    "comes_back",
    "initial_state",
    "need_sound",
    "simulate",
]

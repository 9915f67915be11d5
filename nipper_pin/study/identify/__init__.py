"""Identification: numbers of a model from published ratios or from measured rebounds."""

from .determine import Determinability, determinability
from .fit import Descent, Fit
from .geometry import Sources
from .goodness import Goodness, Verdict, goodness
from .measured import read_measured
from .objective import Objective
from .parameters import read_values, with_values
from .problem import Limits, Parameter, Problem, read_problem
from .profiles import Profile, profile
from .record import record
from .search import identify
from .targets import QUANTITIES, Condition, Target, predict
from .working import WorkingCycle, working_cycle
from .write import write_model

__all__ = [
    "QUANTITIES",
    "Condition",
    "Descent",
    "Determinability",
    "Fit",
    "Goodness",
    "Limits",
    "Objective",
    "Parameter",
    "Problem",
    "Profile",
    "Sources",
    "Target",
    "Verdict",
    "WorkingCycle",
    "determinability",
    "goodness",
    "identify",
    "predict",
    "profile",
    "read_measured",
    "read_problem",
    "read_values",
    "record",
    "with_values",
    "working_cycle",
    "write_model",
]

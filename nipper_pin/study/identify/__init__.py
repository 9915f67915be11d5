"""Identification: numbers of a model from published ratios or from measured rebounds."""

from .fitting.determine import determinability
from .fitting.fit import Descent, Fit
from .fitting.goodness import Goodness, Verdict
from .fitting.objective import Objective
from .fitting.profiles import Profile, profile
from .fitting.search import identify
from .problem.measured import read_measured
from .problem.problem import Limits, Parameter, Problem, read_problem
from .problem.targets import QUANTITIES, Condition, Target, predict
from .problem.working_cycle import WorkingCycle, working_cycle
from .record import record
from .write import write_model

__all__ = [
    "QUANTITIES",
    "Condition",
    "Descent",
    "Fit",
    "Goodness",
    "Limits",
    "Objective",
    "Parameter",
    "Problem",
    "Profile",
    "Target",
    "Verdict",
    "WorkingCycle",
    "determinability",
    "identify",
    "predict",
    "profile",
    "read_measured",
    "read_problem",
    "record",
    "working_cycle",
    "write_model",
]

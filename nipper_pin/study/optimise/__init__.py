"""Design optimisation: the least rebound or transition time inside limits of force and timing."""

from .problem import Aim, Limit, Parameter, Problem
from .problem_file import read_problem
from .result import Design, Optimum
from .run import optimise
from .write import write

__all__ = [
    "Aim",
    "Design",
    "Limit",
    "Optimum",
    "Parameter",
    "Problem",
    "optimise",
    "read_problem",
    "write",
]

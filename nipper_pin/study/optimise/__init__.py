"""Design optimisation: the least rebound or transition time inside limits of force and timing."""

from .control import Control
from .design import Design
from .problem.problem import Limit, Problem
from .problem.problem_file import read_problem
from .result import Optimum
from .run import optimise
from .write import RESULTS, write

__all__ = [
    "RESULTS",
    "Control",
    "Design",
    "Limit",
    "Optimum",
    "Problem",
    "optimise",
    "read_problem",
    "write",
]

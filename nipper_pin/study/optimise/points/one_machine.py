"""Whether one machine serves all designs of a problem, so that its tables are sampled once."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from ....errors import NipperError
from ....extras import installed
from ....mechanism import Mechanism
from ..problem.problem import Problem

Tables = TypeVar("Tables")


def sampled_once(
    problem: Problem, sample: Callable[[Mechanism], Tables]
) -> tuple[Tables | None, str]:
    """Sample the tables of a problem's machine, or say why there are none.

    Args:
        sample: Makes the tables; an error of it is the reason why there are none.

    Returns:
        The tables or None, and the reason for it.
    """
    moving = [item.name for item in problem.parameters if item.target.kind == "model"]
    if moving:
        return None, f"{', '.join(moving)} change the machine, and so the tables"
    if not installed("numba"):
        return None, "the reduced engine needs numba, which is not installed"
    try:
        return sample(problem.mechanism), "one machine: its tables are sampled once"
    except NipperError as error:
        return None, error.message

"""A design problem from its file to its optimum: screen, descents, global check, front, control."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterable
from functools import partial
from pathlib import Path

from ...errors import SimulationError, without_numbers
from ...given import MOST_SEED, MOST_STARTS, whole
from ..processes import worker_count
from .control import control
from .design import Design, design
from .points import Evaluator
from .problem.problem import Problem
from .problem.problem_file import read_problem
from .result import Optimum
from .search.binding import account
from .search.descend import Descent
from .search.front import front
from .search.samples import Found
from .search.stages import Search, screen
from .work import Progress, Work


def optimise(
    problem: str | Path | Problem,
    *,
    starts: int = 6,
    seed: int = 1,
    check: bool = True,
    points: int = 12,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Optimum:
    """Find the best design inside bounds and limits.

    Every part (a share of the screen, a descent, the global check) is a function of the problem and
    the seed alone, so the number of workers does not change a bit of the result.

    Args:
        problem: The TOML file, or the problem that was read from it.
        starts: Number of descents by each aim.
        seed: Seed of starts and of the global check.
        check: Whether differential evolution checks the best descent.
        points: Points of the Pareto front of a problem with two aims.
        workers: Processes; by default as many as there are processors. 1: one, which is this one
            if ``OPENBLAS_NUM_THREADS=1`` was set before numpy was imported.
        progress: Called with (parts finished, parts known so far).

    Returns:
        The optimum, what holds it back, and how it was controlled.

    Raises:
        InputError: The file or an argument cannot be used.
        InfeasibleError: No design that was found meets all limits.
        SimulationError: No sample is a machine that can be simulated, or a process died.
    """
    whole("starts", starts, 1, MOST_STARTS)
    whole("seed", seed, 0, MOST_SEED)
    whole("points", points, 2, MOST_STARTS)
    count = worker_count(workers)
    problem = problem if isinstance(problem, Problem) else read_problem(problem)
    began = time.perf_counter()
    with Work(count, progress) as work:
        search = Search(problem, screen(problem, seed, work), starts, seed, work)
        descents = search.descents(problem.aims[0])
        found, polished = search.check(problem.aims[0]) if check else (None, None)
        best, gain, every = descents[0], 0.0, [*descents]
        if polished is not None:
            every.append(polished)
            if polished.rank < best.rank:
                size = max(abs(best.aim), abs(polished.aim))
                gain = (best.aim - polished.aim) / size if size > 0.0 else 0.0
                best = polished
        curve: tuple[tuple[float, ...], ...] = ()
        if len(problem.aims) > 1:
            second = search.descents(problem.aims[1], best.z)
            scales = tuple(search.scales(aim) for aim in problem.aims)
            curve, more = front(problem, scales, (best, second[0]), points, work)
            every += [*second, *more]
        source, by = Evaluator(problem), search.scales(problem.aims[0])
        designs = [_known(design(source, by, z)) for z in (best.z, *curve)]
        seen, *others = work.mapper(partial(control, problem.text()), designs)
    ends: list[Descent | Found] = [*every, *([] if found is None else [found])]
    engines = Counter(item.engine for item in search.seen if item.engine)
    for item in ends:
        engines.update(item.engines)
    return Optimum(
        problem=problem,
        seed=seed,
        before=design(source, by, tuple(problem.start.tolist())),
        best=designs[0],
        account=account(problem.with_aim(problem.aims[0]), by, best.z),
        descents=descents,
        screened=len(search.seen),
        no_machine=_reasons(item.why for item in search.seen if item.why),
        check=found,
        check_gain=gain,
        engines=dict(engines),
        why_engine=source.why,
        control=seen,
        front=tuple(designs[1:]),
        front_controls=tuple(others),
        evaluations=len(search.seen) + sum(item.evaluations for item in ends),
        wall_s=time.perf_counter() - began,
    )


def _reasons(messages: Iterable[str]) -> tuple[str, ...]:
    """The first message of each kind: two that differ in their numbers alone are one."""
    found: dict[str, str] = {}
    for message in messages:
        found.setdefault(without_numbers(message), message)
    return tuple(found.values())


def _known(found: Design | None) -> Design:
    """A design that was simulated before."""
    if found is None:
        message = "unforeseen, please report it: a design that was simulated cannot be again"
        raise SimulationError(message)
    return found

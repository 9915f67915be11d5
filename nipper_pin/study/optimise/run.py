"""A design problem from its file to its optimum: screen, descents, global check, front, control."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from ...errors import InputError, SimulationError
from .binding import account
from .control import control
from .descend import Descent, Scales, descend
from .evaluate import Evaluator
from .front import front
from .problem import Aim, Problem
from .result import Design, Optimum
from .search import SHARE, Found, Seen, begins, evolve, look, samples, scales
from .store import Store
from .unmet import mended
from .work import Progress, Work


def optimise(
    problem: Problem,
    *,
    starts: int = 6,
    seed: int = 1,
    check: bool = True,
    points: int = 12,
    workers: int | None = None,
    folder: str | Path | None = None,
    progress: Progress | None = None,
) -> Optimum:
    """Find the best design inside bounds and limits.

    Every part (a share of the screen, a descent, the global check) is a function of the problem and
    the seed alone, so the number of workers and an interruption do not change a bit of the result.

    Args:
        problem: The problem.
        starts: Number of descents by each aim.
        seed: Seed of starts and of the global check.
        check: Whether differential evolution checks the best descent.
        points: Points of the Pareto front of a problem with two aims.
        workers: Processes; by default as many as there are processors. 1: one, which is this one
            if ``OPENBLAS_NUM_THREADS=1`` was set before numpy was imported.
        folder: Where finished parts are kept and found again; by default nowhere.
        progress: Called with (parts finished, parts known so far).

    Raises:
        InputError: An argument is out of range, or the folder holds another problem.
        InfeasibleError: No design that was found meets all limits.
        SimulationError: No sample is a machine that can be simulated, or a process died.
    """
    for name, value, least in (
        ("starts", starts, 1),
        ("seed", seed, 0),
        ("points", points, 2),
        ("workers", 1 if workers is None else workers, 1),
    ):
        if value < least:
            message = f"{name} = {value}: at least {least}"
            raise InputError(message, argument=name, value=value)
    began = time.perf_counter()
    store = Store(folder, problem, {"seed": seed, "starts": starts})
    with Work(store, workers or os.cpu_count() or 1, progress) as work:
        seen = _screen(problem, seed, work)
        search = _Search(problem, seen, starts, seed, work)
        descents = search.descents(problem.aims[0], "first")
        best = descents[0]
        found, polished, gain = None, None, 0.0
        if check:
            found, polished = search.check(problem.aims[0])
            if polished is not None and polished.rank < best.rank:
                size = max(abs(best.aim), abs(polished.aim))
                gain = (best.aim - polished.aim) / size if size > 0.0 else 0.0
                best = polished
        every = [*descents, *([] if polished is None else [polished])]
        curve: tuple[tuple[float, ...], ...] = ()
        if len(problem.aims) > 1:
            second = search.descents(problem.aims[1], "second", best.z)
            by = tuple(search.scales(aim) for aim in problem.aims)
            curve, more = front(problem, by, (best, second[0]), points, work)
            every += [*second, *more]
    evaluations = len(seen) + sum(item.evaluations for item in every)
    evaluations += 0 if found is None else found.evaluations
    source = Evaluator(problem)
    other, values = control(problem, np.array(best.z), source.engine)
    first = problem.asking(problem.aims[0])
    by_first = search.scales(problem.aims[0])
    return Optimum(
        problem=problem,
        seed=seed,
        before=_design(source, by_first, tuple(problem.start.tolist())),
        best=_known(_design(source, by_first, best.z)),
        account=account(first, by_first, best.z),
        descents=descents,
        screened=len(seen),
        no_machine=tuple(dict.fromkeys(item.why for item in seen if item.why)),
        check=found,
        check_gain=gain,
        engine=source.engine,
        other_engine=other,
        control=values,
        front=tuple(_known(_design(source, by_first, z)) for z in curve),
        evaluations=evaluations,
        wall_s=time.perf_counter() - began,
    )


def _screen(problem: Problem, seed: int, work: Work) -> list[Seen]:
    places = [tuple(z) for z in samples(problem, seed).tolist()]
    text = problem.text()
    tasks = {
        f"screen_{k}": partial(look, text, tuple(places[k : k + SHARE]))
        for k in range(0, len(places), SHARE)
    }
    shares = work.all(tuple[Seen, ...], tasks)
    seen = [item for share in shares for item in share]
    if not any(item.values for item in seen):
        message = (
            f"none of {len(seen)} samples is a machine that can be simulated ({seen[0].why}); "
            "narrow the bounds around the model's own values"
        )
        raise SimulationError(message, samples=len(seen), why=seen[0].why)
    return seen


@dataclass(frozen=True, eq=False)
class _Search:
    """Descents and checks from one screen."""

    problem: Problem
    seen: Sequence[Seen]
    starts: int
    seed: int
    work: Work

    def scales(self, aim: Aim) -> Scales:
        return scales(self.problem, aim, self.seen)

    def descents(self, aim: Aim, name: str, *more: tuple[float, ...]) -> tuple[Descent, ...]:
        """Descents from all starts, the best first; the limits are met by that one at least."""
        problem, by = self.problem.asking(aim), self.scales(aim)
        text = problem.text()
        places = (*begins(self.seen, aim, by, self.starts), *more)
        tasks = {f"{name}_{k}": partial(descend, text, by, z) for k, z in enumerate(places)}
        found = self.work.all(Descent, tasks)
        if not any(item.feasible for item in found):
            found += mended(problem, by, found, name, self.work)
        return tuple(sorted(found, key=lambda item: item.rank))

    def check(self, aim: Aim) -> tuple[Found, Descent | None]:
        """Differential evolution, and the descent from what it found."""
        problem, by = self.problem.asking(aim), self.scales(aim)
        text = problem.text()
        found = self.work.one(
            Found, "check", partial(evolve, text, by, self.seed, self.work.mapper)
        )
        if not found.feasible:
            return found, None
        (polished,) = self.work.all(
            Descent, {"check_polished": partial(descend, text, by, found.z)}
        )
        return found, polished


def _design(source: Evaluator, by: Scales, z: tuple[float, ...]) -> Design | None:
    point = source.at(np.array(z))
    if not point.usable:
        return None
    return Design(
        z=z,
        numbers=source.problem.numbers(point.z),
        values=dict(point.values),
        slacks=point.slacks,
        inside=by.inside(point),
    )


def _known(design: Design | None) -> Design:
    """A design that was simulated before."""
    if design is None:
        message = "unforeseen, please report it: a design that was simulated cannot be again"
        raise SimulationError(message)
    return design

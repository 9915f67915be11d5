"""Search from several starts; the same seed gives the same bits."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from scipy.stats import qmc

from ....arrays import FloatArray
from ....given import MOST_SEED, MOST_STARTS, whole
from ...processes import mapped, worker_count
from ...toml_files import no_machine
from ..problem.problem import Problem, read_problem
from ..problem.targets import premises
from .fit import Descent, Fit, descend
from .limits import excesses
from .objective import Objective

Progress = Callable[[int, int, float], None]

# Draws for one start until it makes a machine whose jaw closes.
_DRAWS = 64


def identify(
    problem: str | Path | Problem | None = None,
    *,
    starts: int = 4,
    seed: int = 1,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Fit:
    """Fit numbers of a model to published ratios or to measured rebounds.

    The first descent starts from the model's own values, the others from a scrambled Sobol
    sequence over the bounds. Each is independent of all others, so the number of workers does not
    change a bit of the result.

    Transitions are simulated as if the machine arrived in its initial phase. If it does not at the
    best fit, the search is done again with the transitions of whole turns, from that fit on.

    Args:
        problem: The TOML file, or the problem that was read from it; by default the published
            ratios.
        starts: Number of descents.
        seed: Seed of the starts.
        workers: Processes; by default as many as there are processors. 1: one, which is this one
            if ``OPENBLAS_NUM_THREADS=1`` was set before numpy was imported.
        progress: Called with (starts done, starts in all, least cost so far).

    Returns:
        The fit. ``fit.goodness.sentence()`` says how good it is, ``fit.goodness.check()`` raises
        where its data contradict it.

    Raises:
        InputError: The file or an argument cannot be used.
        SimulationError: No start led to a machine that can be simulated.
    """
    problem = problem if isinstance(problem, Problem) else read_problem(problem)
    whole("starts", starts, 1, MOST_STARTS)
    whole("seed", seed, 0, MOST_SEED)
    count = min(starts, worker_count(workers))
    objective = Objective(problem)
    begins = list(_starts(objective, starts, seed))
    fit = _best(objective, begins, seed, count, progress)
    if all(premise.holds is not False for premise in fit.premises.values()):
        return fit
    # Only here: to find out in every step how the machine arrives takes several times as long.
    begins[0] = fit.best.z
    return _best(replace(objective, true=True), begins, seed, count, progress)


def _best(
    objective: Objective,
    begins: Sequence[FloatArray],
    seed: int,
    workers: int,
    progress: Progress | None,
) -> Fit:
    """The best of the descents from some starts."""
    starts = len(begins)
    found: list[Descent] = []
    for descent in mapped(partial(descend, objective), begins, workers):
        found.append(descent)
        if progress is not None:
            progress(len(found), starts, min(item.cost for item in found))
    ranked = tuple(sorted(found, key=lambda item: item.cost))
    if not np.isfinite(ranked[0].cost):
        error = no_machine(f"{starts} starts", objective.failure(objective.start))
        raise error
    (fit,) = mapped(partial(_fitted, objective, seed), [ranked], 1)
    return fit


def _fitted(objective: Objective, seed: int, ranked: tuple[Descent, ...]) -> Fit:
    """Result of the best of some descents."""
    problem, z = objective.problem, ranked[0].z
    mechanism, excess = objective.mechanism(z), np.zeros(0)
    if problem.limits is not None:
        excess = excesses(problem.limits, objective.cycle(mechanism, problem.limits))
    return Fit(
        objective=objective,
        seed=seed,
        descents=ranked,
        values=objective.values(z),
        predicted=objective.predicted(z),
        excess=excess,
        premises=premises(mechanism, problem.targets, problem.tolerance, problem.rest_rate),
    )


def _starts(objective: Objective, count: int, seed: int) -> Iterator[FloatArray]:
    """The model's own values, then points of a Sobol sequence, in blocks of draws."""
    yield objective.start
    if count == 1:
        return
    size = len(objective.problem.parameters)
    draws = qmc.Sobol(size, scramble=True, rng=np.random.default_rng(seed))
    needed = (count - 1) * _DRAWS
    points = draws.random_base2(int(np.ceil(np.log2(needed))))[:needed]
    # Drawn within the middle of the ranges: a descent has to have room on both sides.
    yield from 0.1 + 0.8 * points.reshape(count - 1, _DRAWS, size)

"""The studies as Python functions of the file of a command, or of the value read from it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from ..mechanism import Mechanism, need_mechanism

if TYPE_CHECKING:
    from . import identify as identification
    from . import optimise as optimisation
    from .check import ModelReport
    from .sweep import Plan, SweepReport


def check(
    mechanism: Mechanism, speed_rpm: float | None = None, start_index: float | None = None
) -> ModelReport:
    """Report structure, timing, clearances and forces of a model over one cycle.

    Args:
        mechanism: The model.
        speed_rpm: Cylinder speed [r/min]; by default the rated one.
        start_index: Index at which the cycle starts; by default that of ``Case``.

    Returns:
        The report of ``nipper-pin check``.

    Raises:
        SimulationError: The cycle cannot be simulated.
        InputError: The speed is none, or this is no mechanism.
    """
    need_mechanism(mechanism, "check")
    from ..hybrid import START_INDEX
    from .check import check_model

    speed = mechanism.cylinder.rated_speed_rpm if speed_rpm is None else speed_rpm
    return check_model(mechanism, speed, START_INDEX if start_index is None else start_index)


def sweep(
    study: str | Path | Plan,
    folder: str | Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    chunks: tuple[int, int] | None = None,
    progress: Callable[[int, int, int], None] | None = None,
) -> SweepReport:
    """Compute what is missing of a sweep; ``nipper_pin.read_sweep`` gives its rows.

    Args:
        study: The TOML file, or the plan that was read from it.
        folder: Folder of the results; one that holds a part of them is completed.
        workers: Local processes; by default as many as there are processors.
        scheduler: Address of a Dask scheduler to use instead.
        chunks: Numbers of the first and the last chunk to compute; by default all.
        progress: Called with (scenarios stored, of these found on disk, scenarios in all).

    Returns:
        What was done, with the folder.

    Raises:
        InputError: The file or an argument cannot be used, or the folder holds another sweep.
        SimulationError: Workers were lost; what is finished is kept.
    """
    from .sweep import Plan, read_plan, run_sweep

    plan = study if isinstance(study, Plan) else read_plan(str(study))
    return run_sweep(
        plan, folder, workers=workers, scheduler=scheduler, chunks=chunks, progress=progress
    )


def optimise(
    problem: str | Path | optimisation.Problem,
    *,
    starts: int = 6,
    seed: int = 1,
    check: bool = True,
    points: int = 12,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> optimisation.Optimum:
    """Find the best design inside bounds and limits.

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
    from .optimise import Problem, read_problem
    from .optimise import optimise as search

    return search(
        problem if isinstance(problem, Problem) else read_problem(problem),
        starts=starts,
        seed=seed,
        check=check,
        points=points,
        workers=workers,
        progress=progress,
    )


def identify(
    problem: str | Path | identification.Problem | None = None,
    *,
    starts: int = 4,
    seed: int = 1,
    workers: int | None = None,
    progress: Callable[[int, int, float], None] | None = None,
) -> identification.Fit:
    """Fit numbers of a model to published ratios or to measured rebounds.

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
    from .identify import Problem, read_problem
    from .identify import identify as fit

    return fit(
        problem if isinstance(problem, Problem) else read_problem(problem),
        starts=starts,
        seed=seed,
        workers=workers,
        progress=progress,
    )

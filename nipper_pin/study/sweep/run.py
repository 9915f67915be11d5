"""A sweep from its plan to its folder."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...errors import InputError
from .local import on_this_machine
from .plan import Plan
from .store import Store

Progress = Callable[[int, int, int], None]
"""Called with (scenarios stored, of these found on disk, scenarios in all)."""


@dataclass(frozen=True, kw_only=True)
class SweepReport:
    """What a run of a sweep did.

    Attributes:
        folder: Where the results are.
        scenarios: Scenarios of the plan, all of which are stored.
        found: Those that were stored before.
        chunks: Chunks of the plan.
        workers: Local processes, or the address of the scheduler.
        wall_s: Time of this run [s].
    """

    folder: Path
    scenarios: int
    found: int
    chunks: int
    workers: int | str
    wall_s: float

    def record(self) -> dict[str, Any]:
        """The report as plain data for JSON."""
        return {
            "folder": str(self.folder),
            "scenarios": self.scenarios,
            "found": self.found,
            "chunks": self.chunks,
            "workers": self.workers,
            "wall_s": self.wall_s,
        }


def run_sweep(
    plan: Plan,
    folder: str | Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> SweepReport:
    """Compute what is missing of a sweep, and store each chunk as soon as it is finished.

    The rows do not depend on who computes them: chunks follow from the plan, and each is computed
    alone, in one thread.

    Args:
        plan: The plan.
        folder: Folder of the results; one that holds a part of them is completed.
        workers: Local processes; by default as many as there are processors.
        scheduler: Address of a Dask scheduler to use instead.
        progress: Called at the start and after every chunk.

    Raises:
        InputError: An argument cannot be used, or the folder holds another sweep.
        SimulationError: Workers were lost; what is finished is kept.
    """
    if workers is not None and workers < 1:
        message = f"workers = {workers}: at least 1"
        raise InputError(message, workers=workers)
    if workers is not None and scheduler is not None:
        message = "--workers counts local processes, and --scheduler has its own; leave one out"
        raise InputError(message, workers=workers, scheduler=scheduler)
    began = time.perf_counter()
    store = Store(folder, plan)
    chunks = plan.chunks()
    missing = store.missing(chunks)
    total = plan.scenarios
    found = done = total - sum(chunk.stop - chunk.start for chunk in missing)
    if progress is not None:
        progress(done, found, total)
    count = min(len(missing), workers or os.cpu_count() or 1)
    if missing:
        text, tasks = plan.job.text(), plan.rows(missing)
        if scheduler is None:
            results = on_this_machine(text, tasks, count)
        else:
            from .cluster import on_scheduler

            results = on_scheduler(text, tasks, scheduler)
        # Closed at once if something fails here, so that no worker goes on for nothing.
        with closing(results):
            for chunk, content in results:
                store.write(chunk, content)
                done += chunk.stop - chunk.start
                if progress is not None:
                    progress(done, found, total)
    return SweepReport(
        folder=Path(folder),
        scenarios=total,
        found=found,
        chunks=len(chunks),
        workers=scheduler or count,
        wall_s=time.perf_counter() - began,
    )

"""A sweep from its plan to its folder."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from ...errors import InputError, SimulationError
from ..folders import alone_in
from ..processes import worker_count
from .chunks import DefectError
from .local import on_this_machine
from .plan import Chunk, Plan, chosen
from .report import SweepReport
from .results import Store, Tally, need_pyarrow
from .results.chunk_file import DamageError, read
from .results.extremes import Extremes
from .study_file import read_plan

Progress = Callable[[int, int, int], None]


def sweep(
    study: str | Path | Plan,
    folder: str | Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    chunks: tuple[int, int] | None = None,
    progress: Progress | None = None,
) -> SweepReport:
    """Compute what is missing of a sweep, and store each chunk as soon as it is finished.

    ``nipper_pin.read_sweep`` gives its rows. They do not depend on who computes them: chunks follow
    from the plan, and each is computed alone, in one thread. One process at a time works in a
    folder, or several with ranges of chunks.

    Args:
        study: The TOML file, or the plan that was read from it.
        folder: Folder of the results; one that holds a part of them is completed.
        workers: Local processes; by default as many as there are processors.
        scheduler: Address of a Dask scheduler to use instead.
        chunks: Numbers of the first and the last chunk to compute; by default all.
        progress: Called with (scenarios stored, of these found on disk, scenarios in all): at the
            start, after every chunk, and while a scheduler is waited for.

    Returns:
        What was done, with the folder.

    Raises:
        InputError: The file or an argument cannot be used, the folder holds another sweep, or
            another process works in it.
        SimulationError: Workers were lost, or scenarios met a fault of the program; what is
            finished is kept. Or no scenario at all has a result.
    """
    plan = study if isinstance(study, Plan) else read_plan(str(study))
    count = worker_count(workers)
    if workers is not None and scheduler is not None:
        message = "--workers counts local processes, and --scheduler has its own; leave one out"
        raise InputError(message, workers=workers, scheduler=scheduler)
    if scheduler is not None:
        from .cluster import check_address

        check_address(scheduler)
    need_pyarrow()
    began = time.perf_counter()
    with alone_in(folder, shared=chunks is not None):
        store = Store(folder, plan)
        run = _Run(store, count, scheduler, chosen(store.plan.chunks(), chunks), progress)
        run.complete()
    report = SweepReport(
        folder=Path(folder),
        scenarios=run.total,
        found=run.total - run.computed,
        computed=run.computed,
        chunks=run.chunks,
        damaged=tuple(run.damaged.values()),
        workers=scheduler or run.count,
        wall_s=time.perf_counter() - began,
        tally=run.tally,
        extremes=run.extremes,
    )
    report.check()
    return report


class _Run:
    """One run of a sweep."""

    def __init__(
        self,
        store: Store,
        workers: int,
        scheduler: str | None,
        chosen: list[Chunk],
        progress: Progress | None,
    ) -> None:
        self._store, self._scheduler, self._progress = store, scheduler, progress
        self._workers = workers
        self._left = {chunk.number: chunk for chunk in chosen}
        self._done = self._found = 0
        self.chunks = len(chosen)
        self.total = sum(chunk.stop - chunk.start for chunk in chosen)
        self.computed = self.count = 0
        self.tally, self.extremes = Tally(), Extremes(store.plan.job)
        self.damaged: dict[int, str] = {}
        self.defects: list[DefectError] = []

    def complete(self) -> None:
        """Compute what is missing."""
        self._look_for_stored()
        self._found = self._done
        self._tell()
        try:
            self._compute()
        except KeyboardInterrupt:
            # One that was stored in this moment is counted, too.
            self._look_for_stored()
            self._tell()
            raise
        if self.defects:
            message = (
                f"{self.defects[0].message}; {len(self.defects)} of {self.chunks} chunks are not "
                "stored for such a reason, all others are"
            )
            raise SimulationError(message, **self.defects[0].evidence)

    def _look_for_stored(self) -> None:
        for chunk in list(self._left.values()):
            try:
                table = self._store.rows(chunk)
            except DamageError as error:
                # As good as none.
                self.damaged[chunk.number] = Path(error.evidence["file"]).name
                continue
            if table is not None:
                self._finish(chunk, table)

    def _finish(self, chunk: Chunk, table: object) -> None:
        self.tally.add(table)
        self.extremes.add(table)
        self._done += chunk.stop - chunk.start
        self._left.pop(chunk.number)

    def _compute(self) -> None:
        # Nothing to do: no process is started.
        if not self._left:
            return
        plan = self._store.plan
        text, tasks = plan.job.text(), plan.rows(list(self._left.values()))
        if self._scheduler is None:
            self.count = min(len(self._left), self._workers)
            results = on_this_machine(text, tasks, self.count)
        else:
            from .cluster import on_scheduler

            results = on_scheduler(text, tasks, self._scheduler, self._tell)
        # Closed at once if something fails here, so that no worker goes on for nothing.
        with closing(results):
            for chunk, content in results:
                if isinstance(content, DefectError):
                    self.defects.append(content)
                    self._left.pop(chunk.number)
                else:
                    self._store.write(chunk, content)
                    self._finish(chunk, read(content, self.extremes.columns))
                    self.computed += chunk.stop - chunk.start
                self._tell()

    def _tell(self) -> None:
        if self._progress is not None:
            self._progress(self._done, self._found, self.total)

"""Chunks on the processors of this machine."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool

from ...arrays import FloatArray
from ...errors import InputError, SimulationError
from ..processes import fresh_processes
from .chunks import DefectError, run_chunk
from .plan import Chunk

# Chunks that wait for each worker beside the one that it computes.
_AHEAD = 1


def check_workers(workers: int | None) -> None:
    """Refuse a number of processes that is none.

    Args:
        workers: Number of processes; None: one a processor.

    Raises:
        InputError: It is below 1.
    """
    if workers is not None and workers < 1:
        message = f"workers = {workers}: at least 1"
        raise InputError(message, workers=workers)


def on_this_machine(
    job_text: bytes, tasks: Iterable[tuple[Chunk, FloatArray]], workers: int
) -> Generator[tuple[Chunk, bytes | DefectError], None, None]:
    """Compute chunks in processes, and give each as it finishes, or the defect that it met.

    Even one worker is a process of its own: what it computes does not depend on what else this
    one does.

    Args:
        job_text: Text of the job.
        tasks: Chunks with their rows.
        workers: Number of processes.

    Raises:
        SimulationError: A process died.
    """
    # They start while the first samples are drawn.
    with fresh_processes(workers, wake) as pool:
        running: dict[Future[bytes], Chunk] = {}
        try:
            for chunk, rows in tasks:
                if len(running) >= workers * (1 + _AHEAD):
                    yield from _finished(running)
                running[pool.submit(run_chunk, job_text, chunk.start, rows)] = chunk
            while running:
                yield from _finished(running)
        except BrokenProcessPool as error:
            message = (
                "a worker process died, perhaps for want of memory; what is finished is kept: run "
                "the same command again, with fewer --workers"
            )
            raise SimulationError(message, workers=workers) from error
        finally:
            for future in running:
                future.cancel()


def _finished(running: dict[Future[bytes], Chunk]) -> Iterator[tuple[Chunk, bytes | DefectError]]:
    """Wait for at least one chunk, and take out all that are done."""
    for future in wait(running, return_when=FIRST_COMPLETED).done:
        chunk = running.pop(future)
        try:
            yield chunk, future.result()
        except DefectError as defect:
            yield chunk, defect


def wake() -> None:
    """Nothing: a process starts for it, and imports what this module needs."""

"""Chunks on the processors of this machine."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context, parent_process

from ...arrays import FloatArray
from ...errors import SimulationError
from ..processes import one_thread_each
from .chunks import run_chunk
from .plan import Chunk

# Chunks that wait for each worker beside the one that it computes.
_AHEAD = 1


def on_this_machine(
    job_text: bytes, tasks: Iterable[tuple[Chunk, FloatArray]], workers: int
) -> Generator[tuple[Chunk, bytes], None, None]:
    """Compute chunks in processes, and give each as it finishes.

    Even one worker is a process of its own: what it computes does not depend on what else this
    one does.

    Args:
        job_text: Text of the job.
        tasks: Chunks with their rows.
        workers: Number of processes.

    Raises:
        SimulationError: A process died.
    """
    # Fresh processes: a fork of one that has threads may never end.
    with (
        one_thread_each(),
        ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_prepare) as pool,
    ):
        running: dict[Future[bytes], Chunk] = {}
        # They start while the first samples are drawn.
        with _interrupts_held_back():
            for _ in range(workers):
                pool.submit(_wake)
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


def _finished(running: dict[Future[bytes], Chunk]) -> Iterator[tuple[Chunk, bytes]]:
    """Wait for at least one chunk, and take out all that are done."""
    for future in wait(running, return_when=FIRST_COMPLETED).done:
        yield running.pop(future), future.result()


@contextmanager
def _interrupts_held_back() -> Iterator[None]:
    """Processes that start in here leave interrupts from the keyboard to this one.

    They inherit the mask, and so are deaf from their first instruction on; here an interrupt is
    only late.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _wake() -> None:
    """Nothing: a process starts for it, and imports what this module needs."""


def _prepare() -> None:
    """Do not outlive the process that stores."""
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """A worker whose parent was killed would wait for its next chunk for ever."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)

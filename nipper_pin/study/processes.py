"""Worker processes of all studies: their start, their results and their end."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager
from multiprocessing import active_children, get_context, parent_process
from typing import Self, TypeVar

from ..errors import SimulationError
from ..given import MOST_WORKERS, whole

_T = TypeVar("_T")
_R = TypeVar("_R")
_K = TypeVar("_K")

# Tasks that wait for each worker beside the one that it computes.
_AHEAD = 1
_FEWER = ": use fewer processes"
KEPT = "; what is finished is kept in the folder: run the same command again, with fewer --workers"
"""Advice about a worker that died, where finished results are stored."""

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_AT_START = {name: os.environ.get(name) for name in _THREADS}


class WorkerError(SimulationError):
    """A worker process died, or could not be started. Evidence: ``workers``."""


def worker_count(workers: int | None) -> int:
    """Number of processes that is asked for; without one as many as there are processors.

    Raises:
        InputError: It is below 1.
    """
    return (os.cpu_count() or 1) if workers is None else whole("workers", workers, 1, MOST_WORKERS)


@contextmanager
def one_thread_each() -> Iterator[None]:
    """Processes that start in this block compute in one thread each: there is one a processor."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def in_one_thread() -> bool:
    """Whether BLAS computes in one thread here, as it does in :func:`fresh_processes`.

    In several threads it adds up in another order even three numbers, so the last bits of a
    result would depend on who computes. BLAS reads the environment once, when it is loaded.
    """
    return (_AT_START["OPENBLAS_NUM_THREADS"] or _AT_START["OMP_NUM_THREADS"]) == "1"


@contextmanager
def fresh_processes(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Worker processes of one thread each; they ignore Ctrl-C and end with this process.

    Raises:
        WorkerError: A process cannot be started.
    """
    before = set(active_children())
    # Spawned, since a fork of a process with threads may deadlock.
    with (
        one_thread_each(),
        ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_prepare) as pool,
    ):
        try:
            with _interrupts_held_back():
                for _ in range(workers):
                    # A process starts with a task.
                    pool.submit(bool)
        except OSError as error:
            # The pool does not end those that did start, and Python would wait for them at its end.
            for process in set(active_children()) - before:
                process.terminate()
            message = f"{workers} worker processes cannot be started ({error}): use fewer processes"
            raise WorkerError(message, workers=workers) from error
        yield pool


@contextmanager
def _interrupts_held_back() -> Iterator[None]:
    """Processes that start in this block ignore Ctrl-C.

    They inherit the blocked signal; this process receives it at the end of the block.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _prepare() -> None:
    """Watch the parent process, in a thread."""
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End this worker with its parent; otherwise it would wait for its next task for ever."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


class Workers:
    """Processes that do tasks; they start with the first one.

    Args:
        count: Number of processes; 1: one, which is this one if its BLAS computes in one thread.
        advice: What to do if a process dies, the end of a sentence.
        apart: Even one worker is a process of its own.
    """

    def __init__(self, count: int, *, advice: str = _FEWER, apart: bool = False) -> None:
        """Prepare; nothing starts yet."""
        self._count = count
        self._advice = advice
        self._apart = apart
        self._stack = ExitStack()
        self._pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> Self:
        """Nothing starts yet."""
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """End the processes; after a failure or an interrupt without the tasks that wait."""
        if self._pool is not None and kind is not None:
            # Waits for those that run: otherwise the interpreter may end in the midst of it, and
            # complains. It would wait for them itself.
            self._pool.shutdown(cancel_futures=True)
        self._stack.close()

    def in_order(
        self, function: Callable[[_T], _R], items: Iterable[_T], chunk: int = 1
    ) -> Iterator[_R]:
        """Results of a function in the order of its arguments.

        Args:
            function: A function that another process can find, or a partial of one.
            items: What it is called with.
            chunk: Calls that a process is sent at once.

        Raises:
            WorkerError: A process died.
        """
        pool = self._started()
        if pool is None:
            yield from map(function, items)
            return
        with self._named():
            yield from pool.map(function, items, chunksize=chunk)

    def as_completed(self, tasks: Iterable[tuple[_K, Callable[[], _R]]]) -> Iterator[tuple[_K, _R]]:
        """Results of tasks as they come; tasks are drawn as processes need them.

        Args:
            tasks: What to do, each with what tells its result from the others.

        Raises:
            WorkerError: A process died.
        """
        pool = self._started()
        if pool is None:
            for key, task in tasks:
                yield key, task()
            return
        running: dict[Future[_R], _K] = {}
        try:
            with self._named():
                for key, task in tasks:
                    if len(running) >= self._count * (1 + _AHEAD):
                        yield from _finished(running)
                    running[pool.submit(task)] = key
                while running:
                    yield from _finished(running)
        finally:
            for future in running:
                future.cancel()

    def _started(self) -> ProcessPoolExecutor | None:
        here = self._count == 1 and not self._apart and in_one_thread()
        if self._pool is None and not here:
            self._pool = self._stack.enter_context(fresh_processes(self._count))
        return self._pool

    @contextmanager
    def _named(self) -> Iterator[None]:
        try:
            yield
        except BrokenProcessPool as error:
            message = (
                f"a worker process died, perhaps for want of memory{self._advice} (a script of "
                "your own has to call this below `if __name__ == '__main__':`)"
            )
            raise WorkerError(message, workers=self._count) from error


def mapped(task: Callable[[_T], _R], items: Iterable[_T], workers: int) -> Iterator[_R]:
    """Results of a task for some items, as :meth:`Workers.in_order` gives them."""
    with Workers(workers) as own:
        yield from own.in_order(task, items)


def _finished(running: dict[Future[_R], _K]) -> Iterator[tuple[_K, _R]]:
    """Wait for at least one task, and take out all that are done."""
    for future in wait(running, return_when=FIRST_COMPLETED).done:
        yield running.pop(future), future.result()

"""What all studies that compute in several processes share."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from typing import TypeVar

from ..errors import SimulationError

_T = TypeVar("_T")
_R = TypeVar("_R")

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_AT_START = {name: os.environ.get(name) for name in _THREADS}


@contextmanager
def one_thread_each() -> Iterator[None]:
    """Processes that start in here compute in one thread: there is one for every processor."""
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
def fresh_processes(workers: int, first: Callable[[], None]) -> Iterator[ProcessPoolExecutor]:
    """Processes of one thread each that leave interrupts to this one and do not outlive it.

    Args:
        workers: Number of processes.
        first: Nothing to do, from the module that their work comes from: what it imports is
            imported while this process goes on.
    """
    # Fresh processes: a fork of one that has threads may never end.
    with (
        one_thread_each(),
        ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_prepare) as pool,
    ):
        with _interrupts_held_back():
            for _ in range(workers):
                pool.submit(first)
        yield pool


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


def _prepare() -> None:
    """Do not outlive the process that collects."""
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """A worker whose parent was killed would wait for its next task for ever."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def mapped(task: Callable[[_T], _R], items: Iterable[_T], workers: int) -> Iterator[_R]:
    """Results of a task for some items, in their order.

    Args:
        task: A function that another process can find, or a partial of one.
        items: What it is called with.
        workers: Processes; 1: one, which is this one if its BLAS computes in one thread.

    Raises:
        SimulationError: A process died.
    """
    if workers == 1 and in_one_thread():
        yield from map(task, items)
        return
    with fresh_processes(workers, _nothing) as pool:
        try:
            yield from pool.map(task, items)
        except BrokenProcessPool as error:
            message = (
                "a worker process died, perhaps for want of memory: use fewer processes (a script "
                "of your own has to call this below `if __name__ == '__main__':`)"
            )
            raise SimulationError(message, workers=workers) from error


def _nothing() -> None:
    """What the processes of :func:`mapped` begin with."""

"""What all studies that compute in several processes share."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context
from typing import TypeVar

from ..errors import SimulationError

_T = TypeVar("_T")
_R = TypeVar("_R")

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


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


def mapped(task: Callable[[_T], _R], items: Iterable[_T], workers: int) -> Iterator[_R]:
    """Results of a task for some items, in their order.

    Args:
        task: A function that another process can find, or a partial of one.
        items: What it is called with.
        workers: Processes; 1: this process alone.

    Raises:
        SimulationError: A process died.
    """
    if workers == 1:
        yield from map(task, items)
        return
    # Fresh processes: a fork of one that has threads may never end.
    with one_thread_each(), ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        try:
            yield from pool.map(task, items)
        except BrokenProcessPool as error:
            message = "a worker process died, perhaps for want of memory; use fewer processes"
            raise SimulationError(message, workers=workers) from error

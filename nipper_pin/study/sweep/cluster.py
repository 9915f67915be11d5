"""Chunks on an existing Dask scheduler."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import contextmanager
from queue import Empty, SimpleQueue
from threading import Thread
from typing import Any

from ...arrays import FloatArray
from ...errors import InputError, SimulationError
from ...extras import require
from .chunks import DefectError, run_chunk
from .job import other_versions, versions
from .plan import Chunk

# How long to wait for a scheduler, for its first worker and an answer of each [s]; for workers to
# come again when all are lost; and between two looks at the workers.
_CONNECT_S, _LOST_S, _LOOK_S = 20.0, 30.0, 1.0
# Chunks on the scheduler for each thread of its workers: one runs, others wait at hand.
_AHEAD = 3
_SCHEMES = ("tcp", "tls", "ws", "wss", "ucx")
_KEPT = "what is finished is kept: run the same command again"


def on_scheduler(
    job_text: bytes,
    tasks: Iterable[tuple[Chunk, FloatArray]],
    address: str,
    look: Callable[[], None],
) -> Generator[tuple[Chunk, bytes | DefectError], None, None]:
    """Compute chunks on the workers of a scheduler, and give each as it finishes.

    The scheduler gives the chunks of a worker that dies to others. Results come back here, where
    each chunk is taken once.

    Args:
        tasks: Chunks with their rows.
        address: Address of the scheduler, such as ``tcp://host:8786``, checked.
        look: Called now and then while nothing finishes.

    Raises:
        InputError: The scheduler cannot be reached, has no workers, or these lack the package.
        SimulationError: The scheduler or all workers were lost, or a chunk took down every worker
            that had it.
    """
    from distributed.scheduler import KilledWorker

    with _silent(), _client(address) as client:
        _check_workers(client, address)
        try:
            yield from _Work(client, address, look).results(job_text, tasks)
        except KilledWorker as error:
            message = (
                f"a chunk took down several workers of {address}, perhaps for want of memory; "
                f"{_KEPT}"
            )
            raise SimulationError(message, scheduler=address) from error
        except (OSError, CancelledError) as error:
            message = f"the scheduler {address} was lost; {_KEPT}"
            raise SimulationError(message, scheduler=address) from error


class _Work:
    """Chunks that are under way."""

    def __init__(self, client: Any, address: str, look: Callable[[], None]) -> None:
        self._client, self._address, self._look = client, address, look
        self._running: dict[str, Chunk] = {}
        # Futures are referenced, since the scheduler drops results without a reference.
        self._held: dict[str, Any] = {}
        self._finished: SimpleQueue[Any] = SimpleQueue()
        self._answers: SimpleQueue[tuple[str, bytes | BaseException]] = SimpleQueue()
        self._threads = sum(client.nthreads().values())

    def results(
        self, job_text: bytes, tasks: Iterable[tuple[Chunk, FloatArray]]
    ) -> Iterator[tuple[Chunk, bytes | DefectError]]:
        """Submit as many as the workers need, and give what comes back."""
        fetching = Thread(target=self._fetch, daemon=True)
        fetching.start()
        try:
            for chunk, rows in tasks:
                while len(self._running) >= _AHEAD * max(1, self._threads):
                    yield self._next()
                future = self._client.submit(run_chunk, job_text, chunk.start, rows, pure=False)
                self._held[future.key] = future
                self._running[future.key] = chunk
                future.add_done_callback(self._finished.put)
            while self._running:
                yield self._next()
        finally:
            # A released future ends the wait for its result.
            for future in self._held.values():
                future.release()
            self._finished.put(None)
            fetching.join(_LOOK_S)

    def _fetch(self) -> None:
        """Fetch results in a separate thread.

        A worker that dies takes with it what it has finished and not handed over: only who does
        not wait for it sees that nobody is left to do it again.
        """
        while (future := self._finished.get()) is not None:
            try:
                self._answers.put((future.key, future.result()))
            except BaseException as error:
                self._answers.put((future.key, error))

    def _next(self) -> tuple[Chunk, bytes | DefectError]:
        key, answer = self._answer()
        self._held.pop(key).release()
        if isinstance(answer, BaseException) and not isinstance(answer, DefectError):
            raise answer
        return self._running.pop(key), answer

    def _answer(self) -> tuple[str, bytes | BaseException]:
        """Wait for a result, and see that somebody is there to compute it."""
        last = time.monotonic()
        while True:
            try:
                return self._answers.get(timeout=_LOOK_S)
            except Empty:
                self._look()
            # What Dask does to come back takes it longer, and gives up what was under way.
            if self._client.status != "running":
                raise CancelledError
            self._threads = sum(self._client.nthreads().values())
            if self._threads:
                last = time.monotonic()
            elif time.monotonic() - last > _LOST_S:
                message = (
                    f"all workers of {self._address} were lost, and for {_LOST_S:.0f} s none came; "
                    f"{_KEPT}"
                )
                raise SimulationError(message, scheduler=self._address)


def check_address(address: str) -> None:
    """Refuse what is no scheduler's address, and a machine without Dask.

    Args:
        address: Address of the scheduler, such as ``tcp://host:8786``.

    Raises:
        InputError: It is none, or Dask is not installed.
    """
    require("cluster", "distributed", what="--scheduler")
    scheme, separator, _ = address.partition("://")
    if separator and scheme not in _SCHEMES:
        message = (
            f"--scheduler {address}: no address of a scheduler; such begin with tcp:// or tls://, "
            "as `dask scheduler` prints it"
        )
        raise InputError(message, scheduler=address)


@contextmanager
def _client(address: str) -> Iterator[Any]:
    from distributed import Client

    try:
        client = Client(address, timeout=_CONNECT_S, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        message = f"--scheduler {address}: cannot be reached ({error}); start `dask scheduler`"
        raise InputError(message, scheduler=address) from error
    with client:
        yield client


def _check_workers(client: Any, address: str) -> None:
    """Wait for the first worker, and refuse those that cannot compute what is to be computed."""
    try:
        client.wait_for_workers(1, timeout=_CONNECT_S)
    except TimeoutError as error:
        message = f"--scheduler {address}: has no workers; start `dask worker {address}`"
        raise InputError(message, scheduler=address) from error
    # In a separate thread, since a worker that hangs would never answer.
    pool = ThreadPoolExecutor(1)
    try:
        answer = pool.submit(client.run, versions, on_error="return").result(_CONNECT_S)
    except TimeoutError as error:
        message = f"--scheduler {address}: a worker does not answer; start its workers again"
        raise InputError(message, scheduler=address) from error
    finally:
        pool.shutdown(wait=False)
    other = [worker for worker, found in answer.items() if found != versions()]
    if other:
        found = answer[other[0]]
        lacking = f"the package is not installed there: {found}"
        if isinstance(found, dict):
            lacking = other_versions(found, versions())
        message = (
            f"--scheduler {address}: {len(other)} of {len(answer)} workers cannot compute this, "
            f"such as {other[0]} ({lacking}); install the same versions everywhere"
        )
        raise InputError(message, scheduler=address, workers=other)


@contextmanager
def _silent() -> Iterator[None]:
    """Nothing from Dask beside our own sentence; it logs by many loggers, each with its level."""
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(before)

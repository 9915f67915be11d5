"""Parts of an optimisation, in processes of one thread each, kept as soon as they are finished.

SciPy's SLSQP takes another way, from the last bits on, where its BLAS has several threads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager
from types import TracebackType
from typing import Any, Self, TypeVar

from ...errors import SimulationError
from ..processes import fresh_processes, in_one_thread
from .store import Store

Progress = Callable[[int, int], None]
"""Called with (parts finished, parts known so far)."""

PartT = TypeVar("PartT")
PlaceT = TypeVar("PlaceT")


class Work:
    """Does parts and keeps them; what is kept already is not done again.

    Args:
        store: Where they are kept.
        workers: Processes; 1: one, or this process itself if its BLAS has one thread.
        progress: Called whenever a part is finished or more parts become known.
    """

    def __init__(self, store: Store, workers: int, progress: Progress | None) -> None:
        """Prepare; processes start with the first part that is missing."""
        self._store = store
        self._workers = workers
        self._progress = progress
        self._stack = ExitStack()
        self._pool: ProcessPoolExecutor | None = None
        self._done: set[str] = set()
        self._known = 0

    def __enter__(self) -> Self:
        """Nothing starts yet."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        _error: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        """End the processes; after a failure without what waits in them."""
        if self._pool is not None and kind is not None:
            self._pool.shutdown(wait=False, cancel_futures=True)
        self._stack.close()

    def all(self, kind: type[PartT], tasks: Mapping[str, Callable[[], PartT]]) -> list[PartT]:
        """Results of tasks in their order.

        Args:
            kind: Type of a result, plain data.
            tasks: What to do, by the name under which it is kept.

        Raises:
            SimulationError: A process died.
        """
        found = {name: self._store.get(name, kind) for name in tasks}
        missing = {name: task for name, task in tasks.items() if found[name] is None}
        self._known += len(tasks)
        self._advance(*(name for name in tasks if name not in missing))
        with self._counted(kind, missing):
            for name, part in self._results(missing):
                self._store.put(name, part)
                found[name] = part
                self._advance(name)
        return [part for part in found.values() if part is not None]

    def one(self, kind: type[PartT], name: str, task: Callable[[], PartT]) -> PartT:
        """Result of one task that is done here, perhaps by way of :meth:`mapper`.

        Args:
            kind: Type of the result.
            name: The name under which it is kept.
            task: What to do.
        """
        self._known += 1
        found = self._store.get(name, kind)
        with self._counted(kind, [name]):
            if found is None:
                found = task()
                self._store.put(name, found)
            self._advance(name)
        return found

    def mapper(self, function: Callable[[PlaceT], PartT], places: Iterable[PlaceT]) -> list[PartT]:
        """Results of a function, in the order of its arguments; they are not kept.

        Args:
            function: What to map; it can be sent to other processes.
            places: Its arguments.
        """
        pool = self._processes()
        if pool is None:
            return [function(place) for place in places]
        return self._guarded(lambda: list(pool.map(function, places, chunksize=4)))

    def _results(self, tasks: Mapping[str, Callable[[], PartT]]) -> Iterable[tuple[str, PartT]]:
        pool = self._processes() if tasks else None
        if pool is None:
            for name, task in tasks.items():
                yield name, task()
            return
        running: dict[Future[Any], str] = {pool.submit(task): name for name, task in tasks.items()}
        for future in as_completed(running):
            yield running[future], self._guarded(future.result)

    def _processes(self) -> ProcessPoolExecutor | None:
        if self._pool is None and not (self._workers == 1 and in_one_thread()):
            self._pool = self._stack.enter_context(fresh_processes(self._workers, _wake))
        return self._pool

    def _guarded(self, take: Callable[[], PartT]) -> PartT:
        try:
            return take()
        except BrokenProcessPool as error:
            message = (
                "a worker process died, perhaps for want of memory; parts that are finished are "
                "kept in the folder: run the same command again, with fewer --workers (a script "
                "of your own has to call this below `if __name__ == '__main__':`)"
            )
            raise SimulationError(message, workers=self._workers) from error

    @contextmanager
    def _counted(self, kind: type[PartT], names: Iterable[str]) -> Iterator[None]:
        """An interrupt counts the part, too, that was stored in that moment."""
        try:
            yield
        except KeyboardInterrupt:
            self._advance(*(name for name in names if self._store.get(name, kind) is not None))
            raise

    def _advance(self, *names: str) -> None:
        self._done.update(names)
        if self._progress is not None:
            self._progress(len(self._done), self._known)


def _wake() -> None:
    """Nothing: a process starts for it, and imports what this module needs."""

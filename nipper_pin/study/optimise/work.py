"""Parts of an optimisation, in processes of one thread each, kept as soon as they are finished.

With several threads BLAS rounds differently, and SciPy's SLSQP follows another path.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from types import TracebackType
from typing import Self, TypeVar

from ..processes import KEPT, Workers
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
        self._workers = Workers(workers, _wake, advice=KEPT)
        self._progress = progress
        self._done: set[str] = set()
        self._known = 0

    def __enter__(self) -> Self:
        """Nothing starts yet."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the processes; after a failure without what waits in them."""
        self._workers.__exit__(kind, error, trace)

    def all(self, kind: type[PartT], tasks: Mapping[str, Callable[[], PartT]]) -> list[PartT]:
        """Results of tasks in their order.

        Args:
            kind: Type of a result, plain data.
            tasks: What to do, by the name under which it is kept.

        Raises:
            WorkerError: A process died.
        """
        found = {name: self._store.get(name, kind) for name in tasks}
        missing = {name: task for name, task in tasks.items() if found[name] is None}
        self._known += len(tasks)
        self._advance(*(name for name in tasks if name not in missing))
        with self._counted(kind, missing):
            for name, part in self._workers.as_completed(missing.items()) if missing else ():
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

        Raises:
            WorkerError: A process died.
        """
        return list(self._workers.in_order(function, places, chunk=4))

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
    """No effect; a worker that calls it imports this module."""

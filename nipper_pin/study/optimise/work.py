"""Parts of an optimisation, in processes of one thread each.

With several threads BLAS rounds differently, and SciPy's SLSQP follows another path.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

from ..processes import Workers

Progress = Callable[[int, int], None]
"""Called with (parts finished, parts known so far)."""

PartT = TypeVar("PartT")
PlaceT = TypeVar("PlaceT")


class Work(Workers):
    """Does parts and counts them.

    Args:
        workers: Processes; 1: one, or this process itself if its BLAS has one thread.
        progress: Called whenever a part is finished or more parts become known.
    """

    def __init__(self, workers: int, progress: Progress | None) -> None:
        """Prepare; processes start with the first part."""
        super().__init__(workers)
        self._progress = progress
        self._done = 0
        self._known = 0

    def all(self, tasks: Sequence[Callable[[], PartT]]) -> list[PartT]:
        """Results of tasks in their order.

        Raises:
            WorkerError: A process died.
        """
        self._tell(known=len(tasks))
        found: dict[int, PartT] = {}
        for place, part in self.as_completed(enumerate(tasks)):
            found[place] = part
            self._tell(done=1)
        return [found[place] for place in range(len(tasks))]

    def one(self, task: Callable[[], PartT]) -> PartT:
        """Result of one task that is done here, perhaps by way of :meth:`mapper`."""
        self._known += 1
        found = task()
        self._tell(done=1)
        return found

    def mapper(self, function: Callable[[PlaceT], PartT], places: Iterable[PlaceT]) -> list[PartT]:
        """Results of a function, in the order of its arguments; they are not counted.

        Args:
            function: What to map; it can be sent to other processes.
            places: Its arguments.

        Raises:
            WorkerError: A process died.
        """
        return list(self.in_order(function, places, chunk=4))

    def _tell(self, done: int = 0, known: int = 0) -> None:
        self._done += done
        self._known += known
        if self._progress is not None:
            self._progress(self._done, self._known)

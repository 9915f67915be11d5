"""Rows of scenarios by their numbers: grids as mixed radix numbers, samples as a stream."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import pairwise
from math import prod
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from .axes import Axis

# Points from a number to one before another, shape (points, parameters).
_Stream = Callable[[int, int], FloatArray]
Method = Literal["sobol", "latin_hypercube"]
# A scrambled Sobol sequence of 30 bits has no more points; a Latin hypercube is made as a whole.
MOST_SAMPLES: dict[Method, int] = {"sobol": 2**30, "latin_hypercube": 10_000_000}


@dataclass(frozen=True, kw_only=True)
class Samples:
    """How sampled parameters are drawn.

    Attributes:
        method: Scrambled Sobol sequence or Latin hypercube.
        count: Number of samples.
        seed: Seed; the same one gives the same samples.
        earlier: Counts that the sequence had before points were added, ascending.
    """

    method: Method
    count: int
    seed: int
    earlier: tuple[int, ...] = ()


class Layout:
    """Order of scenarios: everything that needs another mechanism varies slowest.

    Args:
        axes: All parameters.
        samples: How the sampled ones are drawn; None if there are none.

    Attributes:
        total: Number of scenarios.
        inner: Scenarios of one mechanism, which follow one another.
    """

    def __init__(self, axes: Sequence[Axis], samples: Samples | None) -> None:
        """Order the parameters."""
        model = [item for item in axes if item.values and item.target.kind == "model"]
        table = [item for item in axes if item.values and item.target.kind != "model"]
        drawn = any(item.target.kind == "model" for item in axes if not item.values)
        count = 1 if samples is None else samples.count
        # Samples stand between the two grids, or before both if they change the model.
        self._grid = [*model, *table]
        self._place = 0 if drawn else len(model)
        sizes = [len(item.values) for item in self._grid]
        sizes.insert(self._place, count)
        self._sizes = sizes
        self.total = prod(sizes)
        inner = prod(len(item.values) for item in table)
        self.inner = inner if drawn else inner * count

    def indices(self, numbers: NDArray[np.int64]) -> tuple[list[tuple[Axis, Any]], Any]:
        """Places on the grids, and numbers of samples, of scenarios.

        Args:
            numbers: Their numbers, shape (n,).

        Returns:
            Grid parameters with their places, each shape (n,); numbers of samples, shape (n,).
        """
        places = []
        for size in reversed(self._sizes):
            numbers, place = np.divmod(numbers, size)
            places.append(place)
        places.reverse()
        drawn = places.pop(self._place)
        return list(zip(self._grid, places, strict=True)), drawn


@dataclass(frozen=True, kw_only=True)
class Stage:
    """Scenarios of the points that were added at a time.

    Attributes:
        start: First scenario.
        first: First sample.
        layout: Order of these scenarios.
    """

    start: int
    first: int
    layout: Layout


def stages(axes: Sequence[Axis], samples: Samples | None) -> list[Stage]:
    """Scenarios in the parts in which their samples were asked for; mostly that is one."""
    if samples is None:
        return [Stage(start=0, first=0, layout=Layout(axes, None))]
    found, start = [], 0
    for first, last in pairwise([0, *samples.earlier, samples.count]):
        layout = Layout(axes, replace(samples, count=last - first))
        found.append(Stage(start=start, first=first, layout=layout))
        start += layout.total
    return found


class Rows:
    """Values of all parameters of ranges of scenarios; cheapest if asked for in order."""

    def __init__(self, axes: Sequence[Axis], samples: Samples | None) -> None:
        """Prepare the samples."""
        self._axes = tuple(axes)
        self._stages = stages(axes, samples)
        self._drawn = [item for item in axes if not item.values]
        self._stream = None if samples is None else _stream(samples, len(self._drawn))

    def between(self, start: int, stop: int) -> FloatArray:
        """Rows of scenarios ``start`` to ``stop``, shape (stop - start, parameters)."""
        return self.at(np.arange(start, stop, dtype=np.int64))

    def at(self, numbers: NDArray[np.int64]) -> FloatArray:
        """Rows of ascending scenarios of one stage, shape (n, parameters)."""
        stage = [item for item in self._stages if item.start <= numbers[0]][-1]
        grid, drawn = stage.layout.indices(numbers - stage.start)
        columns = {axis.name: np.array(axis.values)[place] for axis, place in grid}
        if self._stream is not None:
            unit = _gathered(self._stream, stage.first + drawn)
            for place, axis in enumerate(self._drawn):
                columns[axis.name] = axis.sampled(unit[:, place])
        return np.stack([columns[axis.name] for axis in self._axes], axis=1)


def _gathered(stream: _Stream, numbers: Any) -> FloatArray:
    """Points by their numbers, which go up and may start again."""
    parts = np.split(numbers, np.flatnonzero(np.diff(numbers) < 0) + 1)
    found = []
    for part in parts:
        low, high = int(part[0]), int(part[-1])
        found.append(stream(low, high + 1)[part - low])
    return np.concatenate(found)


def _stream(samples: Samples, dimensions: int) -> _Stream:
    """Points of samples; those of a Latin hypercube exist only all at once."""
    from scipy.stats import qmc

    rng = np.random.default_rng(samples.seed)
    if samples.method == "latin_hypercube":
        points = np.asarray(qmc.LatinHypercube(dimensions, rng=rng).random(samples.count))
        return lambda start, stop: points[start:stop]
    engine = qmc.Sobol(dimensions, scramble=True, rng=rng)
    # Grids that vary faster than the samples ask for the same points again.
    return lru_cache(maxsize=1)(partial(_drawn, engine))


def _drawn(engine: Any, start: int, stop: int) -> FloatArray:
    """Points of a Sobol sequence; only going back starts it again."""
    if engine.num_generated > start:
        engine.reset()
    if engine.num_generated < start:
        engine.fast_forward(start - engine.num_generated)
    with warnings.catch_warnings():
        # It warns of a first part whose size is no power of two; the parts are ours.
        warnings.simplefilter("ignore", UserWarning)
        return np.asarray(engine.random(stop - start))

"""From ``STUDY.toml`` to a validated plan: scenarios, chunks, and a hash that names them."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from ...arrays import FloatArray
from ...errors import InputError
from ...given import refuse, whole
from ..transitions import REDUCED_PAYS_FROM
from ..turns import TURNS_PAY_FROM
from .axes import Axis
from .job import Job
from .samples import Layout, Rows, Samples, stages

# Chunks that a sweep is cut into before they grow to their most.
_CHUNKS = 64
_MOST_CHUNKS = 1_000_000
# Where mechanisms change, chunks of about this time [s], and what it is made of.
_SHORTEST_S, _LONGEST_S = 0.25, 2.0
_MECHANISM_S = 6e-3


class _Costs(NamedTuple):
    """What the size of chunks is chosen by.

    Attributes:
        least: Fewest scenarios of a chunk where one mechanism serves many.
        most: Most of them.
        pays_from: Scenarios of a mechanism from which on the reduced engine pays.
        tables: Time of its tables of a mechanism [s].
        reduced: Time of a scenario by it [s].
        direct: Time of a scenario by the direct engine [s].
    """

    least: int
    most: int
    pays_from: int
    tables: float
    reduced: float
    direct: float


_TRANSITIONS = _Costs(8192, 65_536, REDUCED_PAYS_FROM, 40e-3, 20e-6, 2.5e-3)
# A scenario that repeats after few turns; one that does not takes up to ten times as long.
_TURNS = _Costs(1024, 8192, TURNS_PAY_FROM, 0.25, 0.3e-3, 60e-3)


@dataclass(frozen=True, kw_only=True)
class Chunk:
    """A range of scenarios that is computed and stored as one.

    Attributes:
        number: Number of the chunk.
        start: First scenario.
        stop: The one after the last.
    """

    number: int
    start: int
    stop: int


@dataclass(frozen=True, kw_only=True)
class Plan:
    """A sweep.

    Attributes:
        title: What it is about.
        job: What workers need to know.
        samples: How sampled parameters are drawn; None if there are none.
        chunk: Most scenarios of a chunk if the study says so, or None.
    """

    title: str
    job: Job
    samples: Samples | None
    chunk: int | None

    @property
    def axes(self) -> tuple[Axis, ...]:
        """The parameters."""
        return self.job.axes

    @property
    def scenarios(self) -> int:
        """Number of scenarios."""
        return Layout(self.axes, self.samples).total

    @property
    def mechanisms(self) -> int:
        """Number of mechanisms that are built."""
        layout = Layout(self.axes, self.samples)
        return layout.total // layout.inner

    @property
    def hash(self) -> str:
        """Name of the results: plans with the same hash have the same rows in the same chunks."""
        rest = repr((self.job.identity, self.samples, self.chunk))
        return hashlib.sha256(rest.encode()).hexdigest()

    def chunks(self) -> list[Chunk]:
        """All chunks. They depend on the plan alone, and so does the engine of every scenario.

        Scenarios of one mechanism are divided evenly if one chunk does not hold them; otherwise a
        chunk holds whole mechanisms. Points that were added to a sequence have chunks of their own.
        """
        edges, costs = [0], _TRANSITIONS if self.job.turn is None else _TURNS
        for stage in stages(self.axes, self.samples):
            edges.extend(stage.start + edge for edge in _edges(stage.layout, self.chunk, costs))
        return [
            Chunk(number=number, start=start, stop=stop)
            for number, (start, stop) in enumerate(pairwise(edges))
        ]

    def rows(self, chunks: Iterable[Chunk]) -> Iterator[tuple[Chunk, FloatArray]]:
        """Values of the parameters, chunk by chunk, each shape (scenarios, parameters)."""
        rows = Rows(self.axes, self.samples)
        for chunk in chunks:
            yield chunk, rows.between(chunk.start, chunk.stop)


def _edges(layout: Layout, chunk: int | None, costs: _Costs) -> list[int]:
    """Ends of the chunks of one layout, ascending."""
    total, inner = layout.total, layout.inner
    most = chunk or (
        min(max(costs.least, math.ceil(total / _CHUNKS)), costs.most)
        if inner > costs.least
        else inner * _mechanisms_together(total // inner, inner, costs)
    )
    step, pieces = max(most // inner, 1) * inner, math.ceil(inner / most)
    # Refused are more chunks than a folder holds files.
    if (count := math.ceil(total / step) * pieces) > _MOST_CHUNKS:
        message = (
            f"chunk: {count} chunks of the scenarios, and at most {_MOST_CHUNKS} are stored; give "
            "a larger chunk, or fewer scenarios"
        )
        raise InputError(message, chunks=count)
    if inner <= most:
        return [*range(step, total, step), total]
    return [
        first + part * inner // pieces
        for first in range(0, total, inner)
        for part in range(1, pieces + 1)
    ]


def _mechanisms_together(mechanisms: int, inner: int, costs: _Costs) -> int:
    """Mechanisms of one chunk."""
    direct = inner < costs.pays_from
    scenarios = inner * costs.direct if direct else costs.tables + inner * costs.reduced
    cost = _MECHANISM_S + scenarios
    least, most = math.ceil(_SHORTEST_S / cost), math.ceil(_LONGEST_S / cost)
    return min(max(least, math.ceil(mechanisms / _CHUNKS)), most)


def chosen(chunks: list[Chunk], bounds: tuple[int, int] | None) -> list[Chunk]:
    """Chunks of a range; one that ends behind the last chunk ends with it.

    Args:
        chunks: All chunks.
        bounds: Numbers of the first and the last one of the range; None: all.

    Raises:
        InputError: There is no such chunk.
    """
    if bounds is None:
        return chunks
    if not (isinstance(bounds, tuple | list) and len(bounds) == 2):
        refuse("chunks", bounds, "two whole numbers, of the first and the last chunk")
    first, last = (whole("chunks", item, 0, _MOST_CHUNKS) for item in bounds)
    if not 0 <= first <= last or first >= len(chunks):
        message = f"--chunks {first}-{last}: there are {len(chunks)} chunks, 0 to {len(chunks) - 1}"
        raise InputError(message, chunks=[first, last])
    return chunks[first : last + 1]

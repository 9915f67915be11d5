"""Estimate of the time of a sweep, from one of its chunks."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

from ...units import MS_PER_S, S_PER_H, S_PER_MIN
from ..processes import Workers, worker_count
from ..transitions import REDUCED_PAYS_FROM
from .chunks import run_chunk
from .plan import Chunk, Plan, chosen
from .results import Tally, need_pyarrow
from .results.chunk_file import read
from .results.tally import SUMMARY

# The first scenario of the chunk that is timed at most: a sequence has to be drawn up to there.
_FAR = 1_000_000
# Start of the processes, until their first chunk [s].
_START_S = 1.5
# Of a chunk that takes longer than this [s] a part is timed, each four times the one before.
_ENOUGH_S, _GROWTH = 2.0, 4


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """Estimated time of a sweep, or of a range of its chunks.

    Attributes:
        seconds: Time on so many processes [s].
        workers: Processes.
        scenario_s: Time of a scenario, with its share of what its mechanism takes [s].
        engines: Scenarios that were timed, by engine.
    """

    seconds: float
    workers: int
    scenario_s: float
    engines: dict[str, int]

    def record(self) -> dict[str, Any]:
        """The estimate as plain data for JSON."""
        return asdict(self)

    def sentence(self) -> str:
        """The estimate in words."""
        parts = [f"{count:,} by the engine {name}" for name, count in self.engines.items()]
        return (
            f"about {_words(self.seconds)} on {self.workers} processors here: "
            f"{MS_PER_S * self.scenario_s:.3g} ms a scenario (timed: {', '.join(parts)})"
        )


def _words(seconds: float) -> str:
    """A time in the unit that suits it; it is no more than an estimate."""
    for unit, length in (("h", S_PER_H), ("min", S_PER_MIN)):
        if seconds > 3.0 * length:
            return f"{seconds / length:,.0f} {unit}"
    return f"{seconds:,.0f} s"


def estimate(
    plan: Plan, workers: int | None = None, chunks: tuple[int, int] | None = None
) -> Estimate:
    """Time a chunk of a plan, in a process like those of a sweep.

    Args:
        workers: Processes; by default as many as there are processors.
        chunks: Numbers of the first and the last chunk to compute; by default all.

    Raises:
        InputError: A package is missing, or an argument cannot be used.
        DefectError: A scenario meets a fault of the program.
        WorkerError: The process died.
    """
    most = worker_count(workers)
    need_pyarrow()
    asked = chosen(plan.chunks(), chunks)
    near = [chunk for chunk in asked if plan.samples is None or chunk.start <= _FAR] or asked[:1]
    count = min(most, len(asked))
    with Workers(1, apart=True) as pool:
        ((scenario_s, engines),) = pool.in_order(partial(timed, plan), [near[len(near) // 2]])
    return Estimate(
        seconds=_START_S + scenario_s * sum(chunk.stop - chunk.start for chunk in asked) / count,
        workers=count,
        scenario_s=scenario_s,
        engines=engines,
    )


def timed(plan: Plan, chunk: Chunk) -> tuple[float, dict[str, int]]:
    """Time of a scenario of a chunk [s], and how many were timed, by engine.

    Where only a part of the chunk is timed, the rest goes on as its last scenarios did: what the
    tables of a mechanism take is in the first ones.
    """
    text, size = plan.job.text(), chunk.stop - chunk.start
    ((_, rows),) = plan.rows([chunk])
    # The first ones load compiled code, once a process.
    count = min(REDUCED_PAYS_FROM, size)
    run_chunk(text, chunk.start, rows[:count])
    before, seconds = 0, 0.0
    while True:
        began = time.perf_counter()
        content = run_chunk(text, chunk.start, rows[:count])
        earlier, seconds = seconds, time.perf_counter() - began
        slope = max(seconds - earlier, 0.0) / (count - before)
        if count == size or seconds > _ENOUGH_S:
            break
        before, count = count, min(_GROWTH * count, size)
    tally = Tally()
    tally.add(read(content, SUMMARY))
    return (seconds + slope * (size - count)) / size, dict(tally.engines)

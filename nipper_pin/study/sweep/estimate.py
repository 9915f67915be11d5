"""Estimate of the time of a sweep, from a few scenarios that are timed."""

from __future__ import annotations

import math
import os
import time
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...units import MS_PER_S, S_PER_H, S_PER_MIN
from ..processes import Workers
from ..transitions import REDUCED, REDUCED_PAYS_FROM
from .chunks import run_chunk
from .local import check_workers, wake
from .plan import Plan, chosen
from .results import Tally, need_pyarrow
from .results.chunk_file import read
from .results.tally import SUMMARY
from .samples import Rows, stages

# Mechanisms that are tried, scenarios of each, and the scenario up to which they are looked for: a
# sequence has to be drawn up to the last point that is asked for.
_MECHANISMS, _FEW, _MANY, _FAR = 3, REDUCED_PAYS_FROM, 1024, 1_000_000
# Start of the processes, until their first chunk [s].
_START_S = 1.5


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """Estimated time of a sweep, or of a range of its chunks.

    Attributes:
        seconds: Time on so many processes [s].
        workers: Processes.
        mechanism_s: Time that a mechanism takes before its first scenario [s].
        scenario_s: Time of a scenario [s].
        engines: Scenarios that were timed, by engine.
    """

    seconds: float
    workers: int
    mechanism_s: float
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
            f"{MS_PER_S * self.mechanism_s:.3g} ms a mechanism, "
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
    """Time a few scenarios of a plan, in a process like those of a sweep.

    Args:
        plan: The plan.
        workers: Processes; by default as many as there are processors.
        chunks: Numbers of the first and the last chunk to compute; by default all.

    Raises:
        InputError: A package is missing, or an argument cannot be used.
        DefectError: A scenario meets a fault of the program.
        WorkerError: The process died.
    """
    check_workers(workers)
    need_pyarrow()
    sizes = [chunk.stop - chunk.start for chunk in chosen(plan.chunks(), chunks)]
    count = min(workers or os.cpu_count() or 1, len(sizes))
    with Workers(1, wake, apart=True) as pool:
        (found,) = pool.in_order(partial(timed, plan), [max(sizes)])
    share = sum(sizes) / plan.scenarios
    work = share * (found.blocks * found.block_s + plan.scenarios * found.scenario_s)
    return Estimate(
        seconds=_START_S + work / count,
        workers=count,
        mechanism_s=found.block_s,
        scenario_s=found.scenario_s,
        engines=found.engines,
    )


@dataclass(frozen=True, kw_only=True)
class Timed:
    """Times of blocks of scenarios of one mechanism, computed together.

    Attributes:
        blocks: Blocks of the whole sweep.
        block_s: Time of a block beside its scenarios [s].
        scenario_s: Time of a scenario [s].
        engines: Scenarios that were timed, by engine.
    """

    blocks: int
    block_s: float
    scenario_s: float
    engines: dict[str, int]


def timed(plan: Plan, most: int) -> Timed:
    """Time some and many scenarios of a few mechanisms: what differs is the scenarios' time.

    Args:
        plan: The plan.
        most: Most scenarios of a chunk.
    """
    text, rows, tally = plan.job.text(), Rows(plan.axes, plan.samples), Tally()
    inner = stages(plan.axes, plan.samples)[0].layout.inner
    block = min(inner, most)
    # The first ones load compiled code, and the tables of a machine that all scenarios share.
    run_chunk(text, 0, rows.at(_spread(block, _FEW)))
    fixed, each = [], []
    for first in _firsts(plan, inner):
        few = first + _spread(block, _FEW)
        by_tables = tally.engines[REDUCED]
        few_s = _seconds(text, rows.at(few), tally)
        slope, rest = few_s / len(few), 0.0
        # A few cases of the direct engine suffice to estimate many.
        if block > _FEW and tally.engines[REDUCED] - by_tables > len(few) // 2:
            many = first + _spread(block, _MANY)
            more_s = _seconds(text, rows.at(many), tally) - few_s
            slope = max(more_s, 0.0) / (len(many) - len(few))
            rest = max(few_s - len(few) * slope, 0.0)
        each.append(slope)
        fixed.append(rest)
    return Timed(
        blocks=math.ceil(plan.scenarios / block),
        block_s=float(np.mean(fixed)),
        scenario_s=float(np.mean(each)),
        engines=dict(tally.engines),
    )


def _spread(block: int, most: int) -> NDArray[np.int64]:
    """Numbers of scenarios of a block, evenly spread over it."""
    last = min(block, _FAR) - 1
    return np.unique(np.linspace(0, last, min(block, most)).astype(np.int64))


def _firsts(plan: Plan, inner: int) -> list[int]:
    """First scenarios of some mechanisms."""
    reach = plan.scenarios if plan.samples is None else min(plan.scenarios, _FAR)
    places = np.linspace(0, max(reach // inner, 1) - 1, _MECHANISMS).astype(np.int64)
    return [int(place) * inner for place in np.unique(places)]


def _seconds(text: bytes, rows: FloatArray, tally: Tally) -> float:
    """Time of the scenarios, which are counted."""
    began = time.perf_counter()
    content = run_chunk(text, 0, rows)
    seconds = time.perf_counter() - began
    tally.add(read(content, SUMMARY))
    return seconds

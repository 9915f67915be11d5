"""The whole benchmark: engines, peers and costs on one machine, in one run."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from ..tolerances import DIRECT_DEFAULT
from .certified import certified, certified_names
from .cost import costs
from .peer_work import PACKAGES, Say, peer_rows
from .reduced_work import reduced_work
from .timing import environment
from .turns import TurnRow, turn_rows
from .work_precision import Row, accuracy, direct_rows


@dataclass(frozen=True)
class Benchmark:
    """Everything that one run found.

    Attributes:
        environment: Versions, processor, cores, threads.
        engines: Work against precision of this package's engines.
        accuracy: Errors of the direct engine in every certified transition.
        peers: Work against precision of other people's solvers, as far as they are installed.
        unavailable: What could not be run, and why.
        reduced: Build time, speed and error of the reduced engine.
        turns: Whole turns of both engines against the certified ones.
        cost: How the time grows with the size of the problem.
    """

    quick: bool
    environment: dict[str, Any]
    engines: tuple[Row, ...]
    accuracy: tuple[Row, ...]
    peers: tuple[Row, ...]
    unavailable: tuple[str, ...]
    reduced: dict[str, Any]
    turns: tuple[TurnRow, ...]
    cost: dict[str, Any]

    def record(self) -> dict[str, Any]:
        """Return the benchmark as plain data; what is not a finite number is null."""
        document: dict[str, Any] = _finite(asdict(self))
        return document


def benchmark(
    *,
    quick: bool = False,
    repeats: int | None = None,
    say: Say = lambda _: None,
) -> Benchmark:
    """Run the benchmark.

    Args:
        quick: Fewer settings and repeats: less than a minute in all.
        repeats: Runs of each setting after the first; 10 or 30 by default.
        say: Told what is being measured.

    Raises:
        SimulationError: A run that is timed fails.
        InputError: The certified reference is missing.
    """
    count = repeats if repeats is not None else (10 if quick else 30)
    reference = certified()
    mechanism = reference.mechanism()
    say("direct engine")
    engines = direct_rows(reference, quick=quick, repeats=count)
    accurate = []
    for name in certified_names():
        case = certified(name)
        accurate.append(accuracy(case, case.mechanism(), DIRECT_DEFAULT))
    say("reduced engine")
    reduced_rows, reduced = reduced_work(reference, quick=quick, repeats=count)
    say("whole turns")
    turns = turn_rows(repeats=count)
    say("peers")
    peers, unavailable = peer_rows(reference, quick=quick, repeats=count, say=say)
    say("costs")
    cost = costs(mechanism, quick=quick, repeats=count)
    return Benchmark(
        quick=quick,
        environment=environment(PACKAGES),
        engines=(*engines, *reduced_rows),
        accuracy=tuple(accurate),
        peers=tuple(peers),
        unavailable=tuple(unavailable),
        reduced=reduced,
        turns=tuple(turns),
        cost=cost,
    )


def _finite(value: Any) -> Any:
    """Plain data in which every number is finite."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value

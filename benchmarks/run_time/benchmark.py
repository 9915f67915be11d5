"""The whole benchmark: engines, peers and costs on one machine, in one run."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

from ..tolerances import DIRECT_DEFAULT
from .certified import certified, certified_names
from .cost import costs
from .peer_work import Say, peer_rows
from .reduced_work import reduced_work
from .timing import environment
from .turns import TurnRow, turn_rows
from .work_precision import Row, accuracy, direct_rows


@dataclass(frozen=True)
class Benchmark:
    """Everything that one run found; what could not be run is said, with the reason."""

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
        text = json.dumps(asdict(self))
        document: dict[str, Any] = json.loads(text, parse_constant=lambda _: None)
        return document


def benchmark(
    *,
    quick: bool = False,
    repeats: int | None = None,
    say: Say = lambda _: None,
) -> Benchmark:
    """Run the benchmark, each setting 30 times after the first or, quick, 10 times.

    Raises:
        SimulationError: A run that is timed fails.
        InputError: The certified reference is missing.
    """
    count = repeats if repeats is not None else (10 if quick else 30)
    reference = certified()
    mechanism = reference.mechanism()
    say("direct engine")
    engines = direct_rows(reference, quick=quick, repeats=count)
    accurate = [accuracy(certified(name), DIRECT_DEFAULT) for name in certified_names()]
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
        environment=environment(),
        engines=(*engines, *reduced_rows),
        accuracy=tuple(accurate),
        peers=tuple(peers),
        unavailable=tuple(unavailable),
        reduced=reduced,
        turns=tuple(turns),
        cost=cost,
    )

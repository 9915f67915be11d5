"""Running a campaign: each trial judged in a worker process."""

from __future__ import annotations

import hashlib
import os
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

from nipper_pin.errors import SimulationError
from nipper_pin.study.processes import WorkerError, Workers

from .judging import REFUSED, RIGHT, TIME_LIMIT_S, WRONG, Verdict, judge
from .refusals import excesses
from .space import trial

_FEWER = ": run fewer --workers"
_Job = tuple[int, int, float, tuple[str, ...]]


@dataclass(frozen=True)
class Campaign:
    """All verdicts of a campaign, in order of number.

    Attributes:
        wall_s: Wall time of the whole [s].
    """

    seed: int
    verdicts: tuple[Verdict, ...]
    wall_s: float

    def record(self) -> dict[str, Any]:
        """The campaign as plain data, the same for any number of workers but for ``wall_s``."""
        words = Counter(item.word for item in self.verdicts)
        digest = hashlib.sha256("".join(v.fingerprint for v in self.verdicts).encode())
        families: dict[str, Counter[str]] = {}
        for item in self.verdicts:
            families.setdefault(item.family, Counter())[item.word] += 1
        return {
            "cases": len(self.verdicts),
            **{word: words[word] for word in (RIGHT, REFUSED, WRONG)},
            "errors": dict(
                sorted(Counter(v.kind for v in self.verdicts if v.word != RIGHT).items())
            ),
            "outcomes": dict(
                sorted(Counter(v.kind for v in self.verdicts if v.word == RIGHT).items())
            ),
            "families": {
                name: {word: count[word] for word in (RIGHT, REFUSED, WRONG)}
                for name, count in families.items()
            },
            "failures": [
                {"number": v.number, "family": v.family, "kind": v.kind, "detail": v.detail}
                for v in self.verdicts
                if v.word == WRONG
            ],
            "refused_too_often": [asdict(item) for item in excesses(self.verdicts)],
            "seed": self.seed,
            "digest": digest.hexdigest(),
            "wall_s": self.wall_s,
        }


def run_campaign(
    cases: int,
    seed: int = 1,
    workers: int | None = None,
    progress: Callable[[Verdict], None] = lambda _: None,
    time_limit_s: float = TIME_LIMIT_S,
    families: Sequence[str] = (),
    first: int = 0,
) -> Campaign:
    """Judge the trials of a campaign in parallel.

    Args:
        cases: Number of trials.
        seed: Seed; a trial depends on it and on its number alone.
        workers: Processes; by default one a processor.
        progress: Called with each verdict as it comes.
        time_limit_s: Time of the processor after which a trial is a hang [s].
        families: Families that the trials are of, in turn; all by default.
        first: Number of the first trial.

    Raises:
        UnknownNameError: There is no such family.
        SimulationError: A worker process died.
    """
    began = time.perf_counter()
    verdicts: dict[int, Verdict] = {}
    count = workers or os.cpu_count() or 1
    jobs = [(seed, number, time_limit_s, tuple(families)) for number in range(first, first + cases)]
    try:
        for verdict in _judged(jobs, count):
            verdicts[verdict.number] = verdict
            progress(verdict)
    except WorkerError as error:
        message = f"{error.message}; {len(verdicts)} of {cases} trials are judged"
        raise SimulationError(message, workers=count, judged=len(verdicts)) from error
    ordered = tuple(verdicts[number] for number in sorted(verdicts))
    return Campaign(seed, ordered, time.perf_counter() - began)


def _judged(jobs: list[_Job], workers: int) -> Iterator[Verdict]:
    """Verdicts as they come."""
    if not jobs:
        return
    with Workers(workers, _wake, advice=_FEWER, apart=True) as pool:
        for _, verdict in pool.as_completed((job, partial(_judge, job)) for job in jobs):
            yield verdict


def _judge(job: _Job) -> Verdict:
    seed, number, time_limit_s, families = job
    return judge(trial(seed, number, families), time_limit_s)


def _wake() -> None:
    """No effect; a worker that calls it imports what trials need."""

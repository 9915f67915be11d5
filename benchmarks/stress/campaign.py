"""Running a campaign: each trial judged in a worker process."""

from __future__ import annotations

import hashlib
import os
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

from nipper_pin.study.processes import Workers

from .judging import REFUSED, RIGHT, TIME_LIMIT_S, WRONG, Verdict, judge
from .refusals import excesses
from .space import trial

_FEWER = ": run fewer --workers"


@dataclass(frozen=True)
class Campaign:
    """All verdicts of a campaign, in order of number."""

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
            "errors": self._kinds(right=False),
            "outcomes": self._kinds(right=True),
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

    def _kinds(self, *, right: bool) -> dict[str, int]:
        kinds = Counter(item.kind for item in self.verdicts if (item.word == RIGHT) is right)
        return dict(sorted(kinds.items()))


def run_campaign(
    cases: int,
    seed: int = 1,
    workers: int | None = None,
    progress: Callable[[Verdict], None] = lambda _: None,
    time_limit_s: float = TIME_LIMIT_S,
    families: Sequence[str] = (),
    first: int = 0,
) -> Campaign:
    """Judge trials, by default of all families in turn, in one process a processor.

    A trial depends on the seed and on its number alone; one that takes this time of the processor
    is a hang. Verdicts are told as they come.

    Raises:
        UnknownNameError: There is no such family.
        WorkerError: A worker process died.
    """
    began = time.perf_counter()
    verdicts: dict[int, Verdict] = {}
    jobs = (
        (number, partial(_judge, seed, number, tuple(families), time_limit_s))
        for number in range(first, first + cases)
    )
    with Workers(workers or os.cpu_count() or 1, advice=_FEWER, apart=True) as pool:
        for number, verdict in pool.as_completed(jobs):
            verdicts[number] = verdict
            progress(verdict)
    ordered = tuple(verdicts[number] for number in sorted(verdicts))
    return Campaign(seed, ordered, time.perf_counter() - began)


def _judge(seed: int, number: int, families: Sequence[str], time_limit_s: float) -> Verdict:
    return judge(trial(seed, number, families), time_limit_s)

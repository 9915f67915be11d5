"""Running a campaign: each trial judged in a worker process, the verdicts in order of number."""

from __future__ import annotations

import hashlib
import os
import signal
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from types import FrameType
from typing import Any

from ...errors import NipperError, SimulationError
from ...hybrid.case import Case, Resolution, Window
from ...hybrid.simulate import simulate
from ...hybrid.solution import Outcome
from ..processes import fresh_processes
from .agreement import bits, engines_agree, mirror_images, same_bits, within_errors
from .invariants import Violation, violations
from .space import Trial, trial

RIGHT, REFUSED, WRONG = "right", "refused", "wrong"
TIME_LIMIT_S = 120.0
# The tolerance of the second run: halved four times.
_FINER, _FINEST = 16.0, 1e-14
# Trials with more evaluations than this are run once only, at their own tolerance.
_LONG = 100_000
# Words of messages that own up to a fault of the package: never a good reason to refuse.
_CONFESSION = "please report"


@dataclass(frozen=True)
class Verdict:
    """What became of one trial.

    Attributes:
        number: Number of the trial.
        family: Its family.
        word: "right", "refused" or "wrong".
        kind: Type of the error of a refusal; the violated invariant, "hang" or "traceback" of a
            wrong one; how the run ended otherwise.
        detail: The reason; empty if right.
        fingerprint: Hash of every bit of the result.
        wall_s: Wall time [s].
    """

    number: int
    family: str
    word: str
    kind: str
    detail: str
    fingerprint: str
    wall_s: float = field(compare=False)


class _TimeIsUpError(BaseException):
    """A trial exceeds its time; not an Exception, so that nothing on the way catches it."""


def judge(item: Trial, time_limit_s: float = TIME_LIMIT_S) -> Verdict:
    """Run one trial and check it.

    Args:
        item: The trial.
        time_limit_s: Time of the processor after which it is a hang [s].
    """
    began = time.perf_counter()
    fingerprint = b""

    def verdict(word: str, kind: str, detail: str) -> Verdict:
        digest = hashlib.sha256(fingerprint or f"{word} {kind} {detail}".encode()).hexdigest()
        wall = time.perf_counter() - began
        return Verdict(item.number, item.family, word, kind, detail, digest, wall)

    try:
        with _limited(time_limit_s), warnings.catch_warnings():
            # A warning of numpy on the way is a wrong turn that nobody has thought of.
            warnings.simplefilter("error")
            outcome, fingerprint, found = _run(item)
    except NipperError as error:
        if _CONFESSION in error.message or not error.message:
            return verdict(WRONG, "confession", error.message)
        return verdict(REFUSED, type(error).__name__, error.message)
    except _TimeIsUpError:
        where = f"no end after {time_limit_s:g} s"
        return verdict(WRONG, "hang", where)
    except Exception:
        return verdict(WRONG, "traceback", traceback.format_exc(limit=-6))
    if found:
        return verdict(WRONG, found[0].kind, "; ".join(f"{x.kind}: {x.detail}" for x in found[:6]))
    return verdict(RIGHT, outcome, "")


def _run(item: Trial) -> tuple[str, bytes, list[Violation]]:
    """Simulate a trial twice as it is, once finer and once mirrored, and check all."""
    values = dict(item.case)
    resolution = Resolution(**values.pop("resolution"))
    case = Case(**values, resolution=resolution)
    mechanism = item.mechanism()
    solution = simulate(mechanism, case)
    found = violations(solution)
    if solution.evaluations > _LONG:
        return solution.outcome.name, bits(solution), found
    found += same_bits(solution, simulate(item.mechanism(), case))
    finer = replace(resolution, tolerance=max(resolution.tolerance / _FINER, _FINEST))
    if finer.tolerance < resolution.tolerance:
        # A tolerance that cannot be had is refused, which is an answer.
        try:
            fine = simulate(mechanism, replace(case, resolution=finer))
        except SimulationError:
            fine = None
        if fine is not None:
            found += within_errors(solution, fine)
    if (image := item.mirror_image()) is not None:
        try:
            seen = simulate(image, case)
        except SimulationError:
            # What is at the limit of the possible may be refused from one side only.
            seen = None
        if seen is not None:
            found += mirror_images(solution, seen)
    if case.window is Window.TRANSITION and solution.outcome is Outcome.AT_REST:
        found += engines_agree(solution, resolution.tolerance) or []
    return solution.outcome.name, bits(solution), found


@contextmanager
def _limited(seconds: float) -> Iterator[None]:
    """Raise in this thread, which must be the main one, when the time is up."""

    def up(_number: int, _frame: FrameType | None) -> None:
        raise _TimeIsUpError

    before = signal.signal(signal.SIGPROF, up)
    # Again and again: an exception that is raised inside a callback of the collector is lost.
    signal.setitimer(signal.ITIMER_PROF, seconds, max(seconds, 0.1))
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


@dataclass(frozen=True)
class Campaign:
    """All verdicts of a campaign, in order of number.

    Attributes:
        seed: Seed.
        verdicts: One for each trial.
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
            "seed": self.seed,
            "digest": digest.hexdigest(),
            "wall_s": self.wall_s,
        }


def run_campaign(
    cases: int,
    seed: int = 1,
    workers: int | None = None,
    progress: Callable[[Verdict], None] | None = None,
    time_limit_s: float = TIME_LIMIT_S,
) -> Campaign:
    """Judge the trials of a campaign in parallel.

    Args:
        cases: Number of trials.
        seed: Seed; a trial depends on it and on its number alone.
        workers: Processes; by default one a processor.
        progress: Called with each verdict, in order of number.
        time_limit_s: Time of the processor after which a trial is a hang [s].

    Raises:
        SimulationError: A worker process died.
    """
    began = time.perf_counter()
    verdicts: list[Verdict] = []
    count = workers or os.cpu_count() or 1
    with fresh_processes(count, _wake) as pool:
        jobs = ((seed, number, time_limit_s) for number in range(cases))
        try:
            for verdict in pool.map(_judged, jobs, chunksize=min(8, 1 + cases // (4 * count))):
                verdicts.append(verdict)
                if progress is not None:
                    progress(verdict)
        except BrokenProcessPool as error:
            message = (
                f"a worker process died at one of the trials after number {len(verdicts)}; run "
                "fewer --workers if memory is short"
            )
            raise SimulationError(message, workers=count, after=len(verdicts)) from error
    return Campaign(seed, tuple(verdicts), time.perf_counter() - began)


def _judged(job: tuple[int, int, float]) -> Verdict:
    seed, number, time_limit_s = job
    return judge(trial(seed, number), time_limit_s)


def _wake() -> None:
    """Nothing to do: a process that comes here has imported what trials need."""

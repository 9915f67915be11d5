"""Judging one trial: it is run, run again in other ways, and all is checked."""

from __future__ import annotations

import hashlib
import signal
import time
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from types import FrameType

from nipper_pin.errors import NipperError, SelfCheckError, SimulationError
from nipper_pin.hybrid import Case, Outcome, Resolution, Solution, Window, need_sound, simulate
from nipper_pin.mechanism import Mechanism

from ..tolerances import FINER_RUN, FINEST_RUN
from .checks.agreement import bits, mirror_images, same_bits, within_errors
from .checks.engines import engines_agree
from .checks.invariants import Violation, violations
from .space import Trial

RIGHT, REFUSED, WRONG = "right", "refused", "wrong"
# Three times the longest of 10,000 cases on a slow processor that had other work, too.
TIME_LIMIT_S = 600.0
# Trials with more evaluations than this are run once only, at their own tolerance.
_LONG = 100_000
# Words of messages about faults of the package: never a valid reason to refuse.
_CONFESSION = "please report"


@dataclass(frozen=True)
class Verdict:
    """Verdict on one trial: "right", "refused" or "wrong", and a hash of every bit of its result.

    The kind is how a right run ended, the type of the error of a refusal, or the first violated
    invariant, "hang" or "traceback".
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
    """Run one trial and check it; after this time of the processor [s] it is a hang."""
    began = time.perf_counter()
    fingerprint = b""

    def verdict(word: str, kind: str, detail: str) -> Verdict:
        digest = hashlib.sha256(fingerprint or f"{word} {kind} {detail}".encode()).hexdigest()
        wall = time.perf_counter() - began
        return Verdict(item.number, item.family, word, kind, detail, digest, wall)

    try:
        with _limited(time_limit_s), warnings.catch_warnings():
            # A warning of numpy is an unforeseen case, and counts as a violation.
            warnings.simplefilter("error")
            outcome, fingerprint, found = _run(item)
    except NipperError as error:
        if _CONFESSION in error.message or not error.message:
            return verdict(WRONG, "confession", error.message)
        return verdict(REFUSED, type(error).__name__, error.message)
    except _TimeIsUpError:
        return verdict(WRONG, "hang", f"no end after {time_limit_s:g} s")
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
    found += _self_check(solution)
    if solution.evaluations > _LONG:
        return solution.outcome.name, bits(solution), found
    found += same_bits(solution, simulate(item.mechanism(), case))
    finer = replace(resolution, tolerance=max(resolution.tolerance / FINER_RUN, FINEST_RUN))
    if finer.tolerance < resolution.tolerance and (
        fine := _beside(mechanism, replace(case, resolution=finer))
    ):
        found += within_errors(solution, fine)
    if (image := item.mirror_image()) and (seen := _beside(image, case)):
        found += mirror_images(solution, seen)
    if case.window is Window.TRANSITION and solution.outcome is Outcome.AT_REST:
        found += engines_agree(solution, resolution.tolerance) or []
    return solution.outcome.name, bits(solution), found


def _beside(mechanism: Mechanism, case: Case) -> Solution | None:
    """A run to compare with; a refusal is an answer, at the limit of what can be solved, too."""
    try:
        return simulate(mechanism, case)
    except SimulationError:
        return None


def _self_check(solution: Solution) -> list[Violation]:
    """No run that is right is refused as one that fails its own checks."""
    try:
        need_sound(solution)
    except SelfCheckError as error:
        return [Violation("self-check", error.message)]
    return []


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

"""Work against precision: wall time and true errors of one transition, by engine and tolerance.

Errors are against the certified reference and relative. ``worst`` is the largest of four: first
and second rebound time, first amplitude and transition time. The others:

* times: collision times from the second on, each by itself;
* impulses, amplitudes: of all collisions that both have, each by itself;
* trajectory: an upper bound of Skorokhod's distance (Billingsley, Convergence of Probability
  Measures, 1999, section 12) of the jaw's motion x = (gap, rate) to the reference,

      inf over time changes T of max(sup |T(t) - t|, sup |x(T(t)) - x_ref(t)|),

  by the one T that maps collisions on collisions and is linear between them. Times are in units
  of the transition time, gaps of the first amplitude, rates of the first separation rate. A
  maximum norm at equal times would instead see the whole jump of the rate between an event and
  its shifted image, however small the shift (peaking; Biemond, van de Wouw, Heemels and Nijmeijer,
  IEEE Trans. Autom. Control 58, 2013).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.hybrid import Case, Resolution, Solution, simulate

from .certified import Certified
from .timing import Timing, timed

TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13)
QUICK_TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-12)

Motion = Callable[[FloatArray, bool], tuple[FloatArray, FloatArray]]


@dataclass(frozen=True)
class Observed:
    """What an engine found in one transition; None for what it does not count or have.

    Quantities of N collisions are those of :class:`~.certified.Certified`. Motion gives gap [rad]
    and rate [rad/s] of the jaw at times [s], at events from the left if so asked.
    """

    times: FloatArray
    impulses: FloatArray
    amplitudes: FloatArray
    transition_time: float
    evaluations: int | None = None
    motion: Motion | None = None


@dataclass(frozen=True)
class Row:
    """One engine, or peer, at one setting; None where it gives no result.

    Times are those of a :class:`~.timing.Timing`; errors are those of the module,
    ``error_duration`` that of the transition time. The version is that of a peer's package.
    """

    engine: str
    setting: str
    wall_ms: float
    first_ms: float
    fastest_ms: float
    spread_ms: float
    runs: int
    error_duration: float | None
    error_worst: float | None
    error_times: float | None = None
    error_impulses: float | None = None
    error_amplitudes: float | None = None
    error_trajectory: float | None = None
    evaluations: int | None = None
    version: str | None = None


def direct_rows(certified: Certified, *, quick: bool, repeats: int) -> list[Row]:
    """Rows of the direct engine; the time includes the four numbers that are graded."""
    mechanism = certified.mechanism()
    rows = []
    for tolerance in QUICK_TOLERANCES if quick else TOLERANCES:
        case = Case(speed_rpm=certified.speed_rpm, resolution=Resolution(tolerance=tolerance))

        def solve(case: Case = case) -> Solution:
            solution = simulate(mechanism, case)
            # Tables and rebounds are computed at their first use.
            first, second = solution.collisions[:2]
            _ = first.rebound_amplitude, first.rebound_time, second.rebound_time
            _ = solution.transitions
            return solution

        timing = timed(solve, repeats)
        rows.append(graded("direct", f"{tolerance:.0e}", timing, observe(solve()), certified))
    return rows


def observe(solution: Solution) -> Observed:
    """Read the graded quantities of a transition from a solution of the direct engine."""
    stop = solution.mechanism.stop(solution.mechanism.transition_stop)
    collisions = [item for item in solution.collisions if item.stop == stop.name]
    origin = collisions[0].t

    def motion(t: FloatArray, left: bool) -> tuple[FloatArray, FloatArray]:
        begin, end = solution.trajectory.span
        # Adding the origin may round a time beyond the end.
        found = solution.trajectory.evaluate(np.clip(t + origin, begin, end), left=left)
        return stop.gaps(found.q), stop.rates(found.v)

    return Observed(
        times=np.array([item.t for item in collisions]) - origin,
        impulses=np.array([item.impulse for item in collisions]),
        amplitudes=np.array([item.rebound_amplitude for item in collisions], dtype=float),
        transition_time=solution.transitions[0].duration if solution.transitions else np.nan,
        evaluations=solution.evaluations,
        motion=motion,
    )


def graded(
    engine: str, setting: str, timing: Timing, observed: Observed, certified: Certified
) -> Row:
    """One row of the table."""
    times = observed.times
    # A setting with fewer than two rebounds has no errors to compare.
    rebounds = np.full(2, np.nan)
    rebounds[: len(times) - 1] = np.diff(times)[:2]
    return graded_four(
        engine,
        setting,
        timing,
        (*rebounds, observed.amplitudes[0], observed.transition_time),
        certified,
        error_times=relative(times[1:], certified.times[1:]),
        error_impulses=relative(observed.impulses, certified.impulses),
        error_amplitudes=relative(observed.amplitudes, certified.amplitudes),
        error_trajectory=trajectory_error(observed, certified),
        evaluations=observed.evaluations,
    )


def graded_four(
    engine: str,
    setting: str,
    timing: Timing,
    four: Sequence[float],
    certified: Certified,
    **more: Any,
) -> Row:
    """One row: first and second rebound time [s], first amplitude [rad], transition time [s]."""
    first, second = certified.rebound_times[:2]
    true = np.array([first, second, certified.amplitudes[0], certified.transition_time])
    found = np.array(four)
    return Row(
        engine=engine,
        setting=setting,
        **asdict(timing),
        error_duration=relative(found[3:], true[3:]),
        error_worst=relative(found, true),
        **more,
    )


def relative(found: FloatArray, true: FloatArray) -> float | None:
    """Largest relative error of the leading values that both have; None if that is not a number."""
    count = min(len(found), len(true))
    worst = float(np.abs(found[:count] / true[:count] - 1.0).max(initial=0.0))
    return worst if np.isfinite(worst) else None


def trajectory_error(observed: Observed, certified: Certified) -> float | None:
    """Bound of Skorokhod's distance of the dense motion (see the module); None without one."""
    if observed.motion is None or not certified.flights:
        return None
    times, worst = observed.times, 0.0
    for number, flight in enumerate(certified.flights[: len(times) - 1]):
        begin, end = times[number], times[number + 1]
        true_t = flight.start_s + flight.fractions * flight.duration_s
        # Written so that the ends are the events to the last bit.
        t = (1.0 - flight.fractions) * begin + flight.fractions * end
        gap, rate = observed.motion(t[:-1], False)
        last_gap, last_rate = observed.motion(t[-1:], True)
        shift = np.abs(t - true_t).max() / certified.transition_time
        high = np.abs(np.append(gap, last_gap) - flight.gap).max() / certified.amplitudes[0]
        fast = np.abs(np.append(rate, last_rate) - flight.rate).max() / certified.separation_rate
        worst = max(worst, float(shift), float(high), float(fast))
    return worst


def accuracy(certified: Certified, tolerance: float) -> Row:
    """Errors of one certified case at one tolerance; its time is that of a single run."""
    mechanism = certified.mechanism()
    case = Case(speed_rpm=certified.speed_rpm, resolution=Resolution(tolerance=tolerance))
    timing = timed(lambda: simulate(mechanism, case).collisions, 1)
    observed = observe(simulate(mechanism, case))
    return graded("direct", f"case {certified.name}", timing, observed, certified)

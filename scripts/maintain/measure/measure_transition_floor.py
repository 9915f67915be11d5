"""Could a transition of the direct engine be as fast as SciPy on the hand-derived equation?

    python scripts/maintain/measure/measure_transition_floor.py [--rounds 300] [--tolerance 1e-10]

Two floors, measured in turns with the transition and with SciPy's DOP853 (rtol 1e-11, located
events). "Calls": what no rearrangement of the Python around it removes is recorded once, with its
arguments, and done again with nothing else. "Small dense work": time within the functions that a
compiler could take over (sweeps, roots, closing, impacts, limits of bounces), without what they
call of Pinocchio; the clock that is read around each call is in it, so it is less. It is wall time,
since that clock is read faster, all else time of the processor: least and median of all rounds.
"""

from __future__ import annotations

import argparse
import gc
import statistics
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from time import perf_counter, process_time
from typing import Any

import numpy as np

import nipper_pin as nip
from benchmarks.peers import scipy_ivp
from nipper_pin.dynamics import impact
from nipper_pin.dynamics import system as systems
from nipper_pin.dynamics.multibody import Multibody
from nipper_pin.dynamics.shaft import ShaftMotion
from nipper_pin.dynamics.system import System
from nipper_pin.hybrid.case import Resolution
from nipper_pin.hybrid.contact.bounce_series import BounceSeries
from nipper_pin.hybrid.event_location import guards
from nipper_pin.hybrid.motion import picard
from nipper_pin.hybrid.motion.panel import Panel
from nipper_pin.hybrid.motion.sweeps import Sweeps

SPEED_RPM, PEER = 650.0, "rtol 1e-11"
Work = Callable[[], object]
Owned = tuple[Any, tuple[str, ...]]
CALLS: dict[str, Owned] = {
    "evaluations of the dynamics": (Multibody, ("accelerations",)),
    "closures and impulse responses": (Multibody, ("closures", "impulse_response")),
    "inverses of the closures": (systems, ("inverted",)),
    "laws of the drives": (ShaftMotion, ("driven", "driven_at")),
}
DENSE: tuple[Owned, ...] = (
    (Sweeps, ("converges", "left_over", "motion")),
    (picard, ("prolonged",)),
    (guards, ("_flight_root", "polish")),
    (System, ("condition", "lift", "closed_velocity")),
    (Panel, ("interpolate_at",)),
    (impact, ("_impulses", "_still", "_outcome")),
    (BounceSeries, ("limit",)),
)
# Called by these, and not to be counted with them.
OTHERS: tuple[Owned, ...] = (
    (System, ("respond", "split")),
    (Multibody, ("impulse_response",)),
)


@contextmanager
def replaced(owned: Sequence[Owned], other: Callable[[Any], Any]) -> Iterator[None]:
    """Put ``other(function)`` in the place of each function."""
    own = [(owner, name, getattr(owner, name)) for owner, names in owned for name in names]
    for owner, name, function in own:
        setattr(owner, name, other(function))
    try:
        yield
    finally:
        for owner, name, function in own:
            setattr(owner, name, function)


def recorded(work: Work, *owned: Owned) -> tuple[Work, int]:
    """Do some work once; what makes its calls of these functions again, and their number."""
    calls: list[tuple[Callable[..., object], tuple[Any, ...]]] = []

    def noted(function: Callable[..., object]) -> Callable[..., object]:
        def call(*arguments: Any) -> object:
            # What is passed may be changed afterwards, in place.
            kept = (item.copy() if isinstance(item, np.ndarray) else item for item in arguments)
            calls.append((function, tuple(kept)))
            return function(*arguments)

        return call

    with replaced(owned, noted):
        work()

    def again() -> None:
        for function, arguments in calls:
            function(*arguments)

    return again, len(calls)


def within(work: Work, dense: Sequence[Owned], others: Sequence[Owned]) -> float:
    """Seconds of some work within the functions ``dense``, without ``others`` that they call."""
    inner, total = [0.0], 0.0

    def timed(counts: bool) -> Callable[[Any], Any]:
        def clocked(function: Any) -> Any:
            def call(*arguments: Any) -> Any:
                nonlocal total
                began = perf_counter()
                inner.append(0.0)
                found = function(*arguments)
                took = perf_counter() - began
                total += counts * (took - inner.pop())
                inner[-1] += took
                return found

            return call

        return clocked

    with replaced(dense, timed(True)), replaced(others, timed(False)):
        work()
    return total


def seconds(work: Work) -> float:
    """Seconds of the processor that some work takes."""
    began = process_time()
    work()
    return process_time() - began


def main() -> int:
    """Measure in turns."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--rounds", type=int, default=300)
    parser.add_argument("--tolerance", type=float, default=1e-10)
    options = parser.parse_args()
    mechanism = nip.load("e62")
    case = nip.Case(speed_rpm=SPEED_RPM, resolution=Resolution(tolerance=options.tolerance))
    (setting,) = (item for item in scipy_ivp.SETTINGS if item.label == PEER)
    peer = scipy_ivp.prepare(mechanism, SPEED_RPM)

    def transition() -> object:
        return nip.simulate(mechanism, case)

    transition()
    rows: dict[str, Callable[[], float]] = {
        f"SciPy, {PEER}": lambda: seconds(lambda: peer(setting)),
        "transition": lambda: seconds(transition),
    }
    for title, owned in CALLS.items():
        again, count = recorded(transition, owned)
        rows[f"{title} ({count} calls)"] = lambda again=again: seconds(again)  # type: ignore[misc]
    rows["small dense work"] = lambda: within(transition, DENSE, OTHERS)
    taken: dict[str, list[float]] = {title: [] for title in rows}
    gc.disable()
    for _ in range(options.rounds):
        for title, measure in rows.items():
            taken[title].append(measure())
    for title, found in taken.items():
        least, middle = 1e3 * min(found), 1e3 * statistics.median(found)
        print(f"{title:42} least {least:6.3f} ms, median {middle:6.3f} ms")
    return 0


if __name__ == "__main__":
    sys.exit(main())

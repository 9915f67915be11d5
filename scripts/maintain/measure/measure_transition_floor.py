"""What of the time of a transition its calls of Pinocchio take, beside that of SciPy.

    python scripts/maintain/measure/measure_transition_floor.py [--rounds 200] [--tolerance 1e-10]

Every call of a transition that no rearrangement of the Python around it removes is recorded once,
with its arguments, and the calls of each kind are then made again and again with nothing else:
evaluations of the dynamics, closures, impulse responses, inverses of closures, laws of the drives.
Whole transition and SciPy's DOP853 (rtol 1e-11, located events) are run in turns with them. Times
are seconds of the processor, the least and the median of all rounds.
"""

from __future__ import annotations

import argparse
import gc
import statistics
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import nipper_pin as nip
from nipper_pin.bench.peers import scipy_ivp
from nipper_pin.dynamics import system as systems
from nipper_pin.dynamics.multibody import Multibody
from nipper_pin.dynamics.shaft import ShaftMotion
from nipper_pin.hybrid.case import Resolution

SPEED_RPM, PEER = 650.0, "rtol 1e-11"
# What is recorded: owner, names, and what the row is called.
KINDS: tuple[tuple[Any, tuple[str, ...], str], ...] = (
    (Multibody, ("accelerations",), "evaluations of the dynamics"),
    (Multibody, ("closures", "impulse_response"), "closures and impulse responses"),
    (systems, ("inverted",), "inverses of the closures"),
    (ShaftMotion, ("driven", "driven_at"), "laws of the drives"),
)
Work = Callable[[], object]


def recorded(work: Work, owner: Any, names: tuple[str, ...]) -> tuple[Work, int]:
    """Do some work once; what makes its calls of these functions again, and their number."""
    calls: list[tuple[Callable[..., object], tuple[Any, ...]]] = []
    own = {name: getattr(owner, name) for name in names}

    def spy(name: str) -> Callable[..., object]:
        def call(*arguments: Any) -> object:
            # What is passed may be changed afterwards, in place.
            kept = (item.copy() if isinstance(item, np.ndarray) else item for item in arguments)
            calls.append((own[name], tuple(kept)))
            return own[name](*arguments)

        return call

    for name in names:
        setattr(owner, name, spy(name))
    try:
        work()
    finally:
        for name, function in own.items():
            setattr(owner, name, function)

    def again() -> None:
        for function, arguments in calls:
            function(*arguments)

    return again, len(calls)


def python_calls(work: Work) -> int:
    """Number of Python functions that some work calls."""
    count = 0

    def noticed(frame: object, event: str, argument: object) -> None:
        nonlocal count
        del frame, argument
        count += event == "call"

    sys.setprofile(noticed)
    try:
        work()
    finally:
        sys.setprofile(None)
    return count


def main() -> int:
    """Measure in turns."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--rounds", type=int, default=200)
    parser.add_argument("--tolerance", type=float, default=1e-10)
    options = parser.parse_args()
    mechanism = nip.load("e62")
    case = nip.Case(speed_rpm=SPEED_RPM, resolution=Resolution(tolerance=options.tolerance))
    (setting,) = (item for item in scipy_ivp.SETTINGS if item.label == PEER)
    peer = scipy_ivp.prepare(mechanism, SPEED_RPM)

    def transition() -> object:
        return nip.simulate(mechanism, case)

    transition()
    rows: dict[str, Work] = {f"SciPy, {PEER}": lambda: peer(setting), "transition": transition}
    for owner, names, title in KINDS:
        again, count = recorded(transition, owner, names)
        rows[f"{title} ({count} calls)"] = again
    seconds: dict[str, list[float]] = {title: [] for title in rows}
    gc.disable()
    for _ in range(options.rounds):
        for title, work in rows.items():
            began = time.process_time()
            work()
            seconds[title].append(time.process_time() - began)
    for title, found in seconds.items():
        least, middle = 1e3 * min(found), 1e3 * statistics.median(found)
        print(f"{title:45} least {least:6.3f} ms, median {middle:6.3f} ms")
    print(f"Python functions called by a transition: {python_calls(transition)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""How long do the reduced model and its transitions take, and how large is the error?

Run: python scripts/maintain/measure/benchmark_reduced.py [CASES]
"""

from __future__ import annotations

import platform
import statistics
import sys
import time
from collections.abc import Callable
from importlib.metadata import version

import numpy as np

import nipper_pin as nip
from nipper_pin.reduced import ReducedTransition, build, transition, transitions

SPEED_RPM = 650.0
TOLERANCES = (1e-6, 1e-8, 1e-9, 1e-10, 1e-12)
REPEATS = 15


def main() -> None:
    """Measure and print."""
    cases = int(sys.argv[1]) if len(sys.argv) > 1 else 20_000
    packages = ", ".join(f"{name} {version(name)}" for name in ("pin", "numpy", "numba"))
    print(f"Python {platform.python_version()}, {packages}; {platform.machine()}")
    mechanism = nip.load()
    model = build(mechanism)
    cells, (count_u, count_x) = model.cells, model.degrees
    print(f"tables: {cells} cells of {count_u} x {count_x} coefficients, {model.samples} samples")
    report("build", 1e3, "ms", lambda: build(mechanism))
    began = time.perf_counter()
    transition(model, speed_rpm=SPEED_RPM)
    print(f"first call, with compilation or its cache: {time.perf_counter() - began:.2f} s")
    direct = nip.simulate(
        mechanism, nip.Case(speed_rpm=SPEED_RPM, resolution=nip.Resolution(tolerance=1e-13))
    )
    same = np.full(cases, SPEED_RPM)
    for tolerance in TOLERANCES:
        print(f"tolerance {tolerance:.0e}")
        found = transition(model, speed_rpm=SPEED_RPM, tolerance=tolerance)
        error = worst_of_four(found, direct)
        print(f"  error {error:.1e} against the direct engine, stated {found.error_bound:.1e}")
        report(
            "  one transition from Python", 1e6, "us",
            lambda: transition(model, speed_rpm=SPEED_RPM, tolerance=tolerance),  # noqa: B023
        )  # fmt: skip
        seconds = report(
            "  one transition in a batch", 1e6 / cases, "us",
            lambda: transitions(model, speed_rpm=same, tolerance=tolerance),  # noqa: B023
        )  # fmt: skip
        print(f"  transitions a second: {cases / seconds:.0f}")


def report(what: str, scale: float, unit: str, work: Callable[[], object]) -> float:
    """Print the least and the median time of some work; return the median [s]."""
    times = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        work()
        times.append(time.perf_counter() - began)
    median = statistics.median(times)
    print(f"{what}: {scale * min(times):.4g} {unit} at best, {scale * median:.4g} median")
    return median


def worst_of_four(found: ReducedTransition, direct: nip.Solution) -> float:
    """Worst relative error of two rebound times, the first amplitude and the duration."""
    first, second = direct.collisions[:2]
    pairs = (
        (found.rebound_time[0], first.rebound_time),
        (found.rebound_time[1], second.rebound_time),
        (found.rebound_amplitude[0], first.rebound_amplitude),
        (found.duration, direct.transitions[0].duration),
    )
    return max(abs(float(value) / true - 1.0) for value, true in pairs if true)


if __name__ == "__main__":
    main()

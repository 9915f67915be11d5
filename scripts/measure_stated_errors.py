"""True over stated error of random transitions of the E62-class model.

    python scripts/measure_stated_errors.py

The truth is a run at a tolerance of 1e-13; its own stated error is added to the one that is judged.
"""

from __future__ import annotations

import argparse

import numpy as np

from nipper_pin import Case, EventKind, Resolution, Solution, load, simulate
from nipper_pin.errors import NipperError

_TOLERANCES = (1e-5, 1e-7, 1e-9, 1e-11)
_TRUTH = 1e-13


def _solution(rpm: float, restitution: float, tolerance: float) -> Solution:
    model = load("e62", {"stops.jaw.restitution": restitution})
    return simulate(model, Case(speed_rpm=rpm, resolution=Resolution(tolerance=tolerance)))


def ratios(truth: Solution, judged: Solution) -> dict[str, list[float]]:
    """True over stated errors of the events that both solutions have."""
    found: dict[str, list[float]] = {"time of a collision": [], "impulse": [], "time of rest": []}
    pairs = zip(truth.events, judged.events, truth.errors, judged.errors, strict=False)
    for exact, event, exact_error, error in pairs:
        if event.kind is not EventKind.COLLISION or exact.kind is not EventKind.COLLISION:
            break
        if exact.t > 0.0:  # The first collision is the start: its time has no error.
            slack = error.time + exact_error.time
            found["time of a collision"].append(abs(event.t - exact.t) / slack)
        stop = event.stops[0]
        relative = abs(event.P_N[stop] / exact.P_N[stop] - 1.0)
        found["impulse"].append(relative / (error.impulse + exact_error.impulse))
    slack = judged.errors[-1].time + truth.errors[-1].time
    found["time of rest"].append(abs(judged.events[-1].t - truth.events[-1].t) / slack)
    return found


def main() -> None:
    """Print, for each tolerance, the median, the 95 % quantile and the largest ratio."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=250)
    parser.add_argument("--seed", type=int, default=5)
    arguments = parser.parse_args()
    random = np.random.default_rng(arguments.seed)
    found: dict[tuple[str, float], list[float]] = {}
    for _ in range(arguments.cases):
        restitution, rpm = random.uniform(0.02, 0.6), random.uniform(500.0, 800.0)
        try:
            truth = _solution(rpm, restitution, _TRUTH)
        except NipperError:
            continue
        if truth.events[-1].kind is not EventKind.REST:
            continue
        for tolerance in _TOLERANCES:
            judged = _solution(rpm, restitution, tolerance)
            if judged.events[-1].kind is EventKind.REST:
                for what, values in ratios(truth, judged).items():
                    found.setdefault((what, tolerance), []).extend(values)
    columns = "".join(
        f"{name:>10}" for name in ("tolerance", "number", "5 %", "median", "95 %", "most")
    )
    print(f"{'what':<22}{columns}")
    for (what, tolerance), values in sorted(found.items()):
        numbers = "".join(
            f"{x:>10.2g}" for x in (*np.quantile(values, (0.05, 0.5, 0.95)), max(values))
        )
        print(f"{what:<22}{tolerance:>10.0e}{len(values):>10}{numbers}")


if __name__ == "__main__":
    main()

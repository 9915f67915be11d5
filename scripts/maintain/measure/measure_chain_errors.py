"""True over stated error of random chains, for which there is no independent solution.

    python scripts/maintain/measure/measure_chain_errors.py

The truth is a run at a tolerance of 1e-13; its own stated error is added to the one that is judged.
Chains have up to five freedoms, with and without loops, and up to four stops (those of the stress
campaign); their events are compared as long as both runs have the same ones and know them.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from benchmarks.stress.space import FAMILIES, trial
from nipper_pin import Case, EventKind, Mechanism, Resolution, Solution, simulate
from nipper_pin.errors import NipperError

_TOLERANCES = (1e-5, 1e-7, 1e-9, 1e-11)
_TRUTH = 1e-13
_CHAINS = "chain", "two stops"
# Longer runs are left out: they take as long as all the others.
_MOST_PANELS = 2000


def chains(count: int, seed: int) -> Iterator[tuple[Mechanism, Case]]:
    """Random chains with several freedoms."""
    places = [place for place, name in enumerate(FAMILIES) if name in _CHAINS]
    for number in range(count):
        turn, place = divmod(number, len(places))
        item = trial(seed, turn * len(FAMILIES) + places[place])
        arguments = {key: value for key, value in item.case.items() if key != "resolution"}
        try:
            yield item.mechanism(), Case(**arguments)
        except NipperError:
            continue


def ratios(truth: Solution, judged: Solution) -> dict[str, list[float]]:
    """True over stated errors of the collisions that both solutions have, as far as both know."""
    found: dict[str, list[float]] = {"time of a collision": [], "impulse": []}
    pairs = zip(truth.events, judged.events, truth.errors, judged.errors, strict=False)
    for exact, event, exact_error, error in pairs:
        known = max(error.impulse, exact_error.impulse) < 1.0
        if not known or (exact.kind, exact.stops) != (event.kind, event.stops):
            break
        if event.kind is not EventKind.COLLISION:
            continue
        if exact.t > 0.0:  # The first collision may be the start: its time has no error.
            slack = error.time + exact_error.time
            found["time of a collision"].append(abs(event.t - exact.t) / slack)
        stop = event.stops[0]
        if event.P_N[stop] > 0.0:
            relative = abs(event.P_N[stop] / exact.P_N[stop] - 1.0)
            found["impulse"].append(relative / (error.impulse + exact_error.impulse))
    return found


def measured(cases: Iterable[tuple[Mechanism, Case]]) -> dict[tuple[str, float], list[float]]:
    """True over stated errors of all cases."""
    found: dict[tuple[str, float], list[float]] = {}
    for mechanism, case in cases:
        runs: list[Solution] = []
        try:
            for tolerance in (_TRUTH, *_TOLERANCES):
                resolution = Resolution(tolerance=tolerance)
                runs.append(simulate(mechanism, replace(case, resolution=resolution)))
                if sum(len(segment.panels) for segment in runs[0].segments) > _MOST_PANELS:
                    break
        except NipperError:
            continue
        truth, *judged = runs
        for tolerance, solution in zip(_TOLERANCES, judged, strict=False):
            for what, values in ratios(truth, solution).items():
                found.setdefault((what, tolerance), []).extend(values)
    return found


def main() -> None:
    """Print, for each tolerance, the median, the 95 % quantile and the largest ratio."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=250)
    parser.add_argument("--seed", type=int, default=5)
    arguments = parser.parse_args()
    columns = ("tolerance", "number", "5 %", "median", "95 %", "most")
    print(f"{'what':<22}" + "".join(f"{name:>10}" for name in columns))
    found = measured(chains(arguments.cases, arguments.seed))
    for (what, tolerance), values in sorted(found.items()):
        quantiles = np.quantile(values, (0.05, 0.5, 0.95))
        numbers = "".join(f"{x:>10.2g}" for x in (*quantiles, max(values)))
        print(f"{what:<22}{tolerance:>10.0e}{len(values):>10}{numbers}")


if __name__ == "__main__":
    main()

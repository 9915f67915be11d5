"""Identifications of random problems, each confirmed by whole turns of the direct engine.

For every problem a machine is drawn: the E62 model with two or three of its numbers somewhere
inside their ranges, filmed at two to four speeds. Its rebounds are read off whole simulated turns
(not off the transitions that an identification simulates), with random errors of stated size, and
identified from the numbers of the E62. Then the machine with the identified numbers makes whole
turns in its own right: every target has to come out as the fit says, and the fit has to be within
its stated deviations of the numbers that were drawn, as often as it should be.

Run: python scripts/maintain/confirm/confirm_fits.py [PROBLEMS] [SEED]

Exit status 1 if a fit is not confirmed, or if the deviations are not those that are stated.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import binom, chi2

import nipper_pin as nip
from nipper_pin.study.identify import (
    Condition,
    Parameter,
    Problem,
    Sources,
    Target,
    identify,
    read_values,
)

MODEL = "e62"
# Numbers that may be drawn, with their ranges.
RANGES = {
    "stops.jaw.restitution": (0.05, 0.4),
    "springs.steeve.preload_length_mm": (8.0, 16.0),
    "springs.steeve.stiffness_N_per_m": (7000.0, 11000.0),
    "cylinder.angle_at_touch_deg": (160.0, 172.0),
    "drives.tension.ratio": (1.8, 2.6),
    "points.rod_pin.x_mm": (-40.0, -12.0),
    "links.top_nipper.mass_kg": (0.8, 1.6),
}
SPEEDS_RPM = (350.0, 700.0)
QUANTITIES = ("rebound_amplitude_1", "rebound_time_s_1", "rebound_amplitude_2", "rebound_time_s_2")
RELATIVE_SIGMA = 0.005
# Largest relative difference between a fit and a whole turn: the tolerance of the fit's
# transitions, amplified by the bounces that follow one another.
CONFIRMED = 1e-6
# Level of significance at which errors or misfits count as distributed otherwise than stated.
CHANCE = 1e-3


@dataclass(frozen=True)
class Confirmed:
    """One problem and what came of it.

    Attributes:
        paths: The free numbers.
        worse: By how much the sum of squares of the numbers drawn is larger than that of the fit:
            chi-square with as many degrees of freedom as there are numbers, however curved the
            valley is in which both lie.
        deviations: Identified less drawn, in stated standard deviations, of the numbers that the
            fit calls determined, shape (determined,).
        chi_square: Of the targets.
        freedom: Its degrees of freedom.
        verdict: What the fit says of itself.
        premise: Whether all transitions were as assumed.
        confirmed: Largest relative difference between whole turns and the fit.
    """

    paths: tuple[str, ...]
    worse: float
    deviations: np.ndarray
    chi_square: float
    freedom: float
    verdict: str
    premise: bool
    confirmed: float


def turn(machine: nip.Mechanism, speed_rpm: float) -> dict[str, float]:
    """Quantities of the closing of a turn that repeats; NaN for those it has not got."""
    case = nip.Case(speed_rpm=speed_rpm, window=nip.Window.CYCLE, cycles=3)
    solution = nip.simulate(machine, case)
    stop, period = machine.transition_stop, 60.0 / speed_rpm
    hits = [hit for hit in solution.collisions if hit.stop == stop and hit.t >= 2.0 * period]
    found = dict.fromkeys(QUANTITIES, np.nan)
    for place, hit in enumerate(hits[:2], start=1):
        if hit.rebound_amplitude is not None and hit.rebound_time is not None:
            found[f"rebound_amplitude_{place}"] = hit.rebound_amplitude
            found[f"rebound_time_s_{place}"] = hit.rebound_time
    return found


def draw(rng: np.random.Generator) -> tuple[Problem, dict[str, float]] | None:
    """A random machine and its measurements; None if it has not got two rebounds at all speeds."""
    paths = sorted(rng.choice(list(RANGES), size=int(rng.integers(2, 4)), replace=False).tolist())
    # Away from the bounds, which would cut the distribution of the errors short.
    truth = {
        path: float(low + (high - low) * rng.uniform(0.2, 0.8))
        for path, (low, high) in ((path, RANGES[path]) for path in paths)
    }
    speeds = rng.uniform(*SPEEDS_RPM, size=int(rng.integers(2, 5))).round(1).tolist()
    machine, base = nip.load(MODEL, truth), nip.load(MODEL)
    targets = []
    for speed in speeds:
        for name, exact in turn(machine, speed).items():
            if not np.isfinite(exact):
                return None
            sigma = RELATIVE_SIGMA * abs(exact)
            value = exact + sigma * rng.standard_normal()
            targets.append(
                Target(
                    name=f"{name}, {speed:g} r/min",
                    quantity=name,
                    at=Condition(speed),
                    value=value,
                    sigma=sigma,
                )
            )
    sources = Sources.of(base)
    parameters = tuple(
        Parameter(path=path, low=low, high=high, start=read_values(sources, [path])[0], why="drawn")
        for path, (low, high) in ((path, RANGES[path]) for path in paths)
    )
    title = "a machine drawn at random"
    found = Problem(title=title, sources=sources, parameters=parameters, targets=tuple(targets))
    return found, truth


def confirm(problem: Problem, truth: dict[str, float]) -> Confirmed:
    """Identify, and hold the fit against whole turns and the numbers that were drawn."""
    fit = identify(problem, starts=2, workers=1)
    known, judged = fit.known, fit.goodness
    off = np.array([fit.values[path] - truth[path] for path in known.paths])
    width = np.array([item.width for item in problem.parameters])
    stated = np.array([known.deviations[path] for path in known.paths]) * width
    drawn = (np.array([truth[path] for path in known.paths]) - fit.objective.low) / width
    machine = nip.load(MODEL, fit.values)
    turns = {
        speed: turn(machine, speed)
        for speed in dict.fromkeys(target.at.speed_rpm for target in problem.targets)
    }
    whole = np.array([turns[item.at.speed_rpm][item.quantity] for item in problem.targets])
    return Confirmed(
        paths=known.paths,
        worse=float(np.sum(fit.objective.rows(drawn) ** 2)) - 2.0 * fit.best.cost,
        deviations=(off / stated)[[path in known.determined for path in known.paths]],
        chi_square=judged.chi_square,
        freedom=judged.degrees_of_freedom,
        verdict=judged.verdict.value,
        premise=all(item.holds is not False for item in fit.premises.values()),
        confirmed=float(np.abs(whole / fit.predicted - 1.0).max()),
    )


def honest(found: Sequence[Confirmed]) -> list[str]:
    """What is wrong with some identifications; empty if nothing is.

    Args:
        found: They.
    """
    wrong = [
        f"problem {place}: whole turns differ from the fit by {item.confirmed:.1e}"
        for place, item in enumerate(found, start=1)
        if not item.confirmed <= CONFIRMED
    ]
    numbers = sum(len(item.paths) for item in found)
    for words, total, freedom in (
        ("numbers drawn against the fits", sum(item.worse for item in found), float(numbers)),
        ("misfits", sum(item.chi_square for item in found), sum(item.freedom for item in found)),
    ):
        low, high = chi2.interval(1.0 - CHANCE, freedom)
        if not low <= total <= high:
            wrong.append(
                f"{words}: chi-square {total:.1f} with {freedom:.1f} degrees of freedom, outside "
                f"of {low:.1f} to {high:.1f}"
            )
    sizes = np.abs(np.concatenate([item.deviations for item in found]))
    for reach, share in ((1.0, 0.6827), (2.0, 0.9545)):
        low, high = binom.interval(1.0 - CHANCE, len(sizes), share)
        inside = int(np.count_nonzero(sizes < reach))
        if not low <= inside <= high:
            wrong.append(
                f"stated deviations: {inside} of {len(sizes)} numbers within {reach:g} of them, "
                f"outside of {low:g} to {high:g}"
            )
    return wrong


def main(count: int = 10, seed: int = 1) -> int:
    """Draw, identify and confirm; print one line for each problem and a summary.

    Args:
        count: Number of problems.
        seed: Seed of the problems.

    Returns:
        0 if all are confirmed, 1 if not.
    """
    begin, refused = time.perf_counter(), 0
    found: list[Confirmed] = []
    print("problem  free  chi-square  freedom  verdict         premise  off (sigmas)  turns differ")
    streams = iter(np.random.SeedSequence(seed).spawn(100 * count))
    while len(found) < count:
        drawn = draw(np.random.default_rng(next(streams)))
        if drawn is None:
            refused += 1
            continue
        item = confirm(*drawn)
        found.append(item)
        print(
            f"{len(found):7d}  {len(item.paths):4d}  {item.chi_square:10.2f}  {item.freedom:7.2f}"
            f"  {item.verdict:14s}  {'held' if item.premise else 'failed':7s}"
            f"  {np.abs(item.deviations).max(initial=0.0):12.2f}  {item.confirmed:12.1e}",
            flush=True,
        )
    sizes = np.abs(np.concatenate([item.deviations for item in found]))
    one, two = (int(np.count_nonzero(sizes < reach)) for reach in (1.0, 2.0))
    print(
        f"{count} problems, seed {seed}, {refused} machines left out (no second rebound); of "
        f"{len(sizes)} determined numbers {one} within one stated deviation (68 % wanted), {two} "
        f"within two (95 %); whole turns differ by {max(item.confirmed for item in found):.1e} at "
        f"most; {time.perf_counter() - begin:.0f} s"
    )
    wrong = honest(found)
    for line in wrong:
        print(f"WRONG: {line}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:3])))

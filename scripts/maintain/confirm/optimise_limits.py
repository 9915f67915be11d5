"""How much of the answer of scripts/optimise_rebound.toml follows from limits without a source?

Least rebounds of the E62 estimate for other strokes and openings, and whether a low first rebound
and a short transition are at odds: python scripts/maintain/confirm/optimise_limits.py
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from nipper_pin.study.optimise import Aim, Limit, Problem, optimise, read_problem

STUDY = Path(__file__).parents[2] / "optimise_rebound.toml"
JUDGED = ("stroke_mm", "jaw_opening_deg")
# Least stroke [mm] and least opening [deg]; None: no such limit.
CASES = ((None, None), (None, 20.0), (2.5, 20.0), (3.0, 20.0), (3.5, 20.0), (3.0, 21.5))


def limited(problem: Problem, *least: float | None) -> Problem:
    """The problem with other limits of stroke and opening; None: without."""
    kept = [item for item in problem.limits if item.quantity not in JUDGED]
    judged = [
        Limit(quantity=name, side="low", value=value)
        for name, value in zip(JUDGED, least, strict=True)
        if value is not None
    ]
    return replace(problem, limits=(*kept, *judged))


def main() -> None:
    """Print a line for each pair of limits, then the front of rebound and time."""
    problem = read_problem(STUDY)
    single = replace(problem, aims=problem.aims[:1])
    print("stroke >=  opening >=  rebound [mrad]  change   preload   ratio   angle")
    for stroke, opening in CASES:
        found = optimise(limited(single, stroke, opening), check=False)
        preload, ratio, angle = found.best.numbers.values()
        rebound = 1e3 * found.best.values["rebound_amplitude_1"]
        print(
            f"{stroke or '-':>9}  {opening or '-':>10}  {rebound:14.4f}  {found.gain or 0.0:+6.1%}"
            f"  {preload:8.3f}  {ratio:6.3f}  {angle:6.2f}"
        )
    time = Aim(quantity="duration_s", sense=1.0)
    both = optimise(replace(problem, aims=(problem.aims[0], time)), check=False, points=5)
    for item in both.front:
        rebound, duration = (item.values[aim.quantity] for aim in both.problem.aims)
        print(f"rebound {1e3 * rebound:.4f} mrad, transition {1e3 * duration:.4f} ms")


if __name__ == "__main__":
    main()

"""Do whole turns of the direct engine have what an optimisation reports?

Random problems on the E62 estimate: speed, free numbers and their bounds, aim and limits are drawn;
limits are such that one drawn design meets them. Each optimum is confirmed twice: by the control of
the optimisation, and here by simulated turns of the overrides that it gives out. Status 1 if one is
not: python scripts/maintain/confirm/confirm_optima.py [PROBLEMS] [SEED]
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from nipper_pin import Case, NipperError, Window, load, simulate
from nipper_pin.study.optimise import Optimum, Problem, optimise, read_problem
from nipper_pin.study.optimise.points import Evaluator

# Free numbers and the bounds between which their ranges are drawn.
NUMBERS = {
    "springs.steeve.preload_length_mm": (3.0, 20.0),
    "springs.steeve.stiffness_N_per_m": (5000.0, 14000.0),
    "stops.jaw.restitution": (0.05, 0.35),
    "drives.tension.ratio": (1.2, 4.0),
    "points.eccentric_pin.angle_deg": (120.0, 240.0),
    "links.top_nipper.mass_kg": (0.6, 2.0),
}
AIMS = (
    ("minimise", "rebound_amplitude_1"),
    ("minimise", "duration_s"),
    ("minimise", "rebound_time_s_1"),
    ("maximise", "clamping_force_N"),
)
LIMITED = ("clamping_force_N", "jaw_opening_deg", "stroke_mm", "duration_s", "rebound_amplitude_1")
TURNS = 4
# Stated errors of a transition at 1e-10 and of turns at 1e-12 are below this share of a value.
AGREES = 1e-8


def drawn(rng: np.random.Generator, folder: Path) -> Problem:
    """A random problem with a design that meets its limits."""
    while True:
        names = rng.choice(list(NUMBERS), size=int(rng.integers(2, 4)), replace=False)
        sense, aim = AIMS[int(rng.integers(len(AIMS)))]
        speed = float(rng.uniform(450.0, 750.0))
        head = f'format = 1\nmodel = "e62"\n{sense} = "{aim}"\ncase = {{ speed_rpm = {speed} }}\n'
        for name in names:
            low, high = np.sort(rng.uniform(*NUMBERS[name], size=2))
            head += f'[parameters."{name}"]\nlow = {low}\nhigh = {high}\n'
        others = [name for name in LIMITED if name != aim]
        limited = rng.choice(others, size=int(rng.integers(1, 3)), replace=False)
        sides = [("low", "high")[int(rng.integers(2))] for _ in limited]
        # Limits too wide to bind: they make the point report the quantities of the design.
        asking = "".join(f"{name} = {{ low = -1e9 }}\n" for name in limited)
        point = _point(folder, f"{head}[limits]\n{asking}", rng.random(len(names)))
        if point is None:
            continue
        lines = [
            f"{name} = {{ {side} = {point[name]} }}\n"
            for name, side in zip(limited, sides, strict=True)
        ]
        return _problem(folder, f"{head}[limits]\n{''.join(lines)}")


def _problem(folder: Path, text: str) -> Problem:
    file = folder / "study.toml"
    file.write_text(text, encoding="utf-8")
    return read_problem(file)


def _point(folder: Path, text: str, z: np.ndarray[Any, Any]) -> Mapping[str, float] | None:
    point = Evaluator(_problem(folder, text)).at(z)
    return point.values if point.usable else None


def seen(problem: Problem, overrides: Mapping[str, object], speed: float) -> dict[str, float]:
    """The last transition of simulated turns, from their collisions and phases."""
    case = Case(speed_rpm=speed, window=Window.CYCLE, cycles=TURNS)
    run = simulate(load(problem.model, overrides), case)
    rest = [item.t_start for item in run.phases if item.closed == {"jaw"}][-1]
    since = rest - 0.5 * 60.0 / speed
    first, *_ = (hit for hit in run.collisions if hit.stop == "jaw" and since < hit.t <= rest)
    return {
        "rebound_amplitude_1": first.rebound_amplitude or 0.0,
        "rebound_time_s_1": first.rebound_time or 0.0,
        "duration_s": rest - first.t,
    }


def refusals(found: Optimum, turn: Mapping[str, float]) -> list[str]:
    """What the turns contradict in what is reported; empty if they confirm it."""
    values = found.best.values
    wrong = [
        f"{name}: {values[name]!r} reported, {value!r} in the turns"
        for name, value in turn.items()
        if not abs(values[name] - value) <= AGREES * abs(value)
    ]
    return [*wrong, *([found.contradiction] if found.contradiction else [])]


def main(count: int, seed: int) -> int:
    """Optimise, confirm and print a line for each problem."""
    refused = 0
    worst = 0.0
    for number in range(1, count + 1):
        rng = np.random.default_rng([seed, number])
        began = time.perf_counter()
        with tempfile.TemporaryDirectory() as folder:
            problem = drawn(rng, Path(folder))
            words = "; ".join(map(str, (*problem.aims, *problem.limits)))
            print(f"{number}: {problem.speed_rpm:.4g} r/min, {words}", flush=True)
            try:
                found = optimise(problem, starts=1, seed=number, check=False, workers=1)
            except NipperError as error:
                refused += 1
                print(f"   no optimum: {error.message}", flush=True)
                continue
        turn = seen(problem, found.overrides, problem.speed_rpm)
        wrong = refusals(found, turn)
        apart = max(abs(found.best.values[name] / value - 1.0) for name, value in turn.items())
        ratio = max(
            abs(row.reported - row.turn) / row.allowed
            for row in found.control.rows
            if row.turn is not None
        )
        worst = max(worst, apart)
        refused += bool(wrong)
        counts = ", ".join(f"{n} {name}" for name, n in found.engines.items())
        aim = problem.aims[0].quantity
        print(
            f"   {aim} {found.best.values[aim]:.6g} ({found.best.engine}), turn apart by "
            f"{apart:.1e}, {ratio:.2g} of the stated errors; points: {counts}; "
            f"{time.perf_counter() - began:.0f} s" + "".join(f"\n   WRONG: {x}" for x in wrong),
            flush=True,
        )
    print(f"{count - refused} of {count} confirmed, apart by {worst:.1e} at most")
    return 1 if refused else 0


if __name__ == "__main__":
    given = [int(word) for word in sys.argv[1:]]
    sys.exit(main(*(given + [10, 1][len(given) :])))

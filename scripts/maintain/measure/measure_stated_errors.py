"""True over stated error of the E62-class model, against a solution that shares nothing with it.

    python scripts/maintain/measure/measure_stated_errors.py --cases 200 [--folder FOLDER]

Random machines (speed, restitution, spring, also touch angles at which the jaw touches slowly) are
solved in 80-bit arithmetic by tests/reference/extended.py, and by both engines at many tolerances,
transitions and whole turns, in processes with other BLAS kernels, of which each case has one. The
folder keeps each case that is done: the same command goes on where it was stopped, and a larger
--cases adds to it.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

REFERENCE = Path(__file__).resolve().parents[3] / "tests" / "reference"
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
# Names that OPENBLAS_CORETYPE knows; with and without AVX-512, and without AVX2.
KERNELS = ("SkylakeX", "Haswell", "Sandybridge")
# Where the jaw of the E62-class model does not close at all, to six digits.
_NO_APPROACH_DEG = 115.58
_TURNS = 3
_SLOW = 5
_CASES_OF_A_KERNEL = 30
# The reduced engine writes no more collisions of a series, and a run asks for no more.
_MOST_COLLISIONS = 250


@dataclass(frozen=True)
class Trial:
    """One random machine: numbers are decimals that both solutions read."""

    number: int
    turn: bool
    speed_rpm: float
    jaw: float
    steeve: float
    stiffness_N_per_m: float
    preload_mm: float
    touch_deg: float


def trial(seed: int, number: int) -> Trial:
    """The random machine of that number; each third one for a whole turn, some touch slowly."""
    random = np.random.default_rng([seed, number])
    turn = number % _TURNS == _TURNS - 1
    touch = 166.0
    if number % _SLOW == 0:
        touch = _NO_APPROACH_DEG + 10.0 ** random.uniform(-3.0, 1.5)
    # The end of long series tells nothing new and takes as long as all the rest.
    jaw, steeve = 0.02 * (0.8 / 0.02) ** random.uniform(size=2)
    return Trial(
        number,
        turn,
        float(random.uniform(300.0, 900.0)),
        float(jaw),
        float(steeve),
        float(random.uniform(4000.0, 12000.0)),
        float(random.uniform(4.0, 14.0)),
        float(touch),
    )


def solved(one: Trial) -> dict[str, Any]:
    """The events of a case by the independent solution, as decimals; none if it has no answer."""
    if str(REFERENCE) not in sys.path:
        sys.path.insert(0, str(REFERENCE))
    extended = import_module("extended")
    changes = {
        "speed_rpm": repr(one.speed_rpm),
        "jaw_restitution": repr(one.jaw),
        "stop_restitution": repr(one.steeve),
        "stiffness_N_per_m": repr(one.stiffness_N_per_m),
        "preload_length_mm": repr(one.preload_mm),
        "cylinder_angle_at_touch_deg": repr(one.touch_deg),
    }
    try:
        events = (extended.cycle if one.turn else extended.transition)(changes)
    except ArithmeticError as error:
        return {"trial": asdict(one), "refused": str(error)}
    rows = [
        {
            key: str(value) if isinstance(value, np.floating) else value
            for key, value in vars(event).items()
        }
        for event in events
    ]
    return {"trial": asdict(one), "events": rows}


class Ratios:
    """True over stated errors of one case, by engine, window, quantity and tolerance."""

    def __init__(self) -> None:
        """Begin with none."""
        self.rows: list[tuple[str, str, str, float, float]] = []
        self.notes: list[str] = []

    def add(self, where: tuple[str, str, float], what: str, true: Any, error: float) -> None:
        """One ratio; where nothing is wrong and nothing stated there is none."""
        engine, window, tolerance = where
        true = float(abs(true))
        if true == 0.0 and error == 0.0:
            return
        self.rows.append(
            (engine, window, what, tolerance, true / error if error > 0.0 else math.inf)
        )


def of_turn(one: Trial, events: list[dict[str, Any]], found: Ratios) -> None:
    """Whole turns: all events that both solutions have, in their order."""
    from nipper_pin import Case, EventKind, Resolution, Window, simulate
    from nipper_pin.errors import NipperError

    mechanism = _mechanism(one)
    for tolerance in TOLERANCES:
        where = ("direct", "turn", tolerance)
        case = Case(
            speed_rpm=one.speed_rpm,
            window=Window.CYCLE,
            resolution=Resolution(tolerance=tolerance),
        )
        try:
            solution = simulate(mechanism, case)
            errors = solution.errors
        except NipperError as refusal:
            found.notes.append(f"{tolerance:g}: {refusal}")
            continue
        place = 0
        for event, error in zip(solution.events, errors, strict=True):
            place = _next(events, place, event.kind.value, event.stops[0])
            if place < 0 or error.impulse >= 1.0:
                found.notes.append(f"{tolerance:g}: other events from {event.t:.6g} s on")
                break
            true = events[place]
            place += 1
            name = {EventKind.COLLISION: "time of a collision"}.get(
                event.kind, f"time of a {event.kind.value}"
            )
            found.add(where, name, event.t - np.longdouble(true["time"]), error.time)
            if event.kind is not EventKind.COLLISION:
                continue
            stop = mechanism.stop(event.stops[0])
            for what, value, exact in (
                ("approach rate", event.v_before[stop.index], true["approach"]),
                ("separation rate", event.v_after[stop.index], true["separation"]),
                ("impulse", event.P_N[stop.name], true["impulse"]),
            ):
                found.add(where, what, value / np.longdouble(exact) - 1, error.impulse)


def _next(events: list[dict[str, Any]], place: int, kind: str, stop: str) -> int:
    """Place of the event that is meant; collisions before a rest that a run leaves out are passed.

    A series has infinitely many collisions: both solutions leave out the last ones.
    """
    while place < len(events):
        if (events[place]["kind"], events[place]["stop"]) == (kind, stop):
            return place
        if kind != "rest" or events[place]["kind"] != "collision":
            return -1
        place += 1
    return -1


def of_transition(
    one: Trial, events: list[dict[str, Any]], lever: Any, engine: str, found: Ratios
) -> None:
    """Transitions as tables state them: collisions of the jaw, their rebounds, the duration."""
    from nipper_pin.reduced import layout as rows
    from nipper_pin.study.transitions import transition_table

    hits = [event for event in events if (event["kind"], event["stop"]) == ("collision", "jaw")]
    # The tables of a reduced model hold for all springs and restitutions of its jaw.
    mechanism = _touching(one.touch_deg) if engine == "reduced" else _mechanism(one)
    for tolerance in TOLERANCES:
        where = (engine, "transition", tolerance)
        table = transition_table(
            mechanism,
            speed_rpm=one.speed_rpm,
            restitution=one.jaw,
            stiffness_N_per_m=one.stiffness_N_per_m,
            preload_length_mm=one.preload_mm,
            tolerance=tolerance,
            engine=engine,  # type: ignore[arg-type]
            max_collisions=_MOST_COLLISIONS,
        )
        if table.outcome[0] != "at_rest":
            found.notes.append(f"{engine} {tolerance:g}: {table.outcome[0]} {table.message[0]}")
            continue
        for true, block in zip(hits, table.table[0].T, strict=False):
            for what, key, value, error, scale in (
                ("time of a collision", "time", rows.TIME, rows.TIME_ERROR, 1),
                ("approach rate", "approach", rows.APPROACH, rows.RATE_ERROR, 1),
                ("impulse", "impulse", rows.IMPULSE, rows.IMPULSE_ERROR, lever),
                ("amplitude", "amplitude", rows.AMPLITUDE, rows.AMPLITUDE_ERROR, 1),
                ("time of a rebound", "rebound", rows.REBOUND, rows.REBOUND_ERROR, 1),
            ):
                if true[key] is not None and np.isfinite(block[value]):
                    wrong = block[value] - np.longdouble(true[key]) / scale
                    found.add(where, what, wrong, float(block[error]))
        wrong = table.duration[0] - np.longdouble(events[-1]["time"])
        found.add(where, "time of a rest", wrong, float(table.duration_error[0]))


def _mechanism(one: Trial) -> Any:
    """The machine of a case."""
    from nipper_pin import load

    values: dict[str, Any] = {
        "stops.jaw.restitution": one.jaw,
        "stops.steeve.restitution": one.steeve,
        "springs.steeve.stiffness_N_per_m": one.stiffness_N_per_m,
        "springs.steeve.preload_length_mm": one.preload_mm,
        "cylinder.angle_at_touch_deg": one.touch_deg,
    }
    return load("e62", values)


@lru_cache(maxsize=8)
def _touching(degrees: float) -> Any:
    """The machine of the file with its usual touch angle, or another one."""
    from nipper_pin import load

    return load("e62", {"cylinder.angle_at_touch_deg": degrees})


def judged(solution: dict[str, Any]) -> dict[str, Any]:
    """Ratios of one case, in this process with its BLAS kernel."""
    from nipper_pin.errors import NipperError

    one, found = Trial(**solution["trial"]), Ratios()
    if "refused" not in solution:
        events = solution["events"]
        try:
            if one.turn:
                of_turn(one, events, found)
            else:
                lever = np.sqrt(np.longdouble("81.8") ** 2 + np.longdouble("36.4") ** 2) / 1000
                for engine in ("direct", "reduced"):
                    of_transition(one, events, lever, engine, found)
        except NipperError as error:
            found.notes.append(str(error))
    return {"number": one.number, "rows": found.rows, "notes": found.notes}


def _lines(path: Path) -> Iterator[dict[str, Any]]:
    """Whole lines of a file of results."""
    if path.exists():
        for line in path.read_text().splitlines():
            yield json.loads(line)


def _append(path: Path, row: dict[str, Any]) -> None:
    with path.open("a") as file:
        file.write(json.dumps(row) + "\n")


def solve(folder: Path, seed: int, count: int) -> None:
    """Independent solutions of all cases."""
    path = folder / "truth.jsonl"
    done = {row["trial"]["number"] for row in _lines(path)}
    for number in range(count):
        if number not in done:
            _append(path, solved(trial(seed, number)))


def judge(folder: Path, kernel: str, count: int) -> None:
    """Both engines with one BLAS kernel."""
    path = folder / f"{kernel}.jsonl"
    done = {row["number"] for row in _lines(path)}
    for row in _lines(folder / "truth.jsonl"):
        number = row["trial"]["number"]
        own = KERNELS[number // _CASES_OF_A_KERNEL % len(KERNELS)] == kernel
        if own and number < count and number not in done:
            _append(path, judged(row))


def report(folder: Path, count: int) -> None:
    """Print quantiles of all ratios, and how many cases could not be compared."""
    values: dict[tuple[str, str, str, float], list[float]] = {}
    notes = cases = 0
    worst: list[tuple[float, str]] = []
    for kernel in KERNELS:
        for row in _lines(folder / f"{kernel}.jsonl"):
            if row["number"] >= count:
                continue
            cases += 1
            notes += bool(row["notes"])
            for engine, window, what, tolerance, ratio in row["rows"]:
                values.setdefault((engine, window, what, tolerance), []).append(ratio)
                if ratio > 1.0:
                    label = f"case {row['number']} {kernel} {engine} {window} {what} {tolerance:g}"
                    worst.append((ratio, label))
    pooled: dict[tuple[str, str, str, float], list[float]] = {}
    for (engine, window, what, _), ratios in values.items():
        pooled.setdefault((engine, window, what, math.inf), []).extend(ratios)
    columns = ("tolerance", "number", "5 %", "median", "95 %", "most")
    print(f"{'':<44}" + "".join(f"{name:>10}" for name in columns))
    for (engine, window, what, tolerance), ratios in sorted((values | pooled).items()):
        quantiles = np.quantile(ratios, (0.05, 0.5, 0.95), method="lower")
        numbers = "".join(f"{x:>10.2g}" for x in (*quantiles, max(ratios)))
        label = "all" if tolerance == math.inf else f"{tolerance:.0e}"
        print(f"{engine:<8}{window:<12}{what:<24}{label:>10}{len(ratios):>10}{numbers}")
    print(f"{cases} cases, {notes} of them compared in part or not at all")
    print(f"{len(worst)} of {sum(map(len, values.values()))} ratios above 1")
    for ratio, label in sorted(worst, reverse=True)[:20]:
        print(f"  {ratio:8.3g}  {label}")


def main() -> None:
    """Solve, judge with every kernel, report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--seed", type=int, default=19)
    parser.add_argument("--folder", type=Path, default=Path("build/stated_errors"))
    parser.add_argument("--kernel", choices=KERNELS, help="judge with this one, no report")
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    if given.kernel:
        judge(given.folder, given.kernel, given.cases)
        return
    solve(given.folder, given.seed, given.cases)
    for kernel in KERNELS:
        command = [sys.executable, __file__, "--kernel", kernel, "--cases", str(given.cases)]
        environment = os.environ | {"OPENBLAS_CORETYPE": kernel}
        subprocess.run([*command, "--folder", str(given.folder)], env=environment, check=True)
    report(given.folder, given.cases)


if __name__ == "__main__":
    main()

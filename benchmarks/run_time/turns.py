"""Whole turns of both engines against the certified ones: run time and error."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.hybrid import Case, EventKind, Resolution, Window, simulate
from nipper_pin.mechanism import Mechanism, load
from nipper_pin.reduced.turns import build_turns, turns
from nipper_pin.units import MS_PER_S, S_PER_MIN

from .certified import MODEL, certified_cycle
from .timing import timed

_SPEEDS = ("450", "650")
_TOLERANCES = (1e-6, 1e-9, 1e-12)
_BUDGET_S = 1.0


@dataclass(frozen=True)
class TurnRow:
    """One engine at one setting: the median of one turn with tables and compiled code at hand.

    Errors are the largest of the collisions, that of times by the time of a turn. Turns a second
    are those on one core; an engine without tables has no time to make them.
    """

    engine: str
    setting: str
    wall_ms: float
    error_times: float
    error_impulses: float
    turns_per_s: float
    tables_ms: float | None


def turn_rows(*, repeats: int) -> list[TurnRow]:
    """Measure one turn at each certified speed, engine beside engine."""
    mechanism = load(MODEL)
    tables_ms = timed(lambda: build_turns(mechanism), repeats, _BUDGET_S).wall_ms
    rows = []
    for speed in _SPEEDS:
        for tolerance in _TOLERANCES:
            for engine, make, ms in (("direct", _direct, None), ("reduced", _reduced, tables_ms)):
                turn = make(mechanism, speed, tolerance)
                rows.append(_row(engine, speed, tolerance, turn, repeats, ms))
    return rows


_Hits = tuple[list[str], FloatArray, FloatArray]
_Turn = Callable[[], _Hits]


def _direct(mechanism: Mechanism, speed: str, tolerance: float) -> _Turn:
    resolution = Resolution(tolerance=tolerance)
    case = Case(speed_rpm=float(speed), window=Window.CYCLE, resolution=resolution)

    def turn() -> _Hits:
        solution = simulate(mechanism, case)
        hits = [item for item in solution.events if item.kind is EventKind.COLLISION]
        lever = {stop.name: stop.lever for stop in mechanism.stops}
        impulses = [hit.P_N[hit.stops[0]] / lever[hit.stops[0]] for hit in hits]
        stops = [hit.stops[0] for hit in hits]
        return stops, np.array([hit.t for hit in hits]), np.array(impulses)

    return turn


def _reduced(mechanism: Mechanism, speed: str, tolerance: float) -> _Turn:
    def turn() -> _Hits:
        found = turns(mechanism, speed_rpm=float(speed), tolerance=tolerance)
        hits = found.collisions
        stops = [found.stops[number] for number in found.stop_number[hits]]
        return stops, found.time[hits], found.impulse[hits]

    return turn


def _row(
    engine: str, speed: str, tolerance: float, turn: _Turn, repeats: int, tables_ms: float | None
) -> TurnRow:
    errors = _errors(speed, *turn())  # has what is compiled compiled, too
    wall_ms = timed(turn, repeats, _BUDGET_S).wall_ms
    setting = f"{speed} r/min, {tolerance:.0e}"
    return TurnRow(engine, setting, wall_ms, *errors, MS_PER_S / wall_ms, tables_ms)


def _errors(
    speed: str, stops: list[str], times: FloatArray, impulses: FloatArray
) -> tuple[float, float]:
    """Largest errors of the collisions, series by series: both may be cut at other bounces."""
    period = S_PER_MIN / float(speed)
    true = [list(rows) for _, rows in groupby(certified_cycle(speed), lambda row: row["stop"])]
    found = [list(hits) for _, hits in groupby(zip(stops, times, impulses, strict=True),
                                               lambda hit: hit[0])]  # fmt: skip
    time = impulse = 0.0
    for rows, hits in zip(true, found, strict=True):
        for row, (_, t, P) in zip(rows, hits, strict=False):
            P_true = float(row.get("impulse_lip_N_s", row["impulse"]))
            time = max(time, abs(float(row["time_s"]) - t) / period)
            impulse = max(impulse, abs(P - P_true) / abs(P_true))
    return time, impulse

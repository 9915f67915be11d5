"""True over stated errors of one machine: whole turns, and transitions by both engines."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from .dimensions import machine
from .found import TOLERANCES, Ratios, following
from .reduced_turns import of_reduced_turn
from .truth import Trial

# Largest number of collisions that the reduced engine writes, and that a run requests.
_MOST_COLLISIONS = 250


def judged(solution: dict[str, Any], *, direct: bool = True) -> dict[str, Any]:
    """Ratios of one case, in this process with its BLAS kernel.

    Args:
        solution: The independent solution of the case.
        direct: Whether to judge whole turns of the direct engine, too.
    """
    from nipper_pin.errors import NipperError

    one, found = Trial(**solution["trial"]), Ratios()
    if "refused" not in solution:
        events = solution["events"]
        try:
            if one.turn:
                if direct:
                    of_turn(one, events, found)
                of_reduced_turn(_mechanism(one), one, solution, found)
            else:
                for engine in ("direct", "reduced"):
                    of_transition(one, events, engine, found)
        except NipperError as error:
            found.notes.append(str(error))
    return {"number": one.number, "rows": found.rows, "notes": found.notes}


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
            place = following(events, place, event.kind.value, event.stops[0])
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


def of_transition(one: Trial, events: list[dict[str, Any]], engine: str, found: Ratios) -> None:
    """Transitions as tables state them: collisions of the jaw, their rebounds, the duration."""
    from nipper_pin.reduced.kernels import layout as rows
    from nipper_pin.study.transitions import transition_table

    hits = [event for event in events if (event["kind"], event["stop"]) == ("collision", "jaw")]
    # The tables of a reduced model hold for all springs and restitutions of its jaw.
    shared = engine == "reduced" and not one.numbers
    mechanism = _touching(one.touch_deg) if shared else _mechanism(one)
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
                ("impulse", "impulse", rows.IMPULSE, rows.IMPULSE_ERROR, one.lever_m),
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

    if one.numbers:
        return machine(one.numbers)
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

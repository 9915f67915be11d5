"""True over stated errors of whole turns of the reduced engine: events and quantities."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .found import TOLERANCES, Ratios, following
from .truth import Trial

_MOST_COLLISIONS = 250
# Quantities: name in a table of ratios, key of the truth, and value. The truth
# has times in seconds and impulses of the jaw along its joint.
_TIMES = (
    ("closing", "closed_at", "closed_at"),
    ("rest", "rests_at", "rests_at"),
    ("loss", "lost_at", "lost_at"),
    ("opening", "opened_at", "opened_at"),
    ("clamped time", "clamped", "clamped"),
)
_NUMBERS = (
    ("least force", "least_force", "least_clamping_force"),
    ("largest force", "most_force", "largest_clamping_force"),
    ("largest gap", "largest_gap", "largest_gap"),
    ("energy lost", "energy_lost", "energy_lost"),
)
_STOPS = ("jaw", "steeve")


def of_reduced_turn(mechanism: Any, one: Trial, solution: dict[str, Any], found: Ratios) -> None:
    """One turn at each tolerance.

    Args:
        mechanism: The machine.
        one: The case.
        solution: Its independent solution.
        found: Where ratios and notes are added.
    """
    from nipper_pin.errors import NipperError

    for tolerance in TOLERANCES:
        where = ("reduced", "turn", tolerance)
        try:
            if of_events(mechanism, one, solution["events"], where, found):
                of_quantities(mechanism, one, solution["quantities"], where, found)
        except NipperError as refusal:
            found.notes.append(f"reduced {tolerance:g}: {refusal}")


def of_events(
    mechanism: Any,
    one: Trial,
    events: list[dict[str, Any]],
    where: tuple[str, str, float],
    found: Ratios,
) -> bool:
    """All events of a turn that both solutions have; returns whether they are the same."""
    from nipper_pin.reduced.turns import turns

    mine = turns(
        mechanism, speed_rpm=one.speed_rpm, tolerance=where[2], max_collisions=_MOST_COLLISIONS
    )
    place = 0
    for i, (kind, stop) in enumerate(zip(mine.kind, mine.stop, strict=True)):
        place = following(events, place, kind, stop)
        if place < 0:
            found.notes.append(f"reduced {where[2]:g}: other events from {mine.time[i]:.6g} s on")
            return False
        true = events[place]
        place += 1
        wrong = mine.time[i] - np.longdouble(true["time"])
        found.add(where, f"time of a {kind}", wrong, mine.time_error[i])
        if kind != "collision":
            continue
        lever = one.lever_m if stop == "jaw" else 1
        loss = np.longdouble(true["impulse"]) * -np.longdouble(true["approach"]) / 2
        loss *= 1 - np.longdouble(one.jaw if stop == "jaw" else one.steeve)
        for what, value, exact, error in (
            ("approach rate", mine.approach_rate, np.longdouble(true["approach"]), mine.rate_error),
            ("impulse", mine.impulse, np.longdouble(true["impulse"]) / lever, mine.impulse_error),
            ("energy of a collision", mine.energy_lost, loss, mine.energy_error),
        ):
            found.add(where, what, value[i] - exact, error[i])
        if true["amplitude"] is not None and np.isfinite(mine.rebound_amplitude[i]):
            wrong = mine.rebound_amplitude[i] - np.longdouble(true["amplitude"])
            found.add(where, "amplitude", wrong, mine.amplitude_error[i])
    rest = [(event["kind"], event["stop"]) for event in events[place:]]
    if any(kind != "collision" for kind, _ in rest):
        found.notes.append(f"reduced {where[2]:g}: no {rest}")
        return False
    return True


def of_quantities(
    mechanism: Any,
    one: Trial,
    true: dict[str, Any],
    where: tuple[str, str, float],
    found: Ratios,
) -> None:
    """What can be asked about the turn."""
    from nipper_pin.reduced.turns import turn_quantities

    mine = turn_quantities(
        mechanism, speed_rpm=one.speed_rpm, tolerance=where[2],
        least_force=float(true["level"] * one.of_force_m),
        max_collisions=_MOST_COLLISIONS,
    )  # fmt: skip
    speed = np.longdouble(one.speed_rpm) * 8 * np.arctan(np.longdouble(1)) / 60
    for name, key, value in (*_TIMES, *_NUMBERS):
        have, stated = getattr(mine, value)[0], float(getattr(mine, f"{value}_error")[0])
        if true[key] is None or math.isnan(have):
            if (true[key] is None) != math.isnan(have):
                found.add(where, name, math.inf, 1.0)
            continue
        times = speed if (name, key, value) in _TIMES else 1
        times = one.of_force_m if name.endswith("force") else times
        found.add(where, name, have - np.longdouble(true[key]) * times, stated)
    for place, stop in enumerate(_STOPS):
        lever = one.lever_m if stop == "jaw" else 1
        for name, key in (("impulse sum", "impulse_sum"), ("largest impulse", "largest_impulse")):
            wrong = getattr(mine, key)[0, place] - np.longdouble(true[f"{key}_{stop}"]) / lever
            found.add(where, name, wrong, float(getattr(mine, f"{key}_error")[0, place]))

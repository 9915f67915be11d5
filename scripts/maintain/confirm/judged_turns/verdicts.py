"""Events of both engines, within both stated errors."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from nipper_pin import Case, EventKind, Mechanism, NipperError, Resolution, Window, simulate
from nipper_pin.reduced.turns import ReducedTurns, turns
from nipper_pin.tolerances.reduced import SAME_TURN

from .machines import Geometry, Setting

_KINDS = {EventKind.COLLISION: "collision", EventKind.REST: "rest", EventKind.RELEASE: "release"}
_TOLERANCE, _FINER = 1e-10, 1e-12
_MOST = 1000
# A relative error from which nothing is known of what follows.
_UNKNOWN = 1e-2


class Verdict(StrEnum):
    """What became of a case."""

    AGREES = "agree"
    REFUSED = "refused"
    BOTH = "refused by both"
    DIRECT = "refused by the direct engine only"
    ROUND_OFF = "left to round-off"
    WRONG = "WRONG"


@dataclass(frozen=True)
class Row:
    """An event: kind, stop, time [s], rate before, impulse, and the bounds on their errors."""

    kind: str
    stop: str
    time: float
    rate: float
    impulse: float
    time_error: float
    rate_error: float
    impulse_error: float

    @property
    def known(self) -> bool:
        """Whether what follows it is determined."""
        return self.kind != "collision" or self.rate_error < _UNKNOWN * abs(self.rate)


def judged(machine: Geometry, base: Mechanism, setting: Setting) -> tuple[Verdict, str]:
    """Verdict on one case, and why.

    Args:
        machine: The geometry.
        base: Its mechanism, whose tables hold for all cases.
        setting: The case.
    """
    changed = machine.mechanism(setting.values)
    mine: list[Row] | str
    try:
        mine = _reduced_rows(base, changed, setting)
    except NipperError as refusal:
        mine = str(refusal.evidence.get("status", refusal.message.split(": ", 1)[-1]))
    try:
        theirs = _direct_rows(changed, setting, _TOLERANCE)
    except NipperError as refusal:
        if isinstance(mine, str):
            return Verdict.BOTH, mine
        return Verdict.DIRECT, refusal.message
    if isinstance(mine, str):
        return Verdict.REFUSED, mine
    difference, known = compared(mine, theirs)
    if not difference:
        return Verdict.AGREES, f"{len(mine)} events"
    if not known:
        return Verdict.ROUND_OFF, difference
    try:
        other, _ = compared(_direct_rows(changed, setting, _FINER), theirs)
    except NipperError as refusal:
        other = refusal.message
    if other:
        return Verdict.ROUND_OFF, f"{difference}; direct engine with itself: {other}"
    return Verdict.WRONG, difference


def compared(mine: list[Row], theirs: list[Row]) -> tuple[str, bool]:
    """What differs first, and whether that is determined; an empty text if nothing does.

    A series may be ended at another bounce: its other collisions, up to its rest, are left out.
    """
    i = j = 0
    known = True
    while i < len(mine) and j < len(theirs):
        a, b = mine[i], theirs[j]
        known = known and a.known and b.known
        if (a.kind, a.stop) == (b.kind, b.stop):
            for what in ("time", "rate", "impulse"):
                wrong = abs(getattr(a, what) - getattr(b, what))
                allowed = getattr(a, f"{what}_error") + getattr(b, f"{what}_error")
                if wrong > allowed:
                    text = f"{what} of a {a.kind} of {a.stop} at {b.time:.9g} s: {wrong:.2e} beyond"
                    return f"{text} {allowed:.2e}", known
            i, j = i + 1, j + 1
        elif a.kind == "rest" and (b.kind, b.stop) == ("collision", a.stop):
            j += 1
        elif b.kind == "rest" and (a.kind, a.stop) == ("collision", b.stop):
            i += 1
        else:
            apart = abs(a.time - b.time)
            near = apart <= a.time_error + b.time_error
            text = f"{a.kind} of {a.stop} at {a.time:.9g} s, {b.kind} of {b.stop} at {b.time:.9g} s"
            return text, known and not near
    left = [row for row in (*mine[i:], *theirs[j:]) if row.kind != "collision"]
    if left:
        return f"{left[0].kind} of {left[0].stop} at {left[0].time:.9g} s has no counterpart", known
    return "", known


def _direct_rows(mechanism: Mechanism, setting: Setting, tolerance: float) -> list[Row]:
    """Events of the direct engine."""
    case = Case(
        speed_rpm=setting.speed_rpm,
        window=Window.CYCLE,
        cycles=setting.turns,
        resolution=Resolution(tolerance=tolerance),
        max_collisions=_MOST * setting.turns,
    )
    run = simulate(mechanism, case)
    rows = []
    for event, error in zip(run.events, run.errors, strict=True):
        stop = mechanism.stop(event.stops[0])
        rate = impulse = 0.0
        if event.kind is EventKind.COLLISION:
            rate = stop.rate(event.v_before)
            impulse = event.P_N[stop.name] / stop.lever
        part = min(error.impulse, 1.0)
        rows.append(Row(_KINDS[event.kind], stop.name, event.t, rate, impulse, error.time,
                        part * abs(rate), part * abs(impulse)))  # fmt: skip
    return rows


def _reduced_rows(base: Mechanism, changed: Mechanism, setting: Setting) -> list[Row]:
    """Events of the reduced engine, those of turns that repeat written out."""
    found = turns(
        base,
        speed_rpm=setting.speed_rpm,
        cycles=setting.turns,
        restitution={stop.name: stop.restitution for stop in changed.stops},
        stiffness=[spring.stiffness for spring in changed.springs] or None,
        preload=[spring.preload for spring in changed.springs] or None,
        tolerance=_TOLERANCE,
        max_collisions=_MOST,
    )
    period = 60.0 / setting.speed_rpm
    rows = _rows(found)
    last = [row for row in rows if row.time >= (found.turns - found.repeats_after) * period]
    if not found.repeats_after:
        last = []
    done, ahead = found.turns, 1
    while last and done < setting.turns:
        shift = ahead * found.repeats_after * period
        for row in last:
            # Copies are as they would be but for what a turn may differ from the one it repeats.
            bound = row.time_error + 16.0 * SAME_TURN * period
            rows.append(Row(row.kind, row.stop, row.time + shift, row.rate, row.impulse, bound,
                            row.rate_error + 1e-6 * abs(row.rate),
                            row.impulse_error + 1e-6 * abs(row.impulse)))  # fmt: skip
        done, ahead = done + found.repeats_after, ahead + 1
    return [row for row in rows if row.time < setting.turns * period]


def _rows(found: ReducedTurns) -> list[Row]:
    """Events of the reduced engine as rows."""
    numbers = (found.time, found.approach_rate, found.impulse, found.time_error, found.rate_error,
               found.impulse_error)  # fmt: skip
    columns = [np.nan_to_num(column).tolist() for column in numbers]
    return [
        Row(kind, stop, *values)
        for kind, stop, *values in zip(found.kind, found.stop, *columns, strict=True)
    ]

"""The setting that is shown, the one before it, and one that is pinned: memory and curves."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from ...arrays import FloatArray
from ...hybrid.result.quantities import force_unit
from ...mechanism import Mechanism
from ...units import S_PER_MS
from ..reading import contact_shown, coordinate_shown, gap_noun
from ..scene.readings import rounded, ticks
from .answer import Answer, Rows

# Moves of a slider that follow each other within this time are one change [s].
ONE_CHANGE = 0.8
PINNED, BEFORE, NOW = "#E69F00", "#A6CDE6", "#0072B2"
"""Colours of the curves; of the dots as well."""
_DASH = (6, 3)
_Record = dict[str, object]
_LineOf = Callable[[Answer], FloatArray]
_STEPS, _DECADES = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0), (1.0, 10.0)
"""Round numbers of a decade, for linear and for logarithmic axes."""


@dataclass(frozen=True)
class Kept:
    """An answer with the numbers of its whole turn."""

    answer: Answer
    turn: Rows


class Memory:
    """What the page compares.

    Attributes:
        present: What is shown; None before the first answer.
        before: The last setting with numbers before the present change; None without one.
        pinned: The setting that is pinned; None without one.
    """

    def __init__(self) -> None:
        """Begin with nothing."""
        self.present: Kept | None = None
        self.before: Kept | None = None
        self.pinned: Kept | None = None
        self._changed = -2.0 * ONE_CHANGE

    @property
    def other(self) -> Kept | None:
        """What numbers are compared with: the pinned setting, or the one before."""
        return self.pinned or self.before

    def take(self, now: float, answer: Answer, turn: Rows) -> None:
        """Show an answer that comes at a time [s]; the one before stays if a new change begins."""
        begins = now - self._changed > ONE_CHANGE
        if begins and self.present is not None and not self.present.answer.message:
            self.before = self.present
        self._changed = now
        self.present = Kept(answer, turn)

    def against(self) -> str:
        """What numbers are compared with, in words; empty without anything."""
        if self.other is None:
            return ""
        which = "the pinned setting" if self.pinned else "the setting before"
        return f"at right: difference to {which} ({self.unlike(self.other)})"

    def unlike(self, kept: Kept) -> str:
        """The numbers of a setting that are others now."""
        now = () if self.present is None else self.present.answer.parts
        other = [item for item in kept.answer.parts if item not in now]
        return ", ".join(other) or "the same setting"

    def turned(self, turn: Rows) -> None:
        """Note the numbers of the whole turn of the present setting, which came later."""
        if self.present is not None:
            self.present = Kept(self.present.answer, turn)

    def end_change(self) -> None:
        """Let what comes next be another change, however soon it comes."""
        self._changed = -2.0 * ONE_CHANGE

    def pin(self) -> None:
        """Pin the present setting, if it has curves; unpin if one is pinned."""
        if self.pinned is not None:
            self.pinned = None
        elif self.present is not None and not self.present.answer.message:
            self.pinned = self.present


def _round_above(value: float, steps: tuple[float, ...] = _STEPS) -> float:
    """The least round number that is not below a positive value."""
    power = 10.0 ** math.floor(math.log10(value))
    # Nine digits, so that a round number is not below itself by round-off.
    least = float(f"{value / power:.9g}")
    return float(f"{power * next(step for step in steps if step >= least):.12g}")


class _Axis:
    """End of an axis.

    Args:
        steps: Round numbers that it may have.
        room: Room above the largest value when it has to grow.

    Attributes:
        top: The end; 1 before anything is shown.
    """

    def __init__(self, steps: tuple[float, ...] = _STEPS, room: float = 1.02) -> None:
        """Begin without a length."""
        self.top = 1.0
        self._steps, self._room, self._fresh = steps, room, True

    def hold(self, needed: float) -> None:
        """Grow, if the largest value of all that is shown would not fit."""
        if needed > 0.0 and (self._fresh or needed > self.top):
            self.top, self._fresh = _round_above(self._room * needed, self._steps), False

    def forget(self) -> None:
        """Fit what is held next, also if it is smaller."""
        self._fresh = True


class Curves:
    """Jaw angle with the gap at the contact, clamping force and impulses over one time.

    Args:
        slow: Seconds of the film in a second of the machine.
    """

    def __init__(self, mechanism: Mechanism, slow: float) -> None:
        """Begin with axes that fit what comes first."""
        stop = mechanism.stop(mechanism.transition_stop)
        term = coordinate_shown(mechanism, stop.index, small=True)
        unit = force_unit(mechanism, stop)
        self._stop = stop.name
        self._per_ms = slow * S_PER_MS
        self._term, self._lips = term, contact_shown(stop)
        self._gap = (f"{stop.name} {gap_noun(mechanism, stop)}", f"[{term.unit}]")
        self._force = ("clamping", f"force [{unit}]")
        self._impulse = ("impulse", f"[{unit} s]")
        self._time, self._high, self._most = _Axis(), _Axis(), _Axis()
        # Ends of the logarithmic axis: the upper one, and the reciprocal of the lower one.
        self._largest, self._least = (_Axis(_DECADES, 1.001) for _ in range(2))

    def forget(self) -> None:
        """Fit the axes to what is shown next."""
        for axis in (self._time, self._high, self._most, self._largest, self._least):
            axis.forget()

    def record(self, memory: Memory) -> _Record:
        """End and marks of the axis of time, and a lane for each quantity, as plain data."""
        kept = [
            (item, colour, dash)
            for item, colour, dash in (
                (memory.pinned, PINNED, _DASH), (memory.before, BEFORE, ()),
                (memory.present, NOW, ()),
            )
            if item is not None and not item.answer.message
        ]  # fmt: skip
        self._hold([item.answer for item, _, _ in kept])

        def lane(label: tuple[str, str], stop: str, most: float, line: _LineOf,
                 **more: object) -> _Record:  # fmt: skip
            drawn = [self._line(line(item.answer), colour, dash) for item, colour, dash in kept]
            first, *others = drawn or [{"colour": NOW, "values": []}]
            return {"label": label, "stop": stop, "most": most, "text": f"{most:g}", **first,
                    "more": others, **more}  # fmt: skip

        high, until = self._high.top, self._time.top
        lips = ""
        if self._lips is not None:
            lips = f"{self._lips.phrase(high / self._term.factor)} at the contact"
        low, top = 1.0 / self._least.top, self._largest.top
        lanes = [
            lane(self._gap, self._stop, high, lambda item: item.gap, right=lips),
            lane(self._force, "", self._most.top, lambda item: item.force),
            lane(self._impulse, "", top, lambda item: item.impulse, decades=(low, top)),
        ]
        marks = [{"at": self._per_ms * t / S_PER_MS, **mark} for t, mark in ticks(S_PER_MS * until)]
        return {"until": self._per_ms * until, "ticks": marks, "curves": lanes}

    def _hold(self, shown: list[Answer]) -> None:
        """Let the axes hold all that is shown."""
        for item in shown:
            self._time.hold(float(item.force[0, -1]))
            self._high.hold(float(item.gap[1].max(initial=0.0)))
            self._most.hold(float(item.force[1].max(initial=0.0)))
        impulses = [value for item in shown for value in item.impulse[1].tolist()]
        if impulses:
            self._largest.hold(max(impulses))
            self._least.hold(1.0 / min(impulses))

    def _line(self, line: FloatArray, colour: str, dash: tuple[int, ...]) -> _Record:
        time, values = line
        at = rounded(self._per_ms * time)
        return {"colour": colour, "dash": dash, "at": at, "values": rounded(values)}


def legend(memory: Memory) -> list[_Record]:
    """Which curve is which, with what is another number than now."""

    def entry(name: str, colour: str, kept: Kept, style: str = "solid") -> _Record:
        return {"name": name, "colour": colour, "style": style,
                "words": f"{name}: {memory.unlike(kept)}"}  # fmt: skip

    found: list[_Record] = [{"name": "now", "colour": NOW, "style": "solid", "words": "now"}]
    if memory.before is not None:
        found.append(entry("before", BEFORE, memory.before))
    if memory.pinned is not None:
        found.append(entry("pinned", PINNED, memory.pinned, "dashed"))
    return found

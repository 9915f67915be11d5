"""What one browser has set, by sliders and by numbers that are typed, and what it is shown.

The page is the viewer's, with a panel of sliders, numbers and curves that follow them.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import msgspec

from ...errors import InputError
from ...hybrid import Solution
from ...mechanism import Mechanism
from ...written_units import number_in
from ..reading import shown_until
from ..scene import Film, Look, Solid, film, pictured
from ..scene.objects import animation
from ..scene.pace import round_slow, steady
from ..scene.page import assembled, cameras, encoded, machine_messages
from ..scene.readings import readings
from .answer import Answer, answer, told
from .curves import Curves, Memory, legend
from .settings import LARGER, RESTITUTION, Knob, knobs, larger_knob
from .whole_turn import WholeTurns

LONGEST = 40
"""Most letters of a field that are read."""
_NOTE = (
    "Every number here is computed from these estimates of the class of machine, also where it "
    "agrees with a publication; none is the maker's. "
)
_LONGEST = 20.0  # seconds of the first film
# Its own server alone, over a WebSocket.
_CONNECT = "data: blob: 'self'"


def field_text(value: float) -> str:
    """A number as it stands in a field."""
    return f"{value:.12g}"


def typed(knob: Knob, text: str, shown: float) -> tuple[float | None, str]:
    """The number that a text in a field means, or why there is none.

    Args:
        text: The text; the number may have a unit of its own.
        shown: The number that is shown instead.

    Returns:
        The number, or None; why it cannot be used, what can, and what is shown: empty of a number.
    """
    found = text.strip()
    value, reason = None, "the field is empty"
    if found:
        try:
            value = number_in(found, knob.shown.unit)
            side = "too large" if value > knob.high else "too small"
            reason = f"{found} is {'no number' if math.isnan(value) else side}"
        except ValueError as error:
            reason = f"“{found}” is not {error}"
    if value is not None and knob.low <= value <= knob.high:
        return value, ""
    now, low, high = (field_text(item) for item in (shown, knob.low, knob.high))
    unit = f" {knob.shown.unit}".rstrip()
    words = f"{knob.shown.words}: {low} to {high}{unit}. Refused: {reason}. Shown: {now}{unit}."
    return None, words


class _Message(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind"):
    """What a page sends."""


class _Slid(_Message, frozen=True, tag="slid"):
    """A slider was moved."""

    key: str
    value: float


class _Typed(_Message, frozen=True, tag="typed"):
    """A text stands in a field."""

    key: str
    text: Annotated[str, msgspec.Meta(max_length=LONGEST)]


class _Pressed(_Message, frozen=True, tag="pressed"):
    """A button was pressed."""

    button: Literal["reset", "pin", "fit"]


_MESSAGE = msgspec.json.Decoder(_Slid | _Typed | _Pressed)


@dataclass(frozen=True)
class Shown:
    """What all browsers are shown.

    Attributes:
        controls: What the sliders set.
        drawn: What the mechanism is drawn with.
        slow: Seconds of a film in a second of the machine.
        turns: Whole turns of the settings.
        larger: How large rebounds are drawn.
    """

    mechanism: Mechanism
    controls: Sequence[Knob]
    drawn: Sequence[Solid]
    slow: float
    turns: WholeTurns
    larger: Knob


class Session:
    """The setting of one browser, and what it remembers.

    Args:
        shown: What all browsers are shown.
        clock: Time, by which moves that follow each other at once are one change [s].
    """

    def __init__(self, shown: Shown, clock: Callable[[], float] = time.perf_counter) -> None:
        """Begin with all sliders at their starts."""
        self._shown, self._clock = shown, clock
        self._knobs = {item.key: item for item in (*shown.controls, shown.larger)}
        self._values = {key: item.start for key, item in self._knobs.items()}
        # Texts as they were typed, also those that are refused.
        self._texts = {key: field_text(value) for key, value in self._values.items()}
        self._memory, self._curves = Memory(), Curves(shown.mechanism, shown.slow)
        self._answer = self._follow()
        self._filmed: tuple[Answer, float] = (self._answer, self._values[LARGER])

    def take(self, raw: str | bytes) -> bool:
        """Take a message of a page, and say whether it was one; what is none changes nothing."""
        try:
            message = _MESSAGE.decode(raw)
        except (msgspec.MsgspecError, UnicodeError, RecursionError):
            return False
        if isinstance(message, _Pressed):
            self._press(message.button)
        elif message.key not in self._knobs:
            return False
        elif isinstance(message, _Typed):
            self._texts[message.key] = message.text
            knob, shown = self._knobs[message.key], self._values[message.key]
            self._set(message.key, typed(knob, message.text, shown)[0])
        elif math.isfinite(message.value):
            knob = self._knobs[message.key]
            value = min(max(message.value, knob.low), knob.high)
            self._texts[message.key] = field_text(value)
            self._set(message.key, value)
        else:
            return False
        return True

    def turned(self) -> None:
        """Follow whole turns, now that this is possible."""
        self._memory.turned(self._shown.turns.rows(self._values))

    def state(self) -> dict[str, object]:
        """Controls, numbers and curves, or why there are none, as plain data."""
        memory, found = self._memory, self._answer
        other = memory.other
        turn = () if memory.present is None else memory.present.turn
        return {
            "controls": {key: self._control(knob) for key, knob in self._knobs.items()},
            "pinned": memory.pinned is not None,
            "setting": found.setting,
            "against": memory.against(),
            "message": found.message,
            "rows": told(found.rows, other.answer.rows if other else ()),
            "turn": told(turn, other.turn if other else ()),
            "legend": legend(memory),
            "axes": self._curves.record(memory),
        }

    def film(self) -> dict[str, object] | None:
        """The film of the setting, and the message that plays it; None if the page has it."""
        wanted, found = (self._answer, self._values[LARGER]), self._answer.solution
        if found is None or wanted == self._filmed:
            return None
        self._filmed = wanted
        shown, remark = filmed(self._shown, found, self._values[LARGER])
        scene = encoded(animation(shown, self._shown.drawn))
        return {"film": read(shown, remark), "scene": scene}

    def _control(self, knob: Knob) -> dict[str, object]:
        value, text = self._values[knob.key], self._texts[knob.key]
        return {"value": value, "text": text, "refusal": typed(knob, text, value)[1]}

    def _press(self, button: str) -> None:
        if button == "pin":
            self._memory.pin()
            return
        self._curves.forget()
        if button == "reset":
            self._memory.end_change()
            for key, knob in self._knobs.items():
                self._texts[key] = field_text(knob.start)
                self._values[key] = knob.start
            self._answer = self._follow()

    def _set(self, key: str, value: float | None) -> None:
        """Follow a number; a text that is none leaves what is shown."""
        if value is None or value == self._values[key]:
            return
        self._values[key] = value
        if key != LARGER:
            self._answer = self._follow()

    def _follow(self) -> Answer:
        """Answer the setting of the sliders, unless it is the present one."""
        shown, present = self._shown, self._memory.present
        found = answer(shown.mechanism, shown.controls, self._values)
        if present is not None and present.answer.parts == found.parts:
            return present.answer
        self._memory.take(self._clock(), found, shown.turns.rows(self._values))
        return found


def filmed(shown: Shown, solution: Solution, larger: float) -> tuple[Film, str]:
    """The film of a transition, and why its rebounds are not drawn larger; empty if they are."""
    frames = steady(solution, shown.slow)
    try:
        return film(solution, Look(exaggerate=larger), frames), ""
    except InputError as error:
        return film(solution, Look(exaggerate=1.0), frames), error.message


def read(shown: Film, remark: str = "") -> dict[str, object]:
    """What the page writes beside a film."""
    found = readings(shown)
    estimate = _NOTE if "estimate" in shown.solution.mechanism.title else ""
    return {**found, "note": f"{estimate}{found['note']} {remark}".rstrip()}


def shown_live(mechanism: Mechanism, speed_rpm: float) -> tuple[Shown, str]:
    """What all browsers are shown, and the page that they begin with, at a speed [r/min].

    Raises:
        InputError: The mechanism has no transition, or cannot be drawn.
    """
    controls = knobs(mechanism, speed_rpm)
    start = {item.key: item.start for item in controls}
    first = answer(mechanism, controls, start)
    # In the place of a setting without motion stands one with the same touch configuration.
    still = answer(mechanism, controls, {**start, RESTITUTION: 0.0})
    solution = first.solution or still.solution
    if solution is None:
        raise InputError(first.message, model=mechanism.name)
    slow = round_slow(shown_until(solution), _LONGEST)
    turns = WholeTurns(mechanism, controls)
    played = film(solution, Look(), steady(solution, slow))
    larger, drawn = larger_knob(played.larger), pictured(mechanism)
    shown = Shown(mechanism, controls, drawn, slow, turns, larger)
    found = {
        **read(played),
        "cameras": cameras((played, drawn)),
        "live": {
            "controls": [
                {"key": knob.key, "name": knob.shown.words, "label": knob.shown.label,
                 "low": knob.low, "high": knob.high, "step": knob.step}
                for knob in (*controls, larger)
            ],
            "state": Session(shown).state(),
        },
    }  # fmt: skip
    messages = [*machine_messages(mechanism, drawn), animation(played, drawn)]
    page = assembled(messages, found, __package__, _CONNECT)
    return shown, page

"""The page: the viewer's, with a panel of sliders, numbers and curves that follow them."""

from __future__ import annotations

from ...errors import InputError
from ...mechanism import Mechanism
from ..reading import shown_until
from ..scene import Look, film, pictured
from ..scene.objects import animation
from ..scene.pace import round_slow, steady
from ..scene.page import assembled, cameras, machine_messages
from .answer import answer
from .session import Session, Shown, read
from .settings import RESTITUTION, Knob, knobs, larger_knob
from .whole_turn import WholeTurns

_LONGEST = 20.0  # seconds of the first film
# Its own server alone, over a WebSocket.
_CONNECT = "data: blob: 'self'"


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
            "controls": [_control(item) for item in (*controls, larger)],
            "state": Session(shown).state(),
        },
    }
    messages = [*machine_messages(mechanism, drawn), animation(played, drawn)]
    page = assembled(messages, found, __package__, _CONNECT)
    return shown, page


def _control(knob: Knob) -> dict[str, object]:
    return {"key": knob.key, "name": knob.shown.words, "label": knob.shown.label,
            "low": knob.low, "high": knob.high, "step": knob.step}  # fmt: skip

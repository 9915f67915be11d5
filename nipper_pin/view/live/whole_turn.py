"""The whole turn of a setting, by the reduced engine.

Its tables and its machine code are made in a thread of its own, so that the page starts and answers
without them. From then on a turn takes less than a millisecond, in the thread that asks for it.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ...errors import NipperError
from ...extras import installed
from ...mechanism import INDEX_PER_TURN, Mechanism, within_turn
from ...reduced.results import TURN_REASONS
from ...reduced.turns import TurnModel, TurnQuantities, TurnStatus, turn_model, turn_quantities
from ...reduced.turns.turn import GAP_SCALES
from ...terms import TERMS
from ...units import MS_PER_S
from .answer import Number, Rows
from .settings import RESTITUTION, SPEED, Knob, changed, in_si

# Turns until they repeat, and collisions of a turn.
_TURNS, _MOST_COLLISIONS = 32, 400
_PENDING = "its tables are being made"
_DIRECT = "none; simulate --window cycle takes the direct one"


class WholeTurns:
    """Turns of the settings of a page."""

    def __init__(self, mechanism: Mechanism, controls: Sequence[Knob]) -> None:
        """Prepare; nothing is made before :meth:`start`."""
        self._mechanism, self._controls = mechanism, controls
        self._why: str | None = None

    def start(self, told: Callable[[], None]) -> None:
        """Make the tables, in a thread that ends with the process, and tell there when it has."""

        def make() -> None:
            self._why = unusable(self._mechanism)
            told()

        threading.Thread(target=make, daemon=True).start()

    def rows(self, shown: Mapping[str, float]) -> Rows:
        """Rows of a setting, in the units of its knobs, or that they are to come."""
        if self._why is None:
            return (Number("turn", "whole turn", _PENDING),)
        return turn_rows(self._mechanism, self._controls, shown, self._why)


def unusable(mechanism: Mechanism) -> str:
    """Make the tables of a mechanism's turns and load compiled code, or say why there are none."""
    if not installed("numba"):
        return "it needs numba (extra study)"
    try:
        # Also the wider ones: a slider must not wait for them.
        for gap_scale in GAP_SCALES:
            turn_model(mechanism, gap_scale=gap_scale)
        turn_quantities(mechanism, speed_rpm=mechanism.cylinder.rated_speed_rpm)
    except NipperError as error:
        return error.message
    return ""


def turn_rows(
    mechanism: Mechanism, controls: Sequence[Knob], shown: Mapping[str, float], why: str = ""
) -> Rows:
    """Numbers of the whole turn of one setting.

    Args:
        shown: Values of the knobs in their units, by key.
        why: Why there are no tables; empty if there are.

    Returns:
        The rows; a turn that cannot be followed gives its reason instead of numbers.
    """
    if why:
        return _nothing(why)
    values = in_si(controls, shown)
    springs = changed(mechanism, values).springs
    began = time.perf_counter()
    try:
        found = turn_quantities(
            mechanism,
            speed_rpm=values[SPEED],
            turns=_TURNS,
            restitution=values[RESTITUTION],
            stiffness=np.array([[spring.stiffness for spring in springs]]),
            preload=np.array([[spring.preload for spring in springs]]),
            max_collisions=_MOST_COLLISIONS,
        )
    except NipperError as error:
        return _nothing(error.message)
    status = TurnStatus(int(found.status[0]))
    if status is not TurnStatus.FOLLOWED:
        return _nothing(TURN_REASONS[status])
    return _numbers(turn_model(mechanism), found, MS_PER_S * (time.perf_counter() - began))


def _nothing(why: str) -> Rows:
    return (
        Number("turn", "whole turn", f"not followed: {why}"),
        Number("turn_engine", "engine of the turn", _DIRECT),
    )


def _numbers(model: TurnModel, found: TurnQuantities, wall_ms: float) -> Rows:
    """Rows of the last turn that was followed."""
    period = int(found.repeats_after[0])
    again = {0: f"not within {_TURNS} turns", 1: "every turn"}.get(period, f"after {period} turns")
    share, held = TERMS["clamped_share"].shown(), TERMS["clamped_time_s"].shown()
    parts = (
        ("clamped", share, float(found.clamped_share[0])),
        ("held", held, float(found.clamped_time[0])),
    )
    return (
        *(Number(key, term.label, term.text(value), value) for key, term, value in parts),
        _index(model, "closing", "index of the first touch", found.closed_at[0], "none"),
        _index(model, "rest", "index of rest", found.rests_at[0], "no rest before it opens"),
        _index(model, "opening", "index of opening by a stop", found.opened_at[0], "none"),
        _index(model, "lost", "index at which clamping is lost", found.lost_at[0], "not lost"),
        Number("repeats", "the turn repeats", again),
        Number("turn_engine", "engine of the turn", f"{found.engine}, {wall_ms:.1f} ms"),
    )


def _index(model: TurnModel, key: str, label: str, travel: float, otherwise: str) -> Number:
    """Index at a travel from the start of the turn [rad]."""
    if not np.isfinite(travel):
        return Number(key, label, otherwise)
    index = float(within_turn(model.start_index + INDEX_PER_TURN * travel / math.tau))
    return Number(key, label, f"{index:.3f}", index, on_scale=True)

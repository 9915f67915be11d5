"""The events of a run as they are written down."""

from __future__ import annotations

import numpy as np
import pytest

from nipper_pin import EventKind
from nipper_pin.dynamics import Impact
from nipper_pin.hybrid.contact.complementarity import Closed
from nipper_pin.hybrid.run.event_log import EventLog
from nipper_pin.hybrid.state import State


def _recorded(rest: float, later: float) -> EventLog:
    """A rest whose limit lies at a time, with an error of 1e-6 s, and a collision after it."""
    none = np.zeros(1)
    impact = Impact(none, none, np.zeros(0), {}, 0.0)
    state = State(0.5, none, none, np.zeros((0, 1)), (none, none, none), Closed())
    log = EventLog(lambda _: frozenset({"jaw", "steeve"}))
    log.record(EventKind.REST, state, rest, ["jaw"], impact, Closed(), series_error=1e-6)
    log.record(EventKind.COLLISION, state, later, ["steeve"], impact, Closed())
    return log


def test_a_rest_that_is_brought_forward_is_off_by_what_it_was_moved() -> None:
    """A limit that lies beyond the next event is put there, and its error grows by the way."""
    rest, hit = _recorded(1.0, 0.9).events
    assert rest.t == hit.t == 0.9
    assert rest.series_error == pytest.approx(0.1 + 1e-6, rel=1e-12)


def test_a_rest_before_the_next_event_stays_where_it_is() -> None:
    """Nothing is moved without need."""
    rest, hit = _recorded(0.8, 0.9).events
    assert (rest.t, hit.t) == (0.8, 0.9)
    assert rest.series_error == 1e-6

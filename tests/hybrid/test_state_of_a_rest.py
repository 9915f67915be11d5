"""The state at the time of a rest, which lies beyond the last collision that was computed."""

from __future__ import annotations

import numpy as np
import pytest

from nipper_pin import Case, EventKind, Mechanism, load, simulate
from nipper_pin.dynamics import ShaftMotion, System
from nipper_pin.hybrid.run.start import initial_state
from nipper_pin.mechanism import with_numbers
from tests.small_machines import link, machine, slide


def _assembled(
    mechanism: Mechanism, closed: frozenset[str], angle: float
) -> tuple[np.ndarray, ...]:
    """Positions and rates with these stops closed, assembled anew along the drives."""
    phase = mechanism.phase_of(closed)
    assert phase is not None
    there = with_numbers(mechanism, {"initial_phase": phase.number})
    shaft = ShaftMotion(there, 450.0 * np.pi / 30.0, angle)
    state = initial_state(System(there, shaft), 0.0)
    return state.q, state.v


@pytest.mark.parametrize("window", ["transition", "cycle"])
def test_it_is_that_of_the_links_at_its_time(window: str) -> None:
    """Held drives and closed stops determine every link, without what came before."""
    mechanism = load("e62")
    solution = simulate(mechanism, Case(speed_rpm=450.0, window=window))
    rest = next(item for item in solution.events if item.kind is EventKind.REST)
    assert rest.closed_after == frozenset({"jaw"})
    motion = solution.motion_at(rest)
    expected = _assembled(mechanism, rest.closed_after, float(solution.shaft.angle(rest.t)))
    assert motion.t[0] == rest.t
    np.testing.assert_allclose(motion.q[0], expected[0], rtol=0.0, atol=2e-13)
    np.testing.assert_allclose(motion.v[0], expected[1], rtol=0.0, atol=1e-10)
    jaw = mechanism.stop("jaw").index
    assert motion.q[0, jaw] == motion.v[0, jaw] == 0.0
    # The fields of the event are those of the collision before it.
    assert np.abs(rest.q - expected[0]).max() > 1e-6


def test_a_free_coordinate_goes_on_to_the_time_of_rest() -> None:
    """A ball comes to rest on its floor while a second one falls on: z = -g t2 / 2."""
    parts = [link("ball"), slide("ball", "frame", "ball", (0.0, 1.0)),
             link("other"), slide("other", "frame", "other", (0.0, 1.0))]  # fmt: skip
    stops = {"floor": {"joint": "ball", "restitution": 0.5, "at_mm": -1.0}}
    mechanism = machine(parts, 2, gravity=9.81, stops=stops)
    solution = simulate(mechanism, Case(speed_rpm=60.0, window="cycle"))
    rest = next(item for item in solution.events if item.kind is EventKind.REST)
    # sqrt(2 h / g) (1 + e) / (1 - e) for a fall from h.
    assert rest.t == pytest.approx(3.0 * np.sqrt(2e-3 / 9.81), rel=1e-12)
    motion = solution.motion_at(rest)
    assert motion.q[0] == pytest.approx([-1e-3, -0.5 * 9.81 * rest.t**2], abs=1e-13)
    assert motion.v[0] == pytest.approx([0.0, -9.81 * rest.t], abs=1e-12)
    (hit, *_) = solution.collisions
    same = solution.motion_at(hit.event)
    assert (same.q[0] == hit.event.q).all()
    assert (same.v[0] == hit.event.v_after).all()

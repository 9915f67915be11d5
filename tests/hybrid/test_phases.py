"""Which stops are closed: complementarity on the E62."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from nipper_pin import Case, EventKind, Mechanism, Window, simulate
from nipper_pin.dynamics import ShaftMotion, System
from nipper_pin.hybrid.contact.complementarity import pressed
from nipper_pin.mechanism import rad_s_from_rpm


def _set(*names: str) -> frozenset[str]:
    return frozenset(names)


Pressed = Callable[[float, float, frozenset[str]], frozenset[str]]


@pytest.fixture(scope="module")
def pressed_at(e62: Mechanism) -> Pressed:
    """Stops that stay closed at an index of the cycle, as a function of speed and stops at rest.

    While the drives determine everything, a configuration depends on the cylinder angle alone and
    velocities on the speed in proportion. They are taken from the cycle at 450 r/min, where the
    steeve never leaves its stop while the jaw is open.
    """
    slow = simulate(e62, Case(speed_rpm=450.0, window=Window.CYCLE))

    def find(speed: float, index: float, at_rest: frozenset[str]) -> frozenset[str]:
        t = (index - 24.0) / 40.0 * slow.shaft.period
        motion = slow.trajectory.evaluate(t)
        shaft = ShaftMotion(e62, rad_s_from_rpm(speed), float(motion.cylinder_angle[0]))
        system = System(e62, shaft)
        q, v = motion.q[0], motion.v[0] * speed / 450.0
        _, jacobian = system.body.closures(q[None])
        return pressed(system, system.shaft.driven(np.zeros(1)), q, v, jacobian[0], at_rest)

    return find


@pytest.mark.parametrize("index", [24.5, 27.0, 29.34, 33.0, 50.0, 60.0])
@pytest.mark.parametrize("speed", [100.0, 450.0])
def test_phase_1_keeps_the_steeve_closed(pressed_at: Pressed, speed: float, index: float) -> None:
    """With the jaw open the spring holds the steeve on its stop up to 641 r/min."""
    assert pressed_at(speed, index, _set("steeve")) == _set("steeve")


def test_phase_1_opens_where_inertia_wins(pressed_at: Pressed) -> None:
    """The stop force is F_spring - c speed^2 at a fixed angle: it is least at index 29.3.

    There it vanishes at 641.2 r/min by the independent reference, so 640 keeps the steeve and 643
    opens it; at index 33, where inertia presses, 643 keeps it.
    """
    assert pressed_at(640.0, 29.34, _set("steeve")) == _set("steeve")
    assert pressed_at(643.0, 29.34, _set("steeve")) == _set()
    assert pressed_at(643.0, 33.0, _set("steeve")) == _set("steeve")


@pytest.mark.parametrize("index", [36.0, 38.7, 42.0, 47.0])
def test_phase_2_keeps_the_jaw_closed(pressed_at: Pressed, index: float) -> None:
    """With the jaw closed the spring presses the lips together."""
    assert pressed_at(450.0, index, _set("jaw")) == _set("jaw")


def test_without_stops_at_rest_none_is_closed(pressed_at: Pressed) -> None:
    """Phase 3 has nothing to press on."""
    assert pressed_at(450.0, 30.0, _set()) == _set()


@pytest.mark.parametrize("speed", [450.0, 650.0])
def test_sets_along_a_cycle_are_complementary(e62: Mechanism, speed: float) -> None:
    """Along a whole cycle closed stops push and open gaps are positive, at 2000 times of each.

    An index set that lags one event behind breaks one of the two at once. The bounds are the
    round-off of forces of 300 N and of gaps of 4 mm and 0.4 rad.
    """
    solution = simulate(e62, Case(speed_rpm=speed, window=Window.CYCLE))
    first, last = solution.trajectory.span
    times = np.linspace(first, last, 2000)[1:-1]
    q = solution.trajectory.evaluate(times).q
    reactions = solution.trajectory.reactions(times)
    for stop in e62.stops:
        assert q[:, stop.index].min() >= -1e-15
        assert reactions.stops[stop.name].min() >= -1e-9
        # Never both: a gap and a force at the same time.
        assert np.minimum(q[:, stop.index], reactions.stops[stop.name]).max() <= 1e-15
        assert reactions.stops[stop.name].max() > 1.0
        assert q[:, stop.index].max() > 1e-3


def test_at_release_the_force_is_zero_and_the_gap_opens(e62: Mechanism) -> None:
    """Where the steeve leaves its stop its force has just fallen to zero.

    The force is found to the round-off of its largest value, 300 N; just after, the gap grows.
    """
    solution = simulate(e62, Case(speed_rpm=650.0, window=Window.CYCLE))
    release = next(event for event in solution.events if event.kind is EventKind.RELEASE)
    assert release.stops == ("steeve",)
    force = solution.trajectory.reactions(release.t, left=True).stops["steeve"][0]
    assert abs(force) <= 1e-9
    before = solution.trajectory.reactions(release.t - 1e-5, left=True).stops["steeve"][0]
    assert before > 0.0
    steeve = e62.stop("steeve").index
    later = solution.trajectory.evaluate(release.t + np.array([1e-4, 2e-4])).q[:, steeve]
    assert 0.0 < later[0] < later[1]

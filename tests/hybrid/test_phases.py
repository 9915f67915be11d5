"""Which stops are closed on the E62, and phases without freedom, against dynamics."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from nipper_pin import Case, EventKind, Mechanism, Solution, Window, simulate
from nipper_pin.hybrid.segment import Segment


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


def integrated(solution: Solution, segment: Segment) -> tuple[np.ndarray, np.ndarray]:
    """q and v at the end of a segment by SciPy's DOP853 on the equations of motion."""
    system, nv = solution.system, solution.system.body.nv
    phase = system.constraint_set(segment.closed)

    def right_side(t: float, y: np.ndarray) -> np.ndarray:
        driven = system.shaft.driven(np.array([t]))
        a = system.accelerations(driven, y[None, :nv], y[None, nv:], phase)
        return np.concatenate([y[nv:], a[0]])

    first = segment.panels[0]
    start = np.concatenate([first.q[0], first.v[0]])
    span = (segment.t_start, segment.t_end)
    end = solve_ivp(right_side, span, start, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    return end[:nv], end[nv:]


def test_integration_of_a_kinematic_phase_is_the_same_motion(e62: Mechanism) -> None:
    """Equations of motion end where kinematics does (1e-7, 1e-6 in rates).

    They drift off the closures where kinematics cannot, by their tolerance times the growth over a
    phase; a wrong phase, force or end would be off by the stroke itself.
    """
    solution = simulate(e62, Case(speed_rpm=450.0, window=Window.CYCLE))
    kinematic = [segment for segment in solution.segments if segment.kinematic]
    assert len(kinematic) >= 3
    for segment in kinematic:
        q, v = integrated(solution, segment)
        end = solution.trajectory.evaluate(segment.t_end, left=True)
        begin = solution.trajectory.evaluate(segment.t_start)
        assert np.abs(end.q - begin.q).max() > 0.1
        assert q == pytest.approx(end.q[0], abs=1e-7)
        assert v == pytest.approx(end.v[0], abs=1e-6)

"""Which stops are closed on the E62, and phases without freedom, against dynamics."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from nipper_pin import Case, EventKind, Mechanism, Solution, Window, simulate
from nipper_pin.dynamics import ShaftMotion, System
from nipper_pin.dynamics.multipliers import multipliers
from nipper_pin.hybrid.contact.complementarity import pressed
from nipper_pin.hybrid.motion.panel import Panel
from nipper_pin.hybrid.segment import Segment
from nipper_pin.mechanism import rad_s_from_rpm

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


@pytest.mark.parametrize(
    ("speeds", "indices", "at_rest", "closed"),
    [
        # With the jaw open the spring holds the steeve on its stop up to 641 r/min.
        ((100.0, 450.0), (24.5, 27.0, 29.34, 33.0, 50.0, 60.0), {"steeve"}, {"steeve"}),
        # The force is F_spring - c speed^2: at index 29.3 it is least, and vanishes at 641.2 r/min
        # by the independent reference; at index 33 inertia presses.
        ((640.0,), (29.34,), {"steeve"}, {"steeve"}),
        ((643.0,), (29.34,), {"steeve"}, set()),
        ((643.0,), (33.0,), {"steeve"}, {"steeve"}),
        # With the jaw closed the spring presses the lips together.
        ((450.0,), (36.0, 38.7, 42.0, 47.0), {"jaw"}, {"jaw"}),
        ((450.0,), (30.0,), set(), set()),
    ],
)
def test_stops_stay_closed_where_they_are_pressed(
    pressed_at: Pressed, speeds: tuple[float, ...], indices: tuple[float, ...],
    at_rest: set[str], closed: set[str],
) -> None:  # fmt: skip
    for speed, index in product(speeds, indices):
        assert pressed_at(speed, index, frozenset(at_rest)) == closed


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


def drive_torques(solution: Solution, segment: Segment, panel: Panel) -> np.ndarray:
    """Torques of the drives at the nodes of a panel, from positions and accelerations there."""
    system = solution.system
    jacobians = system.body.closures(panel.q)[1]
    phase = system.constraint_set(segment.closed)
    driven = system.shaft.driven(panel.times)
    return multipliers(
        system, driven, panel.q, panel.v, panel.a, jacobians, phase, panel.split
    ).drive


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


@pytest.mark.parametrize("window", list(Window))
def test_torques_at_the_nodes_are_those_of_the_solution(e62: Mechanism, window: Window) -> None:
    """Torques from the states of the nodes are those that the solution gives there.

    The solution solves positions and accelerations again at these times, so the two agree to the
    accuracy of the motion, 1e-12, grown a thousandfold by the second derivative. Torques of
    neighbouring nodes differ by parts of the peak: a force of another node or phase would be seen.
    """
    solution = simulate(e62, Case(speed_rpm=650.0, window=window))
    drives = [drive.name for drive in e62.drives]
    compared, torques, errors = 0, [], []
    for segment in solution.segments:
        for panel in segment.panels:
            inside = (segment.t_start < panel.times) & (panel.times < segment.t_end)
            asked = solution.trajectory.reactions(panel.times[inside]).drives
            expected = np.stack([asked[name] for name in drives], axis=1)
            compared += len(expected)
            torques.append(expected)
            errors.append(drive_torques(solution, segment, panel)[inside] - expected)
    assert compared >= 10
    peak = np.abs(np.concatenate(torques)).max(axis=0)
    assert (np.ptp(np.concatenate(torques), axis=0) > 0.1 * peak).all()
    assert (np.abs(np.concatenate(errors)).max(axis=0) <= 1e-9 * peak).all()

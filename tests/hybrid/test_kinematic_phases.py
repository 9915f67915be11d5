"""Phases without freedom, whose motion closures and drives determine, against dynamics."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from nipper_pin import Case, Mechanism, Solution, Window, simulate
from nipper_pin.dynamics.multipliers import multipliers
from nipper_pin.hybrid.motion.panel import Panel
from nipper_pin.hybrid.segment import Segment


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

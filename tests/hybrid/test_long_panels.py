"""Panels that are as long as they may be, and panels that are too long."""

from typing import Any

import pytest

from nipper_pin import Case, Mechanism, Resolution, Window, simulate
from nipper_pin.hybrid import advance
from nipper_pin.hybrid.motion.kinematics import kinematic_panel
from nipper_pin.hybrid.motion.panel import Attempt, Begin
from nipper_pin.hybrid.motion.picard import flight_panel

# Nodes of the nested grids that are not the first one.
COARSE, MIDDLE, FINE = 3, 6, 12
# States in which the round-off of forces is asked for.
ROUND_OFF = 3


def test_a_panel_that_is_too_long_is_given_up_after_two_sweeps_of_each_grid(e62: Mechanism) -> None:
    """What follows the last coefficients is far above the tolerance on a fifth of a turn."""
    solution = simulate(e62, Case(speed_rpm=650.0))
    system, segment = solution.system, solution.segments[0]
    first = segment.panels[0]
    jacobian = system.body.closures(first.q[:1])[1][0]
    begin = Begin(first.t, first.q[0], first.v[0], first.a[0], jacobian)
    phase, before = system.constraint_set(segment.closed), system.body.evaluations
    h = 0.2 * system.shaft.period
    attempt = flight_panel(system, phase, first.split, begin, h, Resolution())
    assert attempt.panel is None
    assert 0.2 <= attempt.factor <= 0.7
    assert system.body.evaluations - before <= 2 * (COARSE + MIDDLE + FINE) + ROUND_OFF


def test_phases_without_freedom_take_panels_of_a_fifth_of_a_turn(
    e62: Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three stretches of a turn of the E62 at 450 r/min: none of their panels is solved twice."""
    tried = []

    def counted(*arguments: Any) -> Attempt:
        tried.append(arguments)
        return kinematic_panel(*arguments)

    monkeypatch.setattr(advance, "kinematic_panel", counted)
    solution = simulate(e62, Case(speed_rpm=450.0, window=Window.CYCLE))
    stretches = [item.panels for item in solution.segments if item.kinematic]
    first = max(panels[0].h for panels in stretches)
    assert first == pytest.approx(2.5 / 12.0 * solution.shaft.period)
    assert max(panel.h for panels in stretches for panel in panels) > 1.1 * first
    assert len(tried) == sum(len(panels) for panels in stretches) == 6

"""Which rules of series a machine has: those of two stops only where there are two."""

from __future__ import annotations

from pathlib import Path

import pytest

from nipper_pin import Case, load, simulate
from nipper_pin.dynamics.shaft import ShaftMotion
from nipper_pin.dynamics.system import System
from nipper_pin.hybrid.run import phase_manager
from nipper_pin.hybrid.run.series.rules import series_rules

ONE_STOP = Path(__file__).parents[2] / "models" / "benchmarks" / "impact_oscillator"
BOUNCES = "bounces to rest"
SEVERAL = ["jams between two stops", "stops that throw one another open", BOUNCES]


def test_rules_of_two_stops_need_two() -> None:
    for model, expected in ((ONE_STOP, [BOUNCES]), ("e62", SEVERAL)):
        mechanism = load(model)
        assert len(mechanism.stops) == min(len(expected), 2)
        system = System(mechanism, ShaftMotion(mechanism, 50.0, 0.0))
        found = [rule.name for rule in series_rules(system, Case(speed_rpm=450.0), [])]
        assert found == expected


def test_rules_are_asked_in_order_until_one_ends_a_series(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the rule of one stop the jaw bounces on to the round-off of its rates."""
    case = Case(speed_rpm=650.0)
    own = phase_manager.series_rules
    whole = simulate(load("e62"), case)
    monkeypatch.setattr(phase_manager, "series_rules", lambda *given: own(*given)[:-1])
    followed = simulate(load("e62"), case)
    assert len(followed.collisions) > 3 * len(whole.collisions)
    count = len(whole.collisions)
    for one, other in zip(whole.collisions, followed.collisions[:count], strict=True):
        assert one.t == other.t

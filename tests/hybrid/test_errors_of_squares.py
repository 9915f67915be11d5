"""What goes with the square of a rate is wrong by (1 + r)^2 - 1 of itself, r being the rate's own.

Losses of energy and heights of rebounds do. A statement that forgets the square is half as large,
which no true error has to show: those are far smaller than any bound.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from small_machines import link, machine, slide

from nipper_pin import Case, EventKind, Mechanism, Resolution, load, simulate
from nipper_pin.hybrid.result.rebound_errors import rebound_error
from nipper_pin.hybrid.result.turns import reported_turn
from nipper_pin.reduced.turns import turn_quantities, turns

# Relative errors of rates are below this, and their squares are beside their doubles.
SMALL, OF_SERIES = 1e-3, 0.05


def grown(values: Any, relative: Any, most: float = SMALL) -> float:
    """What values that go with the square of a rate change by with it, all in one sense."""
    assert 0.0 < np.max(relative) < most
    return math.fsum(np.asarray(values) * ((1.0 + np.asarray(relative)) ** 2 - 1.0))


def ball(restitution: float) -> Mechanism:
    """A ball that falls 0.3 m."""
    floor = {"joint": "z", "side": "lower", "at_mm": -300.0, "restitution": restitution}
    parts = [link("ball"), slide("z", "frame", "ball", axis=(0.0, 1.0))]
    return machine(parts, 1, gravity=9.81, stops={"floor": floor})


MACHINES = {"e62": lambda: load("e62"), "ball": lambda: ball(0.4), "lively ball": lambda: ball(0.8)}
# Machine, speed in r/min, tolerance.
TURNS = [
    ("e62", 450.0, 1e-6),
    ("e62", 650.0, 1e-6),
    ("e62", 650.0, 1e-9),
    ("ball", 30.0, 1e-6),
    ("lively ball", 30.0, 1e-9),
]


@pytest.mark.parametrize(("name", "speed", "tolerance"), TURNS)
def test_the_energy_lost_in_a_turn(name: str, speed: float, tolerance: float) -> None:
    case = Case(speed_rpm=speed, window="cycle", resolution=Resolution(tolerance=tolerance))  # type: ignore[arg-type]
    solution = simulate(MACHINES[name](), case)
    losing = [event for event in solution.events if event.kind is not EventKind.RELEASE]
    relative = [solution.errors[event.number - 1].impulse for event in losing]
    wrong = grown([event.energy_lost for event in losing], relative)
    turn = reported_turn(solution)
    assert turn.energy_lost_error == pytest.approx(wrong, rel=SMALL)
    assert turn.energy_lost_error < SMALL * turn.energy_lost


@pytest.mark.parametrize(("name", "speed", "tolerance"), TURNS)
def test_the_height_of_every_rebound(name: str, speed: float, tolerance: float) -> None:
    """Those that a run leaves out, since their rest is known, have the rate of their collision."""
    case = Case(speed_rpm=speed, window="cycle", resolution=Resolution(tolerance=tolerance))  # type: ignore[arg-type]
    solution = simulate(MACHINES[name](), case)
    compared = 0
    for hit in solution.collisions:
        relative = solution.errors[hit.event.number - 1].impulse
        if hit.rebound_amplitude is None or relative >= SMALL:
            continue
        stated = rebound_error(solution, hit).amplitude
        assert stated >= (1.0 - SMALL) * grown([hit.rebound_amplitude], [relative])
        compared += 1
    assert compared > 3
    left_out = [
        hit.rebounds.until(hit.event, hit.stop)[1] is not None for hit in solution.collisions
    ]
    assert any(left_out) or name == "lively ball"


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
@pytest.mark.parametrize("restitution", [0.2, 0.6])
def test_the_energy_lost_in_a_turn_of_the_reduced_engine(
    restitution: float, tolerance: float
) -> None:
    """Each loss by its rate; those beyond the last bounce by the impulses beyond it.

    Impulses and losses beyond a bounce are the sums of geometric series, P e / (1 - e) and
    E e^2 / (1 - e^2).
    """
    values = {"stops.jaw.restitution": restitution, "stops.steeve.restitution": restitution}
    mechanism, given = load("e62", values), {"speed_rpm": 450.0, "tolerance": tolerance}
    events, found = turns(mechanism, **given), turn_quantities(mechanism, **given)
    kinds, stops = np.array(events.kind), np.array(events.stop)
    hits = kinds == "collision"
    relative = events.rate_error[hits] / -events.approach_rate[hits]
    losses = zip(events.energy_lost[hits], relative, events.energy_error[hits], strict=True)
    for energy, r, error in losses:
        assert error >= (1.0 - SMALL) * grown([energy], [r])
    beyond = 0.0
    for place, stop in enumerate(mechanism.stops):
        (last,) = (
            before[-1]
            for rest in np.flatnonzero((kinds == "rest") & (stops == stop.name))
            if (before := np.flatnonzero(hits[:rest] & (stops[:rest] == stop.name))).size
        )
        e = restitution
        further = events.impulse[last] * e / (1.0 - e)
        own = hits & (stops == stop.name)
        unsure = found.impulse_sum_error[0, place] - events.impulse_error[own].sum()
        lost = events.energy_lost[last] * e**2 / (1.0 - e**2)
        beyond += grown([lost], [unsure / further], OF_SERIES)
    told = found.energy_lost_error[0] - events.energy_error[hits].sum()
    assert told >= (1.0 - OF_SERIES) * beyond

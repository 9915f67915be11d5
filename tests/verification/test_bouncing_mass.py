"""A bouncing ball through the same engine as the nipper: stops, loop, drive and bounce series.

A shelf holds a mass until a table, rising at constant speed V, hits it at t = 0. In the frame of
the table, which is inertial, the mass then is a bouncing ball with approach rates

    w_0 = V,  w_k = e^k V,

rebound k takes T_k = 2 e^k V / g, reaches A_k = (e^k V)^2 / (2 g), and the collisions accumulate at

    t_rest = sum of T_k, k >= 1 = 2 e V / (g (1 - e)).

The carriage and the slide that tie the mass to the shelf move with it, so the impulse is
(m + m_carriage + m_slide) (1 + e) w_k.

The numbers cannot come out by accident: the engine knows neither the ball nor the series; it finds
every impact by root search on a collocation polynomial of a loop with a cut pin.
"""

from __future__ import annotations

import itertools
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from nipper_pin import Case, EventKind, Outcome, Solution, Window, load, simulate

MODEL = Path(__file__).parent / "models" / "bouncing_mass"
GRAVITY = 9.81
MASS = 0.7 + 1e-3 + 1e-3
EPS = float(np.finfo(float).eps)
RESTITUTIONS = [0.05, 0.2, 0.5, 0.8, 0.9, 0.95]


@cache
def run(e: float, speed: float = 0.06, start: float | None = None) -> Solution:
    """A run at 60 r/min, one turn a second; a table speed of v m/s is a lead of v metres a turn.

    A transition, or a turn from an index.
    """
    changes = {"stops.table.restitution": e, "drives.table.lead_mm_per_turn": 1e3 * speed}
    case = Case(speed_rpm=60.0)
    if start is not None:
        case = Case(speed_rpm=60.0, window=Window.CYCLE, start_index=start)
    return simulate(load(MODEL, changes), case)


def _tolerance(e: float, t: float, flight: float) -> float:
    """Relative tolerance of a rate near the end of a series.

    A flight of length T that ends at time t can be known no better than to eps t / T; rates carry
    the errors of all flights before, which form a geometric series, hence 1 / (1 - e). 1e-12 is
    the tolerance that the engine is asked for.
    """
    return 1e-12 + 4.0 * EPS * t / (flight * (1.0 - e))


@pytest.mark.parametrize("e", RESTITUTIONS)
def test_collisions_are_those_of_the_series(e: float) -> None:
    """Rates, times, rebounds, impulses and losses of every collision, by the formulas above.

    Approach rates are w = e^k V and separation rates e times that; times are the partial sums
    2 e V (1 - e^k) / (g (1 - e)); losses M w^2 (1 - e^2) / 2 as seen from the table, and each
    amplitude is e^2 times the one before.
    """
    collisions = run(e).collisions
    rest = 2.0 * e * 0.06 / (GRAVITY * (1.0 - e))
    for k, collision in enumerate(collisions):
        w = e**k * 0.06
        near = _tolerance(e, collision.t, 2.0 * w / GRAVITY)
        assert collision.t == pytest.approx(rest * (1.0 - e**k), abs=1e-12 * rest)
        assert collision.approach_rate == pytest.approx(-w, rel=near)
        assert collision.separation_rate == pytest.approx(e * w, rel=near)
        assert collision.impulse == pytest.approx(MASS * (1.0 + e) * w, rel=near)
        lost = 0.5 * MASS * w**2 * (1.0 - e**2)
        assert collision.energy_lost == pytest.approx(lost, rel=2.0 * near)
        flight = 2.0 * e * w / GRAVITY
        near = _tolerance(e, collision.t, flight)
        height = (e * w) ** 2 / (2.0 * GRAVITY)
        assert collision.rebound_amplitude == pytest.approx(height, rel=2.0 * near)
        assert collision.rebound_time == pytest.approx(flight, rel=near)
    for before, after in itertools.pairwise(collisions):
        near = 4.0 * _tolerance(e, after.t, 2.0 * after.separation_rate / GRAVITY)
        ratio = (after.rebound_amplitude or 0.0) / (before.rebound_amplitude or 1.0)
        assert ratio == pytest.approx(e**2, rel=near)


@pytest.mark.parametrize("e", RESTITUTIONS)
def test_time_of_rest_is_the_zeno_limit(e: float) -> None:
    """Rest comes at 2 e V / (g (1 - e)) to 1e-12, though only finitely many bounces are computed.

    What is left out is not small by itself: the last collision computed lies 1e-5 of the series or
    more before its limit. Collisions and the rest together lose M V^2 / 2: the sum telescopes.
    """
    solution = run(e)
    rest = 2.0 * e * 0.06 / (GRAVITY * (1.0 - e))
    assert solution.outcome is Outcome.AT_REST
    assert solution.events[-1].kind is EventKind.REST
    assert solution.events[-1].t == pytest.approx(rest, rel=1e-12)
    assert rest - solution.collisions[-1].t > 1e-6 * rest
    assert solution.transitions[0].duration == pytest.approx(rest, rel=1e-12)
    lost = sum(event.energy_lost for event in solution.events)
    assert lost == pytest.approx(0.5 * MASS * 0.06**2, rel=1e-11)


@pytest.mark.parametrize("e", RESTITUTIONS)
def test_no_premature_rest(e: float) -> None:
    """The series is followed until w^3 is below a hundred tolerances, w the rate by its first one.

    That is w = 4.6e-4 at 1e-12, and takes ln(w) / ln(e) bounces at least, 149 for e = 0.95.
    """
    solution = run(e)
    w = (100.0 * 1e-12) ** (1.0 / 3.0)
    assert len(solution.collisions) >= math.log(w) / math.log(e)
    assert solution.collisions[-1].separation_rate <= w * solution.collisions[0].separation_rate


@pytest.mark.parametrize("excess", [1e-2, 1e-3, 1e-4, 1e-6, 1e-9, 1e-12, 1e-14, 0.0, -1e-14])
def test_an_impact_just_after_a_panel_is_not_missed(excess: float) -> None:
    """A flight longer than one panel by a tiny part still ends at its impact.

    The first flight takes 2 e V / g; V is chosen so that it is (1 + excess) panels of 1/16 turn.
    The next panel then starts a hair's breadth above the table, with its zero before the first
    point of any grid inside it. A missed zero would let the mass fall through the table.
    """
    e = 0.5
    speed = (1.0 / 16.0) * (1.0 + excess) * GRAVITY / (2.0 * e)
    solution = run(e, speed)
    first = 2.0 * e * speed / GRAVITY
    assert solution.collisions[1].t == pytest.approx(first, rel=1e-13)
    assert solution.collisions[1].approach_rate == pytest.approx(-e * speed, rel=1e-12)
    assert solution.events[-1].t == pytest.approx(first / (1.0 - e), rel=1e-12)


def test_the_table_carries_the_weight_after_rest() -> None:
    """At constant table speed the force after rest is M g, and the shelf is left behind.

    The transition ends at rest; the cycle goes on for the rest of the turn.
    """
    solution = run(0.5, start=-1.0)
    assert solution.events[-1].kind is EventKind.REST
    end = solution.trajectory.span[1]
    reactions = solution.trajectory.reactions(end, left=True)
    assert reactions.contacts["table"][0] == pytest.approx(MASS * GRAVITY, rel=1e-12)
    assert reactions.contacts["shelf"][0] == 0.0
    # The slide rises with the table from the first impact on: 39/40 of a turn, one second each.
    slide = solution.mechanism.stop("shelf").index
    height = solution.trajectory.evaluate(end, left=True).q[0, slide]
    assert height == pytest.approx(0.06 * 39.0 / 40.0, rel=1e-12)

"""A mass that bounces between a floor and a ceiling, against the closed solution.

Floor and ceiling belong to a box that rises at constant speed V and is therefore an inertial frame;
the mass hangs on a shelf until the floor hits it. In the box a flight upwards from the floor at
rate w meets the ceiling, H above, at u = sqrt(w^2 - 2 g H) after (w - u) / g, and one downwards
from the ceiling at rate r meets the floor at v = sqrt(r^2 + 2 g H) after (v - r) / g; each stop
returns its own e of the rate. Once w^2 < 2 g H the mass bounces on the floor alone, to rest after
2 w / (g (1 - e)).

The same box is built with its coordinate upwards and downwards, which makes the floor a lower stop
or an upper one, and with the floor at zero or away from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from math import sqrt

import numpy as np
import pytest
from boxed_mass import CEILING, FLOOR, GRAVITY, HEIGHT, MASS, SPEED, box

from nipper_pin import Case, EventKind, Solution, Window, simulate

EPS = float(np.finfo(float).eps)

# Sense of the coordinate (1 upwards), distance of the floor below the mass at touch [m].
ways = pytest.mark.parametrize(
    ("sense", "below"), [(1.0, 0.0), (-1.0, 0.0), (1.0, 0.15), (-1.0, 0.15)]
)


@dataclass(frozen=True)
class Hit:
    """A collision of the closed solution: its time [s] and rates [m/s]."""

    stop: str
    t: float
    before: float
    after: float


def exact(below: float, count: int) -> list[Hit]:
    """The first collisions, by the recursion above."""
    t, hits = below / SPEED, [Hit("floor", below / SPEED, -SPEED, FLOOR * SPEED)]
    while len(hits) < count:
        last = hits[-1]
        if last.stop == "ceiling":
            v = sqrt(last.after**2 + 2.0 * GRAVITY * HEIGHT)
            t, stop, e = last.t + (v - last.after) / GRAVITY, "floor", FLOOR
        elif last.after**2 > 2.0 * GRAVITY * HEIGHT:
            v = sqrt(last.after**2 - 2.0 * GRAVITY * HEIGHT)
            t, stop, e = last.t + (last.after - v) / GRAVITY, "ceiling", CEILING
        else:
            v, stop, e = last.after, "floor", FLOOR
            t = last.t + 2.0 * v / GRAVITY
        hits.append(Hit(stop, t, -v, e * v))
    return hits


@cache
def run(sense: float, below: float, rest_rate: float | None = None) -> Solution:
    """Three turns of a second each."""
    case = Case(speed_rpm=60.0, window=Window.CYCLE, cycles=3, start_index=0.0, rest_rate=rest_rate)
    return simulate(box(sense, below), case)


@ways
def test_collisions_are_those_of_the_closed_solution(sense: float, below: float) -> None:
    """Stops, times and rates of every collision; four ways of counting give the same machine.

    Floor and ceiling alternate, then the floor is left alone: the order itself has to come out.
    Times are right to 1e-12 of the turn; a rate w carries the errors of earlier times by g / w, and
    the restitutions shrink what it had before.
    """
    solution = run(sense, below)
    wanted = exact(below, len(solution.collisions))
    assert [hit.stop for hit in wanted].count("ceiling") == 2
    for hit, found in zip(wanted, solution.collisions, strict=True):
        assert found.stop == hit.stop
        assert found.t == pytest.approx(hit.t, abs=1e-12)
        tolerance = 1e-12 * (1.0 + GRAVITY / -hit.before)
        assert found.approach_rate == pytest.approx(hit.before, rel=tolerance)
        assert found.separation_rate == pytest.approx(hit.after, rel=tolerance)


@ways
def test_impulses_energy_and_amplitudes(sense: float, below: float) -> None:
    """P = M (w+ - w-) > 0 at either stop, whatever its side; losses M (w-^2 - w+^2) / 2.

    The rebound of a stop reaches the other one, or w^2 / (2 g) from the floor; that of the ceiling
    never ends once the mass does not come back. M counts the slides.
    """
    total = MASS + 2e-3
    hits = run(sense, below).collisions
    last_of_ceiling = max(hit.number for hit in hits if hit.stop == "ceiling")
    for found in hits[:6]:
        before, after = found.approach_rate, found.separation_rate
        assert found.impulse == pytest.approx(total * (after - before), rel=1e-11)
        lost = 0.5 * total * (before**2 - after**2)
        assert found.energy_lost == pytest.approx(lost, rel=1e-11)
        if found.number == last_of_ceiling:
            assert found.rebound_amplitude is None
            continue
        height = HEIGHT
        if found.stop == "floor":
            height = min(HEIGHT, after**2 / (2.0 * GRAVITY))
        assert found.rebound_amplitude == pytest.approx(height, rel=1e-11)


@ways
def test_rest_is_the_limit_of_the_series(sense: float, below: float) -> None:
    """The mass comes to rest on the floor at the sum of the series, on whichever side it is.

    Then it stands at the stop's own coordinate to the last bit and presses on it by M g.
    """
    solution = run(sense, below)
    last = exact(below, len(solution.collisions))[-1]
    rest = next(event for event in solution.events if event.kind is EventKind.REST)
    assert rest.stops == ("floor",)
    assert rest.t == pytest.approx(last.t + 2.0 * last.after / (GRAVITY * (1.0 - FLOOR)), abs=1e-12)
    floor = solution.mechanism.stop("floor")
    end = solution.trajectory.span[1]
    assert solution.trajectory.evaluate(end, left=True).q[0, floor.index] == floor.at
    reactions = solution.trajectory.reactions(end, left=True)
    assert reactions.stops["floor"][0] == pytest.approx((MASS + 2e-3) * GRAVITY, rel=1e-11)
    assert reactions.stops["ceiling"][0] == 0.0


@ways
def test_small_flights_keep_their_relative_precision(sense: float, below: float) -> None:
    """Rebounds down to 1e-7 m/s, 5e-16 m high, fall by e each, at a coordinate of 0.15 m, too.

    Differences of coordinates there have a round-off of 3e-17 m: flights found by them would be
    wrong by a tenth. What is left is the round-off of time, t eps by the length of the flight.
    """
    solution = run(sense, below, 1e-7)
    hits = solution.collisions
    assert hits[-1].separation_rate < 1e-7
    slow = [number for number, hit in enumerate(hits) if hit.separation_rate < 1e-2]
    assert len(slow) > 30
    for number in slow[1:]:
        before = hits[number - 1]
        flight = 2.0 * before.separation_rate / GRAVITY
        tolerance = 1e-12 + 4.0 * EPS * before.t / flight
        assert hits[number].approach_rate == pytest.approx(-before.separation_rate, rel=tolerance)
        assert hits[number].t - before.t == pytest.approx(
            flight, rel=1e-12, abs=4.0 * EPS * before.t
        )

"""How a machine arrives at the touch, where y'' is constant: bounces, rests, releases, errors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import chebyshev
from written_tables import (
    ABOVE,
    BY_TRAVEL,
    HALF,
    bounce,
    case,
    level,
    rest_of_turn,
    solve,
    solver_of,
    tables_of,
)

from nipper_pin.reduced.kernels import (
    closed,
    flight_errors,
    series,
)
from nipper_pin.reduced.kernels.layout import FAILS, HOLDS, UNKNOWN, Charts, Motion, Settings

pytestmark = pytest.mark.usefixtures("plain")

SPEED, E_N = 2.0, 0.5
# y'' = -A while it flies; it is thrown with w = e |approach| speed.
A = 4.0
THROWN = E_N * 1.0 * SPEED
# Travel of the first flight, and of all bounces.
FIRST = SPEED * 2.0 * THROWN / A
ALL = FIRST / (1.0 - E_N)


def turning(travel: float, push: Any = None, *, degree: int = 3, **more: Any) -> Charts:
    """The rest of a turn whose waiting chart is that long; y'' is pushed by the travel alone."""
    equation = level(-A / SPEED**2, count=degree)
    if push is not None:
        place = np.cos(np.pi * (np.arange(degree) + 0.5) / degree)
        values = push(0.5 * travel * (1.0 + place)) / SPEED**2
        equation[0, 0, :, 0] = chebyshev.chebfit(place, values, degree - 1)
    return rest_of_turn(equation, travel, **more)


def arrival(
    travel: float, push: Any = None, *, rest_rate: float = 0.0, e: float = E_N,
    tolerance: float = 1e-10, turn: Charts | None = None, **more: Any,
) -> Any:  # fmt: skip
    """The premise, and x, x' and their errors at the touch."""
    turn = turning(travel, push, **more) if turn is None else turn
    cases = np.array([[SPEED, 0.3, e]])
    settings = Settings(rest_rate, tolerance)
    table, told = solve(turn, cases, settings, 0, ask=True)
    return int(told[0, 2]), *table[0, 0, :4]


@pytest.mark.parametrize(
    ("travel", "rest_rate", "expected"),
    [
        # Twice what the bounces take has to pass before they count as over.
        (2.2 * ALL, 0.0, HOLDS),
        # Bounces that are seen to end by themselves count, too: each shortens what is left.
        (1.9 * ALL, 0.0, HOLDS),
        (0.9 * FIRST, 0.0, FAILS),
        (1.2 * FIRST, 0.0, FAILS),
        (1.6 * FIRST, 0.0, FAILS),
        (FIRST * (1.0 + 1e-7), 0.0, UNKNOWN),
        (FIRST * (1.0 - 1e-3), 0.0, FAILS),
        (1.6 * FIRST, 0.6 * THROWN, HOLDS),
        (1.4 * FIRST, 0.4 * THROWN, FAILS),
        (0.5 * FIRST, 1.1 * THROWN, HOLDS),
    ],
)
def test_bounces_after_the_opening(travel: float, rest_rate: float, expected: int) -> None:
    """Over before the touch, in flight there, or too close to it; by their limit or by a rate."""
    premise, *state = arrival(travel, rest_rate=rest_rate)
    assert premise == expected
    assert expected != HOLDS or np.isnan(state).all()


@pytest.mark.parametrize(
    ("line", "expected", "left"),
    [
        (lambda u: -A + 0.0 * u, HOLDS, None),
        # Let go at 7, and not pressed again.
        (lambda u: 2.0 * (u - 7.0), FAILS, 7.0),
        (lambda u: 2.0 * (u - 9.999999), UNKNOWN, None),
        (lambda u: 2.0 * (u - 10.1), HOLDS, None),
        (lambda u: -A + 3.9 * np.exp(-0.5 * (u - 4.0) ** 2), HOLDS, None),
    ],
)
def test_releases_after_a_rest(line: Any, expected: int, left: float | None) -> None:
    """The flight at the touch begins where nothing presses any more, from rest: y'' = 4 t."""
    premise, x, v, *_ = arrival(10.0, line, high=4.0, degree=8, e=0.0)
    assert premise == expected
    if left is not None:
        t = (10.0 - left) / SPEED
        assert x == pytest.approx(HALF * 2.0 / 3.0 * t**3 + ABOVE, rel=1e-9)
        assert v == pytest.approx(HALF * 2.0 * t**2 + BY_TRAVEL * SPEED, rel=1e-9)


def test_a_stop_that_is_left_and_reached_again_rests_again() -> None:
    """Lifted between 3 and 4 by little, and pressed shut strongly from then on."""

    def push(u: Any) -> Any:
        return 0.4 * (u - 3.0) * (4.0 - u)

    assert arrival(12.0, push, degree=4, e=0.0)[0] == HOLDS
    premise, x, *_ = arrival(4.5, push, degree=4, e=0.0)
    assert premise == FAILS
    # y'' = 0.4 (2 t) (1 - 2 t) since 3: y = 0.4 (t^3 / 3 - t^4 / 3).
    t = 1.5 / SPEED
    assert x == pytest.approx(HALF * 0.4 * (t**3 - t**4) / 3.0 + ABOVE, rel=1e-9)


def test_what_the_tables_do_not_hold_is_unknown() -> None:
    """Flights higher than they are or not known well, and more bounces than are followed."""
    top = 0.5 * THROWN**2 / A
    assert arrival(1.6 * FIRST, high=1.01 * top)[0] == FAILS
    assert arrival(1.6 * FIRST, high=0.99 * top)[0] == UNKNOWN
    assert arrival(300.0, e=1.0)[0] == UNKNOWN
    # Errors are too large, for the verdict or for the motion.
    for wrong in (0.1, 3e-3):
        assert arrival(1.3 * FIRST, residual=np.array([wrong, *[0.0] * 5]))[0] == UNKNOWN


def test_a_series_under_a_changing_force_is_followed() -> None:
    """A rest is not taken for granted where y'' changes by much until it is over."""
    slopes = {"steepest_u": np.array([8.0, 0.0, 0.0, 0.0, 0.0, 0.0])}
    calm = arrival(2.2 * ALL)
    shaken = arrival(2.2 * ALL, **slopes)
    assert (calm[0], shaken[0]) == (HOLDS, HOLDS)
    # A release before the bounces are over comes while the body is in the air.
    lifted = arrival(2.2 * ALL, lambda u: 3.0 * (u - 1.5 * ALL), high=40.0)
    assert lifted[0] != HOLDS


@pytest.mark.parametrize(
    ("change", "over"),
    [
        ({}, True),
        # No deceleration, no loss, no end before that of the chart, no room in it.
        ({"still": 0.0}, False),
        ({"still": A}, False),
        ({"e": 1.0}, False),
        ({"u": 2.0}, False),
        ({"high": 0.08}, False),
        # Along the closed stop x'' falls, or grows, by this part until then.
        ({"change": -0.34}, True),
        ({"change": -0.36}, False),
        ({"change": -1.0, "e": 0.0}, False),
        ({"change": 1.24}, True),
        ({"change": 1.26}, False),
        ({"change": 2.9, "e": 0.0}, True),
        ({"change": 3.1, "e": 0.0}, False),
        # The gap, or the rate, changes it by this part either way.
        ({"steepest_x": 0.26}, True),
        ({"steepest_x": 0.28}, False),
        ({"largest": 0.26}, True),
        ({"largest": 0.28}, False),
        # A rebound opens the other stop, or closes it.
        ({"opens": 0.5}, True),
        ({"opens": -0.5}, False),
    ],
)
def test_a_series_that_is_surely_over(change: dict[str, Any], over: bool) -> None:
    """Within twice the time that it has at a constant x'', however x'' changes within its bounds.

    It takes longest where a body rises against the least deceleration and falls with the most.
    """
    given = {"still": -A, "e": E_N, "u": 0.2, "change": 0.0, "opens": 0.5} | change
    w, u, travel, e = 0.6, given["u"], 4.0, given["e"]
    ahead = 2.0 * 2.0 * w / (A * (1.0 - e)) if e < 1.0 else 1.0
    # In these units x'' may change by A, at a gap of w w / A and a rate of 2 w.
    units = {"steepest_x": (A / w / SPEED) ** 2 * np.eye(6)[0],
             "largest": A / (2.0 * w * SPEED) * np.eye(6)[1]}  # fmt: skip
    bounds = {name: given[name] * unit for name, unit in units.items() if name in given}
    felt = sum(given[name] for name in bounds)
    charts = tables_of(level(-A / SPEED**2), travel=travel, gaps=level(1.0)[:1],
                       high=given.get("high", 1.0), **bounds)  # fmt: skip
    charts.gaps[0, 1, 0, 0, 0] = given["opens"]
    solver = solver_of(charts, case(SPEED, [], [], e))
    # -A (1 + change (u - begin) / (over - begin)).
    slope = -A * given["change"] / (SPEED * ahead)
    solver.work.line[0, 0] = -A + slope * (0.5 * travel - u), slope * 0.5 * travel, 0.0
    thrown = Motion(0, u, 0.0, 0.0, w, 0.0, 0.0, 0.0)
    found = series.surely_over(solver, thrown, given["still"])
    assert found[0] == over
    if over:
        assert found[1] == pytest.approx(ahead, rel=1e-12)
        least, most = (A * (1.0 + pick(given["change"], 0.0) + sign * felt)
                       for pick, sign in ((min, -1.0), (max, 1.0)))  # fmt: skip
        lasts, rate = 0.0, w
        for _ in range(200):
            lasts += rate / least + rate / math.sqrt(least * most)
            rate *= e * math.sqrt(most / least)
        assert lasts <= found[1]


GAP_ERRORS = np.array([2e-6, 3e-6, 5e-6])


@pytest.mark.parametrize("part", [0.7, 1.3])
@pytest.mark.parametrize("wrong", [1e-9, 1e-6])
def test_motion_at_the_touch(part: float, wrong: float) -> None:
    """y and y' of the flight there are taken to x and x'; their errors grow as the motion does."""
    travel = part * FIRST
    residual = np.array([wrong, 0.0, 0.0, 0.0, 0.0, 0.0])
    turn = turning(travel, residual=residual, approach_residual=wrong)
    turn.gap_bounds[1] = GAP_ERRORS
    known, x, v, dx, dv = arrival(travel, turn=turn)
    assert known == FAILS
    t, w, dt, dw = travel / SPEED, THROWN, 0.0, E_N * wrong * SPEED
    r = wrong * SPEED**2
    if part > 1.0:
        T = 2.0 * w / A
        sizes = np.zeros(12)
        flight_errors.sizes_of(turn.bounds[1], sizes, case(SPEED, [], []))
        dt, rate, _ = flight_errors.flight_errors(
            sizes, SPEED, bounce(T, -w, -A, 0.5 * T, w), 0.0, dw
        )
        t, w, dw = t - T, E_N * w, E_N * rate
    height, slope = w * t - 0.5 * A * t**2, w - A * t
    assert x == pytest.approx(HALF * height + ABOVE, rel=1e-10)
    assert v == pytest.approx(HALF * slope + BY_TRAVEL * SPEED, rel=1e-10)
    # Twice what the linearised equation says, and what the time of its start does.
    fastest = max(abs(w), abs(slope))
    dy = 2.0 * (dw * t + 0.5 * r * t**2) + fastest * dt
    dy_t = 2.0 * (dw + r * t) + A * dt
    bent = dy / 2.5
    assert dx == pytest.approx(HALF * dy + 2e-6, rel=1e-4)
    expected = HALF * dy_t + abs(slope) * (3e-6 + HALF * bent)
    expected += SPEED * (5e-6 + abs(BY_TRAVEL) * bent)
    assert dv == pytest.approx(expected, rel=1e-4)


def first_cell(u: Any) -> Any:
    return chebyshev.chebval(2.0 * u - 1.0, (0.0, 0.8, 0.7))


@pytest.mark.parametrize(
    ("values", "begin", "end", "expected"),
    [
        (lambda u: u - 1.3, 0.0, 3.0, 1.3),
        (lambda u: -0.5 - 0.0 * u, 0.0, 3.0, 4.0),
        (lambda u: 1e-3 - (u - 1.23) ** 2, 0.0, 3.0, 1.23 - np.sqrt(1e-3)),
        (lambda u: 1e-5 - (u - 1.23) ** 2, 0.0, 3.0, 1.23 - np.sqrt(1e-5)),
        (lambda u: 1e-5 - (u - 1.0) ** 2, 0.0, 3.0, 1.0 - np.sqrt(1e-5)),
        (lambda u: -1e-5 - (u - 1.0) ** 2, 0.0, 3.0, 4.0),
        (lambda u: -((u - 1.23) ** 2), 0.0, 3.0, -1.0),
        (lambda u: u - 1.3, 2.0, 3.0, 2.0),
        (lambda u: (u - 1.3) * (1.5 - u), 2.0, 3.0, 4.0),
        # Parabolas that are positive on a thirtieth of their cell alone.
        (lambda u: 1e-3 - 4.0 * (u - 0.521) ** 2, 0.0, 3.0, 0.521 - np.sqrt(1e-3 / 4.0)),
        (lambda u: 1e-3 - 4.0 * (u - 0.69) ** 2, 0.0, 3.0, 0.69 - np.sqrt(1e-3 / 4.0)),
        # Positive from 2.5 on: only what lies before the end counts, in a part of a cell, too.
        (lambda u: np.where(u > 2.0, 1.4 * (u - 2.5), -1.0), 0.2, 2.6, 2.5),
        (lambda u: np.where(u > 2.0, 1.4 * (u - 2.5), -1.0), 0.2, 2.0, 3.0),
        # -1 +- (0.8 T1 + 0.7 T2) in the first cell: all terms are large, and signs matter.
        (
            lambda u: np.where(u < 1.0, -1.0 + first_cell(u), -1.0),
            0.0,
            3.0,
            0.5 + 0.5 * (math.sqrt(10.16) - 0.8) / 2.8,
        ),
        (lambda u: np.where(u < 1.0, -1.0 - first_cell(u), -1.0), 0.0, 3.0, 4.0),
        # In its second cell the line is positive where it begins, and negative in the mean.
        (lambda u: 0.05 - (u - 1.0) * (u - 0.9), 0.9, 3.0, 0.9),
        (lambda u: (u - 0.98) * (1.05 - u) * (3.0 - u), 0.0, 3.0, 0.98),
    ],
)
def test_where_a_stop_lets_go(values: Any, begin: float, end: float, expected: float) -> None:
    """First place without pressure: a crossing, a short lift between places, a graze, none.

    The line is cut into three cells of [0, 3]; one behind the end says that there is none, -1 that
    a lift is too small to tell.
    """
    cells, count = 3, 6
    nodes = np.cos(np.pi * (np.arange(count) + 0.5) / count)
    line = np.array(
        [
            chebyshev.chebfit(nodes, values(cell + 0.5 + 0.5 * nodes), count - 1)
            for cell in range(cells)
        ]
    )
    solver = solver_of(tables_of(level(-1.0, cells=cells)), case(SPEED, [], []))
    assert closed.released(solver, 0, line, begin, end) == pytest.approx(expected, abs=1e-9)

"""A chain of twenty links that falls onto a stop at its last hinge, against its own equations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from small_machines import hinge, link, machine

from nipper_pin import Case, Solution, Window, simulate

LINKS, LENGTH, MASS, GRAVITY = 20, 0.1, 0.1, 9.81
STOP = np.deg2rad(20.0)


def _fallen() -> Solution:
    """The chain, which begins level and at rest: at the end of the shaft's first turn."""
    parts = []
    for number in range(LINKS):
        before = f"b{number - 1}" if number else "frame"
        at = (LENGTH if number else 0.0, 0.0)
        parts += [
            link(f"b{number}", MASS, MASS * LENGTH**2 / 12.0, (LENGTH / 2.0, 0.0)),
            hinge(f"j{number}", before, f"b{number}", at),
        ]
    stop = {"joint": f"j{LINKS - 1}", "restitution": 0.5, "side": "lower", "at_deg": -20.0}
    chain = machine(parts, LINKS, gravity=GRAVITY, stops={"end": stop})
    return simulate(chain, Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0))


def _first_strike() -> float:
    """When the last link has turned by 20 degrees against the one before it [s].

    Uniform rods of mass m and length L have in their absolute angles x, with n - k rods from rod k
    on, sum_j A_ij (x_j'' cos(x_i - x_j) + x_j'^2 sin(x_i - x_j)) = -m g L (n - i - 1/2) cos x_i,
    A_ij = m L^2 (n - max(i, j) - 1/2), A_ii = m L^2 (n - i - 2/3); i and j from 0.
    """
    place = np.arange(LINKS)
    left = LINKS - place
    inertia = MASS * LENGTH**2 * (LINKS - np.maximum.outer(place, place) - 0.5)
    inertia[place, place] = MASS * LENGTH**2 * (left - 2.0 / 3.0)
    weight = MASS * GRAVITY * LENGTH * (left - 0.5)

    def slope(_t: float, state: np.ndarray) -> np.ndarray:
        x, rate = np.split(state, 2)
        apart = np.subtract.outer(x, x)
        force = -weight * np.cos(x) - inertia * np.sin(apart) @ rate**2
        return np.concatenate([rate, np.linalg.solve(inertia * np.cos(apart), force)])

    def gap(_t: float, state: np.ndarray) -> float:
        return float(state[LINKS - 1] - state[LINKS - 2] + STOP)

    gap.terminal = True  # type: ignore[attr-defined]
    start = np.zeros(2 * LINKS)
    found = solve_ivp(
        slope, (0.0, 1.0), start, method="DOP853", rtol=1e-12, atol=1e-13, max_step=1e-3,
        events=gap,
    )  # fmt: skip
    return float(found.t_events[0][0])


@pytest.mark.slow
def test_a_long_chain_states_errors_that_bound_the_true_ones_and_tell_something() -> None:
    """Forty deviations in each of sixty panels: bounds of sets in as many dimensions add up.

    By the convergence of the independent solution its own error is below 1e-11 s.
    """
    solution = _fallen()
    late = abs(solution.collisions[0].t - _first_strike())
    stated = [error.time for error in solution.errors]
    assert late <= stated[0] + 1e-11
    assert max(stated) <= 1e-6

"""A cam's machine stopped at more than half of its speeds, where a piece of the cam's law ends.

"the motion cannot be resolved: the step falls to 2.4e-13 s": in a dwell nothing moves, and a panel
whose last node lay behind the dwell by round-off had no larger value than what it saw there.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from driven_machines import GRAVITY, LAWS, MACHINES, follower, swing
from numpy.polynomial import Polynomial
from scipy.integrate import solve_ivp

import nipper_pin as nip

GUIDE = "oscillating guide"
PAIRS = [
    (machine, law)
    for machine in MACHINES
    for law in LAWS
    # A guide rocks a shaft.
    if law != GUIDE or machine not in ("follower", "carriage")
]


def turn(mechanism: nip.Mechanism, speed: float, cycles: int = 1) -> nip.Solution:
    """So many turns, each of them computed."""
    case = nip.Case(speed_rpm=speed, window=nip.Window.CYCLE, cycles=cycles, reuse_cycles=False)
    return nip.simulate(mechanism, case)


def moves_as_its_law(solution: nip.Solution) -> None:
    """What the law moves is where the law has it, at every place of the turn."""
    mechanism = solution.mechanism
    begin, end = solution.trajectory.span
    assert end == pytest.approx(solution.shaft.period, rel=1e-12)
    motion = solution.trajectory.evaluate(np.linspace(begin, end, 101))
    drive = mechanism.drives[0]
    expected = drive.law.evaluate(motion.cylinder_angle)[0] - drive.law_at_touch
    np.testing.assert_allclose(motion.q[:, drive.index], expected, atol=1e-13)


@pytest.mark.sampled(7)
@pytest.mark.parametrize(("machine", "law"), PAIRS)
def test_no_law_stops_the_machine(machine: str, law: str) -> None:
    mechanism = MACHINES[machine](LAWS[law])
    for speed in (79.62235533730035, 200.0, 352.0053691993546):
        moves_as_its_law(turn(mechanism, speed))


@pytest.mark.campaign
@pytest.mark.parametrize(("machine", "law"), PAIRS)
def test_no_law_stops_the_machine_at_any_speed(machine: str, law: str) -> None:
    mechanism = MACHINES[machine](LAWS[law])
    for speed in np.geomspace(40.0, 900.0, 200):
        moves_as_its_law(turn(mechanism, float(speed)))


@pytest.mark.sampled(2)
@pytest.mark.parametrize("law", ["modified_sine, dwells", "12 rows"])
def test_no_number_of_turns_stops_the_machine(law: str) -> None:
    """Round-off of the angle grows with the turns, and moves what the law has at the nodes."""
    solution = turn(MACHINES["rocker"](LAWS[law]), 333.3, cycles=40)
    assert solution.outcome is nip.Outcome.COMPLETED


@pytest.mark.parametrize("beside", [0.0, 1e-15, -1e-14, 1e-12, -1e-12, -0.9e-9, 1.1e-9])
def test_a_run_may_start_beside_the_end_of_a_piece(beside: float) -> None:
    """An angle before it the first panel lies on what follows, and behind it, too."""
    mechanism = follower(LAWS["polynomial_345, dwells"])
    for knot in mechanism.drive_knots_rad:
        index = (24.0 + (knot + beside) * 40.0 / math.tau) % 40.0
        case = nip.Case(speed_rpm=127.0, window=nip.Window.CYCLE, start_index=index)
        assert nip.simulate(mechanism, case).outcome is nip.Outcome.COMPLETED


Motion = Callable[[float], tuple[float, float]]


def _cam(lift: Polynomial, start: float, rise: float, dwell: float, back: float) -> Motion:
    """Lift and its second derivative by the angle, of a law given as a polynomial of 0 to 1."""
    bend = lift.deriv(2)

    def motion(psi: float) -> tuple[float, float]:
        place = (math.degrees(psi) - start) % 360.0
        if place < rise:
            u, width = place / rise, math.radians(rise)
        elif place < rise + dwell:
            return 1.0, 0.0
        elif place < rise + dwell + back:
            u, width = (rise + dwell + back - place) / back, math.radians(back)
        else:
            return 0.0, 0.0
        return float(lift(u)), float(bend(u)) / width**2

    return motion


def _fourier(psi: float) -> tuple[float, float]:
    value = 0.5 - 0.5 * math.cos(psi) + 0.1 * math.cos(2 * psi) + 0.05 * math.sin(2 * psi)
    bend = 0.5 * math.cos(psi) - 0.4 * math.cos(2 * psi) - 0.2 * math.sin(2 * psi)
    return value, bend


P345 = Polynomial([0, 0, 0, 10, -15, 6])
P4567 = Polynomial([0, 0, 0, 0, 35, -84, 70, -20])
CLOSED: dict[str, tuple[Motion, tuple[float, ...]]] = {
    "polynomial_345, dwells": (_cam(P345, 0.0, 90.0, 90.0, 90.0), (0.0, 90.0, 180.0, 270.0)),
    "polynomial_345, late": (_cam(P345, 81.3, 70.0, 35.0, 110.0), (81.3, 151.3, 186.3, 296.3)),
    "polynomial_4567, dwells": (_cam(P4567, 0.0, 90.0, 90.0, 90.0), (0.0, 90.0, 180.0, 270.0)),
    "polynomial_4567, no dwell": (_cam(P4567, -40.0, 170.0, 0.0, 190.0), (130.0, 320.0)),
    "Fourier": (_fourier, ()),
}
"""Laws in closed form, and where their pieces end [deg]."""


@pytest.mark.parametrize("law", CLOSED)
def test_collisions_come_when_an_independent_integration_has_them(law: str) -> None:
    """A pendulum on a driven arm: one equation, integrated from piece to piece of the law.

    With the inertia J about the pivot P and absolute angle beta, J beta'' = -m l (P_x'' cos beta +
    (P_z'' + g) sin beta).
    """
    motion, knots = CLOSED[law]
    speed = 90.0
    solution = turn(swing(LAWS[law]), speed, cycles=2)
    omega, lift, arm = speed * math.tau / 60.0, math.radians(25.0), 0.1
    mass, inertia, length = 0.2, 1e-4 + 0.2 * 0.08**2, 0.08
    columns = {joint.name: joint.index for joint in solution.mechanism.joints}
    begun = solution.trajectory.evaluate(0.0)
    psi0, offset = float(begun.cylinder_angle[0]), motion(0.0)[0]

    def arm_at(t: float) -> tuple[float, float]:
        value, bend = motion(psi0 + omega * t)
        return lift * (value - offset), lift * bend * omega**2

    def slope(t: float, state: np.ndarray) -> list[float]:
        theta, theta_rate, swung, rate = state
        bend = arm_at(t)[1]
        beta = theta + swung
        x = -arm * (bend * math.sin(theta) + theta_rate**2 * math.cos(theta))
        z = arm * (bend * math.cos(theta) - theta_rate**2 * math.sin(theta))
        turned = x * math.cos(beta) + (z + GRAVITY) * math.sin(beta)
        return [theta_rate, bend, rate, -mass * length / inertia * turned - bend]

    def left(_: float, state: np.ndarray) -> float:
        return float(state[2] - math.radians(-12.0))

    def right(_: float, state: np.ndarray) -> float:
        return float(math.radians(15.0) - state[2])

    for guard in (left, right):
        guard.terminal, guard.direction = True, -1.0  # type: ignore[attr-defined]
    borders = sorted(((math.radians(knot) - psi0) % math.tau) / omega for knot in knots)
    period = math.tau / omega
    borders = [*borders, period, *(period + t for t in borders), 2.0 * period]
    place = [columns["arm"], columns["swing"]]
    state = np.array([[begun.q[0, k], begun.v[0, k]] for k in place]).ravel()
    t, times = 0.0, list[float]()
    while borders and len(times) < 5:
        found = solve_ivp(
            slope, (t, borders[0]), state, "DOP853", events=[left, right], rtol=1e-13, atol=1e-14
        )
        t, state = float(found.t[-1]), found.y[:, -1].copy()
        if found.status == 1:
            times.append(t)
            state[3] *= -0.6 if found.t_events[0].size else -0.4
        else:
            borders.pop(0)
    assert len(times) > 2
    assert len(solution.collisions) >= len(times)
    hits = [hit.t for hit in solution.collisions][: len(times)]
    np.testing.assert_allclose(hits, times, atol=1e-10)

"""A hundred turns: closures stay closed and no energy appears or is lost."""

from __future__ import annotations

import pytest

from nipper_pin import Case, Mechanism, Outcome, Solution, Window, load, simulate

SPEEDS = [450.0, 650.0]
TURNS = 100


@pytest.fixture(scope="module")
def nipper() -> Mechanism:
    """The E62."""
    return load("e62")


def _case(speed: float, *, reuse: bool) -> Case:
    return Case(speed_rpm=speed, window=Window.CYCLE, cycles=TURNS, reuse_cycles=reuse)


def _check(solution: Solution) -> None:
    """Closures within 1e-12 m and the energy balance within 1e-9 of the largest kinetic energy.

    Newton's method closes the loops to 16 eps of the reach, below 1e-14 m; the balance adds the
    quadrature of the drives' power, exact to about 1e-13 on each of the panels. The bounds are
    those asked for, the margin is three decades or more. The balance is no tautology: its drive
    work comes from the multipliers, its kinetic energy from the states, its losses from impulses.
    """
    assert solution.outcome is Outcome.COMPLETED
    first, last = solution.trajectory.span
    assert first == 0.0
    assert last == pytest.approx(TURNS * solution.shaft.period, rel=1e-14)
    assert solution.checks.closure_m <= 1e-12
    assert solution.checks.energy_balance <= 1e-9
    # Losses and work are those of a hundred turns, so a balance of nothing does not pass.
    per_turn = len(solution.collisions) / TURNS
    assert per_turn == int(per_turn) >= 12
    assert solution.energy.impact_losses > 0.3 * TURNS
    supplied = solution.energy.drive_work + solution.energy.drive_impulse_work
    assert supplied > 0.3 * TURNS


@pytest.mark.parametrize("speed", SPEEDS)
def test_a_hundred_turns_with_copies(nipper: Mechanism, speed: float) -> None:
    """Turns that repeat are copied; closures and balance hold over all hundred."""
    solution = simulate(nipper, _case(speed, reuse=True))
    assert solution.repeated_from is not None
    assert solution.repeated_from <= 2
    _check(solution)


@pytest.mark.slow
@pytest.mark.parametrize("speed", SPEEDS)
def test_a_hundred_turns_computed(nipper: Mechanism, speed: float) -> None:
    """Every turn computed: the same bounds, and the last turn still is the first one.

    Times of events differ by 99 periods to 1e-12 s plus the round-off of a time of ten seconds.
    """
    solution = simulate(nipper, _case(speed, reuse=False))
    assert solution.repeated_from is None
    _check(solution)
    count = len(solution.collisions) // TURNS
    delay = (TURNS - 1) * solution.shaft.period
    for first, last in zip(solution.collisions[:count], solution.collisions[-count:], strict=True):
        assert first.stop == last.stop
        assert last.t - first.t == pytest.approx(delay, abs=1e-11)
    solution_of_copies = simulate(nipper, _case(speed, reuse=True))
    assert solution.energy.impact_losses == pytest.approx(
        solution_of_copies.energy.impact_losses, rel=1e-11
    )

"""Energy balance: what the drives give is what impacts and motion take."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nipper_pin import Case, DriveMode, Solution, Window, load, simulate
from nipper_pin.hybrid.result.energy_balance import energy_balance

RUNS = [(window, drive) for window in Window for drive in DriveMode]


@pytest.fixture(scope="module", params=RUNS, ids=lambda run: "-".join(run))
def run(request: pytest.FixtureRequest) -> Solution:
    """Both windows with both kinds of drives."""
    window, drive = request.param
    return simulate(load("e62"), Case(speed_rpm=650.0, window=window, drive=drive))


def test_balance_closes(run: Solution) -> None:
    """The residual is below 1e-9 of the largest kinetic energy.

    Work comes from multipliers, energies from states, losses from impulses: three computations that
    share no formula. States are exact to 1e-12 and the quadrature beyond that.
    """
    assert run.energy.relative <= 1e-9
    assert run.checks.energy_balance == run.energy.relative
    assert run.energy.impact_losses > 0.3
    assert run.energy.kinetic_peak > 1.0


def test_balance_sees_a_wrong_loss(run: Solution) -> None:
    """A thousandth of one collision's loss added to it opens the balance by just that."""
    events = list(run.events)
    number = int(np.argmax([event.energy_lost for event in events]))
    change = 1e-3 * events[number].energy_lost
    events[number] = replace(events[number], energy_lost=events[number].energy_lost + change)
    changed = energy_balance(run.system, run.segments, events)
    assert changed.residual == pytest.approx(run.energy.residual - change, rel=1e-6)
    assert changed.relative > 1e-8


@pytest.mark.slow
def test_drive_work_is_the_integral_of_torque_times_rate(run: Solution) -> None:
    """The trapezoidal rule on dense reactions gives the drives' work, segment by segment.

    With 400 steps on a segment the rule is wrong by (length)^2 / (12 * 400^2) of the second
    derivative of the power, some 1e-5 of the work on a smooth stretch; 1e-3 is asked for.
    """
    work = largest = 0.0
    for segment in run.segments:
        times = np.linspace(segment.t_start, segment.t_end, 401)
        inner = times[1:-1]
        if not (np.diff(times) > 0.0).all():
            continue
        reactions = run.trajectory.reactions(inner)
        motion = run.trajectory.evaluate(inner)
        power = np.zeros(len(inner))
        for drive in run.mechanism.drives:
            power += reactions.drives[drive.name] * motion.v[:, drive.index]
        # The two end steps take the inner value next to them.
        part = float(np.trapezoid(power, inner)) + (power[0] + power[-1]) * (times[1] - times[0])
        work += part
        largest += abs(part)
    assert work == pytest.approx(run.energy.drive_work, abs=1e-3 * largest)


def test_a_whole_turn_takes_no_gravity_work_and_stores_nothing() -> None:
    """After one turn with held drives the machine is where it was: only losses remain.

    The initial phase is kinematic, so its state depends on the cylinder angle alone.
    """
    energy = simulate(load("e62"), Case(speed_rpm=450.0, window=Window.CYCLE)).energy
    for part in (energy.gravity_work, energy.spring_change, energy.kinetic_change):
        assert abs(part) <= 1e-12 * energy.kinetic_peak
    supplied = energy.drive_work + energy.drive_impulse_work
    assert supplied == pytest.approx(energy.impact_losses, rel=1e-11)

"""The E62 with light shafts and a stiff spring rests on both stops for a part of its cycle.

A jaw that closes throws the steeve off its stop, and the steeve, coming back, throws the jaw open.
Held drives would never let both be closed. Light shafts on soft drive trains give way instead: the
rattle dies down, both stops close, and jaw and steeve stand still on them while the drive trains
are wound up, until they have unwound again. All numbers are chosen so that this happens; they are
no machine's.
"""

from __future__ import annotations

import numpy as np
import pytest
from small_machines import link, machine, slide

from benchmarks.stress.checks.invariants import violations
from nipper_pin import (
    Case,
    DriveMode,
    EventKind,
    Outcome,
    SimulationError,
    Solution,
    Window,
    load,
    simulate,
)

BOTH = frozenset({"jaw", "steeve"})
DRIVES = ("pendulum", "tension")
# Of the pendulum shaft [kg m2], and of the tension shaft as a share of it, as in the model.
INERTIA, SHARE = 2e-3, 0.2


def light_shafts(**case: object) -> Solution:
    changes = {f"drives.{name}.shaft_frequency_hz": 60.0 for name in DRIVES}
    changes["drives.pendulum.reflected_inertia_kg_m2"] = INERTIA
    changes["drives.tension.reflected_inertia_kg_m2"] = SHARE * INERTIA
    changes["springs.steeve.preload_length_mm"] = 400.0
    changes |= {f"stops.{name}.restitution": 0.0 for name in BOTH}
    options = {"speed_rpm": 60.0, "window": Window.CYCLE, "drive": DriveMode.INERTIAL, **case}
    return simulate(load("e62", changes), Case(**options))  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def run() -> Solution:
    return light_shafts()


def test_both_stops_close_and_open_again(run: Solution) -> None:
    """The rattle ends in a rest of both stops, which lasts until the force of one has gone.

    Without the limit of the rattle it would go on to the largest number of collisions.
    """
    assert run.outcome is Outcome.COMPLETED
    (both,) = (segment for segment in run.segments if segment.closed == BOTH)
    assert both.t_end - both.t_start > 0.1
    # The rattle ends by a collision without a rebound, or at the limit of its series: then what is
    # left of it after the last collision is left out, less than the tolerance in turns.
    begin = next(e for e in run.events if e.closed_after == BOTH and e.kind is EventKind.REST)
    end = next(e for e in run.events if e.closed_before == BOTH and e.closed_after != BOTH)
    last = [item for item in run.collisions if item.t <= begin.t][-1]
    left_out = run.case.resolution.tolerance * run.shaft.period
    assert both.t_start == last.t <= begin.t <= last.t + left_out
    assert end.t == both.t_end
    assert end.kind is EventKind.RELEASE
    # How many there are is decided by round-off: 530 to 1,020 at speeds that differ by 1e-5.
    assert len(run.collisions) < run.case.max_collisions // 4


def test_forces_and_gaps_are_complementary(run: Solution) -> None:
    """Over the whole turn gaps and forces are not negative and never both there.

    The round-off of a force is that of forces of 3600 N, of a gap that of one at rest: none.
    """
    times = np.linspace(*run.trajectory.span, 4000)[1:-1]
    q = run.trajectory.evaluate(times).q
    forces = run.trajectory.reactions(times).stops
    together = np.ones(len(times), dtype=bool)
    for stop in run.mechanism.stops:
        gap, force = q[:, stop.index], forces[stop.name]
        assert gap.min() >= -1e-15
        assert force.min() >= -1e-8
        assert np.minimum(gap, force).max() <= 1e-15
        together &= force > 1.0
    assert 0.1 < together.mean() < 0.5


def test_forces_follow_from_the_torques_by_virtual_work(run: Solution) -> None:
    """With both stops closed the machine is one freedom, and the trains' torques move it.

    The power of torques, gravity and the inertia of links and shafts along that freedom cancels, by
    mass matrix and closure Jacobian alone: the forces of constraint drop out. And opening one stop
    virtually gives its force by the same sum.
    """
    system, trajectory = run.system, run.trajectory
    (both,) = (segment for segment in run.segments if segment.closed == BOTH)
    times = np.linspace(both.t_start, both.t_end, 9)[1:-1]
    motion, reactions = trajectory.evaluate(times), trajectory.reactions(times)
    stops = {stop.name: stop for stop in run.mechanism.stops}
    law = system.shaft.driven(times)
    inertia = np.array([INERTIA, SHARE * INERTIA])
    omega = 2.0 * np.pi * 60.0
    for row in range(len(times)):
        q, v, a = motion.q[row], motion.v[row], reactions.a[row]
        left = -system.body.inverse_dynamics(q[None], v[None], a[None])[0]
        for spring in run.mechanism.springs:
            left[spring.index] -= spring.stiffness * (spring.preload + q[spring.index])
        driven = system.driven
        torque = inertia * (
            law[2][row] - a[driven]
            + omega**2 * (law[0][row] - q[driven])
            + 2.0 * 0.7 * omega * (law[1][row] - v[driven])
        )  # fmt: skip
        left[driven] += torque
        jacobian = system.body.closures(q[None])[1][0]
        rows = np.vstack([jacobian, np.eye(7)[[stop.index for stop in stops.values()]]])
        along = np.linalg.svd(rows)[2][-1]
        assert abs(left @ along) <= 1e-10 * np.abs(left * along).max() + 1e-9
        for name, stop in stops.items():
            others = [item.index for item in stops.values() if item.name != name]
            kept = np.vstack([jacobian, np.eye(7)[others]])
            # Of the two motions that are left, the one in which the stop opens at rate one.
            opening = np.linalg.lstsq(
                np.vstack([kept, np.eye(7)[stop.index]]), np.eye(6)[-1], rcond=None
            )[0]
            force = -stop.sense * float(left @ opening)
            assert reactions.stops[name][row] == pytest.approx(force, rel=1e-8)


def test_energy_balances(run: Solution) -> None:
    """Work of the trains, gravity and spring against kinetic energy and losses: 1e-9 of these.

    The work comes from the trains' torques, the energies from states, and what the rest of both
    stops leaves out of the rattle counts as lost. Losses are a tenth of the largest kinetic energy.
    """
    assert abs(run.energy.residual) < 1e-9 * run.energy.impact_losses
    assert run.energy.impact_losses > 0.1 * run.energy.kinetic_peak
    assert run.checks.closure_m < 1e-12


@pytest.mark.slow
def test_nothing_is_violated(run: Solution) -> None:
    """What the stress campaign demands of every run: phase logic, impact law, motion, energy."""
    assert violations(run) == []
    assert violations(press()) == []


def test_rest_by_a_rate_comes_to_the_same(run: Solution) -> None:
    """A threshold ends the rattle earlier, and what follows once both are closed is the same.

    Both runs then have the same freedom with the same law, and a swing that dies down within some
    periods of the trains: releases agree to 1e-6 of a turn, while the rests are 1e-3 s apart.
    """
    other = light_shafts(rest_rate=1e-2)
    ends = [
        [next(e.t for e in one.events if e.closed_after == BOTH),
         next(e.t for e in one.events if e.closed_before == BOTH and e.closed_after != BOTH)]
        for one in (run, other)
    ]  # fmt: skip
    assert ends[0][0] - ends[1][0] > 1e-3
    assert ends[0][1] == pytest.approx(ends[1][1], abs=1e-6)
    assert len(other.collisions) < 0.1 * len(run.collisions)


# --- a machine that two stops lock altogether ----------------------------------------------------

START = {"speed_rpm": 60.0, "window": Window.CYCLE, "start_index": 0.0}
SPEED, HEAD, BOX, MASS, REFLECTED, FREQUENCY, DAMPING = 0.2, 0.03, 2.0, 0.7, 3.0, 4.0, 0.5


def press() -> Solution:
    """A press that a screw drives down on a mass on a shelf; both stops without restitution."""
    train = {
        "reflected_mass_kg": REFLECTED,
        "shaft_frequency_hz": FREQUENCY,
        "shaft_damping_ratio": DAMPING,
    }
    stops = {
        "head": {"joint": "height", "restitution": 0.0, "side": "upper", "at_mm": 1e3 * HEAD},
        "shelf": {"joint": "shelf_z", "restitution": 0.0},
    }
    mechanism = machine(
        [
            link("press", BOX),
            slide("screw", "frame", "press", (0.0, 1.0)),
            link("mass", MASS),
            slide("height", "press", "mass", (0.0, 1.0)),
            link("shelf", 1e-3),
            slide("shelf_z", "frame", "shelf", (0.0, 1.0)),
            link("carriage", 1e-3),
            slide("shelf_x", "shelf", "carriage"),
        ],
        2,
        gravity=9.81,
        drives={
            "screw": {"joint": "screw", "law": "screw", "lead_mm_per_turn": -1e3 * SPEED, **train}
        },
        stops=stops,
        closures={"tie": {"frame_a": "carriage", "frame_b": "mass"}},
        phases=[{"number": 1, "name": "on the shelf", "closed": ["shelf"]}],
    )
    return simulate(mechanism, Case(**START, drive=DriveMode.INERTIAL))  # type: ignore[arg-type]


def test_stops_that_lock_a_machine_altogether() -> None:
    """With no freedom left the machine stands, and the stops bear what the drive train winds up.

    The train pushes down by k (v t - head) + c v, c = 2 D w I and k = I w^2, the head bears that
    and the press's weight, the shelf the mass's besides. Held, the same drive jams the mechanism,
    and says so.
    """
    run = press()
    both = run.segments[-1]
    assert both.closed == {"head", "shelf"}
    assert both.kinematic
    assert run.system.constraint_set(both.closed).freedom == 0
    times = np.linspace(both.t_start, both.t_end, 20)[1:-1]
    motion, reactions = run.trajectory.evaluate(times), run.trajectory.reactions(times)
    np.testing.assert_allclose(motion.q[:, 0], -HEAD, atol=1e-15)
    assert np.abs(motion.v).max() == 0.0
    omega = 2.0 * np.pi * FREQUENCY
    down = REFLECTED * (omega**2 * (SPEED * times - HEAD) + 2.0 * DAMPING * omega * SPEED)
    assert np.ptp(down) > 50.0
    np.testing.assert_allclose(reactions.drives["screw"], -down, rtol=1e-12)
    head = down + 9.81 * BOX
    np.testing.assert_allclose(reactions.stops["head"], head, rtol=1e-12)
    shelf = head + 9.81 * (MASS + 2e-3)
    np.testing.assert_allclose(reactions.stops["shelf"], shelf, rtol=1e-12)
    assert run.checks.energy_balance < 1e-12
    with pytest.raises(SimulationError, match="inertial"):
        simulate(run.mechanism, Case(**START))  # type: ignore[arg-type]

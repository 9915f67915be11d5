"""Constrained accelerations against a dense KKT solution without Pinocchio.

    [ M + I   -A' ] [a]   [ tau - h ]        A = closures, closed stops, held drives
    [   A      0  ] [y] = [    b    ]        b = -G_dot v, 0, law acceleration

M, h, G and G_dot v come from `planar_tree`, in closed form. The mechanism's KKT matrix has a
condition of about 1e4 after scaling, so round-off allows about 1e4 eps = 2e-12 of the largest
acceleration; 1e-11 is asked for. The 36 states are random, in position as in velocity, so an error
in any term (a Coriolis term, a row's axes, an armature) shows in most of them at full size.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import NamedTuple

import numpy as np
import pytest
from dense import close, constrained

from benchmarks.stress.mechanics.planar_tree import PlanarTree
from nipper_pin import DriveMode, Mechanism, load
from nipper_pin.dynamics import ShaftMotion, System, multipliers, partition
from nipper_pin.hybrid.contact.active_set import active_set

RELATIVE = 1e-11

modes = pytest.mark.parametrize("drive", list(DriveMode))


def kkt(mechanism: Mechanism, tree: PlanarTree, state, held: bool):
    """Accelerations and multipliers: closures, then closed stops, then held drives or torques."""
    q, v = state.q, state.v
    zero = np.zeros(tree.nv)
    M = tree.mass_matrix(q)
    force = -tree.inverse_dynamics(q, v, zero)
    for spring in mechanism.springs:
        force[spring.index] -= spring.stiffness * (spring.preload + q[spring.index])
    rows = [stop.index for stop in mechanism.stops if stop.name in state.closed]
    rates = [0.0] * len(rows)
    torques = []
    for column, drive in enumerate(mechanism.drives):
        law, law_rate, law_acceleration = (item[0, column] for item in state.motion)
        if held:
            rows.append(drive.index)
            rates.append(law_acceleration)
            continue
        inertia, omega = drive.reflected_inertia, 2.0 * np.pi * drive.shaft_frequency_hz
        torques.append(
            inertia
            * (
                law_acceleration
                + omega**2 * (law - q[drive.index])
                + 2.0 * drive.shaft_damping_ratio * omega * (law_rate - v[drive.index])
            )
        )
        M[drive.index, drive.index] += inertia
        force[drive.index] += torques[-1]
    A = np.vstack([tree.closure_jacobian(q), np.eye(tree.nv)[rows]])
    b = np.concatenate([-tree.closure(q, v, zero)[2], rates])
    a, y = constrained(M, force, A, b)
    return a, y, torques


@modes
def test_accelerations_equal_an_independent_solution(
    mechanism: Mechanism, tree: PlanarTree, states, make_system, drive: DriveMode
) -> None:
    """In every phase and both drive modes the accelerations are those of a dense KKT solution."""
    system: System = make_system(drive)
    for state in states:
        a = system.accelerations(
            state.motion, state.q[None], state.v[None], system.constraint_set(state.closed)
        )[0]
        expected, _, _ = kkt(mechanism, tree, state, system.held)
        assert np.abs(a - expected).max() <= RELATIVE * np.abs(expected).max()


def test_prescribed_accelerations_are_met_to_the_last_digits(states, make_system) -> None:
    """Held drives take the law's acceleration and closed stops none, whatever pulls at them.

    Infinite inertia is 2^100, so the pull of the links (some 1e3 N m) moves the drive by 1e-27;
    what is left is the rounding of one quotient. A finite large inertia of 1e10 would show 1e-7.
    """
    system: System = make_system(DriveMode.HELD)
    for state in states:
        rows = system.constraint_set(state.closed)
        a = system.accelerations(state.motion, state.q[None], state.v[None], rows)[0]
        wanted = state.motion[2][0]
        np.testing.assert_allclose(a[system.driven], wanted, rtol=1e-15, atol=0.0)
        assert np.abs(a[list(rows.stops)]).max(initial=0.0) <= 1e-15


@modes
def test_forces_of_constraint_equal_an_independent_solution(
    mechanism: Mechanism, tree: PlanarTree, states, make_system, drive: DriveMode
) -> None:
    """Closure forces, stop forces and drive torques are the multipliers of the KKT solution.

    They are differences of inertia and spring forces, so the largest of them sets the scale of
    their round-off; held torques and stop forces come by inverse dynamics, on another way than
    the KKT solution.
    """
    system: System = make_system(drive)
    for state in states:
        rows = system.constraint_set(state.closed)
        q, v = state.q[None], state.v[None]
        a = system.accelerations(state.motion, q, v, rows)
        _, jacobian = system.body.closures(q)
        found = multipliers(
            system,
            state.motion,
            q,
            v,
            a,
            jacobian,
            rows,
            partition(jacobian[0], rows.given, rows.yielding),
        )
        _, y, torques = kkt(mechanism, tree, state, system.held)
        stops = len(rows.stops)
        m = system.body.closure_rows
        scale = RELATIVE * np.abs([*y, *torques]).max()
        assert np.abs(found.la_g[0] - y[:m]).max() <= scale
        assert np.abs(found.la_N[0] - y[m : m + stops]).max(initial=0.0) <= scale
        drives = torques or y[m + stops :]
        assert np.abs(found.drive[0] - drives).max() <= scale


def test_states_are_evaluated_independently(states, make_system: Callable[..., System]) -> None:
    """A batch of states gives bitwise what the states give one by one, in any order."""
    system = make_system(DriveMode.HELD)
    phase = [state for state in states if not state.closed]
    rows = system.constraint_set(frozenset())
    one = [
        system.accelerations(state.motion, state.q[None], state.v[None], rows)[0]
        for state in reversed(phase)
    ][::-1]
    motion = tuple(np.vstack([state.motion[i] for state in phase]) for i in range(3))
    batch = system.accelerations(
        motion, np.array([s.q for s in phase]), np.array([s.v for s in phase]), rows
    )
    assert np.array_equal(batch, np.array(one))


BOTH = frozenset({"jaw", "steeve"})

DRIVES = ("pendulum", "tension")

# The condition of the linear system is 3.5e4 after scaling, so each rounding of its 13 unknowns may
# be 8e-12 of the largest acceleration: last digits of a state move the engine's by 2e-11.
BOTH_CLOSED = 1e-10


class State(NamedTuple):
    """A configuration with both gaps zero, a velocity along the one freedom, and any law."""

    closed: frozenset[str]
    q: np.ndarray
    v: np.ndarray
    motion: tuple[np.ndarray, np.ndarray, np.ndarray]


def both_closed(mechanism: Mechanism, tree: PlanarTree, count: int, seed: int) -> list[State]:
    """Random states with both gaps zero: anywhere along the one freedom, with any law."""
    rng = np.random.default_rng(seed)
    driven = [drive.index for drive in mechanism.drives]
    stops = [stop.index for stop in mechanism.stops]
    free = [i for i in range(tree.nv) if i not in (driven[0], *stops)]
    found = []
    for _ in range(count):
        q = np.zeros(tree.nv)
        # In small steps from touch, where everything is zero.
        for angle in np.linspace(0.0, rng.uniform(-0.3, 0.2), 9)[1:]:
            q[driven[0]] = angle
            q = close(tree, q, free)
        G = tree.closure_jacobian(q)
        v = np.zeros(tree.nv)
        v[driven[0]] = rng.uniform(-6.0, 6.0)
        v[free] = -np.linalg.solve(G[:, free], G[:, driven[0]] * v[driven[0]])
        motion = (
            q[None, driven] + rng.uniform(-0.3, 0.3, 2),
            v[None, driven] + rng.uniform(-5.0, 5.0, 2),
            rng.uniform(-2e3, 2e3, (1, 2)),
        )
        found.append(State(BOTH, q, v, motion))
    return found


def solved(mechanism: Mechanism, tree: PlanarTree, state: State, closed: frozenset[str]):  # type: ignore[no-untyped-def]
    """Accelerations and stop forces along the gaps by the dense KKT system, shafts giving way."""
    chosen = State(closed, state.q, state.v, state.motion)
    a, y, torques = kkt(mechanism, tree, chosen, held=False)
    senses = np.array([stop.sense for stop in mechanism.stops if stop.name in closed])
    return a, y[: tree.nv - 3], y[tree.nv - 3 :] * senses, np.array(torques)


def test_forces_of_both_stops(mechanism: Mechanism, tree: PlanarTree) -> None:
    """Accelerations, closure forces, stop forces and torques are those of the dense KKT system.

    That has its own mass matrix and its own closures. Torques, which act on coordinates that here
    depend on one another, are of 1e3 N m, so leaving them out of the balance would show.
    """
    system = System(mechanism, ShaftMotion(mechanism, 50.0, 1.0), DriveMode.INERTIAL)
    rows = system.constraint_set(BOTH)
    assert rows.freedom == 1
    for state in both_closed(mechanism, tree, 12, 3):
        q, v = state.q[None], state.v[None]
        a = system.accelerations(state.motion, q, v, rows)
        _, jacobian = system.body.closures(q)
        split = system.split(jacobian[0], rows.given, rows.yielding)
        # The closures leave room for one of the shafts only.
        assert len(set(split.dependent) & set(system.driven.tolist())) == 1
        forces = multipliers(system, state.motion, q, v, a, jacobian, rows, split)
        expected, la_g, la_N, torques = solved(mechanism, tree, state, BOTH)
        assert np.abs(a[0] - expected).max() <= BOTH_CLOSED * np.abs(expected).max()
        scale = BOTH_CLOSED * np.abs([*la_g, *la_N, *torques]).max()
        assert np.abs(forces.la_g[0] - la_g).max() <= scale
        assert np.abs(forces.la_N[0] - la_N).max() <= scale
        assert np.abs(forces.drive[0] - torques).max() <= scale


@pytest.mark.slow
def test_which_stay_closed() -> None:
    """Of both stops at rest those stay closed that a complementary KKT solution keeps closed.

    All four sets are tried with the dense system; one of them alone has forces and departures that
    are not negative. Each of the sets, both stops among them, is the answer somewhere.
    """
    sets = [frozenset(chosen) for size in range(3) for chosen in combinations(sorted(BOTH), size)]
    answers = []
    for preload in (5.0, 200.0):
        changes = {f"drives.{name}.reflected_inertia_kg_m2": 0.02 for name in DRIVES}
        mechanism = load("e62", {"springs.steeve.preload_length_mm": preload, **changes})
        tree = PlanarTree.of(mechanism)
        system = System(mechanism, ShaftMotion(mechanism, 50.0, 1.0), DriveMode.INERTIAL)
        for state in both_closed(mechanism, tree, 40, 5):
            legal = []
            for closed in sets:
                a, _, la_N, _ = solved(mechanism, tree, state, closed)
                leaving = [s.rate(a) for s in mechanism.stops if s.name not in closed]
                if min([*la_N, *leaving]) >= 0.0:
                    legal.append(closed)
            _, jacobian = system.body.closures(state.q[None])
            found = active_set(system, state.motion, state.q, state.v, jacobian[0], BOTH)
            assert legal == [found]
            answers.append(found)
    assert set(answers) == set(sets)


def test_held_drives_never_keep_both(mechanism: Mechanism, tree: PlanarTree) -> None:
    """Held drives and both stops are one row too many: one of them opens, whatever presses."""
    system = System(mechanism, ShaftMotion(mechanism, 50.0, 1.0), DriveMode.HELD)
    assert system.constraint_set(BOTH).freedom == -1
    for state in both_closed(mechanism, tree, 12, 7):
        _, jacobian = system.body.closures(state.q[None])
        assert active_set(system, state.motion, state.q, state.v, jacobian[0], BOTH) < BOTH


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_limit_of_large_inertia(tree: PlanarTree, seed: int) -> None:
    """What the shafts do not give way to grows with their inertia, and the choice is the held one.

    With both stops closed the links make the shafts follow one another, so a law that would not
    needs forces in proportion to the inertia: slope 1. A held drive taken as one that gives way, or
    the reverse, has slope 0.
    """
    scales = 10.0 ** np.arange(2.0, 6.0)
    sizes = []
    for scale in scales:
        changes = {f"drives.{name}.reflected_inertia_kg_m2": float(scale) for name in DRIVES}
        mechanism = load("e62", changes)
        (state,) = both_closed(mechanism, tree, 1, seed)
        inertial, held = (
            System(mechanism, ShaftMotion(mechanism, 50.0, 1.0), mode)
            for mode in (DriveMode.INERTIAL, DriveMode.HELD)
        )
        # The law is where the shafts are: what is left to disagree on are accelerations.
        driven = inertial.driven
        motion = (state.q[None, driven], state.v[None, driven], state.motion[2])
        q, v = state.q[None], state.v[None]
        _, jacobian = inertial.body.closures(q)
        rows = inertial.constraint_set(BOTH)
        a = inertial.accelerations(motion, q, v, rows)
        split = inertial.split(jacobian[0], rows.given, rows.yielding)
        la_N = multipliers(inertial, motion, q, v, a, jacobian, rows, split).la_N[0]
        sizes.append(np.abs(la_N).max())
        # One of the two forces pulls, so both stops are not kept.
        assert la_N.min() < 0.0
        choices = {
            active_set(system, motion, state.q, state.v, jacobian[0], BOTH)
            for system in (inertial, held)
        }
        assert len(choices) == 1
        assert len(next(iter(choices))) <= 1
    slope = np.polyfit(np.log10(scales), np.log10(sizes), 1)[0]
    assert slope == pytest.approx(1.0, abs=0.05)

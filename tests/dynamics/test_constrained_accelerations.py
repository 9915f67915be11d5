"""Constrained accelerations against a dense KKT solution without Pinocchio.

    [ M + I   -A' ] [a]   [ tau - h ]        A = closures, closed stops, held drives
    [   A      0  ] [y] = [    b    ]        b = -G_dot v, 0, law acceleration

M, h, G and G_dot v come from `planar_tree`, in closed form. The mechanism's KKT matrix has a
condition of about 1e4 after scaling, so round-off allows about 1e4 eps = 2e-12 of the largest
acceleration; 1e-11 is asked for. The 36 states are random, in position as in velocity, so an error
in any term (a Coriolis term, a row's axes, an armature) shows in most of them at full size.
"""

from collections.abc import Callable

import numpy as np
import pytest
from dense import constrained

from benchmarks.stress.mechanics.planar_tree import PlanarTree
from nipper_pin import DriveMode, Mechanism
from nipper_pin.dynamics import System, partition
from nipper_pin.dynamics.multipliers import multipliers

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

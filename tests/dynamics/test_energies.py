"""Mass matrix, inverse dynamics and energies of the tree."""

from collections.abc import Callable

import numpy as np

from benchmarks.stress.mechanics.planar_tree import PlanarTree
from nipper_pin.dynamics import System

MakeSystem = Callable[..., System]


def test_energies_equal_planar_sums(tree: PlanarTree, states, make_system: MakeSystem) -> None:
    """Kinetic and potential energy are the sums of m c'^2 / 2 + I w^2 / 2 and m g z.

    Seven terms of one sign in T: a few roundings. Potential energies are compared up to the same
    zero, the frame's origin. Every link moves in these states, so every mass counts.
    """
    body = make_system().body
    q, v = np.array([s.q for s in states]), np.array([s.v for s in states])
    kinetic = [tree.kinetic_energy(*state) for state in zip(q, v, strict=True)]
    np.testing.assert_allclose(body.kinetic_energy(q, v), kinetic, rtol=1e-14)
    centres = tree.motion(q, np.zeros_like(q), np.zeros_like(q)).com
    heights = tree.gravity * centres.imag @ tree.masses
    np.testing.assert_allclose(body.gravity_energy(q), heights, rtol=0.0, atol=1e-14)


def test_mass_matrix_is_the_metric_of_the_kinetic_energy(
    tree: PlanarTree, states, make_system: MakeSystem
) -> None:
    """M equals the planar one, and M_ij = T(e_i + e_j) - T(e_i) - T(e_j) exactly.

    T is quadratic, so the polarisation identity has no error but round-off (entries below 1).
    """
    body = make_system().body
    unit = np.eye(body.nv)
    for state in states[::5]:
        M = body.mass_matrix(state.q)
        assert np.array_equal(M, M.T)
        assert np.abs(M - tree.mass_matrix(state.q)).max() <= 1e-15

        def T(v: np.ndarray, q: np.ndarray = state.q) -> float:
            return float(body.kinetic_energy(q[None], v[None])[0])

        polar = [[T(e + f) - T(e) - T(f) for f in unit] for e in unit]
        assert np.abs(M - polar).max() <= 4e-15


def test_inverse_dynamics_equals_virtual_work(
    tree: PlanarTree, states, make_system: MakeSystem
) -> None:
    """M a + h equals the virtual work of the links' inertia and weight, term by term.

    Round-off is some eps of the largest generalised force; accelerations are random, so that
    inertia, Coriolis and gravity terms are all of consequence.
    """
    body = make_system().body
    rng = np.random.default_rng(5)
    for state in states:
        a = rng.uniform(-500.0, 500.0, body.nv)
        found = body.inverse_dynamics(state.q[None], state.v[None], a[None])[0]
        expected = tree.inverse_dynamics(state.q, state.v, a)
        assert np.abs(found - expected).max() <= 1e-13 * np.abs(expected).max()


def test_inverse_dynamics_equals_lagrange_differences(states, make_system: MakeSystem) -> None:
    """M a + h = d/dt dT/dv - dT/dq + dV/dq, the derivatives by differences of the energies.

    M a + M_dot v - (1/2) d(v' M v)/dq + dV/dq; central differences with step d = 2e-3, extrapolated
    once, err by O(d^4) (some 1e-11) and eps / d (some 1e-12 of the energies): 1e-9 of the largest
    force is asked for. The energies know nothing of the recursive algorithm behind the forces.
    """
    body = make_system().body
    d = 2e-3
    for state in states[::4]:
        q, v = state.q, state.v
        a = 40.0 * np.cos(np.arange(body.nv))

        def L_q(k: float, q: np.ndarray = q, v: np.ndarray = v) -> np.ndarray:
            values = []
            for step in k * d * np.eye(body.nv):
                ahead, behind = (q + step)[None], (q - step)[None]
                T = body.kinetic_energy(ahead, v[None]) - body.kinetic_energy(behind, v[None])
                V = body.gravity_energy(ahead) - body.gravity_energy(behind)
                values.append(float((T - V)[0]) / (2.0 * k * d))
            return np.array(values)

        def M_dot_v(k: float, q: np.ndarray = q, v: np.ndarray = v) -> np.ndarray:
            # Derivative along v, over a step of length d in q.
            s = k * d / np.abs(v).max()
            return (body.mass_matrix(q + s * v) - body.mass_matrix(q - s * v)) @ v / (2.0 * s)

        gradient, turning = ((4.0 * f(0.5) - f(1.0)) / 3.0 for f in (L_q, M_dot_v))
        expected = body.mass_matrix(q) @ a + turning - gradient
        found = body.inverse_dynamics(q[None], v[None], a[None])[0]
        assert np.abs(found - expected).max() <= 1e-9 * np.abs(expected).max()


def test_link_velocities_equal_differences_of_placements(
    tree: PlanarTree, states, make_system: MakeSystem
) -> None:
    """Angular and centroid velocities are those of the planar geometry, and of moved placements.

    Closed form: a few roundings. Differences over +-d, extrapolated: O(d^4) = 1e-10 relative.
    """
    body = make_system().body
    for state in states[::3]:
        spin, centroid = body.link_velocities(state.q, state.v)
        motion = tree.motion(state.q, state.v, np.zeros(tree.nv))
        assert np.abs(spin - motion.spin).max() <= 1e-14 * np.abs(spin).max()
        moved = np.column_stack([motion.com_rate.real, motion.com_rate.imag])
        assert np.abs(centroid - moved).max() <= 1e-14 * np.abs(spin).max()

        def place(s: float, q: np.ndarray = state.q, v: np.ndarray = state.v) -> np.ndarray:
            placed = body.placements(q + s * v)
            com = [
                (p.translation + p.rotation @ [link.com.real, 0.0, link.com.imag])[[0, 2]]
                for p, link in zip(placed, tree.links, strict=True)
            ]
            return np.array(com)

        d = 1e-3 / np.abs(state.v).max()
        rate = [(place(k * d) - place(-k * d)) / (2.0 * k * d) for k in (0.5, 1.0)]
        difference = (4.0 * rate[0] - rate[1]) / 3.0 - centroid
        assert np.abs(difference).max() <= 1e-10 * np.abs(centroid).max()

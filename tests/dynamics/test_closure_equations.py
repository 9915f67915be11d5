"""The tree and its closures: gaps, Jacobians, mass matrix, energies, by planar geometry."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from benchmarks.stress.mechanics.planar_tree import PlanarTree
from benchmarks.stress.space import trial
from nipper_pin import DriveMode, Mechanism
from nipper_pin.dynamics import Multibody, System
from nipper_pin.dynamics.multibody import Loops
from nipper_pin.mechanism.gallery import GALLERY, drawn
from nipper_pin.tolerances.mechanics import EPS

MakeSystem = Callable[..., System]


def test_gaps_and_jacobian_equal_planar_geometry(
    tree: PlanarTree, states, make_system: MakeSystem
) -> None:
    """On closed configurations g is zero and G is the Jacobian of the planar geometry.

    Both are sums of at most six products of lengths below 0.3 m, so 1e-15 is a few roundings; the
    axes of frame a turn by up to 0.5 rad in these states, so rows in other axes would show.
    """
    body = make_system().body
    q = np.array([state.q for state in states])
    g, G = body.closures(q)
    assert np.abs(g).max() <= 1e-15
    for row, state in enumerate(states):
        assert np.abs(G[row] - tree.closure_jacobian(state.q)).max() <= 2e-15


def test_gaps_of_open_configurations_equal_planar_geometry(
    tree: PlanarTree, make_system: MakeSystem
) -> None:
    """Away from the closed manifold too, g is the vector between the pins in the axes of frame a.

    Random coordinates leave gaps of centimetres, so no term can vanish by itself.
    """
    rng = np.random.default_rng(3)
    q = rng.uniform(-0.4, 0.4, (20, tree.nv))
    g, _ = make_system().body.closures(q)
    zero = np.zeros(tree.nv)
    expected = np.array([tree.closure(row, zero, zero)[0] for row in q])
    assert np.abs(expected).max() > 0.05
    assert np.abs(g - expected).max() <= 1e-15


def test_accelerations_keep_the_closures(tree: PlanarTree, states, make_system: MakeSystem) -> None:
    """G a + G_dot v = 0, with G_dot v from the planar geometry in closed form.

    Terms are lengths times accelerations of up to some 1e4 rad/s^2, so round-off is some 1e-13 of
    them; G_dot v alone is of the size of the terms, so leaving it out cannot pass.
    """
    system = make_system(DriveMode.HELD)
    zero = np.zeros(tree.nv)
    for state in states:
        rows = system.constraint_set(state.closed)
        a = system.accelerations(state.motion, state.q[None], state.v[None], rows)[0]
        _, _, drift = tree.closure(state.q, state.v, a)
        bias = np.abs(tree.closure(state.q, state.v, zero)[2]).max()
        scale = np.abs(tree.closure_jacobian(state.q)).max() * np.abs(a).max() + bias
        assert bias > 1e-2
        assert np.abs(drift).max() <= 1e-13 * scale


def test_placement_caches_never_go_stale(states, make_system: MakeSystem) -> None:
    """Closures and accelerations do not depend on what was evaluated before them, to the bit.

    Pinocchio keeps placements in its data; each answer is compared with the one of a fresh system
    that was asked nothing else, so a stale placement of another configuration shows at once.
    """
    first, second = states[0], states[-1]
    for drive in DriveMode:
        used = make_system(drive)

        def closures(system: System) -> tuple[np.ndarray, ...]:
            return system.body.closures(first.q[None])

        def accelerations(system: System) -> tuple[np.ndarray, ...]:
            rows = system.constraint_set(first.closed)
            return (system.accelerations(first.motion, first.q[None], first.v[None], rows),)

        def disturb(system: System = used) -> None:
            rows = system.constraint_set(second.closed)
            q, v = second.q[None], second.v[None]
            system.accelerations(second.motion, q, v, rows)
            _, G = system.body.closures(q)
            system.body.impulse_response(second.q, G[0], second.v, system.drive_armature)
            system.body.mass_matrix(second.q)
            system.body.inverse_dynamics(q, v, v)
            system.body.kinetic_energy(q, v)
            system.body.link_velocities(second.q, second.v)
            system.body.joint_wrenches(second.q, second.v, second.v, np.ones(len(G[0])))

        for question in (closures, accelerations, closures):
            other_system = make_system(drive)
            # Systems of one thread share their buffers; this one gets its own.
            other_system.body = Multibody(other_system.mechanism)
            fresh = question(other_system)
            disturb()
            for one, other in zip(question(used), fresh, strict=True):
                assert np.array_equal(one, other)


def test_impulses_do_not_disturb_flight(states, make_system: MakeSystem) -> None:
    """An impulse between two evaluations at one state leaves the second bitwise as the first."""
    system = make_system(DriveMode.HELD)
    state, other = states[-1], states[2]
    rows = system.constraint_set(state.closed)
    ask = (state.motion, state.q[None], state.v[None], rows)
    first = system.accelerations(*ask)
    gaps = system.body.closures(state.q[None])
    for q in (state.q, other.q):
        G = system.body.closures(q[None])[1][0]
        z = np.linalg.lstsq(G, np.ones(len(G)), rcond=None)[0]
        system.body.impulse_response(q, G, z, system.drive_armature)
        assert np.array_equal(system.accelerations(*ask), first)
    again = system.body.closures(state.q[None])
    assert np.array_equal(again[0], gaps[0])
    assert np.array_equal(again[1], gaps[1])


STATES = 5

# Sums of a few dozen products, each with a rounding of its own.
ROUNDINGS = 40.0 * EPS


def _agree(mechanism: Mechanism) -> None:
    """Gaps, Jacobians and accelerations, at loops that stand open: no term vanishes by itself."""
    body = Multibody(mechanism)
    q, v, a = np.random.default_rng(5).uniform(-1.0, 1.0, (3, STATES, body.nv))
    singly = [body.closures(row[None]) for row in q]
    alone = [
        body.closure_accelerations(*(state[None] for state in states))[0]
        for states in zip(q, v, a, strict=True)
    ]
    gaps, jacobians = body.closures(q)
    # Lengths of the links, slides by up to one metre, and two rates of up to nv each.
    size = body.reach_m + body.nv
    assert np.abs(gaps - np.concatenate([one[0] for one in singly])).max() <= ROUNDINGS * size
    assert np.abs(jacobians - np.concatenate([one[1] for one in singly])).max() <= ROUNDINGS * size
    found = body.closure_accelerations(q, v, a)
    assert np.abs(found - alone).max() <= ROUNDINGS * size * body.nv**2


@pytest.mark.parametrize("name", GALLERY)
def test_of_the_machines_of_the_gallery(name: str) -> None:
    mechanism = drawn(name).mechanism()
    if mechanism.closures:
        _agree(mechanism)


@pytest.mark.parametrize("number", range(40))
def test_of_random_machines(number: int) -> None:
    """Mirror images turn about -y; chains have slides, and frames that stand askew."""
    drawn_at_random = trial(11, number)
    mirrored = drawn_at_random.mirror_image()
    for mechanism in (drawn_at_random.mechanism(), mirrored):
        if mechanism is not None and mechanism.closures:
            _agree(mechanism)


def test_of_the_e62(e62: Mechanism) -> None:
    _agree(e62)


def test_of_no_configuration(e62: Mechanism) -> None:
    """A motion that the drives determine has no tangent to follow."""
    body = Multibody(e62)
    none = np.empty((0, body.nv))
    loops = Loops(e62.model, body.cuts)
    gaps, jacobians = loops.closures(none)
    rows = (0, body.closure_rows)
    assert (gaps.shape, jacobians.shape) == (rows, (*rows, body.nv))
    assert loops.accelerations(none, none, none).shape == rows


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

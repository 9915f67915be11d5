"""Forces at all nine joints, drives, stops and lips against balances of links and virtual work.

Positions and velocities are those of the trajectory, accelerations those that come with the
forces; everything else (centroids, arms, inertia, the closures' directions) is planar geometry of
the test's own, exact to round-off. Balances are differences of forces up to the largest one, so
round-off is some 1e-13 of that; 1e-10 is asked for.
"""

from dataclasses import dataclass

import numpy as np
import pytest

from benchmarks.stress.mechanics.planar_tree import Motion, PlanarTree
from nipper_pin import Case, EventKind, Mechanism, Reactions, Solution, simulate

EXACT = 1e-10
SAMPLES_PER_PHASE = 12
RUNS = {
    "held 450": {"speed_rpm": 450.0},
    "held 650": {"speed_rpm": 650.0},
    "inertial 450": {"speed_rpm": 450.0, "drive": "inertial"},
}


@dataclass(frozen=True)
class Sample:
    """States and forces at random times of one run, with the closed stops of each."""

    run: Solution
    tree: PlanarTree
    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    forces: Reactions
    closed: list[frozenset[str]]

    def motion(self, row: int) -> Motion:
        """The links at one of the times."""
        return self.tree.motion(self.q[row], self.v[row], self.forces.a[row])


@pytest.fixture(scope="module", params=list(RUNS))
def sample(request: pytest.FixtureRequest, e62: Mechanism) -> Sample:
    """Random times within each phase of a cycle: 1, 2 and both kinds of 3."""
    run = simulate(e62, Case(**RUNS[request.param], window="cycle"))
    rng = np.random.default_rng(21)
    times, closed = [], []
    for phase in run.phases:
        times.extend(rng.uniform(phase.t_start, phase.t_end, SAMPLES_PER_PHASE))
        closed.extend([phase.closed] * SAMPLES_PER_PHASE)
    assert {phase.number for phase in run.phases} == {1, 2, 3}
    t = np.array(times)
    motion = run.trajectory.evaluate(t)
    forces = run.trajectory.reactions(t)
    return Sample(run, PlanarTree.of(run.mechanism), t, motion.q, motion.v, forces, closed)


def _acting(
    sample: Sample,
    motion: Motion,
    joints: dict[str, np.ndarray],
    closures: dict[str, np.ndarray],
    lips: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Forces on the links, and their moments about the centroids: every arm counts.

    The wrench that the parent exerts at the link's own joint, minus those that it exerts on its
    children, plus the forces of the cut joints and of the lips at their contact point. Springs, the
    steeve's stop and drives act between a link and its parent, so the wrenches contain them.
    """
    tree, mechanism = sample.tree, sample.run.mechanism
    force = np.zeros(tree.nv, dtype=complex)
    moment = np.zeros(tree.nv)

    def act(link: int, point: complex, f: complex, m: float = 0.0) -> None:
        if link >= 0:
            force[link] += f
            moment[link] += ((point - motion.com[link]).conjugate() * f).imag + m

    for i, link in enumerate(tree.links):
        x, z, m = joints[link.joint]
        act(i, motion.origin[i], complex(x, z), m)
        act(link.parent, motion.origin[i], -complex(x, z), -m)
    for closure, ends in zip(mechanism.closures, tree.closures, strict=True):
        f = complex(*closures[closure.name])
        for end, place, sense in zip(ends, motion.points(ends)[0], (1.0, -1.0), strict=True):
            act(end.body, place, sense * f)
    contact, jaw = mechanism.stop("jaw").contact, mechanism.stop("jaw").index
    assert contact is not None
    above = tree.links[jaw].parent
    # The lower lip turns with its link from where it is in the touch configuration.
    touch = tree.motion(*np.zeros((3, tree.nv)))
    spin = np.exp(1j * motion.angle[above])
    place = motion.origin[jaw] + spin * (complex(*contact.point[[0, 2]]) - touch.origin[jaw])
    f = lips * spin * complex(*contact.normal[[0, 2]])
    act(jaw, place, f)
    act(above, place, -f)
    return force, moment


def test_every_link_balances(sample: Sample) -> None:
    """Newton and Euler for each link: m (c'' + i g) and I alpha from all that acts on it."""
    tree, forces = sample.tree, sample.forces
    largest = max(np.abs(wrench[:, :2]).max() for wrench in forces.joints.values())
    assert largest > 50.0
    for row in range(len(sample.t)):
        motion = sample.motion(row)
        force, moment = _acting(
            sample,
            motion,
            {name: wrenches[row] for name, wrenches in forces.joints.items()},
            {name: cuts[row] for name, cuts in forces.closures.items()},
            forces.contacts["jaw"][row],
        )
        needed = tree.masses * (motion.com_acceleration + 1j * tree.gravity)
        assert np.abs(force - needed).max() <= EXACT * largest
        turning = tree.inertias * motion.spin_rate
        # Arms are up to 0.2 m.
        assert np.abs(moment - turning).max() <= EXACT * largest * 0.2


def test_every_link_balances_at_every_collision(sample: Sample) -> None:
    """The same of impulses: m and I times the changes of velocities and spins."""
    tree = sample.tree
    for event in sample.run.events:
        if event.kind is not EventKind.COLLISION:
            continue
        impulses = sample.run.trajectory.impulses(event)
        largest = max(np.abs(wrench[:2]).max() for wrench in impulses.joints.values())
        struck = sample.run.mechanism.stop(event.stops[0])
        assert impulses.contacts[struck.name] == event.P_N[struck.name] / struck.lever > 0.0
        rest = np.zeros(tree.nv)
        motion = tree.motion(event.q, event.delta, rest)
        force, moment = _acting(
            sample, motion, impulses.joints, impulses.closures, impulses.contacts["jaw"]
        )
        assert np.abs(force - tree.masses * motion.com_rate).max() <= EXACT * largest
        assert np.abs(moment - tree.inertias * motion.spin).max() <= EXACT * largest * 0.2


def test_accelerations_are_derivatives_of_the_motion(sample: Sample) -> None:
    """The accelerations that come with the forces are the second derivative of the trajectory.

    Central differences of the velocities over +-d, extrapolated, d = 1 / 4000 of a turn: O(d^4) of
    harmonics up to about the tenth, 1e-9, and round-off eps v / (d a), 1e-10. 1e-6 is asked for,
    since within bounces the intervals are shorter; times nearer than 2 d to an event are left out.
    """
    trajectory, run = sample.run.trajectory, sample.run
    d = run.shaft.period / 4000.0
    events = np.array([0.0, run.trajectory.span[1], *(event.t for event in run.events)])
    far = np.abs(sample.t[:, None] - events).min(axis=1) > 2.0 * d
    assert far.sum() >= 3 * SAMPLES_PER_PHASE
    t, a = sample.t[far], sample.forces.a[far]

    def slope(k: float) -> np.ndarray:
        ahead, behind = trajectory.evaluate(t + k * d).v, trajectory.evaluate(t - k * d).v
        return (ahead - behind) / (2.0 * k * d)

    difference = (4.0 * slope(0.5) - slope(1.0)) / 3.0
    assert (np.abs(difference - a).max(axis=1) <= 1e-6 * np.abs(a).max(axis=1)).all()


def test_power_of_all_forces_is_the_rate_of_the_kinetic_energy(sample: Sample) -> None:
    """Drive torques, gravity and spring together have the power dT/dt.

    dT/dt = sum m Re(conj(c') c'') + I w alpha. Closures and closed stops do no work. For free
    shafts the torque also speeds up their own inertia.
    """
    tree, run = sample.tree, sample.run
    for row in range(len(sample.t)):
        motion, v, a = sample.motion(row), sample.v[row], sample.forces.a[row]
        growth = tree.masses @ (motion.com_rate.conj() * motion.com_acceleration).real
        growth += (tree.inertias * motion.spin) @ motion.spin_rate
        powers = [-tree.gravity * float(tree.masses @ motion.com_rate.imag)]
        for column, drive in enumerate(run.mechanism.drives):
            torque = sample.forces.drives[drive.name][row]
            powers.append(torque * v[drive.index])
            if not run.system.held:
                growth += run.system.inertia[column] * v[drive.index] * a[drive.index]
        for spring in run.mechanism.springs:
            push = -spring.stiffness * (spring.preload + sample.q[row, spring.index])
            powers.append(push * v[spring.index])
        assert abs(sum(powers) - growth) <= EXACT * np.abs([*powers, growth]).max()


def test_torques_and_stop_forces_follow_from_virtual_work(sample: Sample) -> None:
    """For every displacement that the closures allow, the applied forces do the work of inertia.

    N' (M a + h - spring) = N' (S' torques + W' stop forces), N a basis of G N = 0: closure forces
    drop out, and the three rows give the two torques and the stop's force, or a zero in flight.
    """
    tree, run = sample.tree, sample.run
    for row in range(len(sample.t)):
        q, v, a = sample.q[row], sample.v[row], sample.forces.a[row]
        _, sizes, basis = np.linalg.svd(tree.closure_jacobian(q))
        N = basis[len(sizes) :].T
        assert N.shape[1] == 3
        needed = tree.inverse_dynamics(q, v, a)
        applied = np.zeros(tree.nv)
        for spring in run.mechanism.springs:
            applied[spring.index] -= spring.stiffness * (spring.preload + q[spring.index])
        for column, drive in enumerate(run.mechanism.drives):
            applied[drive.index] += sample.forces.drives[drive.name][row]
            if not run.system.held:
                needed[drive.index] += run.system.inertia[column] * a[drive.index]
        for stop in run.mechanism.stops:
            applied[stop.index] += sample.forces.stops[stop.name][row]
        scale = np.abs([needed, applied]).max()
        assert np.abs(N.T @ (needed - applied)).max() <= EXACT * scale


def test_stops_push_only_while_they_are_closed(sample: Sample) -> None:
    """A closed stop pushes, an open one exerts nothing, and the gap agrees with that."""
    for stop in sample.run.mechanism.stops:
        closed = np.array([stop.name in names for names in sample.closed])
        force = sample.forces.stops[stop.name]
        assert closed.any()
        assert (force[closed] > 0.0).all()
        assert not force[~closed].any()
        assert not sample.q[closed, stop.index].any()


def test_clamping_force_times_its_lever_is_the_multiplier(sample: Sample) -> None:
    """The lips' normal force has the moment of the jaw's multiplier about the jaw pivot.

    Lever: the normal's arm about the pivot, from the contact point and normal of the collision
    shapes and the pivot of the URDF. The pivot itself carries no moment, as every hinge on which
    nothing acts.
    """
    stop = sample.run.mechanism.stop("jaw")
    contact = stop.contact
    assert contact is not None
    touch = sample.tree.motion(*np.zeros((3, sample.tree.nv)))
    arm = complex(*contact.point[[0, 2]]) - touch.origin[stop.index]
    lever = (arm.conjugate() * complex(*contact.normal[[0, 2]])).imag
    assert lever == pytest.approx(stop.lever, rel=1e-12)
    moment = sample.forces.contacts["jaw"] * lever
    scale = np.abs(sample.forces.stops["jaw"]).max()
    assert scale > 1.0
    assert np.abs(moment - sample.forces.stops["jaw"]).max() <= EXACT * scale
    for name in ("jaw", "nipper_pivot", "rod_pin", "rocker_pin"):
        assert np.abs(sample.forces.joints[name][:, 2]).max() <= EXACT * scale

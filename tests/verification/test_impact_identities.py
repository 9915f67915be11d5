"""Impulse, momentum and energy of every collision of whole cycles and transitions.

What the engine reports is compared with the links' momenta by planar geometry (`planar_tree`),
which knows nothing of Pinocchio. Impulses of late bounces are 1e-5 of the first one, and
M (v+ - v-) is formed from velocities whose last digit is eps |v|, so a tolerance is 1e-11 of the
impulses plus a few eps of the momenta themselves.
"""

from collections.abc import Iterator

import numpy as np
import pytest

from benchmarks.stress.mechanics.model_text import Frame
from benchmarks.stress.mechanics.planar_tree import Motion, PlanarTree
from nipper_pin import Case, Event, EventKind, Mechanism, Solution, simulate

RELATIVE = 1e-11
ROUNDING = 16.0 * np.finfo(float).eps
RUNS = {
    "cycle at 450": {"speed_rpm": 450.0, "window": "cycle"},
    "cycle at 650": {"speed_rpm": 650.0, "window": "cycle"},
    "inertial transition at 650": {"speed_rpm": 650.0, "drive": "inertial"},
    "inertial cycle at 450": {"speed_rpm": 450.0, "window": "cycle", "drive": "inertial"},
}


@pytest.fixture(scope="module", params=list(RUNS))
def run(request: pytest.FixtureRequest, e62: Mechanism) -> Solution:
    return simulate(e62, Case(**RUNS[request.param]))


@pytest.fixture(scope="module")
def tree(run: Solution) -> PlanarTree:
    return PlanarTree.of(run.mechanism)


def collisions(run: Solution) -> Iterator[Event]:
    """All collisions; more than six, so that late and early ones are among them."""
    found = [event for event in run.events if event.kind is EventKind.COLLISION]
    assert len(found) >= 6
    yield from found


def inertia(run: Solution, tree: PlanarTree, event: Event) -> np.ndarray:
    """Mass matrix of the links, with the shafts' own inertia where these are free."""
    M = tree.mass_matrix(event.q)
    if not run.system.held:
        M[run.system.driven, run.system.driven] += run.system.inertia
    return M


def test_momentum_changes_by_the_impulses(run: Solution, tree: PlanarTree) -> None:
    """M (v+ - v-) = G' P_g + W' P_N + S' P_drive at every collision.

    Each of the terms is of the size of the jump, so none can be missing or of the wrong sign.
    """
    for event in collisions(run):
        M = inertia(run, tree, event)
        impulse = tree.closure_jacobian(event.q).T @ event.P_g
        for name, P in event.P_N.items():
            impulse[run.mechanism.stop(name).index] += P
        impulse[run.system.driven] += run.drive_impulses[event.number - 1]
        gained = M @ (event.v_after - event.v_before)
        scale = np.abs(gained).max()
        floor = ROUNDING * (np.abs(M) @ np.abs(event.v_before)).max()
        assert np.abs(gained - impulse).max() <= RELATIVE * scale + floor
        assert np.abs(event.P_g).max() > 0.0
        assert run.system.held == bool(run.drive_impulses[event.number - 1].any())


def test_closures_hold_after_the_impact(run: Solution, tree: PlanarTree) -> None:
    """G v = 0 before and after, to round-off of its terms, and held drives keep their rates."""
    for event in collisions(run):
        G = tree.closure_jacobian(event.q)
        for v in (event.v_before, event.v_after):
            assert np.abs(G @ v).max() <= 1e-13 * np.abs(v).max()
        if run.system.held:
            driven = run.system.driven
            assert np.array_equal(event.v_after[driven], event.v_before[driven])
        else:
            assert not np.array_equal(event.v_after, event.v_before)


def test_restitution_and_complementarity(run: Solution) -> None:
    """A stop with an impulse rebounds with e of its approach; one without separates faster.

    The rate after is written by the law, so equality is to the bit: g_dot+ = -e g_dot-.
    """
    for event in collisions(run):
        struck = 0
        for name, P in event.P_N.items():
            stop = run.mechanism.stop(name)
            before, after = event.v_before[stop.index], event.v_after[stop.index]
            assert P >= 0.0
            assert event.q[stop.index] == 0.0
            if P > 0.0:
                struck += 1
                assert after == -stop.restitution * before
            else:
                assert after >= -stop.restitution * before
        assert struck == 1
        assert event.v_before[run.mechanism.stop(event.stops[0]).index] < 0.0


def test_energy_is_lost_at_the_stops_and_fed_by_the_drives(run: Solution, tree: PlanarTree) -> None:
    """T+ - T- = -lost + work of the held drives' impulses, and lost = -sum P (g_dot- + g_dot+) / 2.

    T by planar geometry, 1e-11 of T; the loss once more with the full relative precision of the
    bounce, as P and the rates have it.
    """
    for event in collisions(run):
        shaft = [
            0.5 * run.system.inertia @ v[run.system.driven] ** 2 * (not run.system.held)
            for v in (event.v_before, event.v_after)
        ]
        T = [tree.kinetic_energy(event.q, v) for v in (event.v_before, event.v_after)]
        change = (T[1] + shaft[1]) - (T[0] + shaft[0])
        fed = run.drive_impulses[event.number - 1] @ event.v_before[run.system.driven]
        supplied = fed - event.energy_lost
        assert abs(change - supplied) <= RELATIVE * (T[0] + shaft[0])
        lost = 0.0
        for name, P in event.P_N.items():
            index = run.mechanism.stop(name).index
            lost -= 0.5 * P * (event.v_before[index] + event.v_after[index])
        assert event.energy_lost == pytest.approx(lost, rel=RELATIVE)
        assert event.energy_lost > 0.0


def test_link_velocities_are_those_of_the_geometry(run: Solution, tree: PlanarTree) -> None:
    """Angular and centroid velocities before and after, for every link, by planar geometry.

    A few roundings of the fastest link. They differ before and after by far more.
    """
    for event in collisions(run):
        sides = run.link_velocities(event)
        for v, found in zip((event.v_before, event.v_after), sides, strict=True):
            motion = tree.motion(event.q, v, np.zeros(tree.nv))
            centroid = found.centroid @ [1.0, 1.0j]
            assert found.links == tuple(link.name for link in tree.links)
            scale = np.abs(motion.spin).max()
            assert np.abs(found.angular - motion.spin).max() <= 1e-14 * scale
            assert np.abs(centroid - motion.com_rate).max() <= 1e-14 * scale
    first = next(collisions(run))
    before, after = run.link_velocities(first)
    assert np.abs(after.angular - before.angular).max() > 0.1


def _jumps(
    run: Solution, tree: PlanarTree, event: Event
) -> tuple[Motion, np.ndarray, np.ndarray, float]:
    """Links at the event, changes of their momenta, and the size of the rounding of these."""
    zero = np.zeros(tree.nv)
    before, after = (tree.motion(event.q, v, zero) for v in (event.v_before, event.v_after))
    spin = [side.angular for side in run.link_velocities(event)]
    rate = [side.centroid @ [1.0, 1.0j] for side in run.link_velocities(event)]
    linear = tree.masses * (rate[1] - rate[0])
    angular = tree.inertias * (spin[1] - spin[0])
    floor = ROUNDING * (tree.masses @ np.abs(before.com_rate) + tree.inertias @ np.abs(before.spin))
    return after, linear, angular, float(floor)


def _moment(arm: complex, force: complex) -> float:
    """Counter-clockwise moment of a force at an arm, both as x + i z."""
    return float((arm.conjugate() * force).imag)


def test_subsystems_gain_the_angular_momentum_of_the_outer_impulses(
    run: Solution, tree: PlanarTree
) -> None:
    """About a pin, the links beyond it gain the moment of the impulses from outside.

    sum (c - p) x m dv + I dw = moments about p, with the links' velocities as reported:
    - about the jaw pivot, top nipper and steeve: the lip impulse at the contact point along the
      normal, and the eccentric pin's closure impulse;
    - about the rod pin, the steeve: the eccentric pin's impulse (its end stop is inside);
    - about the rocker pin, the rocker: the cylinder axis' closure impulse;
    - about the tension shaft, the eccentric: the pin's impulse and the drive's.
    The pins' own impulses pass through p, so each balance stands alone: a closure impulse in wrong
    axes, a lip normal or a lever that does not fit to the point would show in one of them.
    """
    names = {link.name: i for i, link in enumerate(tree.links)}
    jaw, contact = run.mechanism.stop("jaw"), run.mechanism.stop("jaw").contact
    touch = tree.motion(*np.zeros((3, tree.nv)))
    closures = [closure.name for closure in run.mechanism.closures]
    balances = {
        "jaw": ("top_nipper", ["top_nipper", "steeve_lower", "steeve_upper"]),
        "rod": ("steeve_lower", ["steeve_lower", "steeve_upper"]),
        "rocker": ("rocker", ["rocker"]),
        "eccentric": ("eccentric", ["eccentric"]),
    }
    lips = 0
    for event in collisions(run):
        motion, linear, angular, floor = _jumps(run, tree, event)
        cut = {}
        for i, (name, ends) in enumerate(zip(closures, tree.closures, strict=True)):
            force = complex(*event.P_g[2 * i : 2 * i + 2]) * motion.axes(ends)[0]
            cut[name] = (motion.points(ends)[0][0], force)
        bottom = names["bottom_nipper"]
        turn = np.exp(1j * motion.angle[bottom])
        local = complex(*contact.point[[0, 2]]) - touch.origin[bottom]
        lip = event.P_N.get("jaw", 0.0) / jaw.lever * complex(*contact.normal[[0, 2]]) * turn
        lips += bool(lip)
        met = motion.points([Frame(bottom, local, 1.0)])[0][0]
        outer = {
            "jaw": [(met, lip), cut["eccentric_pin"]],
            "rod": [cut["eccentric_pin"]],
            "rocker": [cut["rocker_axis"]],
            "eccentric": [(cut["eccentric_pin"][0], -cut["eccentric_pin"][1])],
        }
        drives = [drive.name for drive in run.mechanism.drives]
        torque = {"eccentric": run.drive_impulses[event.number - 1][drives.index("tension")]}
        if not run.system.held:
            # A free shaft's own inertia takes part: its impulse is minus the gain of its momentum.
            tension = names["eccentric"]
            jump = event.v_after[tension] - event.v_before[tension]
            torque["eccentric"] = -run.system.inertia[drives.index("tension")] * jump
        for key, (carrier, members) in balances.items():
            pivot = motion.origin[names[carrier]]
            gained = sum(
                _moment(motion.com[i] - pivot, linear[i]) + angular[i]
                for i in (names[name] for name in members)
            )
            moments = [_moment(point - pivot, force) for point, force in outer[key]]
            moments.append(torque.get(key, 0.0))
            scale = np.abs([gained, *moments]).max()
            assert abs(gained - sum(moments)) <= RELATIVE * scale + floor
    assert lips >= 6

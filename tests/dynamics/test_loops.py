"""The tree and its loops against planar geometry in complex numbers, which knows no Pinocchio."""

from __future__ import annotations

import math
from itertools import permutations

import numpy as np
import pytest

from benchmarks.stress.machines.small_machines import four_bar
from benchmarks.stress.mechanics.planar_tree import PlanarTree
from benchmarks.stress.space import trial
from nipper_pin import Case, DriveMode, Mechanism, load, simulate
from nipper_pin.dynamics import (
    Multibody,
    ShaftMotion,
    System,
    assemble,
    close_positions,
    close_velocities,
    partition,
)
from nipper_pin.dynamics.assembly import same_sign
from nipper_pin.mechanism.gallery import GALLERY, drawn
from nipper_pin.tolerances.mechanics import CLOSURE_RESIDUAL, EPS

STATES = 5
# Sums of a few dozen products, each with a rounding of its own.
ROUNDINGS = 40.0 * EPS
# Machines at random, some with slides, and frames that stand askew.
AT_RANDOM = range(8)


def machines(name: str | int) -> list[Mechanism]:
    """One of the gallery, the E62; or one at random and its mirror image, which turns about -y."""
    if isinstance(name, str):
        return [load(name) if name == "e62" else drawn(name).mechanism()]
    one = trial(11, name)
    return [made for made in (one.mechanism(), one.mirror_image()) if made is not None]


@pytest.mark.parametrize("name", ["e62", *GALLERY, *AT_RANDOM])
def test_gaps_energies_and_forces_are_those_of_the_links(name: str | int) -> None:
    """Of loops that stand open by centimetres, moved anyhow: no term vanishes by itself.

    All configurations together have the gaps and Jacobians that each has alone.
    """
    for mechanism in machines(name):
        body, tree = Multibody(mechanism), PlanarTree.of(mechanism)
        q, v, a = np.random.default_rng(5).uniform(-1.0, 1.0, (3, STATES, body.nv))
        # Lengths of the links, slides by up to one metre, and two rates of up to nv each.
        size = body.reach_m + body.nv
        wanted = tree.closure(q, np.zeros_like(q), np.zeros_like(q))[0], tree.closure_jacobian(q)
        alone = [body.closures(row[None]) for row in q]
        for together, singly, right in zip(
            body.closures(q), map(np.concatenate, zip(*alone, strict=True)), wanted, strict=True
        ):
            assert np.abs(together - right).max(initial=0.0) <= ROUNDINGS * size
            assert np.abs(singly - right).max(initial=0.0) <= ROUNDINGS * size
        kinetic = tree.kinetic_energy(q, v)
        np.testing.assert_allclose(body.kinetic_energy(q, v), kinetic, rtol=ROUNDINGS)
        heights = tree.motion(q, np.zeros_like(q), np.zeros_like(q)).com.imag
        weights = tree.gravity * tree.masses
        off = np.abs(body.gravity_energy(q) - heights @ weights)
        assert off.max() <= ROUNDINGS * size * weights.sum()
        inertia = tree.mass_matrix(q)
        for row, M in zip(q, inertia, strict=True):
            assert np.abs(body.mass_matrix(row) - M).max() <= ROUNDINGS * np.abs(M).max()
        forces = tree.inverse_dynamics(q, v, a)
        off = np.abs(body.inverse_dynamics(q, v, a) - forces)
        assert off.max() <= body.nv * ROUNDINGS * np.abs(forces).max()


@pytest.mark.parametrize("name", ["e62", *GALLERY])
def test_accelerations_of_gaps_have_the_terms_of_the_rates(name: str) -> None:
    """G a + G_dot v at loops that are closed, moved as they let them be, with any acceleration."""
    (mechanism,) = machines(name)
    body, tree = Multibody(mechanism), PlanarTree.of(mechanism)
    q = np.zeros((STATES, body.nv))
    v, a = np.random.default_rng(6).uniform(-1.0, 1.0, (2, STATES, body.nv))
    rows = tree.closure_jacobian(q[0])
    v -= v @ (np.linalg.pinv(rows) @ rows).T
    wanted = tree.closure(q, v, a)[2]
    found = body.closure_accelerations(q, v, a)
    limit = 100.0 * ROUNDINGS * (body.reach_m + body.nv) * body.nv**2
    assert np.abs(found - wanted).max(initial=0.0) <= limit


@pytest.fixture(scope="module")
def moved(e62: Mechanism) -> np.ndarray:
    """Configurations of the E62 all along a turn."""
    run = simulate(e62, Case(speed_rpm=450.0, window="cycle"))
    return run.trajectory.evaluate(np.linspace(*run.trajectory.span, 37)[:-1]).q


def test_what_is_given_stays_and_the_rest_closes_the_loops(
    e62: Mechanism, moved: np.ndarray
) -> None:
    """Dependent coordinates a few degrees off come back; others stay to the bit, rates likewise.

    Given coordinates are never dependent, a preferred stop neither; the stops are preferred one at
    a time, so that each would have to be left out by luck.
    """
    body, tree, rng = Multibody(e62), PlanarTree.of(e62), np.random.default_rng(6)
    driven, zero = [drive.index for drive in e62.drives], np.zeros(7)
    for q in moved:
        G = body.closures(q[None])[1][0]
        for stop in e62.stops:
            split = partition(G, driven, [stop.index])
            assert sorted([*split.dependent, *split.independent]) == list(range(7))
            assert not {stop.index, *driven} & set(split.dependent)
            assert np.linalg.cond(G[:, split.columns]) < 1e4
            guess = np.repeat(q[None], 3, axis=0)
            guess[:, split.columns] += rng.uniform(-0.02, 0.02, (3, 4))
            closed, jacobians = close_positions(body, guess, split)
            kept = list(split.independent)
            assert np.array_equal(closed[:, kept], guess[:, kept])
            np.testing.assert_allclose(closed, np.repeat(q[None], 3, axis=0), rtol=0.0, atol=1e-12)
            assert np.abs(tree.closure(closed, zero, zero)[0]).max() <= 1e-14
            rates = rng.uniform(-10.0, 10.0, (3, 7))
            v = close_velocities(rates, jacobians, split)
            assert np.array_equal(v[:, kept], rates[:, kept])
            gone = np.einsum("nij,nj->ni", tree.closure_jacobian(closed), v)
            assert np.abs(gone).max() <= 1e-14 * np.abs(v).max()


def test_assembly_does_not_depend_on_its_steps_nor_on_what_was_assembled_before(
    e62: Mechanism,
) -> None:
    """Along 12 or 240 steps the mechanism stands in one configuration, and moves alike.

    Configurations differ by the last Newton step only, 1e-16 m by the condition of the closures
    (about 10 to 1e3); on another branch they would differ by radians. A run at another rate starts
    where the last path ended: no closure is asked for again; another path is followed anew.
    """
    body, tree = Multibody(e62), PlanarTree.of(e62)
    given = [*(drive.index for drive in e62.drives), e62.stop("steeve").index]
    end, rates = np.array([-0.4, -0.88, 0.0]), np.array([3.0, 6.6, 0.0])
    paths = [end * np.linspace(0.0, 1.0, steps + 1)[1:, None] for steps in (12, 240)]
    few, many = (assemble(body, path, given, rates) for path in paths)
    for q, v, _ in (few, many):
        assert np.array_equal(q[given], end)
        assert np.array_equal(v[given], rates)
        g, g_dot, _ = tree.closure(q, v, np.zeros(7))
        assert np.abs(g).max() <= 1e-14
        assert np.abs(g_dot).max() <= 1e-13
    assert np.abs(few[0] - many[0]).max() <= 1e-13
    assert np.abs(few[1] - many[1]).max() <= 1e-12
    asked: list[int] = []
    body.closures = lambda q: asked.append(len(q)) or Multibody.closures(body, q)  # type: ignore[method-assign, func-returns-value]
    again = assemble(body, paths[1], given, 3.0 * rates)
    assert asked == []
    np.testing.assert_array_equal(again[0], many[0])
    np.testing.assert_allclose(again[1], 3.0 * many[1], rtol=1e-13, atol=0.0)
    # What is returned is the caller's own.
    again[0][:] = 7.0
    np.testing.assert_array_equal(assemble(body, paths[1], given, rates)[0], many[0])
    half = assemble(body, 0.5 * paths[1], given, rates)
    assert asked
    fresh = assemble(Multibody(e62), 0.5 * paths[1], given, rates)
    for one, other in zip(half, fresh, strict=True):
        np.testing.assert_array_equal(one, other)


def test_near_a_dead_centre_positions_closed_anew_do_not_depend_on_the_guess() -> None:
    """Coupler and rocker are nearly in line: along their common motion gaps hardly open.

    Guesses whose gaps are half of what may be left are taken as they are, thousands of times as far
    apart as round-off; one step of Newton's method leaves what the gaps lose to round-off.
    """
    linkage = four_bar(0.10, 0.06, 0.0744, 0.07, (0.1, 0.2, 0.3)).mechanism()
    # The crank stops where the law of cosines has the others in line.
    dead = math.acos((0.10**2 + 0.06**2 - (0.0744 + 0.07) ** 2) / (2.0 * 0.10 * 0.06))
    body, path = Multibody(linkage), np.linspace(0.0, 1.0, 40)[1:, None] * (dead - 1e-7)
    q, _, jacobian = assemble(body, path, [0], np.zeros(1))
    split = partition(jacobian, [0], [])
    _, sizes, motions = np.linalg.svd(jacobian[:, split.columns])
    assert sizes[-1] < 1e-3 * sizes[0]
    weak = np.zeros_like(q)
    weak[split.columns] = 0.5 * CLOSURE_RESIDUAL * body.reach_m / sizes[-1] * motions[-1]
    guesses = [(q + sense * weak)[None] for sense in (1.0, -1.0)]
    taken, anew = (
        np.ptp([close_positions(body, one, split, anew=new)[0] for one in guesses], axis=0).max()
        for new in (False, True)
    )
    assert taken == np.ptp(guesses, axis=0).max()
    assert anew < 0.25 * taken


def test_a_choice_of_coordinates_that_has_become_singular_is_made_anew(e62: Mechanism) -> None:
    """The closures of a second configuration do not determine what those of the first did."""
    system = System(e62, ShaftMotion(e62, 50.0, 0.0))
    given = tuple(int(index) for index in system.driven)
    (jacobian,) = system.body.closures(np.zeros((1, 7)))[1]
    first = system.split(jacobian, given, ())
    again = jacobian.copy()
    again[:, first.columns[0]] = again[:, first.columns[1]]
    # What the lost column did is done by another coordinate, which was independent.
    other = next(column for column in first.independent if column not in given)
    again[:, other] = jacobian[:, first.columns[0]]
    assert np.linalg.cond(again[:, first.columns]) > 1e12
    assert np.linalg.cond(again[:, system.split(again, given, ()).columns]) < 1e4


def test_signs_of_determinants_are_compared() -> None:
    """Rows that change places change the sign; a singular matrix has none."""
    one, singular = np.diag([2.0, 3.0]), np.ones((2, 2))
    swapped = one[::-1].copy()
    for same in ((one, -one), (singular, np.zeros((2, 2))), (np.empty((0, 0)),) * 2):
        assert same_sign(*same)
    for first, second in permutations((one, swapped, singular), 2):
        assert not same_sign(first, second)


def test_placement_caches_never_go_stale(e62: Mechanism, moved: np.ndarray) -> None:
    """Closures and accelerations do not depend on what was evaluated before them, to the bit.

    Pinocchio keeps placements in its data; each answer is compared with the one of a fresh system
    that was asked nothing else, so a stale placement of another configuration shows at once.
    """
    q, other = moved[[3]], moved[[20]]
    v = np.random.default_rng(4).uniform(-3.0, 3.0, (1, 7))
    for drive in DriveMode:
        used, fresh = (System(e62, ShaftMotion(e62, 50.0, 1.0), drive) for _ in range(2))
        # Systems of one thread share their buffers; this one gets its own.
        fresh.body = Multibody(e62)
        motion = used.shaft.driven(np.zeros(1))
        rows = used.constraint_set(frozenset())
        expected = fresh.body.closures(q), fresh.accelerations(motion, q, v, rows)
        for _ in range(2):
            used.accelerations(motion, other, v, rows)
            _, (G,) = used.body.closures(other)
            used.body.impulse_response(other[0], G, v[0], used.drive_armature)
            used.body.mass_matrix(other[0])
            used.body.inverse_dynamics(other, v, v)
            used.body.kinetic_energy(other, v)
            used.body.link_velocities(other[0], v[0])
            used.body.joint_wrenches(other[0], v[0], v[0], np.ones(len(G)))
            found = used.body.closures(q), used.accelerations(motion, q, v, rows)
            for one, right in zip((*found[0], found[1]), (*expected[0], expected[1]), strict=True):
                assert np.array_equal(one, right)

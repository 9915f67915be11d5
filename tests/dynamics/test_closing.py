"""Closing the loops: which coordinates follow from which, positions, velocities, dead centres."""

import math
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from benchmarks.stress.mechanics.planar_tree import PlanarTree
from nipper_pin import ConvergenceError, Mechanism, SingularConfigurationError, load
from nipper_pin.dynamics import (
    Multibody,
    ShaftMotion,
    System,
    assemble,
    close_positions,
    close_velocities,
    partition,
)
from nipper_pin.tolerances.mechanics import CLOSURE_RESIDUAL

MakeSystem = Callable[..., System]
FOUR_BAR = Path(__file__).parents[1] / "verification" / "models" / "four_bar"
GROUND = 0.10
# Where the rocker's end stands in the touch configuration: its length from its pivot at (0.10, 0).
ROCKER_END = complex(0.08785714285714285, 0.06893874832348035)
ROCKER = abs(ROCKER_END - GROUND)


@dataclass(frozen=True)
class DoubleRocker:
    """A four-bar whose crank cannot turn round."""

    mechanism: Mechanism
    crank: float
    coupler: float
    dead_angle: float


@pytest.fixture
def double_rocker(tmp_path: Path) -> DoubleRocker:
    """The four-bar with a crank of 60 mm instead of 30, its coupler changed to fit.

    Lengths 100, 60, 74.4 and 70 mm: shortest + longest = 160 > 144.4 = the others, so Grashof's
    condition fails. The crank stops where coupler and rocker are in line, at the angle f with
    0.10^2 + 0.06^2 - 2 0.10 0.06 cos f = (coupler + rocker)^2.
    """
    crank = 0.06
    folder = tmp_path / "four_bar"
    shutil.copytree(FOUR_BAR, folder)
    path = folder / "four_bar.urdf"
    text = path.read_text(encoding="utf-8")
    arm = ROCKER_END - crank
    for old, new in (
        ('xyz="0.03 0 0"', f'xyz="{crank} 0 0"'),
        ('xyz="0.05785714285714285 0', f'xyz="{arm.real!r} 0'),
    ):
        assert text.count(old) == 1
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    reach = abs(arm) + ROCKER
    cosine = (GROUND**2 + crank**2 - reach**2) / (2.0 * GROUND * crank)
    return DoubleRocker(load(folder), crank, abs(arm), math.acos(cosine))


def _system(mechanism: Mechanism) -> System:
    return System(mechanism, ShaftMotion(mechanism, 30.0, 0.0))


def _free_of(q: np.ndarray, split) -> np.ndarray:
    return q[..., list(split.independent)]


def test_partition_keeps_what_is_given_and_what_is_preferred(
    mechanism: Mechanism, states, make_system: MakeSystem
) -> None:
    """Given coordinates are never dependent, a preferred stop neither, and the block is regular.

    The stops are preferred one at a time, so a partition that ignored the preference would have
    to leave each of them out by luck in 36 states.
    """
    body = make_system().body
    driven = [drive.index for drive in mechanism.drives]
    for state in states:
        G = body.closures(state.q[None])[1][0]
        for stop in mechanism.stops:
            split = partition(G, driven, [stop.index])
            assert sorted([*split.dependent, *split.independent]) == list(range(body.nv))
            assert len(split.dependent) == len(G)
            assert not {stop.index, *driven} & set(split.dependent)
            assert np.linalg.cond(G[:, list(split.dependent)]) < 1e4


def test_a_mechanism_without_closures_has_only_independent_coordinates() -> None:
    """No rows, no dependent coordinates."""
    split = partition(np.zeros((0, 3)), [0], [2])
    assert split.dependent == ()
    assert split.independent == (0, 1, 2)


def test_positions_close_and_independent_ones_stay(
    mechanism: Mechanism, tree: PlanarTree, states, make_system: MakeSystem
) -> None:
    """From guesses a few degrees off, gaps fall to 1e-14 m and independent coordinates stay to
    the bit.

    Gaps are judged by the planar geometry; lengths below 0.5 m leave round-off of some 1e-16 m. The
    guesses' gaps are millimetres, so that nothing is closed beforehand.
    """
    body = make_system().body
    rng = np.random.default_rng(6)
    driven = [drive.index for drive in mechanism.drives]
    zero = np.zeros(tree.nv)
    for state in states:
        G = body.closures(state.q[None])[1][0]
        split = partition(G, driven, [mechanism.stops[0].index])
        guess = np.repeat(state.q[None], 3, axis=0)
        guess[:, list(split.dependent)] += rng.uniform(-0.02, 0.02, (3, len(split.dependent)))
        q, jacobian = close_positions(body, guess, split)
        assert np.array_equal(_free_of(q, split), _free_of(guess, split))
        for row, before, J in zip(q, guess, jacobian, strict=True):
            assert np.abs(tree.closure(before, zero, zero)[0]).max() > 1e-4
            assert np.abs(tree.closure(row, zero, zero)[0]).max() <= 1e-14
            # The same branch: back where the guess came from, up to Newton's last step.
            np.testing.assert_allclose(row, state.q, rtol=0.0, atol=1e-12)
            assert np.abs(J - tree.closure_jacobian(row)).max() <= 2e-15


def test_velocities_close_and_independent_ones_stay(
    mechanism: Mechanism, tree: PlanarTree, states, make_system: MakeSystem
) -> None:
    """G v = 0 to round-off of its terms; independent velocities stay to the bit."""
    body = make_system().body
    rng = np.random.default_rng(7)
    driven = [drive.index for drive in mechanism.drives]
    for state in states:
        _, jacobian = body.closures(state.q[None])
        split = partition(jacobian[0], driven, [mechanism.stops[1].index])
        guess = rng.uniform(-10.0, 10.0, (1, body.nv))
        v = close_velocities(guess, jacobian, split)
        assert np.array_equal(_free_of(v, split), _free_of(guess, split))
        rate = tree.closure_jacobian(state.q) @ v[0]
        assert np.abs(rate).max() <= 1e-14 * np.abs(v).max()


def test_assembly_does_not_depend_on_its_steps(
    mechanism: Mechanism, tree: PlanarTree, make_system: MakeSystem
) -> None:
    """Assembled along 12 or 240 steps the mechanism stands in one configuration, and moves alike.

    Configurations differ by the last Newton step only, 1e-16 m by the condition of the closures
    (about 10 to 1e3); on another branch they would differ by radians.
    """
    body = make_system().body
    given = [drive.index for drive in mechanism.drives]
    steeve = mechanism.stop("steeve").index
    end = np.array([-0.4, -0.88, 0.0])
    rates = np.array([3.0, 6.6, 0.0])
    results = [
        assemble(body, end * np.linspace(0.0, 1.0, steps + 1)[1:, None], [*given, steeve], rates)
        for steps in (12, 240)
    ]
    for q, v, _ in results:
        assert np.array_equal(q[[*given, steeve]], end)
        assert np.array_equal(v[[*given, steeve]], rates)
        g, g_dot, _ = tree.closure(q, v, np.zeros(tree.nv))
        assert np.abs(g).max() <= 1e-14
        assert np.abs(g_dot).max() <= 1e-13
    assert np.abs(results[0][0] - results[1][0]).max() <= 1e-13
    assert np.abs(results[0][1] - results[1][1]).max() <= 1e-12


def test_runs_at_other_rates_start_where_the_last_path_ended(e62: Mechanism) -> None:
    """No closure is asked for again, and another path is followed from the touch configuration."""
    body = Multibody(e62)
    given = [drive.index for drive in e62.drives] + [e62.stop("steeve").index]
    path = np.outer(np.linspace(0.0, 1.0, 5)[1:], [0.1, 0.1, 0.0][: len(given)])
    slow, fast = np.full(len(given), 1.0), np.full(len(given), 3.0)
    first = assemble(body, path, given, slow)
    asked: list[int] = []
    body.closures = lambda q: asked.append(len(q)) or Multibody.closures(body, q)  # type: ignore[method-assign, func-returns-value]
    again = assemble(body, path, given, fast)
    assert asked == []
    np.testing.assert_array_equal(again[0], first[0])
    np.testing.assert_allclose(again[1], 3.0 * first[1], rtol=1e-13, atol=0.0)
    # What is returned is the caller's own.
    again[0][:] = 7.0
    np.testing.assert_array_equal(assemble(body, path, given, slow)[0], first[0])
    half = assemble(body, 0.5 * path, given, slow)
    assert asked
    fresh = assemble(Multibody(e62), 0.5 * path, given, slow)
    for one, other in zip(half, fresh, strict=True):
        np.testing.assert_array_equal(one, other)


def test_near_a_dead_centre_positions_closed_anew_do_not_depend_on_the_guess(
    double_rocker: DoubleRocker,
) -> None:
    """Coupler and rocker are nearly in line: along their common motion gaps hardly open.

    Guesses whose gaps are half of what may be left are taken as they are, thousands of times as far
    apart as round-off; one step of Newton's method leaves what the gaps lose to round-off.
    """
    mechanism = double_rocker.mechanism
    system = _system(mechanism)
    (crank,) = (drive.index for drive in mechanism.drives)
    path = np.linspace(0.0, 1.0, 40)[1:, None] * (double_rocker.dead_angle - 1e-7)
    q, _, jacobian = assemble(system.body, path, [crank], np.zeros(1))
    split = partition(jacobian, [crank], [])
    _, sizes, motions = np.linalg.svd(jacobian[:, split.columns])
    assert sizes[-1] < 1e-3 * sizes[0]
    weak = np.zeros_like(q)
    weak[split.columns] = 0.5 * CLOSURE_RESIDUAL * system.body.reach_m / sizes[-1] * motions[-1]
    guesses = np.stack([q + weak, q - weak])
    apart = float(np.ptp(guesses, axis=0).max())
    taken = [close_positions(system.body, guess[None], split)[0][0] for guess in guesses]
    assert np.ptp(taken, axis=0).max() == apart
    anew = [close_positions(system.body, guess[None], split, anew=True)[0][0] for guess in guesses]
    assert np.ptp(anew, axis=0).max() < 0.25 * apart


def test_a_dead_centre_is_refused(double_rocker: DoubleRocker) -> None:
    """Coupler and rocker in line: the crank no longer determines them, and that is an error.

    The configuration is placed in closed form. Driving a coordinate that does determine the others
    there (the rocker) must work, so it is the dead centre that is refused and not the place.
    """
    machine = double_rocker
    body = _system(machine.mechanism).body
    index = {joint.name: joint.index for joint in machine.mechanism.joints}
    pin = machine.crank * np.exp(1j * machine.dead_angle)
    line = np.angle(GROUND - pin)
    joint_end = pin + machine.coupler * np.exp(1j * line)
    q = np.zeros(body.nv)
    q[index["crank_axis"]] = machine.dead_angle
    coupler_turn = line - np.angle(ROCKER_END - machine.crank)
    q[index["crank_pin"]] = coupler_turn - machine.dead_angle
    turn = np.angle(joint_end - GROUND) - np.angle(ROCKER_END - GROUND)
    q[index["rocker_axis"]] = turn
    g, G = body.closures(q[None])
    assert np.abs(g).max() <= 1e-15
    with pytest.raises(SingularConfigurationError, match="dead centre") as caught:
        partition(G[0], [index["crank_axis"]], [])
    assert caught.value.evidence["condition"] > 1e8
    assert index["rocker_axis"] not in partition(G[0], [index["rocker_axis"]], []).dependent


def test_an_exactly_singular_block_is_refused() -> None:
    """A closed velocity that does not exist is an error of the package, not of numpy."""
    G = np.array([[[0.1, 0.3, 0.6], [0.2, 0.1, 0.2]]])
    with pytest.raises(SingularConfigurationError, match="dead centre"):
        partition(G[0], [0], [])


def test_an_unreachable_drive_says_how_far_it_is(double_rocker: DoubleRocker) -> None:
    """Beyond the dead centre the loops cannot close: the error tells the gap that remains in mm.

    At crank angle f the pins are apart by at least |pin - pivot| - coupler - rocker, 15.6 mm at
    f = 180 degrees. No iteration can go below that, and the error must not claim less.
    """
    machine = double_rocker
    body = _system(machine.mechanism).body
    crank = next(j.index for j in machine.mechanism.joints if j.name == "crank_axis")
    q = np.zeros((1, body.nv))
    G = body.closures(q)[1][0]
    q[0, crank] = math.pi
    least = GROUND + machine.crank - machine.coupler - ROCKER
    with pytest.raises(ConvergenceError, match=" mm remain") as caught:
        close_positions(body, q, partition(G, [crank], []))
    # The residual is the larger component of a vector, at least its length by the root of 2.
    assert caught.value.evidence["residual"] >= least / math.sqrt(2.0)
    assert f"{1e3 * caught.value.evidence['residual']:.3g} mm" in str(caught.value)
    path = np.linspace(0.0, math.pi, 25)[1:, None]
    with pytest.raises(ConvergenceError, match=" mm remain"):
        assemble(body, path, [crank], np.array([1.0]))

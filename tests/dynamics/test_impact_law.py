"""The impact law against a dense solution without Pinocchio, and its complementarity.

[ M  -A' ] [v+]   [ M v- ]        A = closures, active stops, held drives
[ A   0  ] [P ] = [  b   ]        b = 0, -e g_N_dot-, v-
"""

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from dense import close, constrained

from benchmarks.stress.mechanics.planar_tree import PlanarTree
from nipper_pin import DriveMode, ImpactError, Mechanism, load
from nipper_pin.dynamics import (
    Impact,
    ShaftMotion,
    System,
    closing_impulse,
    collide,
    drive_impulses,
    impact_condition,
)
from nipper_pin.mechanism import find_model

MakeSystem = Callable[..., System]
modes = pytest.mark.parametrize("drive", list(DriveMode))
# As for accelerations: condition of the scaled matrix, about 1e4, times eps is 2e-12; with both
# stops closed and shafts that give way it is 3.5e4, and each rounding of 13 unknowns counts.
RELATIVE, BOTH_CLOSED = 1e-11, 1e-10


@dataclass(frozen=True)
class Meeting:
    """A closed configuration with gaps of exactly zero, and its closure Jacobian."""

    q: np.ndarray
    G: np.ndarray


@cache
def _places(
    tree: PlanarTree, pendulum: int, tension: int, zero: tuple[int, ...]
) -> list[np.ndarray]:
    """Random closed configurations with these coordinates at zero."""
    rng, found = np.random.default_rng(8), []
    for _ in range(12):
        q = np.zeros(tree.nv)
        # Several steps, so that Newton's iteration stays on the branch of the machine.
        target = rng.uniform(-0.35, 0.1)
        kept = [pendulum, *zero] if len(zero) == 2 else [pendulum, tension, *zero]
        for part in np.linspace(0.0, target, 8)[1:]:
            q[pendulum] = part
            if tension in kept:
                q[tension] = 2.2 * part
            q = close(tree, q, [i for i in range(tree.nv) if i not in kept])
        found.append(q)
    return found


def _meetings(tree: PlanarTree, system: System, stops: tuple[str, ...], count: int):
    """Random configurations in which these stops are closed, all else anywhere near."""
    mechanism = system.mechanism
    drives = (drive.index for drive in mechanism.drives)
    zero = tuple(mechanism.stop(name).index for name in stops)
    for q in _places(tree, *drives, zero)[:count]:
        yield Meeting(q, system.body.closures(q[None])[1][0])


def _velocity(G: np.ndarray, given: dict[int, float], rng: np.random.Generator) -> np.ndarray:
    """A random velocity with G v = 0 and some rates given."""
    columns = list(given)
    v = rng.uniform(-8.0, 8.0, G.shape[1])
    rows = np.vstack([G, np.eye(G.shape[1])[columns]])
    wanted = np.concatenate([np.zeros(len(G)), list(given.values())])
    for _ in range(2):
        v -= np.linalg.lstsq(rows, rows @ v - wanted, rcond=None)[0]
    v[columns] = list(given.values())
    return v


def _dense(tree: PlanarTree, system: System, q, v, active, e):
    """v+ and the impulses: closures, active stops, held drives."""
    M = tree.mass_matrix(q)
    rows = list(active)
    rates = list(-np.asarray(e) * v[rows])
    if system.held:
        rows += list(system.driven)
        rates += list(v[system.driven])
    else:
        M[system.driven, system.driven] += system.inertia
    G = tree.closure_jacobian(q)
    A = np.vstack([G, np.eye(tree.nv)[rows]])
    return constrained(M, M @ v, A, np.concatenate([np.zeros(len(G)), rates]))


def _agrees(tree, system, q, v, impact: Impact, names, e, most=RELATIVE) -> None:
    """The impact is the dense solution with these stops active."""
    stops = [system.mechanism.stop(name) for name in names]
    v_after, P = _dense(tree, system, q, v, [stop.index for stop in stops], e)
    jump = np.abs(v_after - v).max()
    m = system.body.closure_rows
    assert np.abs(impact.v_after - v_after).max() <= most * jump
    scale = most * np.abs(P).max()
    assert np.abs(impact.P_g - P[:m]).max() <= scale
    found = [impact.P_N[name] for name in names]
    assert np.abs(np.array(found) - P[m : m + len(names)]).max() <= scale
    P_drive = _of_drives(system, q, impact)
    if system.held:
        assert np.abs(P_drive - P[m + len(names) :]).max() <= scale
    else:
        assert np.array_equal(P_drive, np.zeros(len(system.driven)))


def _of_drives(system, q, impact: Impact) -> np.ndarray:
    return drive_impulses(system, q, impact.delta, impact.P_g)


@pytest.mark.slow
@modes
@pytest.mark.parametrize("name", ["jaw", "steeve"])
@pytest.mark.parametrize("e_N", [0.0, 0.2, 1.0])
def test_one_stop_equals_an_independent_solution(
    tree: PlanarTree, make_system: MakeSystem, drive: DriveMode, name: str, e_N: float
) -> None:
    """Velocity, closure impulses, stop impulse and drive impulses are those of a dense solution.

    Positions and velocities are random, drives move, and the other gap is open.
    """
    system = make_system(drive)
    stop = system.mechanism.stop(name)
    rng = np.random.default_rng(9)
    for meeting in _meetings(tree, system, (name,), 8):
        v = _velocity(meeting.G, {stop.index: -rng.uniform(0.1, 10.0)}, rng)
        impact = collide(system, meeting.q, v, meeting.G, [stop], [e_N])
        _agrees(tree, system, meeting.q, v, impact, [name], [e_N])
        # The stop's rate and the held rates are not solved for: they are what the law says.
        assert impact.v_after[stop.index] == -e_N * v[stop.index]
        if system.held:
            assert np.array_equal(impact.v_after[system.driven], v[system.driven])
        assert impact.P_N[name] > 0.0


@modes
@pytest.mark.parametrize("name", ["jaw", "steeve"])
def test_energy_lost_is_the_drop_of_the_kinetic_energy(
    tree: PlanarTree, make_system: MakeSystem, drive: DriveMode, name: str
) -> None:
    """T- - T+ = energy lost - work of the drives' impulses, and lost = (1/2) m_eff w^2 (1 - e^2).

    T is a sum of squares by planar geometry; m_eff = 1 / (W' M^-1 W), M^-1 restricted to closed
    motion, is found as the impulse for a unit jump. Round-off relative to T- is some 1e-14 by the
    condition of the impulses.
    """
    system = make_system(drive)
    stop = system.mechanism.stop(name)
    rng = np.random.default_rng(10)
    for meeting in _meetings(tree, system, (name,), 8):
        q, e_N = meeting.q, 0.3
        v = _velocity(meeting.G, {stop.index: -3.0}, rng)
        impact = collide(system, q, v, meeting.G, [stop], [e_N])
        T = [tree.kinetic_energy(q, rate) for rate in (v, impact.v_after)]
        if not system.held:
            T = [
                kinetic + 0.5 * system.inertia @ rate[system.driven] ** 2
                for kinetic, rate in zip(T, (v, impact.v_after), strict=True)
            ]
        balance = T[0] - T[1] - impact.energy_lost
        balance += _of_drives(system, q, impact) @ v[system.driven]
        assert abs(balance) <= 1e-11 * T[0]
        M = tree.mass_matrix(q)
        rows = [stop.index, *(system.driven if system.held else [])]
        if not system.held:
            M[system.driven, system.driven] += system.inertia
        A = np.vstack([meeting.G, np.eye(tree.nv)[rows]])
        rates = np.zeros(len(A))
        rates[len(meeting.G)] = 1.0
        effective = constrained(M, np.zeros(tree.nv), A, rates)[1][len(meeting.G)]
        assert impact.energy_lost == pytest.approx(
            0.5 * effective * 9.0 * (1.0 - e_N**2), rel=RELATIVE
        )
        assert impact.P_N[name] == pytest.approx(effective * 3.0 * (1.0 + e_N), rel=RELATIVE)


@pytest.mark.parametrize(("hitting", "closed"), [("jaw", "steeve"), ("steeve", "jaw")])
def test_a_collision_opens_the_other_stop(
    tree: PlanarTree, make_system: MakeSystem, hitting: str, closed: str
) -> None:
    """A held nipper that hits one stop leaves the other, which was closed and gets no impulse.

    With the drives held one freedom is left, in which jaw and steeve open together, so the solution
    of the law is the one with the hitting stop alone; the closed one must not pull.
    """
    system = make_system(DriveMode.HELD)
    stops = [system.mechanism.stop(name) for name in (hitting, closed)]
    rng = np.random.default_rng(11)
    for meeting in _meetings(tree, system, ("jaw", "steeve"), 8):
        v = _velocity(meeting.G, {stops[0].index: -2.0, stops[1].index: 0.0}, rng)
        for order in (stops, stops[::-1]):
            impact = collide(system, meeting.q, v, meeting.G, order, [0.2, 0.2])
            assert impact.P_N[closed] == 0.0
            assert impact.v_after[stops[1].index] > 0.0
            _agrees(tree, system, meeting.q, v, impact, [hitting], [0.2])


def test_two_stops_satisfy_the_complementarity(tree: PlanarTree, make_system: MakeSystem) -> None:
    """With inertial shafts both stops may be hit at once; the law picks the one right set.

    xi = g_dot+ + e g_dot- >= 0, P >= 0, xi P = 0. The dense solution is tried with each set of
    active stops, and exactly one of them satisfies the law (the Delassus matrix of independent
    stops is positive definite). Random rates must bring up at least two different sets, or the
    test would not see the choice.
    """
    system = make_system(DriveMode.INERTIAL)
    stops = [system.mechanism.stop(name) for name in ("jaw", "steeve")]
    indices = [stop.index for stop in stops]
    e = np.array([0.2, 0.5])
    rng = np.random.default_rng(12)
    seen = set()
    for meeting in _meetings(tree, system, ("jaw", "steeve"), 12):
        rates = -rng.uniform(0.0, 1.0, 2) * np.array([10.0, 0.5])
        v = _velocity(meeting.G, dict(zip(indices, rates, strict=True)), rng)
        right = []
        for size in (1, 2):
            for active in combinations(range(2), size):
                chosen = list(active)
                after, P = _dense(
                    tree, system, meeting.q, v, [indices[i] for i in chosen], e[chosen]
                )
                xi = after[indices] + e * v[indices]
                if P[4:].min() >= 0.0 and xi.min() >= -1e-12:
                    right.append(active)
        assert len(right) == 1
        seen.add(right[0])
        impact = collide(system, meeting.q, v, meeting.G, stops, list(e))
        names = [stops[i].name for i in right[0]]
        _agrees(tree, system, meeting.q, v, impact, names, e[list(right[0])])
        assert {name for name, P in impact.P_N.items() if P > 0.0} == set(names)
    assert len(seen) >= 2


@pytest.mark.parametrize("name", ["jaw", "steeve"])
@modes
def test_small_impacts_keep_their_relative_precision(
    tree: PlanarTree, make_system: MakeSystem, drive: DriveMode, name: str
) -> None:
    """An approach rate 1e-10 times smaller gives impulses 1e-10 times smaller, to 1e-11 relative.

    The law is linear in the approach rate. The drives keep their full speed, so any path that forms
    impulses from whole velocities (some 10 rad/s, round-off 1e-15) would be wrong by 1e-5 here.
    """
    system = make_system(drive)
    stop = system.mechanism.stop(name)
    rng = np.random.default_rng(13)
    for meeting in _meetings(tree, system, (name,), 6):
        q, G = meeting.q, meeting.G
        fast = _velocity(G, {stop.index: -1.0}, rng)
        slow = _velocity(G, {stop.index: -1e-10}, rng)
        large, small = (collide(system, q, v, G, [stop], [0.2]) for v in (fast, slow))
        for one, other in (
            (small.P_g, large.P_g),
            (np.array([small.P_N[name]]), np.array([large.P_N[name]])),
            (_of_drives(system, q, small), _of_drives(system, q, large)),
        ):
            assert np.abs(1e10 * one - other).max() <= 1e-11 * np.abs(other).max(initial=0.0)
        assert 1e20 * small.energy_lost == pytest.approx(large.energy_lost, rel=1e-11)
        assert small.v_after[stop.index] == 0.2 * 1e-10


def test_a_rest_takes_away_the_last_rate(tree: PlanarTree, make_system: MakeSystem) -> None:
    """`closing_impulse` is the plastic impact of the stop's rate, whatever its sign.

    For a stop that still moves apart the impulse is negative, and it is minus the impulse of the
    same approach: the law is odd in the rate.
    """
    system = make_system(DriveMode.HELD)
    stop = system.mechanism.stop("jaw")
    rng = np.random.default_rng(14)
    for meeting in _meetings(tree, system, ("jaw",), 6):
        q, G = meeting.q, meeting.G
        leaving = _velocity(G, {stop.index: 1e-6}, rng)
        closing = _velocity(G, {stop.index: -1e-6}, rng)
        rest = closing_impulse(system, q, leaving, G, [stop])
        plastic = collide(system, q, closing, G, [stop], [0.0])
        assert rest.v_after[stop.index] == 0.0
        assert rest.P_N["jaw"] < 0.0
        assert rest.P_N["jaw"] == pytest.approx(-plastic.P_N["jaw"], rel=1e-11)
        assert rest.energy_lost == pytest.approx(plastic.energy_lost, rel=1e-11)
        assert rest.energy_lost > 0.0


@pytest.fixture(scope="module")
def opposed(tmp_path_factory: pytest.TempPathFactory) -> Mechanism:
    """The E62 with a steeve that counts lengthening as positive, so that its stop bars shortening.

    Opening the jaw shortens the steeve: jaw and steeve cannot both move away from their stops, and
    with held drives nothing else can give way.
    """
    folder = tmp_path_factory.mktemp("opposed") / "e62"
    shutil.copytree(find_model("e62"), folder)
    path = folder / "e62.urdf"
    text = path.read_text(encoding="utf-8")
    axis = 'axis xyz="0.3835683289474219 0 -0.9235124996601196"'
    assert text.count(axis) == 1
    turned = 'axis xyz="-0.3835683289474219 0 0.9235124996601196"'
    path.write_text(text.replace(axis, turned), encoding="utf-8")
    return load(folder)


def test_opposed_stops_jam_held_drives(opposed: Mechanism) -> None:
    """A stop that may neither yield nor rebound against held drives is an error, naming the stops.

    The same impact has a solution once the shafts may change their speed, with impulses at both
    stops: it is the jam that is refused.
    """
    tree = PlanarTree.of(opposed)
    stops = [opposed.stop(name) for name in ("jaw", "steeve")]
    rng = np.random.default_rng(15)
    shaft = ShaftMotion(opposed, 50.0, 1.0)
    held, inertial = System(opposed, shaft), System(opposed, shaft, DriveMode.INERTIAL)
    for meeting in _meetings(tree, held, ("jaw", "steeve"), 4):
        v = _velocity(meeting.G, {stops[0].index: -1.0, stops[1].index: 0.0}, rng)
        with pytest.raises(ImpactError, match=r"jaw, steeve .*jam") as caught:
            collide(held, meeting.q, v, meeting.G, stops, [0.2, 0.2])
        assert caught.value.evidence["rates_before"] == [-1.0, 0.0]
        impact = collide(inertial, meeting.q, v, meeting.G, stops, [0.2, 0.2])
        names = ["jaw", "steeve"]
        _agrees(tree, inertial, meeting.q, v, impact, names, [0.2, 0.2], BOTH_CLOSED)
        assert min(impact.P_N.values()) > 0.0


@modes
def test_a_stop_that_moves_apart_is_not_pulled_back(opposed: Mechanism, drive: DriveMode) -> None:
    """A contact that already separates gets no impulse, though pulling at it would do for the law.

    Between opposed stops, pulling the steeve back by e of its rate opens the jaw faster than its
    rebound: a set of stops with xi >= 0 everywhere that only P >= 0 rules out. The steeve stands
    first in order, so that set is tried before the right one, the jaw alone.
    """
    tree = PlanarTree.of(opposed)
    stops = [opposed.stop(name) for name in ("steeve", "jaw")]
    indices = [stop.index for stop in stops]
    rng = np.random.default_rng(16)
    system = System(opposed, ShaftMotion(opposed, 50.0, 1.0), drive)
    for meeting in _meetings(tree, system, ("jaw", "steeve"), 4):
        v = _velocity(meeting.G, {indices[0]: 2.0, indices[1]: -0.1}, rng)
        pulled, P = _dense(tree, system, meeting.q, v, indices[:1], [0.2])
        assert P[len(meeting.G)] < 0.0
        assert (pulled[indices] + 0.2 * v[indices]).min() >= -1e-12
        impact = collide(system, meeting.q, v, meeting.G, stops, [0.2, 0.2])
        assert impact.P_N["steeve"] == 0.0
        _agrees(tree, system, meeting.q, v, impact, ["jaw"], [0.2])


def test_the_impact_condition_is_that_of_the_impulses_for_unit_jumps(e62: Mechanism) -> None:
    """Pinocchio's impulses for unit jumps of the rows are the columns of -A^-1.

    The condition number is computed from the mass matrix and a dense solution; both have to be the
    same matrix, which at the touch configuration with the jaw closed has five rows.
    """
    system = System(e62, ShaftMotion(e62, 1.0, e62.cylinder.angle_at_touch_rad))
    q, jaw = np.zeros(7), e62.stop("jaw").index
    _, jacobian = system.body.closures(q[None])
    rows = np.vstack([jacobian[0], np.eye(7)[jaw]])
    moving = [i for i in range(7) if i not in system.held_coordinates]
    columns = []
    for unit in np.eye(5):
        z = np.zeros(7)
        z[moving] = np.linalg.solve(rows[:, moving], unit)
        columns.append(-system.body.impulse_response(q, rows, z, system.drive_armature)[1])
    matrix = np.linalg.inv(np.array(columns).T)
    size = np.sqrt(np.diag(matrix))
    expected = np.linalg.cond(matrix / np.outer(size, size))
    found = impact_condition(system, q, jacobian[0], [jaw])
    assert found == pytest.approx(expected, rel=1e3 * expected * np.finfo(float).eps)


def test_rows_that_depend_on_one_another_have_an_infinite_impact_condition(
    e62: Mechanism,
) -> None:
    """Held drives leave five coordinates: four closures and two stops are one row too many."""
    system = System(e62, ShaftMotion(e62, 1.0, e62.cylinder.angle_at_touch_rad))
    _, jacobian = system.body.closures(np.zeros((1, 7)))
    stops = [stop.index for stop in e62.stops]
    assert impact_condition(system, np.zeros(7), jacobian[0], stops) > 1e14

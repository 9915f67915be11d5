"""Impact law and resting contact of random machines, against every choice of stops tried densely.

Chains of two to four free links, on the frame or on a shaken base, some tied to the frame by two
links more and a pin, with a lower and an upper stop on each joint. The linear complementarity
problems

    xi = A P + b >= 0,  P >= 0,  xi P = 0,    A = W' Z (Z' M Z)^-1 Z' W,

Z being a basis of the motions that held drives and loops leave, are solved here by trying all 2^k
sets; M and the forces are those of Pinocchio's tree, which other tests check. A is positive
definite, so exactly one set must come out, and it has to be the engine's.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pytest
from random_chains import chain

from nipper_pin.dynamics import (
    Partition,
    ShaftMotion,
    System,
    close_positions,
    closing_impulse,
    collide,
    drive_impulses,
    impact_condition,
)
from nipper_pin.dynamics.complementarity import complementary
from nipper_pin.dynamics.impact_laws import solve_impact
from nipper_pin.hybrid import State
from nipper_pin.hybrid.contact.active_set import active_set
from nipper_pin.mechanism import Stop

SEEDS = range(60)

NOW = np.zeros(1)


@dataclass(frozen=True)
class Meeting:
    """A state with some stops in contact, one a joint.

    ``lift`` turns rates of the shaft and the chain into those of all joints, shape (nv, nv); its
    columns of the links that close the loop are zero.
    """

    system: System
    q: np.ndarray
    jacobian: np.ndarray
    lift: np.ndarray
    dependent: list[int]
    contacts: list[Stop]
    rng: np.random.Generator

    def velocity(self, rates: np.ndarray) -> np.ndarray:
        """A closed velocity with these gap rates at the contacts and the shaft's own rate."""
        v = self.rng.normal(0.0, 2.0, len(self.q))
        for stop, rate in zip(self.contacts, rates, strict=True):
            v[stop.index] = stop.sense * rate
        v[self.system.driven] = self.system.shaft.driven(NOW)[1][0]
        return self.lift @ v

    @property
    def motions(self) -> np.ndarray:
        """Z, shape (nv, free)."""
        held = {*self.system.driven.tolist(), *self.dependent}
        return self.lift[:, [i for i in range(len(self.q)) if i not in held]]

    def drift(self, v: np.ndarray) -> np.ndarray:
        """Acceleration of the shaft's law, and what loops need for it and for G_dot v."""
        a = np.zeros_like(v)
        a[self.system.driven] = self.system.shaft.driven(NOW)[2][0]
        a = self.lift @ a
        if self.dependent:
            step = 1e-6
            ahead, behind = self.system.body.closures(self.q + step * np.outer([1.0, -1.0], v))[1]
            turning = (ahead - behind) @ v / (2.0 * step)
            a[self.dependent] -= np.linalg.solve(self.jacobian[:, self.dependent], turning)
        return a

    def normals(self) -> np.ndarray:
        """W, shape (nv, contacts)."""
        W = np.zeros((len(self.q), len(self.contacts)))
        for column, stop in enumerate(self.contacts):
            W[stop.index, column] = stop.sense
        return W

    def response(self) -> np.ndarray:
        """M^-1 of the free motions, shape (nv, nv)."""
        M, Z = self.system.body.mass_matrix(self.q), self.motions
        return Z @ np.linalg.solve(Z.T @ M @ Z, Z.T)


def met(seed: int) -> Meeting:
    """Two to four joints, two or more in contact, each on one side."""
    rng = np.random.default_rng(seed)
    tied = seed % 5 > 2
    mechanism = chain(rng, 2 + seed % 3, shaken=bool(seed % 2), tied=tied)
    system = System(mechanism, ShaftMotion(mechanism, 2.0 * np.pi, 0.07))
    nv = system.body.nv
    q = rng.uniform(-0.02, 0.02, nv)
    q[system.driven] = system.shaft.driven(NOW)[0][0]
    contacts: list[Stop] = []
    for joint in mechanism.joints:
        sides = [stop for stop in mechanism.stops if stop.index == joint.index]
        if sides and (rng.random() < 0.75 or len(contacts) < 2):
            contacts.append(sides[int(rng.integers(2))])
            q[joint.index] = contacts[-1].at
    loop = ("rocker_axis", "elbow")
    dependent = [joint.index for joint in mechanism.joints if joint.name in loop]
    q = close_positions(system.body, q[None], Partition.of(dependent, nv))[0][0]
    _, (jacobian,) = system.body.closures(q[None])
    lift = np.eye(nv)
    lift[:, dependent] = 0.0
    if dependent:
        lift[dependent] = -np.linalg.solve(jacobian[:, dependent], jacobian @ lift)
    return Meeting(system, q, jacobian, lift, dependent, contacts, rng)


def every_choice(A: np.ndarray, b: np.ndarray) -> list[tuple[tuple[int, ...], np.ndarray]]:
    """All sets that satisfy A P + b >= 0, P >= 0 with P zero outside of the set and xi in it."""
    found = []
    for size in range(len(b) + 1):
        for chosen in combinations(range(len(b)), size):
            P = np.zeros(len(b))
            P[list(chosen)] = np.linalg.solve(A[np.ix_(chosen, chosen)], -b[list(chosen)])
            xi = A @ P + b
            xi[list(chosen)] = 0.0
            if P.min() >= 0.0 and xi.min() >= 0.0:
                found.append((chosen, P))
    return found


@pytest.mark.parametrize("seed", SEEDS)
def test_impacts_are_the_only_complementary_ones(seed: int) -> None:
    """Impulses and velocities after equal those of the one set that satisfies the law.

    Rates before are random, some contacts closed (rate zero), at least one approaching. Exactly one
    of the 2^k sets fits, so a set that were only assumed would differ by a whole impulse. 1e-10 is
    the condition of A, below 1e5 in these machines, times round-off.
    """
    meeting = met(seed)
    system, contacts, rng = meeting.system, meeting.contacts, meeting.rng
    before = rng.normal(0.0, 1.0, len(contacts))
    before[rng.random(len(contacts)) < 0.4] = 0.0
    before[-1] = -abs(before[-1]) - 0.1
    e = np.array([stop.restitution for stop in contacts])
    v = meeting.velocity(before)
    W, inverse = meeting.normals(), meeting.response()
    A, b = W.T @ inverse @ W, (1.0 + e) * before
    assert np.linalg.cond(A) < 1e5
    solutions = every_choice(A, b)
    assert len(solutions) == 1
    chosen, P = solutions[0]
    impact = collide(system, meeting.q, v, meeting.jacobian, contacts, e.tolist())
    found = np.array([impact.P_N[stop.name] for stop in contacts])
    assert {i for i, value in enumerate(found) if value > 0.0} == set(chosen)
    assert np.abs(found - P).max() <= 1e-10 * np.abs(P).max()
    wanted = v + inverse @ W @ P
    assert np.abs(impact.v_after - wanted).max() <= 1e-10 * np.abs(wanted - v).max()
    after = np.array([stop.rate(impact.v_after) for stop in contacts])
    assert (after[list(chosen)] == -e[list(chosen)] * before[list(chosen)]).all()
    assert impact.energy_lost == pytest.approx(-0.5 * P @ (before + after), rel=1e-9)
    if len(system.driven):
        M = system.body.mass_matrix(meeting.q)
        loops = impact.P_g @ meeting.jacobian
        reaction = drive_impulses(system, meeting.q, impact.delta, impact.P_g)
        missing = (M @ (wanted - v) - W @ P - loops)[system.driven]
        assert reaction == pytest.approx(missing, rel=1e-9, abs=1e-12)
    # The law is linear in the rates; formed from whole velocities the rest would be round-off.
    slow = meeting.velocity(1e-10 * before)
    faint = collide(system, meeting.q, slow, meeting.jacobian, contacts, e.tolist())
    assert 1e10 * np.array(list(faint.P_N.values())) == pytest.approx(found, rel=1e-9)
    assert 1e20 * faint.energy_lost == pytest.approx(impact.energy_lost, rel=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_impact_condition_is_that_of_the_impulses_of_unit_jumps(seed: int) -> None:
    """Of closures and stops, each row by its own size; infinite with one row twice."""
    meeting = met(seed)
    system, stops = meeting.system, [stop.index for stop in meeting.contacts]
    moving = [i for i in range(len(meeting.q)) if i not in system.driven]
    rows = np.vstack([meeting.jacobian, np.eye(len(meeting.q))[stops]])[:, moving]
    M = system.body.mass_matrix(meeting.q)[np.ix_(moving, moving)]
    yields = rows @ np.linalg.solve(M, rows.T)
    size = np.sqrt(np.diag(yields))
    expected = np.linalg.cond(yields / np.outer(size, size))
    found = impact_condition(system, meeting.q, meeting.jacobian, stops)
    assert found == pytest.approx(expected, rel=1e3 * expected * np.finfo(float).eps)
    assert impact_condition(system, meeting.q, meeting.jacobian, [*stops, stops[0]]) > 1e14


@pytest.mark.parametrize("seed", SEEDS)
def test_strikes_in_sequence_are_single_impacts(seed: int) -> None:
    """The sum of impacts at one contact each, by the engine's own law, until none approaches.

    That of the largest r^2 / A_ii comes first, M^-1 and loops by the dense matrices. Each impact is
    right to 1e-10, as above, and there are no more than hundreds.
    """
    meeting = met(seed)
    system, contacts, rng = meeting.system, meeting.contacts, meeting.rng
    before = rng.normal(0.0, 1.0, len(contacts))
    before[0] = -abs(before[0]) - 0.1
    v = meeting.velocity(before)
    W = meeting.normals()
    A = np.diag(W.T @ meeting.response() @ W)
    now, P = v, dict.fromkeys((stop.name for stop in contacts), 0.0)
    lost = 0.0
    for _ in range(3000):
        rates = np.array([stop.rate(now) for stop in contacts])
        first = int((rates / np.sqrt(A)).argmin())
        if rates[first] >= -1e-12:
            break
        stop = contacts[first]
        one = collide(system, meeting.q, now, meeting.jacobian, [stop], [stop.restitution])
        now, lost = one.v_after, lost + one.energy_lost
        P[stop.name] += one.P_N[stop.name]
    found = solve_impact(system, meeting.q, v, meeting.jacobian, contacts, "sequential")
    assert np.abs(found.v_after - now).max() <= 1e-9 * np.abs(v).max()
    assert list(found.P_N.values()) == pytest.approx(list(P.values()), rel=1e-9, abs=1e-9)
    assert found.energy_lost == pytest.approx(lost, rel=1e-9, abs=1e-9)
    assert np.abs(meeting.jacobian @ found.v_after).max(initial=0.0) <= 1e-10 * np.abs(v).max()
    M = system.body.mass_matrix(meeting.q)
    left = M @ found.delta - W @ list(found.P_N.values()) - found.P_g @ meeting.jacobian
    left[system.driven] = 0.0
    assert np.abs(left).max() <= 1e-9 * np.abs(M @ found.delta).max()


@pytest.mark.parametrize("seed", SEEDS)
def test_resting_contacts_are_the_only_complementary_ones(seed: int) -> None:
    """Stops at rest that stay closed are those of the one set with forces and accelerations >= 0.

    Springs are preloaded either way and the other joints move, so some stops push and others are
    left; a stop that leaves alone may stay closed because another one leaves, and the reverse.
    """
    meeting = met(seed)
    system, contacts = meeting.system, meeting.contacts
    v = meeting.velocity(np.zeros(len(contacts)))
    drift = meeting.drift(v)
    q = meeting.q[None]
    missing = system.body.inverse_dynamics(q, v[None], drift[None])[0]
    force = system.applied_forces(q, v[None])[0] - missing
    W, inverse = meeting.normals(), meeting.response()
    solutions = every_choice(W.T @ inverse @ W, W.T @ (inverse @ force + drift))
    assert len(solutions) == 1
    names = frozenset(stop.name for stop in contacts)
    motion = system.shaft.driven(NOW)
    state = State(0.0, meeting.q, v, meeting.jacobian, motion, names)
    found = active_set(system, state, names)
    assert found == {contacts[i].name for i in solutions[0][0]}


@pytest.mark.parametrize("seed", SEEDS)
def test_a_series_ends_without_moving_the_other_closed_stops(seed: int) -> None:
    """At its limit a stop loses its rate while the closed ones keep theirs, zero.

    The change is M^-1 W P with both rates prescribed, by a dense solution; the bare plastic impact
    of one stop would make the others move, by a share of order one in these chains.
    """
    meeting = met(seed)
    rates = np.zeros(len(meeting.contacts))
    rates[0] = 1e-5
    v = meeting.velocity(rates)
    W, inverse = meeting.normals(), meeting.response()
    P = np.linalg.solve(W.T @ inverse @ W, -rates)
    first, *closed = meeting.contacts
    impact = closing_impulse(meeting.system, meeting.q, v, meeting.jacobian, [first, *closed])
    assert [stop.rate(impact.v_after) for stop in meeting.contacts] == [0.0] * len(rates)
    wanted = inverse @ W @ P
    assert np.abs(impact.delta - wanted).max() <= 1e-10 * np.abs(wanted).max()
    alone = closing_impulse(meeting.system, meeting.q, v, meeting.jacobian, [first])
    moved = max(abs(stop.rate(alone.v_after)) for stop in closed)
    assert moved > 0.0


@pytest.mark.parametrize("seed", range(40))
def test_the_choice_is_that_of_all_choices(seed: int) -> None:
    """Units of the coordinates differ by up to 1e4; the same set gives the same bits."""
    rng = np.random.default_rng(seed)
    n = 1 + seed % 8
    root = rng.normal(size=(n, n)) * 10.0 ** rng.uniform(-2.0, 2.0, n)
    b = rng.normal(size=n) * 10.0 ** rng.uniform(-2.0, 2.0, n)
    A = root.T @ root
    ((_, right),) = every_choice(A, b)
    assert np.array_equal(complementary(A, b), right)


@pytest.mark.parametrize("seed", range(40))
def test_of_dependent_stops_a_few_carry_all(seed: int) -> None:
    """A has a lower rank than rows; P is that of min |B P + c|^2 / 2, P >= 0, with A = B' B.

    b = B' c makes A P + b >= 0 possible always. The conditions hold to the round-off of sums of
    eight terms, 1e-13 of the largest, and no more stops carry than there are directions.
    """
    rng = np.random.default_rng(seed)
    n = 2 + seed % 7
    rank = int(rng.integers(1, n))
    B, c = rng.normal(size=(rank, n)), rng.normal(size=rank)
    P = complementary(B.T @ B, B.T @ c)
    assert P is not None
    xi = B.T @ (B @ P + c)
    scale = 1e-12 * max(np.abs(B.T @ B) @ P + np.abs(B.T @ c))
    assert P.min() >= 0.0
    assert xi.min() >= -scale
    assert np.abs(xi * P).max() <= scale * max(P.max(), 1.0)
    assert np.count_nonzero(P) <= rank


@pytest.mark.parametrize(
    ("A", "b"),
    [
        ([[1.0, -1.0], [-1.0, 1.0]], [-1.0, -1.0]),  # a link that two held walls squeeze
        ([[0.0]], [-1.0]),  # one that nothing moves
        ([[0.0, 0.0], [0.0, 2.0]], [-1.0, -1.0]),
    ],
)
def test_what_is_jammed_has_no_impulses(A: list[list[float]], b: list[float]) -> None:
    assert complementary(np.array(A), np.array(b)) is None


@pytest.mark.parametrize("n", [13, 40, 80])
def test_many_stops_take_no_search(n: int) -> None:
    """Balls in a row, each with the relative slide to the last one: A is (-1, 2, -1).

    The first pair approaches with 1 and no one else, so that all contacts have to take an impulse
    of (n - i) / (n + 1). 2^80 sets could not be tried.
    """
    A = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    b = np.zeros(n)
    b[0] = -1.0
    wanted = (n - np.arange(n)) / (n + 1.0)
    # Its condition is 4 (n + 1)^2 / pi^2, below 3000.
    assert complementary(A, b) == pytest.approx(wanted, rel=3000 * 2.3e-16)

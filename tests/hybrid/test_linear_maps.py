"""Small changes through flights and impacts, by linear maps and by neighbouring motions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from random_chains import chain
from rows_of_balls import row
from small_machines import link, machine, slide, turn

import nipper_pin as nip
from nipper_pin import Case, DriveMode, EventKind, Resolution, Solution, load, simulate
from nipper_pin.dynamics import ShaftMotion, System
from nipper_pin.hybrid.error_estimate.saltation import impact_map, sequence_map
from nipper_pin.hybrid.error_estimate.variational import flight_map, free_coordinates
from nipper_pin.hybrid.error_estimate.zonotope import NOTHING_KNOWN, Zonotope

CHANGE = 1e-6
# Seed, freedoms, whether tied, a stop that is struck early, and what the base's shaft does.
CHAINS = (
    (8, 2, False, "j1 upper", DriveMode.HELD), (0, 3, False, "j2 upper", DriveMode.INERTIAL),
    (1, 3, True, "j2 lower", DriveMode.INERTIAL), (10, 2, True, "j1 upper", DriveMode.HELD),
)  # fmt: skip


def _chain(
    restitution: float, *, seed: int, free: int, tied: bool, stop: str, drive: DriveMode
) -> Solution:
    """A chain on a rocking base, with stops on both sides of its joints; tied, it is a loop."""
    swinging = chain(np.random.default_rng(seed), free, shaken=True, tied=tied)
    changed = nip.changed(swinging, {f"stops.{stop}.restitution": restitution})
    return turn(changed, tolerance=1e-13, max_collisions=7, drive=drive)


def _nipper(restitution: float, drive: DriveMode = DriveMode.HELD) -> Solution:
    """The transition of the E62-class nipper: two loops, and shafts that are held or yield."""
    case = Case(speed_rpm=650.0, drive=drive, resolution=Resolution(tolerance=1e-13))
    return simulate(load("e62", {"stops.jaw.restitution": restitution}), case)


def _derivatives(solution: Solution, name: str) -> list[tuple[float, float]]:
    """Derivatives of the times of all collisions and of their impulses, by a restitution."""
    system, mechanism, nv = solution.system, solution.mechanism, solution.system.body.nv
    found = Zonotope(np.zeros((2 * nv, 1)), np.zeros(1), np.zeros(1))
    segments, derivatives = list(solution.segments), []
    for event in solution.events:
        if event.kind is not EventKind.COLLISION:
            break
        while segments and segments[0].t_end <= event.t:
            segment = segments.pop(0)
            first = segment.panels[0]
            found = found.later(-found.late, np.concatenate([first.v[0], first.a[0]]))
            rows = system.constraint_set(segment.closed)
            for panel, begin, end in segment.pieces():
                found = found.through(flight_map(system, rows, panel, end - begin)[0])
            rows = system.constraint_set(event.closed_before)
            motion = system.shaft.driven(np.array([event.t]))
            a = system.accelerations(motion, event.q[None], event.v_before[None], rows)[0]
            stop = mechanism.stop(event.stops[0])
            late = -found.states[stop.index] / event.v_before[stop.index]
            found = found.later(late, np.concatenate([event.v_before, a]))
            assert found.states[stop.index] == pytest.approx([0.0], abs=1e-12)
        stop = mechanism.stop(event.stops[0])
        matrix, pushes = impact_map(system, event.q, event.v_before, [stop], [stop.restitution])
        impulse = float((pushes @ found.states)[0, 0])
        found = found.through(matrix)
        if stop.name == name:
            # v+ = v- + (1 + e) times something that e does not change; so the impulse.
            found.states[nv:, 0] += event.delta / (1.0 + stop.restitution)
            impulse += event.P_N[name] / (1.0 + stop.restitution)
        derivatives.append((float(found.late[0]), impulse))
    return derivatives


@pytest.mark.parametrize(
    ("run", "stop", "restitution"),
    [
        *(
            (partial(_chain, seed=seed, free=free, tied=tied, stop=stop, drive=drive), stop, 0.6)
            for seed, free, tied, stop, drive in CHAINS
        ),
        *((partial(_nipper, drive=drive), "jaw", 0.3) for drive in DriveMode),
    ],
)
def test_changes_of_times_and_impulses_are_those_of_a_neighbouring_motion(
    run: Callable[[float], Solution], stop: str, restitution: float
) -> None:
    """A second run of the whole engine, whose restitution is larger by 1e-6.

    That changes what follows collisions and nothing else. Of differences of first order 1e-6 is
    left, and errors of 1e-13 over changes of 1e-6. Each collision multiplies what those before it
    have done, so a wrong sign or a lost term in one map shows in all later ones.
    """
    base, other = run(restitution), run(restitution + CHANGE)
    derivatives = _derivatives(base, stop)
    assert len(derivatives) > 3
    for number, (late, impulse) in enumerate(derivatives):
        one, two = base.events[number], other.events[number]
        assert one.stops == two.stops
        name = one.stops[0]
        assert (two.t - one.t) / CHANGE == pytest.approx(late, rel=1e-3, abs=1e-7 * one.t)
        changed = (two.P_N[name] - one.P_N[name]) / CHANGE
        assert changed == pytest.approx(impulse, rel=1e-3, abs=1e-6 * one.P_N[name])
    assert abs(derivatives[-1][0]) > 1e-4 * base.events[len(derivatives) - 1].t


def test_errors_of_a_ballistic_flight_grow_with_its_length() -> None:
    """(1, T; 0, 1): an error of the rate moves the ball by T times as much and stays the same.

    Differences of accelerations that do not depend on anything are round-off over the step of 1e-6:
    1e-16 g / 1e-6, times T^2, is below 1e-9.
    """
    floor = {"joint": "z", "restitution": 0.5, "at_mm": -500.0}
    parts = [link("ball"), slide("z", "frame", "ball", (0.0, 1.0))]
    solution = turn(machine(parts, 1, gravity=9.81, stops={"floor": floor}))
    segment, system = solution.segments[0], solution.system
    rows, whole = system.constraint_set(segment.closed), np.eye(2)
    for panel, begin, end in segment.pieces():
        assert free_coordinates(rows, panel.split) == [0]
        whole = flight_map(system, rows, panel, end - begin)[0] @ whole
    length = segment.t_end - segment.t_start
    np.testing.assert_allclose(whole, [[1.0, length], [0.0, 1.0]], rtol=0.0, atol=1e-8)


@pytest.mark.parametrize(("e", "f"), [(1.0, 1.0), (0.9, 0.8)])
def test_the_map_of_a_cannon_is_the_product_of_its_two_strikes(e: float, f: float) -> None:
    """Floor, then pair: both are linear in the rates of the gaps, and nothing depends on places.

    With 3 kg below 1 kg the floor changes the rates (w, r) to (-e w, r + (1 + e) w), the pair then
    to (-e w + (1 + f) r' / 4, -f r'). Impulses: 3 (1 + e) w of the lower ball and what it gets
    from the pair, whose reduced mass is 3/4 kg. Differences of linear functions are exact but for
    round-off by a step of 1e-6.
    """
    mechanism = row([3.0, 1.0], [e, f], wall=True, law="sequential")
    system = System(mechanism, ShaftMotion(mechanism, 1.0, 0.0))
    contacts = list(mechanism.stops)
    matrix, pushes = sequence_map(
        system, np.zeros(2), np.array([-1.0, 0.0]), contacts, contacts
    )  # fmt: skip
    floor = np.array([[-e, 0.0], [1.0 + e, 1.0]])
    pair = np.array([[1.0, (1.0 + f) / 4.0], [0.0, -f]])
    wanted = np.eye(4)
    wanted[2:, 2:] = pair @ floor
    assert matrix == pytest.approx(wanted, abs=1e-9)
    impulses = np.array([[-3.0 * (1.0 + e), 0.0], -(1.0 + f) * 0.75 * floor[1]])
    assert pushes[:, :2] == pytest.approx(np.zeros((2, 2)), abs=1e-9)
    assert pushes[:, 2:] == pytest.approx(impulses, abs=1e-9)


def _extent(found: Zonotope, direction: np.ndarray) -> float:
    """How far the set reaches in a direction of (dq, dv, dt, dt): what determines a convex set."""
    columns = np.vstack([found.states, found.late, found.before])
    return float(np.abs(direction @ columns).sum())


@pytest.mark.parametrize("rows", [6, 8, 24, 40])
def test_sets_stay_close_to_the_deviations_that_they_stand_for(rows: int) -> None:
    """Sixty maps, each of which brings two deviations of every row: a long flight of a chain.

    In every direction a merged set reaches as far as the deviations do, and of no row farther than
    one merging into a box may; rows differ by 1e9 in size, as places, rates and times do.
    """
    random = np.random.default_rng(rows)
    sizes = 10.0 ** random.uniform(-9.0, 0.0, (rows, 1))
    whole = merged = Zonotope.of(np.zeros((rows, 0)))
    for _ in range(60):
        turned, _ = np.linalg.qr(random.normal(size=(rows, rows)))
        turned = sizes * turned / sizes.T
        own = sizes * np.hstack([np.eye(rows), 0.1 * random.normal(size=(rows, rows))])
        one = replace(Zonotope.of(own), late=1e-6 * random.normal(size=2 * rows))
        whole = whole.through(turned).joined(one)
        merged = merged.through(turned).joined(one).merged()
    assert merged.states.shape[1] <= 16 * (rows + 2)
    for direction in random.normal(size=(300, rows + 2)) / np.vstack([sizes, [[1e-8]] * 2]).T:
        assert _extent(merged, direction) >= _extent(whole, direction) * (1.0 - 1e-9)
    for place in range(rows):
        assert merged.size(place) <= np.sqrt(rows + 2) * 1.5 * whole.size(place)


def test_signs_are_kept_through_maps() -> None:
    """An eighth of a turn, eight times: the set is what it was, and not 16 times as large.

    A rotation by 45 degrees makes a box sqrt(2) larger each time that signs are forgotten.
    """
    eighth = np.array([[1.0, -1.0], [1.0, 1.0]]) / np.sqrt(2.0)
    found = Zonotope.independent(np.array([1.0]), np.array([2.0]))
    for _ in range(8):
        found = found.through(eighth).merged()
    assert [found.size(row) for row in (0, 1)] == pytest.approx([1.0, 2.0], rel=1e-14)


def test_what_grows_beyond_all_motion_is_unknown_and_does_not_overflow() -> None:
    found = Zonotope.independent(np.array([1.0]), np.array([1.0]))
    for _ in range(5):
        found = found.through(np.full((2, 2), 1e90)).merged()
    assert np.isfinite(found.states).all()
    assert found.size(0) >= NOTHING_KNOWN


def test_one_position_or_rate_is_kept_within_a_limit() -> None:
    """What a stop determines is known there, and no more of the others than before."""
    found = Zonotope.independent(np.array([3.0]), np.array([2.0])).through(np.ones((2, 2)))
    limited = found.within(0, 0.5)
    assert limited.size(0) == pytest.approx(0.5)
    assert limited.size(1) == found.size(1) == 5.0
    assert found.within(0, 10.0) is found

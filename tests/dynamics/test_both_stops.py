"""Both stops of the E62 closed at once: legal with shafts that give way, never with held drives.

Seven coordinates less four closure rows less two stops leave one freedom. Held drives would take
two more; shafts with a finite inertia then follow from one another through the links.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np
import pytest
from dense import close
from test_constrained_accelerations import kkt

from benchmarks.stress.mechanics.planar_tree import PlanarTree
from nipper_pin import DriveMode, Mechanism, load
from nipper_pin.dynamics import ShaftMotion, System
from nipper_pin.dynamics.multipliers import multipliers
from nipper_pin.hybrid.contact.complementarity import pressed

BOTH = frozenset({"jaw", "steeve"})
DRIVES = ("pendulum", "tension")
# The condition of the linear system is 3.5e4 after scaling, so each rounding of its 13 unknowns may
# be 8e-12 of the largest acceleration: last digits of a state move the engine's by 2e-11.
RELATIVE = 1e-10


class State(NamedTuple):
    """A configuration with both gaps zero, a velocity along the one freedom, and any law."""

    closed: frozenset[str]
    q: np.ndarray
    v: np.ndarray
    motion: tuple[np.ndarray, np.ndarray, np.ndarray]


def both_closed(mechanism: Mechanism, tree: PlanarTree, count: int, seed: int) -> list[State]:
    """Random states with both gaps zero: anywhere along the one freedom, with any law."""
    rng = np.random.default_rng(seed)
    driven = [drive.index for drive in mechanism.drives]
    stops = [stop.index for stop in mechanism.stops]
    free = [i for i in range(tree.nv) if i not in (driven[0], *stops)]
    found = []
    for _ in range(count):
        q = np.zeros(tree.nv)
        # In small steps from touch, where everything is zero.
        for angle in np.linspace(0.0, rng.uniform(-0.3, 0.2), 9)[1:]:
            q[driven[0]] = angle
            q = close(tree, q, free)
        G = tree.closure_jacobian(q)
        v = np.zeros(tree.nv)
        v[driven[0]] = rng.uniform(-6.0, 6.0)
        v[free] = -np.linalg.solve(G[:, free], G[:, driven[0]] * v[driven[0]])
        motion = (
            q[None, driven] + rng.uniform(-0.3, 0.3, 2),
            v[None, driven] + rng.uniform(-5.0, 5.0, 2),
            rng.uniform(-2e3, 2e3, (1, 2)),
        )
        found.append(State(BOTH, q, v, motion))
    return found


def solved(mechanism: Mechanism, tree: PlanarTree, state: State, closed: frozenset[str]):  # type: ignore[no-untyped-def]
    """Accelerations and stop forces along the gaps by the dense KKT system, shafts giving way."""
    chosen = State(closed, state.q, state.v, state.motion)
    a, y, torques = kkt(mechanism, tree, chosen, held=False)
    senses = np.array([stop.sense for stop in mechanism.stops if stop.name in closed])
    return a, y[: tree.nv - 3], y[tree.nv - 3 :] * senses, np.array(torques)


def test_forces_of_both_stops(mechanism: Mechanism, tree: PlanarTree) -> None:
    """Accelerations, closure forces, stop forces and torques are those of the dense KKT system.

    That has its own mass matrix and its own closures. Torques, which act on coordinates that here
    depend on one another, are of 1e3 N m, so leaving them out of the balance would show.
    """
    system = System(mechanism, ShaftMotion(mechanism, 50.0, 1.0), DriveMode.INERTIAL)
    rows = system.constraint_set(BOTH)
    assert rows.freedom == 1
    for state in both_closed(mechanism, tree, 12, 3):
        q, v = state.q[None], state.v[None]
        a = system.accelerations(state.motion, q, v, rows)
        _, jacobian = system.body.closures(q)
        split = system.split(jacobian[0], rows.given, rows.yielding)
        # The closures leave room for one of the shafts only.
        assert len(set(split.dependent) & set(system.driven.tolist())) == 1
        forces = multipliers(system, state.motion, q, v, a, jacobian, rows, split)
        expected, la_g, la_N, torques = solved(mechanism, tree, state, BOTH)
        assert np.abs(a[0] - expected).max() <= RELATIVE * np.abs(expected).max()
        scale = RELATIVE * np.abs([*la_g, *la_N, *torques]).max()
        assert np.abs(forces.la_g[0] - la_g).max() <= scale
        assert np.abs(forces.la_N[0] - la_N).max() <= scale
        assert np.abs(forces.drive[0] - torques).max() <= scale


@pytest.mark.slow
def test_which_stay_closed() -> None:
    """Of both stops at rest those stay closed that a complementary KKT solution keeps closed.

    All four sets are tried with the dense system; one of them alone has forces and departures that
    are not negative. Each of the sets, both stops among them, is the answer somewhere.
    """
    sets = [frozenset(chosen) for size in range(3) for chosen in combinations(sorted(BOTH), size)]
    answers = []
    for preload in (5.0, 200.0):
        changes = {f"drives.{name}.reflected_inertia_kg_m2": 0.02 for name in DRIVES}
        mechanism = load("e62", {"springs.steeve.preload_length_mm": preload, **changes})
        tree = PlanarTree.of(mechanism)
        system = System(mechanism, ShaftMotion(mechanism, 50.0, 1.0), DriveMode.INERTIAL)
        for state in both_closed(mechanism, tree, 40, 5):
            legal = []
            for closed in sets:
                a, _, la_N, _ = solved(mechanism, tree, state, closed)
                leaving = [s.rate(a) for s in mechanism.stops if s.name not in closed]
                if min([*la_N, *leaving]) >= 0.0:
                    legal.append(closed)
            _, jacobian = system.body.closures(state.q[None])
            found = pressed(system, state.motion, state.q, state.v, jacobian[0], BOTH)
            assert legal == [found]
            answers.append(found)
    assert set(answers) == set(sets)


def test_held_drives_never_keep_both(mechanism: Mechanism, tree: PlanarTree) -> None:
    """Held drives and both stops are one row too many: one of them opens, whatever presses."""
    system = System(mechanism, ShaftMotion(mechanism, 50.0, 1.0), DriveMode.HELD)
    assert system.constraint_set(BOTH).freedom == -1
    for state in both_closed(mechanism, tree, 12, 7):
        _, jacobian = system.body.closures(state.q[None])
        assert pressed(system, state.motion, state.q, state.v, jacobian[0], BOTH) < BOTH


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_limit_of_large_inertia(tree: PlanarTree, seed: int) -> None:
    """What the shafts do not give way to grows with their inertia, and the choice is the held one.

    With both stops closed the links make the shafts follow one another, so a law that would not
    needs forces in proportion to the inertia: slope 1. A held drive taken as one that gives way, or
    the reverse, has slope 0.
    """
    scales = 10.0 ** np.arange(2.0, 6.0)
    sizes = []
    for scale in scales:
        changes = {f"drives.{name}.reflected_inertia_kg_m2": float(scale) for name in DRIVES}
        mechanism = load("e62", changes)
        (state,) = both_closed(mechanism, tree, 1, seed)
        inertial, held = (
            System(mechanism, ShaftMotion(mechanism, 50.0, 1.0), mode)
            for mode in (DriveMode.INERTIAL, DriveMode.HELD)
        )
        # The law is where the shafts are: what is left to disagree on are accelerations.
        driven = inertial.driven
        motion = (state.q[None, driven], state.v[None, driven], state.motion[2])
        q, v = state.q[None], state.v[None]
        _, jacobian = inertial.body.closures(q)
        rows = inertial.constraint_set(BOTH)
        a = inertial.accelerations(motion, q, v, rows)
        split = inertial.split(jacobian[0], rows.given, rows.yielding)
        la_N = multipliers(inertial, motion, q, v, a, jacobian, rows, split).la_N[0]
        sizes.append(np.abs(la_N).max())
        # One of the two forces pulls, so both stops are not kept.
        assert la_N.min() < 0.0
        choices = {
            pressed(system, motion, state.q, state.v, jacobian[0], BOTH)
            for system in (inertial, held)
        }
        assert len(choices) == 1
        assert len(next(iter(choices))) <= 1
    slope = np.polyfit(np.log10(scales), np.log10(sizes), 1)[0]
    assert slope == pytest.approx(1.0, abs=0.05)

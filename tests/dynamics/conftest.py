"""Closed states of the E62, taken from all over its working range."""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))

from dense import close

from benchmarks.stress.mechanics.planar_tree import PlanarTree
from nipper_pin import Case, DriveMode, Mechanism, simulate
from nipper_pin.dynamics import ShaftMotion, System


@dataclass(frozen=True)
class State:
    """A closed configuration with a closed velocity and an arbitrary drive motion."""

    closed: frozenset[str]
    q: np.ndarray
    v: np.ndarray
    motion: tuple[np.ndarray, np.ndarray, np.ndarray]


@pytest.fixture(scope="session")
def mechanism(e62: Mechanism) -> Mechanism:
    return e62


@pytest.fixture(scope="session")
def tree(mechanism: Mechanism) -> PlanarTree:
    return PlanarTree.of(mechanism)


@pytest.fixture(scope="session")
def make_system(mechanism: Mechanism) -> Callable[[DriveMode], System]:
    def make(drive: DriveMode = DriveMode.HELD) -> System:
        return System(mechanism, ShaftMotion(mechanism, 50.0, 1.0), drive)

    return make


@pytest.fixture(scope="session")
def states(mechanism: Mechanism, tree: PlanarTree) -> list[State]:
    """Twelve random states in each phase: anywhere in the cycle, any velocity the closures allow.

    The loops are closed by the test's own Newton iteration.
    """
    rng = np.random.default_rng(20)
    run = simulate(mechanism, Case(speed_rpm=450.0, window="cycle"))
    driven = [drive.index for drive in mechanism.drives]
    found = []
    for closed in (phase.closed for phase in mechanism.phases):
        stops = [stop.index for stop in mechanism.stops if stop.name in closed]
        for t in rng.uniform(*run.trajectory.span, 12):
            q = run.trajectory.evaluate(t).q[0]
            # The opened gap of a phase is any gap that the machine shows at this drive position.
            q[driven] += rng.uniform(-0.02, 0.02, len(driven))
            q[stops] = 0.0
            kept = sorted({*driven, *stops})
            q = close(tree, q, [i for i in range(tree.nv) if i not in kept])
            G = tree.closure_jacobian(q)
            v = rng.uniform(-8.0, 8.0, tree.nv)
            rows = np.vstack([G, np.eye(tree.nv)[stops]])
            v -= np.linalg.pinv(rows) @ (rows @ v)
            v -= np.linalg.pinv(rows) @ (rows @ v)
            v[stops] = 0.0
            motion = (
                q[None, driven] + rng.uniform(-0.01, 0.01, len(driven)),
                v[None, driven] + rng.uniform(-0.5, 0.5, len(driven)),
                rng.uniform(-2e3, 2e3, (1, len(driven))),
            )
            found.append(State(closed, q, v, motion))
    return found

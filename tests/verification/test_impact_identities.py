"""Impulse and momentum of every collision of whole cycles and transitions.

What the engine reports is compared with the links' momenta by planar geometry (`planar_tree`),
which knows nothing of Pinocchio. Impulses of late bounces are 1e-5 of the first one, and
M (v+ - v-) is formed from velocities whose last digit is eps |v|, so a tolerance is 1e-11 of the
impulses plus a few eps of the momenta themselves.
"""

from collections.abc import Iterator

import numpy as np
import pytest

from benchmarks.stress.mechanics.planar_tree import PlanarTree
from nipper_pin import Case, Event, EventKind, Mechanism, Solution, simulate
from nipper_pin.dynamics import drive_impulses

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
    """M (v+ - v-) = G' P_g + W' P_N + S' P_drive at every collision, and G v = 0 on both sides.

    Each of the terms is of the size of the jump, so none can be missing or of the wrong sign.
    """
    for event in collisions(run):
        M, G = inertia(run, tree, event), tree.closure_jacobian(event.q)
        for v in (event.v_before, event.v_after):
            assert np.abs(G @ v).max() <= 1e-13 * np.abs(v).max()
        impulse = G.T @ event.P_g
        for name, P in event.P_N.items():
            impulse[run.mechanism.stop(name).index] += P
        of_drives = drive_impulses(run.system, event.q, event.delta, event.P_g)
        impulse[run.system.driven] += of_drives
        gained = M @ (event.v_after - event.v_before)
        scale = np.abs(gained).max()
        floor = ROUNDING * (np.abs(M) @ np.abs(event.v_before)).max()
        assert np.abs(gained - impulse).max() <= RELATIVE * scale + floor
        assert np.abs(event.P_g).max() > 0.0
        assert run.system.held == bool(of_drives.any())


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

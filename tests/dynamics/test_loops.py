"""Closures of many configurations at once, and one by one by Pinocchio."""

import numpy as np
import pytest

from benchmarks.stress.space import trial
from nipper_pin import Mechanism
from nipper_pin.dynamics import Multibody
from nipper_pin.dynamics.loops import Loops
from nipper_pin.mechanism.drawing import drawn_mechanism
from nipper_pin.mechanism.gallery import GALLERY, drawn
from nipper_pin.tolerances.mechanics import EPS

STATES = 5
# Sums of a few dozen products, each with a rounding of its own.
ROUNDINGS = 40.0 * EPS


def _agree(mechanism: Mechanism) -> None:
    """Gaps, Jacobians and accelerations, at loops that stand open: no term vanishes by itself."""
    body = Multibody(mechanism)
    q, v, a = np.random.default_rng(5).uniform(-1.0, 1.0, (3, STATES, body.nv))
    singly = [body.closures(row[None]) for row in q]
    alone = [
        body.closure_accelerations(*(state[None] for state in states))[0]
        for states in zip(q, v, a, strict=True)
    ]
    gaps, jacobians = body.closures(q)
    # Lengths of the links, slides by up to one metre, and two rates of up to nv each.
    size = body.reach_m + body.nv
    assert np.abs(gaps - np.concatenate([one[0] for one in singly])).max() <= ROUNDINGS * size
    assert np.abs(jacobians - np.concatenate([one[1] for one in singly])).max() <= ROUNDINGS * size
    found = body.closure_accelerations(q, v, a)
    assert np.abs(found - alone).max() <= ROUNDINGS * size * body.nv**2


@pytest.mark.parametrize("name", GALLERY)
def test_of_the_machines_of_the_gallery(name: str) -> None:
    mechanism = drawn_mechanism(drawn(name))
    if mechanism.closures:
        _agree(mechanism)


@pytest.mark.parametrize("number", range(40))
def test_of_random_machines(number: int) -> None:
    """Mirror images turn about -y; chains have slides, and frames that stand askew."""
    drawn_at_random = trial(11, number)
    mirrored = drawn_at_random.mirror_image()
    for mechanism in (drawn_at_random.mechanism(), mirrored):
        if mechanism is not None and mechanism.closures:
            _agree(mechanism)


def test_of_the_e62(e62: Mechanism) -> None:
    _agree(e62)


def test_of_no_configuration(e62: Mechanism) -> None:
    """A motion that the drives determine has no tangent to follow."""
    body = Multibody(e62)
    none = np.empty((0, body.nv))
    loops = Loops(e62.model, body.cuts)
    gaps, jacobians = loops.closures(none)
    rows = (0, body.closure_rows)
    assert (gaps.shape, jacobians.shape) == (rows, (*rows, body.nv))
    assert loops.accelerations(none, none, none).shape == rows

"""Sets of deviations: merging columns never loses a deviation, and adds few."""

from __future__ import annotations

import numpy as np
import pytest

from nipper_pin.hybrid.error_estimate.zonotope import NOTHING_KNOWN, Deviations


def _extent(found: Deviations, direction: np.ndarray) -> float:
    """How far the set reaches in a direction of (dq, dv, dt, dt): what determines a convex set."""
    columns = np.vstack([found.states, found.late, found.before])
    return float(np.abs(direction @ columns).sum())


@pytest.mark.parametrize("seed", range(5))
def test_a_merged_set_contains_the_one_that_it_stands_for(seed: int) -> None:
    """In 300 random directions, with rows that differ by 1e9 in size as positions and rates do.

    The bound above: a box along the principal directions of K columns in r rows reaches at most
    sqrt(r) times as far as they do, and the kept columns reach as far as before.
    """
    random = np.random.default_rng(seed)
    rows = 6
    sizes = 10.0 ** random.uniform(-9.0, 0.0, (rows, 1))
    columns = sizes * (random.normal(size=(rows, rows)) @ random.normal(size=(rows, 400)))
    columns *= 10.0 ** random.uniform(-4.0, 0.0, 400)
    whole = Deviations(columns[:-2], columns[-2], columns[-1])
    merged = whole.merged()
    assert merged.states.shape[1] <= 16 * rows
    growth = []
    for direction in random.normal(size=(300, rows)) / sizes.T:
        exact, found = _extent(whole, direction), _extent(merged, direction)
        assert found >= exact * (1.0 - 1e-9)
        growth.append(found / exact)
    assert max(growth) <= np.sqrt(rows) * 1.5


def test_signs_are_kept_through_maps() -> None:
    """An eighth of a turn, eight times: the set is what it was, and not 16 times as large.

    A rotation by 45 degrees makes a box sqrt(2) larger each time that signs are forgotten.
    """
    turn = np.array([[1.0, -1.0], [1.0, 1.0]]) / np.sqrt(2.0)
    found = Deviations.independent(np.array([1.0]), np.array([2.0]))
    for _ in range(8):
        found = found.through(turn).merged()
    assert found.size(0) == pytest.approx(1.0, rel=1e-14)
    assert found.size(1) == pytest.approx(2.0, rel=1e-14)


@pytest.mark.parametrize("rows", [8, 24, 40])
def test_sets_of_many_dimensions_stay_close_to_the_deviations_that_they_stand_for(
    rows: int,
) -> None:
    """Sixty maps, each of which brings two deviations of every row: a long flight of a chain.

    All of them together may make the set larger by what one merging into a box may, as above.
    """
    random = np.random.default_rng(rows)
    whole = merged = Deviations.of(np.zeros((rows, 0)))
    for _ in range(60):
        turn, _ = np.linalg.qr(random.normal(size=(rows, rows)))
        own = Deviations.of(np.hstack([np.eye(rows), 0.1 * random.normal(size=(rows, rows))]))
        whole = whole.through(turn).joined(own)
        merged = merged.through(turn).joined(own).merged()
    for row in range(rows):
        exact, found = whole.size(row), merged.size(row)
        assert exact * (1.0 - 1e-12) <= found <= np.sqrt(rows) * 1.5 * exact


def test_what_grows_beyond_all_motion_is_unknown_and_does_not_overflow() -> None:
    found = Deviations.independent(np.array([1.0]), np.array([1.0]))
    for _ in range(5):
        found = found.through(np.full((2, 2), 1e90)).merged()
    assert np.isfinite(found.states).all()
    assert found.size(0) >= NOTHING_KNOWN


def test_one_position_or_rate_is_kept_within_a_limit() -> None:
    """What a stop determines is known there, and no more of the others than before."""
    found = Deviations.independent(np.array([3.0]), np.array([2.0])).through(np.ones((2, 2)))
    limited = found.within(0, 0.5)
    assert limited.size(0) == pytest.approx(0.5)
    assert limited.size(1) == found.size(1) == 5.0
    assert found.within(0, 10.0) is found

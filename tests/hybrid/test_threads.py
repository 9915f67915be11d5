"""One mechanism, simulated in several threads at once: each run has the bits of a run alone."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from nipper_pin import Case, load, simulate


def test_threads_share_a_mechanism() -> None:
    """Eight threads, three cases each of another speed; a shared `pin.Data` would mix them up."""
    mechanism = load("e62")
    cases = [Case(speed_rpm=450.0 + 25.0 * k) for k in range(8)]
    alone = [simulate(mechanism, case).events for case in cases]
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(lambda case: simulate(mechanism, case).events, cases * 3))
    for events, expected in zip(together, alone * 3, strict=True):
        assert len(events) == len(expected) > 2
        for one, other in zip(events, expected, strict=True):
            assert (one.t, one.kind, one.P_N) == (other.t, other.kind, other.P_N)
            assert np.array_equal(one.q, other.q)
            assert np.array_equal(one.v_after, other.v_after)

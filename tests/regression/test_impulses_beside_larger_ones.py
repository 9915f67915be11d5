"""Found by the stress campaign (linkages, case 23 of seed 421): a small impulse beside a large one.

"impulses 9.40543e-09 and 9.40543e-09, stated 2.47e-12 of them": in a collision of 0.016 N s a stop
that was closed is pushed by a millionth of that, which has the round-off of the 0.016 N s. What was
stated for the struck stop was taken for all.
"""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.stress import trial
from benchmarks.stress.checks.agreement import within_errors
from nipper_pin import Case, Resolution, Solution, simulate

COLLISION = 2


@pytest.fixture(scope="module")
def runs() -> tuple[Solution, Solution]:
    """The case, and the same at a sixteenth of its tolerance."""
    item = trial(421, 23, ("linkage",))
    resolution = Resolution(**item.case["resolution"])
    case = Case(**{**item.case, "resolution": resolution, "max_collisions": 4})
    finer = replace(case.resolution, tolerance=max(case.resolution.tolerance / 16.0, 1e-14))
    mechanism = item.mechanism()
    return simulate(mechanism, case), simulate(mechanism, replace(case, resolution=finer))


def test_every_impulse_of_an_event_has_a_stated_error_that_holds(
    runs: tuple[Solution, Solution],
) -> None:
    coarse, fine = runs
    small, struck = "box1_far", "slide1"
    pushed, stated = coarse.events[COLLISION].P_N, coarse.errors[COLLISION]
    assert 0.0 < pushed[small] < 1e-6 * pushed[struck]
    assert [set(error.impulses) for error in coarse.errors] == [set(e.P_N) for e in coarse.events]
    off = abs(pushed[small] - fine.events[COLLISION].P_N[small])
    assert off <= stated.impulses[small] < 1e-15 * pushed[struck]
    assert stated.impulses[struck] <= stated.impulse * pushed[struck]
    assert within_errors(coarse, fine) == []


def test_a_small_impulse_that_is_off_by_more_is_noticed(runs: tuple[Solution, Solution]) -> None:
    coarse, fine = runs
    event = coarse.events[COLLISION]
    more = 5.0 * (coarse.errors[COLLISION].impulses["box1_far"] * 2.0)
    wrong = replace(event, P_N={**event.P_N, "box1_far": event.P_N["box1_far"] + more})
    events = (*coarse.events[:COLLISION], wrong, *coarse.events[COLLISION + 1 :])
    doctored = replace(coarse, events=events)
    doctored.__dict__["errors"] = coarse.errors
    assert any("impulses of box1_far" in item.detail for item in within_errors(doctored, fine))

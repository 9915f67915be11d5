"""The table of true and stated errors: each ratio is the largest of true error over stated one."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest

from benchmarks.run_time import work_precision
from benchmarks.run_time.certified import certified
from nipper_pin import Solution


def test_ratios_are_true_errors_over_stated_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    """With stated errors of a thousandth of each time and impulse, and the truth moved by one.

    The transition is right to 1e-10 beside these, so the ratios are one.
    """
    name = "650"
    right = certified(name)

    def errors(solution: Solution) -> tuple[SimpleNamespace, ...]:
        first = solution.events[0].t
        return tuple(
            SimpleNamespace(time=1e-3 * max(event.t - first, 1e-9), impulse=1e-3)
            for event in solution.events
        )

    moved = replace(
        right,
        times=tuple(t * 1.001 for t in right.times),
        impulses=tuple(impulse / 1.002 for impulse in right.impulses),
        transition_time=right.transition_time * 1.001,
    )
    monkeypatch.setattr(Solution, "errors", property(errors))
    monkeypatch.setattr(work_precision, "certified_names", lambda: (name,))
    monkeypatch.setattr(work_precision, "certified", lambda _name: moved)
    rows = work_precision.true_over_stated()
    assert [row.case for row in rows] == [name] * len(work_precision.STATED_TOLERANCES)
    fine = min(rows, key=lambda row: row.tolerance)
    assert fine.times == pytest.approx(1.0, rel=1e-6)
    assert fine.impulses == pytest.approx(2.0, rel=1e-6)

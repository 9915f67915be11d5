"""The script that confirms random identifications, and what it refuses."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "scripts/maintain/confirm"))

import confirm_fits as script
from confirm_fits import Confirmed, honest


def campaign() -> list[Confirmed]:
    """Twenty fits as they should be: errors and misfits drawn from their own distributions."""
    rng = np.random.default_rng(3)
    found = []
    for _ in range(20):
        errors, misfits = rng.standard_normal(3), rng.standard_normal(9)
        found.append(
            Confirmed(
                paths=("a", "b", "c"), worse=float(errors @ errors), deviations=errors,
                chi_square=float(misfits @ misfits), freedom=9.0, verdict="agrees", premise=True,
                confirmed=1e-9,
            )
        )  # fmt: skip
    return found


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda item: replace(item, worse=4.0 * item.worse), "numbers drawn"),
        (lambda item: replace(item, worse=0.0 * item.worse), "numbers drawn"),
        (lambda item: replace(item, deviations=2.0 * item.deviations), "stated deviations"),
        (lambda item: replace(item, deviations=0.5 * item.deviations), "stated deviations"),
        (lambda item: replace(item, chi_square=9.0 * item.chi_square), "misfits"),
        (lambda item: replace(item, chi_square=item.chi_square / 3.0), "misfits"),
        (lambda item: replace(item, confirmed=1e-4), "whole turns differ"),
        (lambda item: replace(item, confirmed=float("nan")), "whole turns differ"),
    ],
    ids=["not the fit", "the numbers drawn", "deviations halved", "deviations doubled",
         "sigmas too small", "sigmas too large",
         "another transition", "no transition"],
)  # fmt: skip
def test_each_error_is_refused(change: Callable[[Confirmed], Confirmed], word: str) -> None:
    assert honest(campaign()) == []
    (*_, last) = honest([change(item) for item in campaign()])
    assert word in last


@pytest.mark.slow
def test_a_random_problem_is_confirmed() -> None:
    """The first one of the campaign whose figures are documented."""
    (stream,) = np.random.SeedSequence(1).spawn(1)
    drawn = script.draw(np.random.default_rng(stream))
    assert drawn is not None
    problem, truth = drawn
    found = script.confirm(problem, truth)
    assert set(found.paths) == set(truth)
    assert honest([found]) == []
    assert np.isfinite(found.worse)
    # A fit of another machine is not confirmed: the numbers are not those that were drawn.
    wrong = {path: 1.1 * value for path, value in truth.items()}
    assert "numbers drawn" in " ".join(honest([script.confirm(problem, wrong)]))

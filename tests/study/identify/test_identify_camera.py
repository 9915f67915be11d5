"""The example of the documentation: a machine that was filmed, and its numbers found again."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

from nipper_pin.study.identify import Fit, Problem, determinability, identify, read_problem

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "scripts/maintain/confirm"))

import make_camera_example as example

SCRIPTS = Path(example.__file__).parents[2]


@pytest.fixture(scope="module")
def problem() -> Problem:
    return read_problem(SCRIPTS / "identify_camera.toml")


def off(fit: Fit) -> np.ndarray:
    """Distances of the found numbers from the true ones, in stated standard deviations."""
    stated = determinability(fit.objective, fit.best.z).deviations
    return np.array([
        (fit.values[item.path] - example.TRUTH[item.path])
        / (stated[item.path] * (item.high - item.low))
        for item in fit.objective.problem.parameters
    ])  # fmt: skip


def test_the_file_in_the_repository_is_what_the_script_writes(tmp_path: Path) -> None:
    """No measurement was improved by hand."""
    example.main(tmp_path / "again.csv")
    kept = (SCRIPTS / "identify_camera_measured.csv").read_text(encoding="utf-8")
    assert (tmp_path / "again.csv").read_text(encoding="utf-8") == kept


@pytest.mark.slow
def test_the_numbers_of_the_filmed_machine_come_back(problem: Problem) -> None:
    """Within three and a half stated standard deviations, from starts all over the bounds.

    The model's own numbers, where the search begins, are ten of them away and more, so a search
    that stays or a deviation stated far too large fails.
    """
    fit = identify(problem, starts=3, seed=1, workers=1)
    assert np.abs(off(fit)).max() < 3.5
    stated = determinability(fit.objective, fit.best.z).deviations
    for item in problem.parameters:
        away = abs(item.start - example.TRUTH[item.path])
        assert away > 10.0 * stated[item.path] * (item.high - item.low)
    # The page that explains it shows these numbers.
    page = (SCRIPTS.parent / "docs" / "identification.md").read_text(encoding="utf-8")
    for item in problem.parameters:
        deviation = stated[item.path] * (item.high - item.low)
        row = f"| `{item.path}` | {example.TRUTH[item.path]:g} | {item.start:g} |"
        assert f"{row} {fit.values[item.path]:.5g} ± {deviation:.2g} |" in page
    # All starts find the same machine.
    costs = [item.cost for item in fit.descents]
    assert costs == pytest.approx([costs[0]] * 3, rel=1e-4)


@pytest.mark.slow
def test_stated_deviations_are_those_of_repeated_films(problem: Problem) -> None:
    """Eight films of one machine: errors and misfits are distributed as they should be.

    24 errors in units of their stated deviations have a sum of squares with 24 degrees of freedom
    (the three of one film are correlated, which widens it a little, but not beyond 99.9 %), the
    misfits of 8 times 12 measurements less 3 numbers one with 72. Deviations wrong by a half, or
    times counted in other units, are far outside of both.
    """
    errors, misfits = [], []
    for seed in range(100, 108):
        seen = example.measurements(seed)
        targets = tuple(
            replace(target, value=value, sigma=sigma)
            for target, (_, _, value, sigma) in zip(problem.targets, seen, strict=True)
        )
        fit = identify(replace(problem, targets=targets), starts=1, workers=1)
        errors.append(off(fit))
        misfits.append(2.0 * fit.best.cost)
    low, high = chi2.interval(0.999, 24)
    assert low < np.sum(np.square(errors)) < high
    low, high = chi2.interval(0.999, 72)
    assert low < np.sum(misfits) < high

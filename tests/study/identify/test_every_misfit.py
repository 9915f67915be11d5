"""Every number and word on how good a fit is, of problems that are linear: all by plain algebra."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from linear_problem import PATHS, RANGES, STARTS, Linear, fitted, problem
from scipy.stats import t as student

from nipper_pin.errors import MisfitError
from nipper_pin.study.identify.fitting import outliers as outliers_module
from nipper_pin.study.identify.fitting.goodness import Goodness, Verdict
from nipper_pin.study.identify.fitting.outliers import leverages, outliers
from nipper_pin.study.identify.fitting.profiles import profile
from nipper_pin.study.identify.fitting.suspects import suspected_units
from nipper_pin.study.identify.record import record

WIDTHS = np.array([high - low for low, high in RANGES])


def linear(seed: int, count: int = 9, steep: float = 30.0, **others: Any) -> Linear:
    """Random slopes, all targets of 100 with sigmas from 1 to 2."""
    random = np.random.default_rng(seed)
    sigma = random.uniform(1.0, 2.0, count)
    wanted = 100.0 + random.normal(0.0, 1.0, count) * sigma
    matrix = random.normal(0.0, steep, (count, 3))
    return Linear(
        problem(wanted, sigma, **others), matrix=matrix, offset=100.0 - matrix @ np.full(3, 0.5)
    )


def hat(jacobian: np.ndarray, weight: float) -> np.ndarray:
    """J (J' J + P)^-1 J', with P = 12 + weight^2: a range and the prior."""
    known = (12.0 + weight * weight) * np.eye(jacobian.shape[1])
    return np.asarray(jacobian @ np.linalg.inv(jacobian.T @ jacobian + known) @ jacobian.T)


@pytest.mark.parametrize("weight", [0.0, 3.0])
@pytest.mark.parametrize("absolute", [True, False])
def test_chances_of_single_targets(weight: float, absolute: bool) -> None:
    """Residuals by their own deviation; Student's law where the others give the scale."""
    random = np.random.default_rng(11)
    rows, here = random.normal(0.0, 2.0, (8, 3)), random.normal(0.0, 1.0, 8)
    part = np.diag(hat(rows, weight))
    assert leverages(rows, weight) == pytest.approx(part)
    refit = outliers_module._refitted(here, rows, weight)
    assert rows @ refit == pytest.approx(hat(rows, weight) @ here)
    size, chance = outliers_module._chances(here, part, absolute=absolute)
    wanted = np.abs(here) / np.sqrt(1.0 - part)
    assert size == pytest.approx(wanted)
    if absolute:
        assert chance == pytest.approx([math.erfc(x / math.sqrt(2.0)) for x in wanted])
    else:
        freedom = 8 - part.sum() - 1.0
        others = (float(here @ here) - wanted**2) / freedom
        known = np.maximum(others, 0.0)
        with np.errstate(divide="ignore"):
            assert chance == pytest.approx(2.0 * student.sf(wanted / np.sqrt(known), freedom))


def test_targets_that_alone_determine_a_number() -> None:
    """They have no residual of their own: next to nothing is divided by 1e-3, not by zero."""
    size, chance = outliers_module._chances(
        np.array([1e-4, 0.3]), np.array([1.0, 0.75]), absolute=True
    )
    assert size == pytest.approx([0.1, 0.6])
    assert chance == pytest.approx([math.erfc(x / math.sqrt(2.0)) for x in (0.1, 0.6)])
    # As many numbers as targets: no scale is left to judge by.
    _, chance = outliers_module._chances(np.array([9.0, 1.0]), np.array([0.6, 0.4]), absolute=False)
    assert chance.tolist() == [1.0, 1.0]


@pytest.mark.parametrize("absolute", [True, False])
def test_wrong_targets_are_found_one_after_the_other(absolute: bool) -> None:
    """The worst first, and no other; none if a third of all would have to go."""
    random = np.random.default_rng(3)
    rows, noise = random.normal(0.0, 20.0, (12, 3)), random.normal(0.0, 0.7, 12)
    free = np.eye(12) - hat(rows, 0.0)

    def found(*wrong: tuple[int, float]) -> tuple[int, ...]:
        off = noise.copy()
        for place, by in wrong:
            off[place] += by
        return outliers(free @ off, rows, 0.0, absolute=absolute)

    assert found() == ()
    assert found((4, 60.0)) == (4,)
    assert found((4, 60.0), (9, -300.0)) == (9, 4)
    assert found((2, 80.0), (4, 60.0), (9, -400.0), (11, 100.0))[0] == 9
    # A twelfth by chance alone: Bonferroni's bound is 0.01 / 12, 3.34 sigmas.
    alone = np.zeros((12, 1))
    for size, outside in ((3.30, ()), (3.38, (5,))):
        here = np.zeros(12)
        here[5] = size
        assert outliers(here, alone, 0.0, absolute=True) == outside
    # More than a third lie outside: all that did so at first, the worst first.
    many = np.zeros(12)
    many[[1, 3, 5, 7, 9]] = (5.0, -9.0, 7.0, 6.0, -8.0)
    assert outliers(many, alone, 0.0, absolute=True) == (3, 9, 5, 7, 1)
    many[[1, 7]] = 0.0
    assert outliers(many, alone, 0.0, absolute=True) == (3, 9, 5)


@pytest.mark.parametrize("weight", [0.0, 3.0])
@pytest.mark.parametrize("absolute", [True, False])
def test_goodness_of_a_fit(weight: float, absolute: bool) -> None:
    """Chi-square of the targets alone; numbers at a bound determine nothing."""
    objective = linear(5, prior_weight=weight, absolute_sigma=absolute)
    fit = fitted(objective, 0.52, 1.0 - 5e-4, 0.48)
    sigma = np.array([target.sigma for target in objective.problem.targets])
    wanted = np.array([target.value for target in objective.problem.targets])
    slopes = objective.matrix / sigma[:, None]
    found = fit.goodness
    off = (objective.predicted(fit.best.z) - wanted) / sigma
    assert found.names == tuple(f"t{n}" for n in range(9))
    assert found.residuals == pytest.approx(off)
    assert found.chi_square == pytest.approx(sum(x * x for x in off))
    fitted_numbers = np.trace(hat(slopes[:, [0, 2]], weight))
    assert found.fitted == pytest.approx(fitted_numbers, rel=1e-6)
    assert found.degrees_of_freedom == pytest.approx(9.0 - fitted_numbers, rel=1e-6)
    assert found.absolute_sigma is absolute
    assert (found.probability is None) is not absolute
    assert found.outliers == outliers(off, slopes[:, [0, 2]], weight, absolute=absolute)
    assert found.suspects == suspected_units(fit.objective, fit.best.z, fit.predicted)
    for bound, inside in ((1e-3 - 1e-6, False), (1e-3 + 1e-6, True)):
        numbers = fitted(objective, 0.52, 1.0 - bound, bound).goodness.fitted
        chosen = [0, 1, 2] if inside else [0]
        assert numbers == pytest.approx(np.trace(hat(slopes[:, chosen], weight)), rel=1e-6)


def judged(**changes: Any) -> Goodness:
    given: dict[str, Any] = {
        "names": ("a", "b", "c", "d", "e", "f", "g", "h"), "chi_square": 12.5, "fitted": 3.0,
        "residuals": np.array([0.5, -4.25, 3.0, 9.5, 1.0, -7.0, 6.0, 2.0]), "probability": 0.25,
        "outliers": (), "suspects": (), "absolute_sigma": True,
    }  # fmt: skip
    return Goodness(**{**given, **changes})


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [
        ({}, Verdict.AGREES), ({"probability": 1.01e-3}, Verdict.AGREES),
        ({"probability": 0.99e-3}, Verdict.CONTRADICTED),
        ({"probability": 0.9989}, Verdict.AGREES), ({"probability": 0.9991}, Verdict.TOO_GOOD),
        ({"probability": None}, Verdict.WEIGHTS_ALONE),
        # Sigmas ten times too small: chi-square is 100 times its degrees of freedom.
        ({"probability": None, "chi_square": 499.0}, Verdict.WEIGHTS_ALONE),
        ({"probability": None, "chi_square": 501.0}, Verdict.CONTRADICTED),
        ({"probability": None, "suspects": ("s",)}, Verdict.CONTRADICTED),
        ({"fitted": 7.6, "probability": None}, Verdict.UNTESTED),
        ({"fitted": 7.4, "probability": None}, Verdict.WEIGHTS_ALONE),
        ({"fitted": 7.6, "probability": None, "suspects": ("s",)}, Verdict.CONTRADICTED),
    ],
)  # fmt: skip
def test_verdicts(changes: dict[str, Any], verdict: Verdict) -> None:
    found = judged(**changes)
    assert found.verdict is verdict
    if verdict is not Verdict.CONTRADICTED:
        found.check()
        return
    with pytest.raises(MisfitError) as caught:
        replace(found, outliers=(3, 5)).check()
    assert caught.value.evidence == {
        "chi_square": found.chi_square, "degrees_of_freedom": found.degrees_of_freedom,
        "probability": found.probability, "outliers": ["d", "f"],
    }  # fmt: skip


def test_sentences_of_verdicts() -> None:
    """Word for word, with the numbers as they are; five outliers by name and how many more."""
    numbers = "chi-square 12.5, degrees of freedom 5"
    assert judged().sentence() == f"The data agree with the fit: {numbers}, probability 0.25."
    assert judged(probability=0.9999).sentence() == (
        f"The fit is better than its sigmas allow: {numbers}, probability 1. They are stated too "
        "large, or the targets are no measurements."
    )
    assert judged(probability=None).sentence() == (
        f"Sigmas are weights alone, so there is no test of the fit: {numbers}; sigmas 1.58 times "
        "as large would be met."
    )
    against = (
        f"THE DATA CONTRADICT THE FIT: {numbers}, probability 0.0001. Its numbers and their "
        "standard deviations are not to be used."
    )
    worst = "Outliers: d (+9.5 sigmas), f (-7 sigmas), g (+6 sigmas), b (-4.25 sigmas)"
    other = (
        " Either measurements are wrong, or sigmas are too small (1.58 times as large would be "
        "met), or the model lacks something."
    )
    found = judged(probability=1e-4, outliers=(3, 5, 6, 1))
    assert found.sentence() == f"{against} {worst}.{other}"
    five = judged(probability=1e-4, outliers=(3, 5, 6, 1, 2))
    assert five.sentence() == f"{against} {worst}, c (+3 sigmas).{other}"
    seven = judged(probability=1e-4, outliers=(3, 5, 6, 1, 2, 7, 0))
    assert seven.sentence() == f"{against} {worst}, c (+3 sigmas) and 2 more.{other}"
    units = replace(found, suspects=("Is it in deg?",))
    assert units.sentence() == f"{against} Is it in deg?"
    assert judged(outliers=(3,)).sentence().endswith("0.25. Outliers: d (+9.5 sigmas).")
    assert judged(fitted=7.625, probability=None, suspects=("Is it?",)).sentence() == (
        "The targets (8) are no more than the numbers that they determine (7.62): nothing is left "
        "over that could test the fit. Is it?"
    )


@pytest.mark.parametrize("place", [0, 2])
def test_profile_of_a_line(place: int) -> None:
    """Half the least sum of squares with one number held: a parabola, exactly.

    Its curvature is the inverse of the number's variance, prior included. Derivatives of a line
    are exact but for round-off; the descents stop at 1e-7 of the cost.
    """
    objective = linear(8, steep=40.0, prior_weight=3.0)
    sigma = np.array([target.sigma for target in objective.problem.targets])
    wanted = np.array([target.value for target in objective.problem.targets])
    own = (np.array(STARTS) - [low for low, _ in RANGES]) / WIDTHS
    slopes = np.vstack([objective.matrix / sigma[:, None], 3.0 * np.eye(3)])
    right = np.concatenate([(wanted - objective.offset) / sigma, 3.0 * own])
    best = np.linalg.solve(slopes.T @ slopes, slopes.T @ right)
    assert ((best > 0.2) & (best < 0.8)).all()
    deviation = math.sqrt(np.linalg.inv(slopes.T @ slopes)[place, place])
    found = profile(fitted(objective, *best), PATHS[place], points=5, reach=2.0, workers=1)
    steps = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
    low = RANGES[place][0]
    assert found.path == PATHS[place]
    assert found.sigma == pytest.approx(deviation * WIDTHS[place], rel=1e-6)
    assert found.values == pytest.approx(
        low + WIDTHS[place] * (best[place] + steps * deviation), rel=1e-6
    )
    assert found.quadratic == pytest.approx(0.5 * steps**2, abs=1e-5)
    assert found.cost == pytest.approx(0.5 * steps**2, abs=1e-4)


def test_profile_at_a_bound_and_beside_an_edge() -> None:
    """Off the best point the misfit has a slope; values beyond an edge have no cost."""
    matrix = np.diag([4.0, 9.0, 9.0])
    objective = Linear(problem(np.zeros(3), np.ones(3)), matrix=matrix,
                       offset=np.array([2.0, -4.5, -4.5]), edge=0.9)  # fmt: skip
    found = profile(fitted(objective, 0.0, 0.5, 0.5), PATHS[0], points=5, reach=4.0, workers=1)
    # From the bound on: (2 + 4 z)^2 / 2 above its value at z = 0; a sigma of 1/4 reaches z = 1,
    # where no machine is.
    z = np.array([0.0, 0.25, 0.5, 0.75])
    assert found.values == pytest.approx(8.0 + 8.0 * z)
    assert found.cost == pytest.approx(8.0 * z + 8.0 * z**2, abs=1e-5)
    assert found.quadratic == pytest.approx(8.0 * z + 8.0 * z**2, abs=1e-5)
    assert found.sigma == pytest.approx(8.0 / 4.0)


def test_the_record_has_every_number_in_its_place() -> None:
    objective = linear(5, prior_weight=3.0)
    fit = fitted(objective, 0.52, 1.0 - 5e-4, 0.48, excess=np.array([0.5, 0.0, -3.0, 0.0]))
    lost = replace(fit.best, cost=math.inf, converged=False, steps=64)
    fit = replace(fit, descents=(fit.best, lost))
    known, good = fit.known, fit.goodness
    line = profile(fit, PATHS[0], points=3, reach=1.0, workers=1)
    found = record(fit, good, known, [line])
    start = dict(zip(PATHS, [low + 0.5 * (high - low) for low, high in RANGES], strict=True))
    assert found["starts"] == [
        {"cost": fit.best.cost, "steps": 12, "converged": True, "from": pytest.approx(start),
         "to": fit.values},
        {"cost": None, "steps": 64, "converged": False, "from": pytest.approx(start), "to": None},
    ]  # fmt: skip
    assert (found["title"], found["model"], found["seed"]) == ("a line", "e62", 7)
    assert found["cost"] == fit.best.cost
    assert found["limits"] == {
        "closing_index": 0.5, "opening_index": 0.0, "jaw_opening_deg": -3.0, "stop_force_N": 0.0,
    }  # fmt: skip
    # Three times 0.2 degrees.
    assert found["broken_limits"] == pytest.approx({"jaw_opening_deg": -0.6})
    scaled = known.scaled_deviations(good.scale)
    for row, path, (low, high), own in zip(found["parameters"], PATHS, RANGES, STARTS, strict=True):
        width = high - low
        assert row == {
            "path": path, "low": low, "high": high, "before": own,
            "identified": fit.values[path], "why": f"because of {path}",
            "standard_deviation": pytest.approx(known.deviations[path] * width),
            "standard_deviation_scaled": pytest.approx(scaled[path] * width),
            "range_left": pytest.approx(known.deviations[path] * math.sqrt(12.0)),
            "determined": known.deviations[path] * math.sqrt(12.0) < 0.5,
            "at_bound": "high" if path == PATHS[1] else None,
        }  # fmt: skip
    assert found["profiles"] == [
        {"path": PATHS[0], "sigma": line.sigma, "values": line.values.tolist(),
         "cost": line.cost.tolist(), "quadratic": line.quadratic.tolist()}
    ]  # fmt: skip
    assert found["goodness"] == {
        "verdict": good.verdict.value, "sentence": good.sentence(), "chi_square": good.chi_square,
        "degrees_of_freedom": good.degrees_of_freedom, "probability": good.probability,
        "scale": good.scale, "absolute_sigma": True, "suspects": [],
        "outliers": [f"t{place}" for place in good.outliers],
    }  # fmt: skip

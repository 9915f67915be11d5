"""How good a fit is: chi-square, outliers and mistaken units of lines, by textbook formulas."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linear_problem import Linear, fitted, problem
from scipy.stats import chi2, norm, t
from snapshots import Words

from nipper_pin import SimulationError
from nipper_pin.errors import MisfitError
from nipper_pin.study.identify import Goodness, Objective, Verdict, read_problem
from nipper_pin.study.identify.fitting.outliers import outliers
from nipper_pin.study.identify.fitting.suspects import suspected_units


def hat(jacobian: np.ndarray, weight: float) -> np.ndarray:
    """J (J' J + P)^-1 J', with P = 12 + weight^2: a range and the prior."""
    known = (12.0 + weight * weight) * np.eye(jacobian.shape[1])
    return np.asarray(jacobian @ np.linalg.inv(jacobian.T @ jacobian + known) @ jacobian.T)


# --- outliers ------------------------------------------------------------------------------------


@pytest.mark.parametrize("absolute", [True, False])
def test_wrong_targets_are_found_one_after_the_other(absolute: bool) -> None:
    """The worst first, and no other; none of the good ones that they drag along."""
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


@pytest.mark.parametrize("absolute", [True, False])
@pytest.mark.parametrize("weight", [0.0, 3.0])
def test_what_lies_outside(absolute: bool, weight: float) -> None:
    """Residuals by their own deviation, at a chance of 0.01 in all targets together (Bonferroni).

    Where the sigmas are weights alone the other targets give the scale, by Student's law. One more
    fit of all targets is exact for a line, so residuals are given as they are after a fit.
    """
    random = np.random.default_rng(11)
    rows, count = random.normal(0.0, 2.0, (8, 2)), 8
    part = np.diag(hat(rows, weight))
    others = (np.eye(count) - hat(rows, weight)) @ random.normal(0.0, 1.0, count)
    chance = 0.01 / count / 2.0

    def studentized(off: np.ndarray) -> float:
        """Chance of the residual of target 5 on one side."""
        here = off - hat(rows, weight) @ off
        size = here[5] / np.sqrt(1.0 - part[5])
        if absolute:
            return float(norm.sf(size))
        freedom = count - part.sum() - 1.0
        scale = max(here @ here - size**2, 1e-300) / freedom
        return float(t.sf(size / np.sqrt(scale), freedom))

    low, high = 0.0, 1e3
    for _ in range(60):
        middle = 0.5 * (low + high)
        wrong = others + middle * np.eye(count)[5]
        low, high = (middle, high) if studentized(wrong) > chance else (low, middle)
    for factor, outside in ((0.999, ()), (1.001, (5,))):
        off = others + factor * low * np.eye(count)[5]
        assert outliers(off, rows, weight, absolute=absolute)[:1] == outside


def test_many_wrong_targets_are_no_outliers() -> None:
    """More than a third lie outside: all that did so at first, the worst first."""
    alone, many = np.zeros((12, 1)), np.zeros(12)
    many[[1, 3, 5, 7, 9]] = (5.0, -9.0, 7.0, 6.0, -8.0)
    assert outliers(many, alone, 0.0, absolute=True) == (3, 9, 5, 7, 1)
    many[[1, 7]] = 0.0
    assert outliers(many, alone, 0.0, absolute=True) == (3, 9, 5)
    # A target that alone determines a number has no residual of its own; as many numbers as
    # targets leave no scale to judge by.
    assert outliers(np.array([1e-4, 0.3]), 1e6 * np.eye(2), 0.0, absolute=True) == ()
    assert outliers(np.array([9.0, 1.0]), 5.0 * np.eye(2), 0.0, absolute=False) == ()


# --- chi-square and its verdicts -----------------------------------------------------------------


@pytest.mark.parametrize("weight", [0.0, 3.0])
@pytest.mark.parametrize("absolute", [True, False])
def test_goodness_of_a_fit(weight: float, absolute: bool) -> None:
    """Chi-square of the targets alone; numbers at a bound determine nothing."""
    random = np.random.default_rng(5)
    sigma, matrix = random.uniform(1.0, 2.0, 9), random.normal(0.0, 30.0, (9, 3))
    wanted = 100.0 + random.normal(0.0, 1.0, 9) * sigma
    objective = Linear(
        problem(wanted, sigma, prior_weight=weight, absolute_sigma=absolute), matrix=matrix,
        offset=100.0 - matrix @ np.full(3, 0.5),
    )  # fmt: skip
    slopes = matrix / sigma[:, None]
    for bound, chosen in ((1e-3 - 1e-6, [0]), (1e-3 + 1e-6, [0, 1, 2])):
        fit = fitted(objective, 0.52, 1.0 - bound, bound)
        found, numbers = fit.goodness, np.trace(hat(slopes[:, chosen], weight))
        off = (objective.predicted(fit.best.z) - wanted) / sigma
        assert found.names == tuple(f"t{n}" for n in range(9))
        assert found.residuals == pytest.approx(off)
        assert found.chi_square == pytest.approx(off @ off)
        assert found.fitted == pytest.approx(numbers, rel=1e-6)
        assert found.degrees_of_freedom == pytest.approx(9.0 - numbers, rel=1e-6)
        assert found.probability == (
            pytest.approx(chi2.sf(off @ off, 9.0 - numbers), rel=1e-5) if absolute else None
        )
        assert found.outliers == outliers(off, slopes[:, chosen], weight, absolute=absolute)


def judged(**changes: Any) -> Goodness:
    given: dict[str, Any] = {
        "names": ("a", "b", "c", "d", "e", "f", "g", "h"), "chi_square": 12.5, "fitted": 3.0,
        "residuals": np.array([0.5, -4.25, 3.0, 9.5, 1.0, -7.0, 6.0, 2.0]), "probability": 0.25,
        "outliers": (), "suspects": (), "absolute_sigma": True,
    }  # fmt: skip
    return Goodness(**{**given, **changes})


VERDICTS: list[tuple[dict[str, Any], Verdict]] = [
    ({}, Verdict.AGREES), ({"probability": 1.01e-3}, Verdict.AGREES),
    ({"outliers": (3,)}, Verdict.AGREES),
    ({"probability": 0.99e-3, "outliers": (3, 5)}, Verdict.CONTRADICTED),
    # Five outliers by name, and how many more.
    ({"probability": 1e-4, "outliers": (3, 5, 6, 1, 2, 7, 0)}, Verdict.CONTRADICTED),
    ({"probability": 1e-4, "outliers": (3,), "suspects": ("Is it in deg?",)}, Verdict.CONTRADICTED),
    ({"probability": 0.9989}, Verdict.AGREES), ({"probability": 0.9991}, Verdict.TOO_GOOD),
    ({"probability": None}, Verdict.WEIGHTS_ALONE),
    # Sigmas ten times too small: chi-square is 100 times its degrees of freedom.
    ({"probability": None, "chi_square": 499.0}, Verdict.WEIGHTS_ALONE),
    ({"probability": None, "chi_square": 501.0}, Verdict.CONTRADICTED),
    ({"probability": None, "suspects": ("s",)}, Verdict.CONTRADICTED),
    ({"fitted": 7.6, "probability": None}, Verdict.UNTESTED),
    ({"fitted": 7.4, "probability": None}, Verdict.WEIGHTS_ALONE),
    ({"fitted": 7.6, "probability": None, "suspects": ("s",)}, Verdict.CONTRADICTED),
]  # fmt: skip


def test_verdicts(words: Words) -> None:
    """What is contradicted is an error with its evidence; each verdict has its sentence."""
    said = []
    for changes, verdict in VERDICTS:
        found = judged(**changes)
        assert found.verdict is verdict
        said.append(found.sentence())
        if verdict is not Verdict.CONTRADICTED:
            found.check()
            continue
        with pytest.raises(MisfitError) as caught:
            found.check()
        assert caught.value.evidence == {
            "chi_square": found.chi_square, "degrees_of_freedom": found.degrees_of_freedom,
            "probability": found.probability,
            "outliers": ["abcdefgh"[place] for place in found.outliers],
        }  # fmt: skip
    words("\n".join(said) + "\n")


# --- units that measurements may be in by mistake ------------------------------------------------

MASS = Path(__file__).resolve().parents[2] / "verification" / "models" / "bouncing_mass"


# A quantity, and by how much its targets are off.
MISTAKEN: list[tuple[str, float]] = [
    *(("duration_s", factor) for factor in (1e3, 1.2e6, 3e3, 60.0, 5.1, 1 / 5.1, 4.9, 1 / 4.9)),
    ("first_two_share", 100.0), ("rebound_time_s_1", 1e3), ("rebound_amplitude_1", 57.0),
    ("rebound_amplitude_1", 1e3), ("rebound_amplitude_1", 20.0), ("approach_rate_1", 57.3),
    ("approach_rate_1", -20.0),
]  # fmt: skip


def test_units_that_were_mistaken(words: Words) -> None:
    """The median of a quantity's targets by what the model gives, at its start and at the fit."""
    values, said = np.array([0.5, 0.25, 2.0]), ""
    for name, factor in MISTAKEN:
        wanted = factor * values * np.array([1.0, 0.9, 1.3])
        objective = Linear(
            problem(wanted, np.abs(wanted), (name,) * 3), matrix=np.zeros((3, 3)), offset=values
        )
        suspects = fitted(objective, 0.5, 0.5, 0.5).goodness.suspects
        said += f"{name} times {factor:.4g}: {', '.join(suspects) or 'nothing'}\n"
    words(said)


def test_no_unit_is_suspected_of_what_a_fit_meets() -> None:
    """Ten times off at the start, and at the fit by 5.1, 4.9, 2.1 and 1.9; changes are shares.

    Where the model's own numbers cannot be simulated, what the fit gives is compared.
    """
    objective = Linear(problem(np.array([10.0]), np.array([1.0])), matrix=np.zeros((1, 3)),
                       offset=np.array([1.0]))  # fmt: skip
    z = np.full(3, 0.5)
    for found, told in ((10.0 / 2.1, True), (10.0 / 1.9, False), (19.0, False), (21.0, True)):
        assert bool(suspected_units(objective, z, np.array([found]))) is told
    (target,) = objective.problem.targets
    change = replace(target, value=100.0, since=target.at._replace(speed_rpm=450.0))
    asked = replace(objective, problem=replace(objective.problem, targets=(change,)))
    assert suspected_units(asked, z, np.ones(1)) == (
        "change of duration_s is wanted about 100 times what the model gives: is it in percent?",
    )
    jammed = replace(objective, edge=0.1)
    with pytest.raises(SimulationError):
        jammed.predicted(jammed.start)
    assert "about 1000 times" in suspected_units(jammed, z, np.array([0.01]))[0]


def test_units_of_a_slide(tmp_path: Path) -> None:
    """A stop on a slide has no angles: a ball that leaves a table of 1.5 m/s with half of it."""
    rows = {"rebound_amplitude_1": 1e3 * 0.75**2 / (2.0 * 9.81), "approach_rate_1": -1.5e3}
    text = f'format = 1\ntitle = "t"\nmodel = "{MASS}"\n'
    for name, value in rows.items():
        text += f'[[targets]]\nname = "{name}"\nquantity = "{name}"\nat = {{ speed_rpm = 60.0 }}\n'
        text += f"value = {value!r}\nsigma = 1.0\n"
    text += '[parameters."stops.table.restitution"]\nlow = 0.1\nhigh = 0.9\n'
    (tmp_path / "fit.toml").write_text(text, encoding="utf-8")
    objective = Objective(read_problem(tmp_path / "fit.toml"))
    said = suspected_units(objective, objective.start, objective.predicted(objective.start))
    asked = ("millimetres?", "millimetres a second?")
    assert said == tuple(
        f"{name} is wanted about 1000 times what the model gives: is it in {unit}"
        for name, unit in zip(rows, asked, strict=True)
    )

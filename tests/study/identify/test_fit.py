"""Fits of lines: descents, what targets determine, profiles and limits, all by plain algebra."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from linear_problem import AT, PATHS, RANGES, STARTS, Linear, fitted, problem
from scipy.stats import chi2

from nipper_pin import SimulationError
from nipper_pin.errors import MisfitError
from nipper_pin.hybrid.result.premise import Premise
from nipper_pin.study.identify import Limits, Target, WorkingCycle, determinability, profile, record
from nipper_pin.study.identify.fitting.differences import jacobian, slopes
from nipper_pin.study.identify.fitting.fit import descend
from nipper_pin.study.identify.fitting.limits import excesses, limit_rows
from nipper_pin.study.identify.problem.working_cycle import SAMPLES, Phase
from nipper_pin.tolerances.study import FIT_STEP

MATRIX = np.array([[30.0, 5.0, 0.0], [0.0, 40.0, -3.0], [2.0, 0.0, 50.0], [9.0, 9.0, 9.0]])
END = np.array([0.3, 0.6, 0.4])
OWN = (np.array(STARTS) - [low for low, _ in RANGES]) / [high - low for low, high in RANGES]


def linear(edge: float = 2.0, sigma: float = 2.0, off: Any = 0.0, **others: Any) -> Linear:
    """Targets of sigma two that are met at an end, or are off by so much."""
    asked = problem(MATRIX @ END + 100.0 + off, np.full(4, sigma), **others)
    return Linear(asked, matrix=MATRIX, offset=np.full(4, 100.0), edge=edge)


# --- descents ------------------------------------------------------------------------------------


def test_a_descent_ends_where_the_normal_equations_say() -> None:
    """From any start; the cost is half the sum of squares, prior included."""
    objective = linear(prior_weight=3.0)
    slope = np.vstack([MATRIX / 2.0, 3.0 * np.eye(3)])
    right = np.concatenate([MATRIX @ END / 2.0, 3.0 * OWN])
    best = np.linalg.solve(slope.T @ slope, slope.T @ right)
    cost = 0.5 * float(((slope @ best - right) ** 2).sum())
    for start in (np.array([0.9, 0.1, 0.5]), np.array([[0.9, 0.1, 0.5], [0.1, 0.1, 0.1]])):
        found = descend(objective, start)
        assert found.start.tolist() == [0.9, 0.1, 0.5]
        assert found.z == pytest.approx(best, abs=1e-5)
        assert found.cost == pytest.approx(cost, rel=1e-6)
        assert found.converged
    assert not descend(objective, np.array([0.9, 0.1, 0.5]), max_steps=1).converged


def test_weights_alone_decide() -> None:
    """Sigmas that are all larger by one factor change no number, only what is left of the cost."""
    off = np.array([1.0, -2.0, 0.5, 1.5])
    best = END + np.linalg.lstsq(MATRIX, off, rcond=None)[0]
    left = float(((MATRIX @ (best - END) - off) ** 2).sum())
    for sigma in (0.5, 2.0, 30.0):
        found = descend(linear(sigma=sigma, off=off), np.array([0.9, 0.1, 0.5]))
        assert found.z == pytest.approx(best, abs=1e-6)
        assert found.cost == pytest.approx(0.5 * left / sigma**2, rel=1e-6)


def test_a_descent_begins_at_the_first_draw_that_makes_a_machine() -> None:
    """Of which the first is told where none does."""
    draws = np.array([[0.9, 0.1, 0.1], [0.2, 0.2, 0.2], [0.7, 0.7, 0.7]])
    found = descend(linear(edge=0.8), draws)
    assert found.start.tolist() == [0.2, 0.2, 0.2]
    assert found.z == pytest.approx(END, abs=1e-5)
    none = descend(linear(edge=-1.0), draws[:2])
    assert (none.cost, none.steps, none.converged) == (math.inf, 2, False)
    assert none.z.tolist() == none.start.tolist() == [0.9, 0.1, 0.1]


def parabola(low: float, high: float) -> Callable[[np.ndarray], np.ndarray]:
    """x^2 and 3 x of the second coordinate; no machine outside of a stretch."""

    def function(z: np.ndarray) -> np.ndarray:
        if not low <= z[1] <= high:
            words = "outside"
            raise SimulationError(words)
        return np.array([z[1] ** 2, 3.0 * z[1], z[0]])

    return function


@pytest.mark.parametrize(
    ("z", "low", "high", "first"),
    [
        # Inwards by 1e-4, from either half; outwards where there is no machine inwards.
        (0.25, 0.0, 1.0, 1e-4), (0.75, 0.0, 1.0, -1e-4), (0.25, 0.0, 0.25, -1e-4),
        (0.75, 0.75, 1.0, 1e-4),
    ],
)  # fmt: skip
def test_slopes_to_go_down(z: float, low: float, high: float, first: float) -> None:
    found = slopes(parabola(low, high), np.array([0.5, z]))
    assert found[:, 1] == pytest.approx([2.0 * z + first, 3.0, 0.0], abs=1e-9)
    assert found[:, 0] == pytest.approx([0.0, 0.0, 1.0])
    with pytest.raises(SimulationError, match="outside"):
        slopes(parabola(0.5, 0.5), np.array([0.5, 0.5]))


@pytest.mark.parametrize(
    ("z", "low", "high"),
    [
        (0.5, 0.0, 1.0), (FIT_STEP, 0.0, 1.0), (0.5 * FIT_STEP, 0.0, 1.0),
        (1.0 - 0.5 * FIT_STEP, 0.0, 1.0), (0.3, 0.3, 1.0), (0.3, 0.0, 0.3), (0.7, 0.7, 1.0),
    ],
)  # fmt: skip
def test_derivatives_are_of_the_second_order(z: float, low: float, high: float) -> None:
    """Exact for parabolas, inside, at a bound and beside an edge; no step leaves the bounds."""
    found = jacobian(parabola(low, high), np.array([0.5, z]))
    assert found == pytest.approx(np.array([[0.0, 2.0 * z], [0.0, 3.0], [1.0, 0.0]]), abs=1e-9)


# --- what a fit says -----------------------------------------------------------------------------


def test_what_a_fit_says_of_itself() -> None:
    objective = linear()
    found = fitted(objective, 0.9e-3, 1.1e-3, 1.0 - 0.9e-3)
    assert found.at_bounds == {PATHS[0]: "low", PATHS[2]: "high"}
    off = np.array([0.03, -0.04, 0.05, -0.2])
    found = replace(found, predicted=(MATRIX @ END + 100.0) * (1.0 + off))
    assert found.deviations == pytest.approx(off)
    assert [found.within(part) for part in (0.02, 0.035, 0.045, 0.06, 0.3)] == [0, 1, 2, 3, 4]
    other = AT._replace(speed_rpm=450.0)
    one = Target(name="x", quantity="duration_s", at=AT, value=1.0, sigma=1.0)
    two = replace(one, since=other)
    for here, before, single, change in (
        (True, True, True, True), (True, False, True, False), (False, True, False, False),
        (True, None, True, None), (None, False, None, False),
    ):  # fmt: skip
        held = replace(found, premises={AT: Premise(here, ""), other: Premise(before, "")})
        assert held.premise_holds(one) is single
        assert held.premise_holds(two) is change


def test_what_targets_determine() -> None:
    """Slopes by sigmas, without the prior; and what is said of them."""
    found = determinability(linear(prior_weight=5.0), END)
    slope = MATRIX / 2.0
    assert found.jacobian == pytest.approx(slope, abs=1e-9)
    assert found.singular_values == pytest.approx(
        np.sqrt(np.linalg.eigvalsh(slope.T @ slope))[::-1]
    )
    made = replace(found, narrowed=np.array([0.51, 0.2, 0.49]), correlations=np.array(
        [[1.0, -0.6, 0.3], [-0.6, 1.0, 0.7], [0.3, 0.7, 1.0]]))  # fmt: skip
    assert made.ranked() == ((PATHS[1], 0.2), (PATHS[2], 0.49), (PATHS[0], 0.51))
    assert made.determined == (PATHS[1], PATHS[2])
    assert made.strongest(0.6) == ((PATHS[1], PATHS[2], 0.7), (PATHS[0], PATHS[1], -0.6))
    # Half of a range of deviation 1 / sqrt(12) is left where 1 / (s^2 + 12) is 1 / 48.
    edge = replace(found, singular_values=np.array([9.0, 6.01, 5.99]))
    assert edge.identifiable_directions == 2


@pytest.mark.parametrize("place", [0, 2])
def test_profile_of_a_line(place: int) -> None:
    """Half the least sum of squares with one number held: a parabola, exactly.

    Its curvature is the inverse of the number's variance, prior included. Derivatives of a line
    are exact but for round-off; the descents stop at 1e-7 of the cost.
    """
    objective = linear(prior_weight=3.0)
    slope = np.vstack([MATRIX / 2.0, 3.0 * np.eye(3)])
    right = np.concatenate([MATRIX @ END / 2.0, 3.0 * OWN])
    best = np.linalg.solve(slope.T @ slope, slope.T @ right)
    deviation = math.sqrt(np.linalg.inv(slope.T @ slope)[place, place])
    found = profile(fitted(objective, *best), PATHS[place], points=5, reach=2.0, workers=1)
    steps, (low, high) = np.array([-2.0, -1.0, 0.0, 1.0, 2.0]), RANGES[place]
    assert found.path == PATHS[place]
    assert found.sigma == pytest.approx(deviation * (high - low), rel=1e-6)
    values = low + (high - low) * (best[place] + steps * deviation)
    assert found.values == pytest.approx(values, rel=1e-6)
    assert found.quadratic == pytest.approx(0.5 * steps**2, abs=1e-5)
    assert found.cost == pytest.approx(0.5 * steps**2, abs=1e-4)


def test_profile_at_a_bound_and_beside_an_edge() -> None:
    """Off the best point the misfit has a slope; values beyond an edge have no cost.

    From the bound on: (2 + 4 z)^2 / 2 above its value at z = 0; a sigma of 1/4 reaches z = 1, where
    no machine is. A number that is the only one is held, and nothing else is fitted.
    """
    matrix, z = np.diag([4.0, 9.0, 9.0]), np.array([0.0, 0.25, 0.5, 0.75])
    objective = Linear(problem(np.zeros(3), np.ones(3)), matrix=matrix,
                       offset=np.array([2.0, -4.5, -4.5]), edge=0.9)  # fmt: skip
    first = replace(
        objective, matrix=matrix[:1, :1], offset=objective.offset[:1],
        problem=replace(objective.problem, parameters=objective.problem.parameters[:1],
                        targets=objective.problem.targets[:1]),
    )  # fmt: skip
    for fit in (fitted(objective, 0.0, 0.5, 0.5), fitted(first, 0.0)):
        found = profile(fit, PATHS[0], points=5, reach=4.0, workers=1)
        assert found.values == pytest.approx(8.0 + 8.0 * z)
        assert found.cost == pytest.approx(8.0 * z + 8.0 * z**2, abs=1e-5)
        assert found.quadratic == pytest.approx(8.0 * z + 8.0 * z**2, abs=1e-5)
        assert found.sigma == pytest.approx(8.0 / 4.0)


# --- limits --------------------------------------------------------------------------------------


def cycle(closing: float, opening: float, gap: float, force: float) -> WorkingCycle:
    """A jaw that opens by a degree more in one sample, and a stop force of 2 N less in another."""
    gaps, forces = np.full(SAMPLES, math.radians(gap)), np.full(SAMPLES, force)
    gaps[7] += math.radians(1.0)
    forces[9] -= 2.0
    waiting = Phase(np.arange(float(SAMPLES)), gaps, forces)
    return WorkingCycle(650.0, closing, opening, waiting, waiting, 77.0)


@pytest.mark.parametrize(
    ("found", "wanted"),
    [
        (cycle(34.0, 8.0, 30.0, 12.0), (0.0, 0.0, 0.0, 0.0)),
        (cycle(35.1, 6.9, 28.8, 11.5), (2.0, -2.0, -1.0, -0.5)),
        (cycle(32.9, 9.1, 29.0, 10.0), (-2.0, 2.0, 0.0, -2.0)),
        # The short way around the turn of 40.
        (cycle(34.0, 39.0, 29.0, 12.0), (0.0, -160.0, 0.0, 0.0)),
    ],
)
def test_how_far_a_cycle_is_outside(found: WorkingCycle, wanted: tuple[float, ...]) -> None:
    """In sigmas of 0.05 indices, 0.2 degrees and 1 N; each sample of the force has its own row."""
    limits = Limits(at=AT, closing_index=(33.0, 35.0), opening_index=(7.0, 9.0), stop_force_N=10.0,
                    jaw_opening_deg=30.0)  # fmt: skip
    assert excesses(limits, found) == pytest.approx(wanted)
    rows = limit_rows(limits, found)
    assert rows[3 + 9] == pytest.approx(wanted[3])
    assert rows[3] == pytest.approx(min(0.0, wanted[3] + 2.0))
    none = Limits(at=AT, closing_index=None, opening_index=None, stop_force_N=None,
                  jaw_opening_deg=None)  # fmt: skip
    assert not limit_rows(none, found).any()


def test_a_fit_that_breaks_its_limits() -> None:
    """Each by more than its uncertainty; the record has them in their own units."""
    right = fitted(linear(), *END, excess=np.array([0.9, -0.9, -1.0, -1.0]))
    right.check()
    assert right.broken_limits == {}
    wrong = replace(right, excess=np.array([1.5, -2.0, -3.0, -4.0]))
    told = {"closing_index": 0.075, "opening_index": -0.1, "jaw_opening_deg": -0.6,
            "stop_force_N": -4.0}  # fmt: skip
    assert wrong.broken_limits == pytest.approx(told)
    with pytest.raises(MisfitError, match=r"closing_index by \+0.075, opening_index by -0.1, jaw"):
        wrong.check()


def test_a_start_that_was_lost_is_in_the_record() -> None:
    """JSON has no infinity: its end and its cost are null."""
    fit = fitted(linear(), *END, excess=np.array([0.5, 0.0, -3.0, 0.0]))
    lost = replace(fit.best, cost=math.inf, converged=False, steps=64)
    fit = replace(fit, descents=(fit.best, lost))
    found = record(fit, fit.goodness, fit.known)
    begun = fit.objective.values(fit.best.start)
    assert found["starts"] == [
        {"cost": fit.best.cost, "steps": 12, "converged": True, "from": begun, "to": fit.values},
        {"cost": None, "steps": 64, "converged": False, "from": begun, "to": None},
    ]  # fmt: skip
    assert found["limits"] == {
        "closing_index": 0.5, "opening_index": 0.0, "jaw_opening_deg": -3.0, "stop_force_N": 0.0,
    }  # fmt: skip
    assert [row["why"] for row in found["parameters"]] == [f"because of {path}" for path in PATHS]


def test_the_record_of_a_line() -> None:
    """Every number that it states, by plain algebra with a range's own variance of 1 / 12."""
    off = np.array([3.0, -1.0, 2.0, 5.0])
    fit = fitted(linear(off=off), *END)
    found = record(fit, fit.goodness, fit.known)
    slope, wanted = MATRIX / 2.0, MATRIX @ END + 100.0 + off
    covariance = np.linalg.inv(slope.T @ slope + 12.0 * np.eye(3))
    chi_square, freedom = float((off**2).sum() / 4.0), 4.0 - np.trace(slope @ covariance @ slope.T)
    scale = math.sqrt(chi_square / freedom)
    scaled = np.linalg.inv(slope.T @ slope / scale**2 + 12.0 * np.eye(3))
    good = {key: found["goodness"][key] for key in
            ("chi_square", "degrees_of_freedom", "probability", "scale")}  # fmt: skip
    assert good == pytest.approx({
        "chi_square": chi_square, "degrees_of_freedom": freedom, "scale": scale,
        "probability": chi2.sf(chi_square, freedom),
    }, rel=1e-6)  # fmt: skip
    deviations = np.sqrt(np.diag(covariance))
    correlations = covariance / np.outer(deviations, deviations)
    assert np.array(found["correlations"]) == pytest.approx(correlations, abs=1e-9)
    values = np.array(found["singular_values"])
    rows = np.array([[row[path] for path in PATHS] for row in found["directions"]])
    assert rows.T @ np.diag(values**2) @ rows == pytest.approx(slope.T @ slope, rel=1e-6)
    assert found["cost"] == pytest.approx(0.5 * chi_square)
    for place, (row, (low, high)) in enumerate(zip(found["parameters"], RANGES, strict=True)):
        deviation, larger = (math.sqrt(item[place, place]) for item in (covariance, scaled))
        assert (row["low"], row["high"], row["at_bound"]) == (low, high, None)
        assert row["identified"] == pytest.approx(low + END[place] * (high - low))
        assert row["standard_deviation"] == pytest.approx(deviation * (high - low))
        assert row["standard_deviation_scaled"] == pytest.approx(larger * (high - low), rel=1e-6)
        assert row["range_left"] == pytest.approx(deviation * math.sqrt(12.0))
        assert row["determined"] == (row["range_left"] < 0.5)
    for place, row in enumerate(found["targets"]):
        assert (row["wanted"], row["sigma"]) == (wanted[place], 2.0)
        assert row["found"] == pytest.approx(wanted[place] - off[place])
        assert row["residual_sigmas"] == pytest.approx(-off[place] / 2.0)
        assert row["relative_deviation"] == pytest.approx(-off[place] / wanted[place])
    within = np.abs(off / wanted)
    assert found["within_4_percent"] == np.count_nonzero(within <= 0.04)
    assert found["within_10_percent"] == np.count_nonzero(within <= 0.1)

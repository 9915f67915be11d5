"""Every number of a fit, of its starts and of its search, of problems that are linear."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from linear_problem import AT, PATHS, RANGES, STARTS, Linear, fitted, problem
from scipy.stats import qmc

from nipper_pin.errors import InputError, MisfitError, SimulationError
from nipper_pin.hybrid.result.premise import Premise
from nipper_pin.study.identify.fitting import fit as fit_module
from nipper_pin.study.identify.fitting import profiles, search
from nipper_pin.study.identify.fitting.determine import determinability
from nipper_pin.study.identify.fitting.fit import descend
from nipper_pin.study.identify.fitting.limits import broken_limits
from nipper_pin.study.identify.problem.targets import Target

MATRIX = np.array([[30.0, 5.0, 0.0], [0.0, 40.0, -3.0], [2.0, 0.0, 50.0], [9.0, 9.0, 9.0]])


def linear(end: tuple[float, float, float] = (0.3, 0.6, 0.4), **others: Any) -> Linear:
    """Targets of sigma two that are met at an end."""
    wanted = MATRIX @ np.array(end) + 100.0
    edge = others.pop("edge", 2.0)
    asked = problem(wanted, np.full(4, 2.0), **others)
    return Linear(asked, matrix=MATRIX, offset=np.full(4, 100.0), edge=edge)


def test_a_fit_of_a_line() -> None:
    """The end is that of the normal equations, from any start; the cost half the sum of squares."""
    objective = linear(prior_weight=3.0)
    own = objective.start
    low, high = np.array(RANGES).T
    assert own == pytest.approx((np.array(STARTS) - low) / (high - low))
    slope = np.vstack([MATRIX / 2.0, 3.0 * np.eye(3)])
    right = np.concatenate([MATRIX @ np.array([0.3, 0.6, 0.4]) / 2.0, 3.0 * own])
    best = np.linalg.solve(slope.T @ slope, slope.T @ right)
    cost = 0.5 * float(((slope @ best - right) ** 2).sum())
    for start in (np.array([0.9, 0.1, 0.5]), np.array([[0.9, 0.1, 0.5], [0.1, 0.1, 0.1]])):
        found = descend(objective, start)
        assert found.start.tolist() == [0.9, 0.1, 0.5]
        assert found.z == pytest.approx(best, abs=1e-5)
        assert found.cost == pytest.approx(cost, rel=1e-6)
        assert (found.converged, found.reason) == (True, "")
        assert 2 <= found.steps < 20
    assert not descend(objective, np.array([0.9, 0.1, 0.5]), max_steps=1).converged
    # The first draw that makes a machine, and why none does.
    edged = linear(edge=0.8)
    found = descend(edged, np.array([[0.9, 0.1, 0.1], [0.2, 0.2, 0.2], [0.7, 0.7, 0.7]]))
    assert found.start.tolist() == [0.2, 0.2, 0.2]
    assert found.z == pytest.approx([0.3, 0.6, 0.4], abs=1e-5)
    none = descend(linear(edge=-1.0), np.array([[0.9, 0.1, 0.1], [0.2, 0.2, 0.2]]))
    assert (none.cost, none.steps, none.converged, none.reason) == (
        math.inf, 2, False, "no machine",
    )  # fmt: skip
    assert none.z.tolist() == none.start.tolist() == [0.9, 0.1, 0.1]


def test_residuals_without_a_machine() -> None:
    """Above all residuals of the machine that a descent starts from, and a thousand at least."""
    objective = linear(prior_weight=2.0, edge=0.5)
    rows = objective.residuals(np.array([0.6, 0.1, 0.1]))
    prior = 2.0 * (np.array([0.6, 0.1, 0.1]) - objective.start)
    assert rows == pytest.approx([1e3] * 4 + prior.tolist())
    assert objective.fenced(np.array([-300.0, 2.0])).unusable == 3000.0
    assert objective.fenced(np.array([-3.0, 2.0])).unusable == 1000.0
    inside = objective.rows(np.array([0.3, 0.5, 0.4]))
    assert inside[:4] == pytest.approx(MATRIX @ np.array([0.0, -0.1, 0.0]) / 2.0)
    numbers = objective.values(np.array([0.25, 0.5, 1.0]))
    assert numbers == pytest.approx({PATHS[0]: 10.0, PATHS[1]: 0.2, PATHS[2]: 2.6})
    assert objective.misfit(np.zeros(4)) == pytest.approx(
        -(MATRIX @ np.array([0.3, 0.6, 0.4]) + 100.0) / 2.0
    )


def test_what_a_fit_says_of_itself() -> None:
    objective = linear()
    found = fitted(objective, 0.9e-3, 1.1e-3, 1.0 - 0.9e-3)
    assert found.at_bounds == {PATHS[0]: "low", PATHS[2]: "high"}
    assert fitted(objective, 0.5, 0.4, 1.0 - 1.1e-3).at_bounds == {}
    wanted = np.array([target.value for target in objective.problem.targets])
    off = np.array([0.03, -0.04, 0.05, -0.2])
    found = replace(found, predicted=wanted * (1.0 + off))
    assert found.deviations == pytest.approx(off)
    assert [found.within(part) for part in (0.02, 0.035, 0.045, 0.06, 0.3)] == [0, 1, 2, 3, 4]
    assert found.best is found.descents[0]
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


def test_a_fit_that_cannot_be_used(monkeypatch: pytest.MonkeyPatch) -> None:
    """By its data, or by a limit that it breaks, each by more than its uncertainty."""
    right = fitted(linear(), 0.3, 0.6, 0.4, excess=np.array([0.9, -0.9, -1.0, -1.0]))
    monkeypatch.setattr(type(right), "goodness", SimpleNamespace(check=lambda: None))
    right.check()
    assert right.broken_limits == {}
    wrong = replace(right, excess=np.array([1.5, -2.0, -3.0, -4.0]))
    # Of 0.05 indices, 0.2 degrees and 1 N.
    told = {"closing_index": 0.075, "opening_index": -0.1, "jaw_opening_deg": -0.6,
            "stop_force_N": -4.0}  # fmt: skip
    assert wrong.broken_limits == pytest.approx(told)
    with pytest.raises(MisfitError, match=r"closing_index by \+0.075, opening_index by -0.1, jaw"):
        wrong.check()
    assert broken_limits(np.zeros(0)) == {}


def test_what_targets_determine() -> None:
    """Covariance with a range's own variance of 1 / 12 for each number, by plain algebra."""
    objective = linear(prior_weight=5.0)
    found = determinability(objective, np.array([0.3, 0.6, 0.4]))
    slope = MATRIX / 2.0
    assert found.paths == PATHS
    assert found.jacobian == pytest.approx(slope, abs=1e-9)
    assert found.singular_values == pytest.approx(
        np.sqrt(np.linalg.eigvalsh(slope.T @ slope))[::-1]
    )
    for scale in (1.0, 2.5):
        inverse = np.linalg.inv(slope.T @ slope / scale**2 + 12.0 * np.eye(3))
        deviations = np.sqrt(np.diag(inverse))
        assert list(found.scaled_deviations(scale).values()) == pytest.approx(deviations)
        if scale == 1.0:
            assert list(found.deviations.values()) == pytest.approx(deviations)
            assert found.narrowed == pytest.approx(deviations * math.sqrt(12.0))
            right = inverse / np.outer(deviations, deviations)
            assert found.correlations == pytest.approx(right)
    made = replace(found, narrowed=np.array([0.51, 0.2, 0.49]), correlations=np.array(
        [[1.0, -0.6, 0.3], [-0.6, 1.0, 0.7], [0.3, 0.7, 1.0]]))  # fmt: skip
    assert made.ranked() == ((PATHS[1], 0.2), (PATHS[2], 0.49), (PATHS[0], 0.51))
    assert made.determined == (PATHS[1], PATHS[2])
    assert made.strongest(0.3) == (
        (PATHS[1], PATHS[2], 0.7), (PATHS[0], PATHS[1], -0.6), (PATHS[0], PATHS[2], 0.3),
    )  # fmt: skip
    assert len(made.strongest(0.65)) == 1
    # Half of a range of deviation 1 / sqrt(12) is left where 1 / (s^2 + 12) is 1 / 48.
    edge = replace(found, singular_values=np.array([9.0, 6.01, 5.99]))
    assert edge.identifiable_directions == 2


@pytest.mark.parametrize("holds", [True, None, False])
def test_a_search_for_a_line(monkeypatch: pytest.MonkeyPatch, holds: bool | None) -> None:
    """Starts, what is told, and a second search from the first one's end where turns differ."""
    monkeypatch.setattr(search, "Objective", lambda asked: replace(linear(), problem=asked))
    monkeypatch.setattr(search, "mapped", lambda task, items, _: map(task, items))
    premises = {AT: Premise(holds, "why")}
    monkeypatch.setattr(search, "premises", lambda *_: premises)
    begins: list[Any] = []
    real = fit_module.descend

    def followed(objective: Linear, begin: np.ndarray) -> Any:
        begins.append((objective.true, begin))
        return real(objective, begin)

    monkeypatch.setattr(search, "descend", followed)
    told: list[tuple[int, int, float]] = []
    found = search.identify(linear().problem, starts=3, seed=11, workers=1,
                            progress=lambda *words: told.append(words))  # fmt: skip
    assert found.seed == 11
    assert found.best.z == pytest.approx([0.3, 0.6, 0.4], abs=1e-5)
    assert [item.cost for item in found.descents] == sorted(item.cost for item in found.descents)
    assert found.values == pytest.approx(linear().values(np.array([0.3, 0.6, 0.4])), rel=1e-5)
    assert found.predicted == pytest.approx(linear().predicted(found.best.z))
    assert found.premises is premises
    assert found.excess.shape == (0,)
    assert begins[0][1] == pytest.approx(linear().start)
    draws = qmc.Sobol(3, rng=np.random.default_rng(11)).random(128).reshape(2, 64, 3)
    for (true, begin), points in zip(begins[1:3], draws, strict=True):
        assert not true
        assert begin == pytest.approx(0.1 + 0.8 * points)
    rounds = 2 if holds is False else 1
    assert [words[:2] for words in told] == [(1, 3), (2, 3), (3, 3)] * rounds
    assert [words[2] for words in told[:3]] == sorted((w[2] for w in told[:3]), reverse=True)
    assert len(begins) == 3 * rounds
    assert found.objective.true is (holds is False)
    if rounds == 2:
        assert begins[3][1] == pytest.approx([0.3, 0.6, 0.4], abs=1e-5)
        assert all(true for true, _ in begins[3:])


def test_searches_that_cannot_be(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        search, "Objective", lambda asked: replace(linear(edge=-1.0), problem=asked)
    )
    with pytest.raises(SimulationError, match=r"none of 2 starts .* nor is the .* no machine"):
        search.identify(linear().problem, starts=2, seed=3, workers=1)
    for name in ("starts", "workers"):
        with pytest.raises(InputError, match=f"{name} = 0 cannot be used") as caught:
            search.identify(linear().problem, **{name: 0})  # type: ignore[arg-type]
        assert (caught.value.evidence["key"], caught.value.evidence["value"]) == (name, 0)


def test_a_profile_of_the_only_number() -> None:
    """Half the sum of squares where nothing is left to fit; infinite where there is no machine."""
    rows = lambda z: np.array([3.0 * z[0], 4.0])  # noqa: E731
    objective: Any = SimpleNamespace(rows=rows)
    assert profiles._held(objective, np.array([0.9]), 0, 1.0) == 12.5

    def none(_: Any) -> Any:
        message = "no machine"
        raise SimulationError(message)

    assert profiles._held(SimpleNamespace(rows=none), np.array([0.9]), 0, 1.0) == math.inf  # type: ignore[arg-type]

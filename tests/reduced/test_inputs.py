"""What a case may be, where each of its numbers goes, and how a case without rest is refused."""

from __future__ import annotations

import inspect
import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from snapshots import Words
from written_tables import lowered

import nipper_pin.reduced
from nipper_pin import InputError, Mechanism, NipperError, SimulationError
from nipper_pin.reduced import ReducedModel, Status, build, results, transition, transitions
from nipper_pin.reduced.model import Arrival

RPM = 500.0


SHARES, PRELOADS = np.array([0.3, 0.7]), np.array([0.031, 0.002])


@pytest.fixture(scope="module")
def parallel(model: ReducedModel) -> ReducedModel:
    """Two springs in the place of one: of other rates and preloads, and of its force in sum."""

    charts = model.charts
    both = [*range(6), 4, 5]
    return replace(
        model, springs=("one", "two"),
        numbers=np.concatenate([model.numbers[:-2], model.numbers[-2] * SHARES, PRELOADS]),
        arrival=Arrival(why="not of two springs"),
        charts=charts._replace(
            # Code is compiled anew for arrays of another order.
            equation=np.ascontiguousarray(charts.equation[..., both, :]),
            along=np.ascontiguousarray(charts.along[..., both, :]), bounds=charts.bounds[:, both],
        ),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("given", "alone"),
    [
        ({}, (9000.0, SHARES @ PRELOADS)),
        ({"stiffness": 4000.0}, (8000.0, PRELOADS.mean())),
        ({"stiffness": [2000.0, 6000.0]}, (8000.0, 0.25 * PRELOADS[0] + 0.75 * PRELOADS[1])),
        ({"preload": 0.012}, (9000.0, 0.012)),
        ({"preload": [0.02, 0.005]}, (9000.0, 0.3 * 0.02 + 0.7 * 0.005)),
    ],
)
def test_springs_in_parallel_are_one(
    model: ReducedModel, parallel: ReducedModel, given: dict[str, Any], alone: tuple[float, float]
) -> None:
    """Of the sum of their rates, and of the preload that has the sum of their forces."""
    stiffness, preload = alone
    one = transition(model, speed_rpm=RPM, stiffness=stiffness, preload=preload)
    two = transition(parallel, speed_rpm=RPM, **given)
    rows = {key: [value] * 2 if isinstance(value, list) else value for key, value in given.items()}
    many = transitions(parallel, speed_rpm=[RPM, RPM], **rows)
    assert two.duration == pytest.approx(one.duration, rel=1e-9)
    assert many.duration.tolist() == [two.duration] * 2


def test_rows_of_springs_that_do_not_fit(parallel: ReducedModel) -> None:
    """One number for all, one for each, or a row a case."""
    for value in ([1.0, 2.0, 3.0], [[1.0], [2.0]], [[[1.0]]], [1.0, math.nan], math.inf, -1e-9):
        for solve in (transition, transitions):
            with pytest.raises(InputError) as caught:
                solve(parallel, speed_rpm=RPM, stiffness=value)  # type: ignore[operator]
            assert caught.value.evidence["key"] == "stiffness"
    with pytest.raises(InputError, match="stiffness"):
        transition(parallel, speed_rpm=RPM, stiffness=[1.0])


@pytest.mark.parametrize(
    ("key", "good", "bad"),
    [
        ("speed_rpm", (RPM, np.float32(RPM), np.int64(500), 500), (0.0, -1.0, math.nan, math.inf)),
        ("restitution", (0.0, 0, np.float32(0.25)), (1.1, -0.1, math.nan)),
        ("stiffness", (9000.0, 9000), (-1.0, math.nan, math.inf, [[1.0, 2.0]])),
        ("preload", (0.011, np.float64(0.011)), (math.nan, math.inf)),
        ("tolerance", (1e-13, 1e-3), (0.9e-13, 1.1e-3, math.nan)),
        ("max_collisions", (32,), (0, -1)),
        ("rest_rate", (1e-3, None), (0.0, -1.0, math.inf, math.nan)),
    ],
)
def test_numbers_of_a_case(model: ReducedModel, key: str, good: Any, bad: Any) -> None:
    """At their limits, alone and in a batch; beyond them refused by exactly their name."""
    for solve in (transition, transitions):
        for value in good:
            solve(model, **{"speed_rpm": RPM, key: value})  # type: ignore[operator]
        for value in bad:
            with pytest.raises(InputError) as caught:
                solve(model, **{"speed_rpm": RPM, key: value})  # type: ignore[operator]
            assert caught.value.evidence["key"] == key


def test_one_case_a_call(model: ReducedModel) -> None:
    several: Any = {"speed_rpm": [500.0, 600.0]}, {"speed_rpm": RPM, "stiffness": [9e3, 8e3]}
    for given in several:
        with pytest.raises(InputError, match=[*given][-1]):
            transition(model, **given)


def test_cases_of_a_batch_go_together(model: ReducedModel) -> None:
    """One number counts for all of them; rows of two lengths do not."""
    preloads = [0.010, 0.011, 0.012]
    many = transitions(model, speed_rpm=RPM, preload=preloads)
    assert many.duration.tolist() == [
        transition(model, speed_rpm=RPM, preload=preload).duration for preload in preloads
    ]
    with pytest.raises(InputError, match="need the same number of cases"):
        transitions(model, speed_rpm=[300.0, 400.0], preload=preloads)


def test_one_transition_may_have_more_collisions_than_most(model: ReducedModel) -> None:
    """It is that of a batch with room for all of them, and ends by their number where that is."""
    given: dict[str, Any] = {"speed_rpm": 200.0, "restitution": 0.8}
    found, batch = transition(model, **given), transitions(model, max_collisions=64, **given)
    assert found.collisions == batch.collisions[0] > 32
    np.testing.assert_array_equal(found.table, batch.table[0, :, : found.collisions])
    with pytest.raises(SimulationError, match="after 34 collisions"):
        transition(model, max_collisions=34, **given)


def without_rest(e62: Mechanism, model: ReducedModel) -> list[tuple[Any, dict[str, Any], Status]]:
    """Models, cases, and how each ends."""
    charts = model.charts
    near, far, jump = charts.gaps.copy(), charts.gaps.copy(), charts.equation.copy()
    near[:, 0, :, 0, 0] -= 1e-3
    far[:, 0, :, 0, 0] += 1e-3
    # From one cell to the next, within a flight.
    jump[0, 1:, 0, 0, 0] -= 1e4
    low = lowered(model.arrival)
    flying = {"speed_rpm": 690.0, "restitution": 0.3, "stiffness": 7000.0, "preload": 0.0085,
              "assumed": False}  # fmt: skip
    return [
        (build(e62, travel_rad=0.5, gap_max=0.02), {"restitution": 0.3}, Status.LEFT_TRAVEL),
        (build(e62, gap_max=0.004), {}, Status.LEFT_GAP),
        (replace(model, charts=charts._replace(gaps=near)), {}, Status.OTHER_STOP),
        (replace(model, charts=charts._replace(gaps=far)), {}, Status.AT_REST),
        (model, {"restitution": 0.0, "preload": -0.05}, Status.NOT_PRESSED),
        (model, {"restitution": 0.6, "max_collisions": 3}, Status.TOO_MANY_COLLISIONS),
        (replace(model, charts=charts._replace(equation=jump)), {}, Status.UNRESOLVED),
        (replace(model, arrival=Arrival(why="stops jam")), {"assumed": False}, Status.UNTOLD),
        (replace(model, arrival=low), flying, Status.UNTOLD),
    ]


def test_a_transition_without_rest_is_refused(
    e62: Mechanism, model: ReducedModel, words: Words
) -> None:
    """With its reason, and marked in a batch, whose other cases come to rest."""
    said = []
    for made, keys, status in without_rest(e62, model):
        given = {"speed_rpm": 650.0, **keys}
        batch = transitions(made, **given)
        assert (batch.status.tolist(), np.isnan(batch.duration).tolist()) == (
            [status], [status != Status.AT_REST],
        )  # fmt: skip
        if status == Status.AT_REST:
            assert transition(made, **given).collisions > 5
            continue
        outside = status in (Status.LEFT_TRAVEL, Status.LEFT_GAP)
        kind: type[NipperError] = InputError if outside else SimulationError
        with pytest.raises(kind) as caught:
            transition(made, **given)
        assert caught.value.evidence == {
            "status": status.name, "speed_rpm": given["speed_rpm"],
            "collisions": batch.collisions[0],
        }  # fmt: skip
        said.append(str(caught.value))
    words("\n".join(said) + "\n")
    mixed = transitions(build(e62, gap_max=0.004), speed_rpm=[450.0, 650.0, 400.0])
    assert mixed.status.tolist() == [Status.AT_REST, Status.LEFT_GAP, Status.AT_REST]
    assert np.isnan(mixed.duration).tolist() == [False, True, False]


def test_advice_names_what_there_is() -> None:
    """Each function that a reason names exists, and takes what it says to give it."""
    knobs = 0
    for reason in results.REASONS.values():
        for name, rest in re.findall(r"nipper_pin\.reduced\.(\w+) with ([^;,]*)", reason):
            taken = inspect.signature(getattr(nipper_pin.reduced, name)).parameters
            named = re.findall(r"\b[a-z]+_[a-z]+\b|\b\w+(?==)", rest)
            assert named, reason
            assert set(named) <= set(taken), reason
            knobs += len(named)
    assert knobs >= 4

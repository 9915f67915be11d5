"""How a turn arrives at the touch, by tables, judged by whole turns of the direct engine."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from written_tables import lowered

from nipper_pin import Case, Mechanism, Resolution, SimulationError, load, transition_table
from nipper_pin.mechanism import retuned
from nipper_pin.reduced import ReducedModel, Status, build, transition, transitions
from nipper_pin.reduced.model import Arrival
from nipper_pin.study.true_transition import true_transition

# Fast, soft and little preloaded: many of them arrive with their steeve off its stop.
RISKY = {
    "speed_rpm": (600.0, 690.0),
    "restitution": (0.02, 0.3),
    "stiffness": (7000.0, 9000.0),
    "preload": (0.0085, 0.0105),
}


def risky(count: int, seed: int) -> dict[str, Any]:
    random = np.random.default_rng(seed)
    return {name: random.uniform(*span, count) for name, span in RISKY.items()}


def named(cases: dict[str, Any]) -> dict[str, Any]:
    """The same for a table, whose arguments have their units in their names."""
    return {
        "speed_rpm": cases["speed_rpm"],
        "restitution": cases["restitution"],
        "stiffness_N_per_m": cases["stiffness"],
        "preload_length_mm": 1e3 * cases["preload"],
    }


def judge(mechanism: Mechanism, cases: dict[str, Any], number: int) -> Any:
    """The transition that the direct engine finds, in whole turns if need be."""
    tuned = retuned(
        mechanism,
        restitution={mechanism.transition_stop: float(cases["restitution"][number])},
        stiffness=[cases["stiffness"][number]],
        preload=[cases["preload"][number]],
    )
    tolerance = Resolution(tolerance=1e-13)
    return true_transition(
        tuned, Case(speed_rpm=float(cases["speed_rpm"][number]), resolution=tolerance)
    )


@pytest.mark.slow
def test_agrees_with_whole_turns(e62: Mechanism, model: ReducedModel) -> None:
    """Both verdicts, and the transition of the turn within the stated errors."""
    cases = risky(24, 3)
    found = transitions(model, assumed=False, **cases)
    assert (found.premise == 1).sum() >= 5
    assert (found.premise == 0).sum() >= 5
    assert (found.premise >= 0).all()
    for number in range(24):
        true = judge(e62, cases, number)
        assert bool(found.premise[number]) is true.premise_holds
        for key, wrong in (
            ("approach_rate", "rate_error"),
            ("rebound_amplitude", "amplitude_error"),
            ("rebound_time", "rebound_error"),
        ):
            for place in (0, 1):
                here = getattr(found, key)[number, place]
                stated = getattr(found, wrong)[number, place]
                there = getattr(true.collisions[place], key)
                own = true.errors[place].impulse * abs(there)
                own += true.errors[min(place + 1, len(true.errors) - 1)].time
                assert abs(here - there) <= stated + 2.0 * own, (number, key, place)
        angle = true.collisions[0].cylinder_angle
        turn = 2.0 * np.pi
        apart = (found.cylinder_angle[number, 0] - angle + 0.5 * turn) % turn - 0.5 * turn
        assert abs(apart) < 1e-9
        assert true.transition is not None
        error = found.duration_error[number] + 2.0 * (true.duration_error or 0.0)
        assert abs(found.duration[number] - true.transition.duration) <= error


def test_assumed_or_not(model: ReducedModel) -> None:
    """What is assumed starts as ever; the verdict is the same, and true cases do not differ."""
    cases = risky(40, 7)
    assumed, true = (transitions(model, assumed=how, **cases) for how in (True, False))
    holds = true.premise == 1
    np.testing.assert_array_equal(assumed.premise[holds], 1)
    np.testing.assert_array_equal(assumed.duration[holds], true.duration[holds])
    fails = true.premise == 0
    assert (assumed.approach_rate[:, 0] / cases["speed_rpm"]).std() < 1e-12
    assert (true.approach_rate[fails, 0] != assumed.approach_rate[fails, 0]).all()


def test_a_stop_that_is_let_go_before_its_opening(model: ReducedModel) -> None:
    """Its transition is as assumed, but not known to be that of the turn, which is not told."""
    charts = model.arrival.charts
    assert charts is not None
    along = charts.along.copy()
    along[0] *= -1.0
    pulled = replace(model, arrival=replace(model.arrival, charts=charts._replace(along=along)))
    assumed, true = (transitions(pulled, speed_rpm=[450.0, 650.0], assumed=how)
                     for how in (True, False))  # fmt: skip
    assert assumed.premise.tolist() == true.premise.tolist() == [-1, -1]
    assert (assumed.status == Status.AT_REST).all()
    assert (true.status == Status.UNTOLD).all()
    assert (true.collisions == 0).all()
    assert np.isnan(true.table).all()


def test_a_table_keeps_them(e62: Mechanism) -> None:
    """A table of many cases has the transition of the turn where the premise fails."""
    cases = risky(80, 11)
    table = transition_table(e62, **named(cases))
    false = [number for number in range(80) if table.premise_holds[number] is False]
    assert len(false) > 5
    assert (table.engine[false] == "reduced").all()
    assumed = transition_table(e62, engine="reduced", **named(cases))
    for number in false[:3]:
        hit = judge(e62, cases, number).collisions[0]
        assert table.approach_rate[number, 0] == pytest.approx(hit.approach_rate, rel=1e-8)
        assert abs(assumed.approach_rate[number, 0] / hit.approach_rate - 1.0) > 1e-6


def test_long_bounces_are_not_called_true(e62: Mechanism) -> None:
    """Bounces of the steeve after the opening that last until the touch."""
    lively = build(load("e62", {"stops.steeve.restitution": 0.97}))
    assert transition(lively, speed_rpm=650.0).premise_holds is not True
    assert transition(build(e62), speed_rpm=650.0).premise_holds is True


def test_the_transition_of_the_turn_is_refused_where_the_tables_cannot_tell_it(
    e62: Mechanism, model: ReducedModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Tables narrower than a turn, or than its flights: no transition as assumed in its place.

    Of eight cases that arrive in flight each leaves tables that end just above the stop. What does
    not ask for the turn is answered as ever.
    """
    cases = risky(8, 5)
    told = transitions(model, assumed=False, **cases)
    flying = told.premise == 0
    assert flying.any()
    low = replace(model, arrival=lowered(model.arrival))
    for narrow, why in (
        (replace(model, arrival=Arrival(why="it was not sampled")), "was not sampled"),
        (low, "leaves them"),
    ):
        lost = flying if narrow is low else np.full(8, True)
        assert transition(narrow, speed_rpm=450.0).premise_holds is None
        found = transitions(narrow, assumed=False, **cases)
        assert (found.status[lost] == Status.UNTOLD).all()
        assert (found.premise[lost] == -1).all()
        assert (found.collisions[lost] == 0).all()
        assert np.isnan(found.duration[lost]).all()
        assert np.isnan(found.table[lost]).all()
        place = int(np.flatnonzero(flying)[0])
        one = {key: float(value[place]) for key, value in cases.items()}
        with pytest.raises(SimulationError, match=why):
            transition(narrow, assumed=False, **one)
    # A table of many cases computes these by the direct engine.
    chosen = "nipper_pin.study.transitions.engine_choice"
    monkeypatch.setattr(f"{chosen}.REDUCED_PAYS_FROM", 2)
    monkeypatch.setattr(f"{chosen}.reduced_model", lambda *_: low)
    table = transition_table(e62, **{key: value[flying][:2] for key, value in named(cases).items()})
    assert table.engine.tolist() == ["turn"] * len(table)
    assert f"{len(table)} that its tables do not cover: direct" in table.why

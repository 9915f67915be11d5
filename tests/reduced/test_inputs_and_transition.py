"""What a case may be, where each of its numbers goes, and what comes back: nothing is computed."""

from __future__ import annotations

import inspect
import math
import re
import sys
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

import nipper_pin.reduced
from nipper_pin import InputError, NipperError, SimulationError
from nipper_pin.reduced import ReducedModel, Status, inputs, results, transition, transitions
from nipper_pin.reduced.kernels import kernel
from nipper_pin.reduced.kernels.layout import COLUMNS, FAILS, HOLDS, UNKNOWN
from nipper_pin.reduced.tables.arrival import unknown

WHY = "the turn is written nowhere"


def made(**changes: Any) -> ReducedModel:
    """A model of which no two numbers are equal; it has two springs."""
    arrays = {
        "equation": np.random.default_rng(1).normal(size=(8, 3, 4, 5)),
        "gaps": np.random.default_rng(2).normal(size=(2, 3, 4, 5)),
        "inertia": np.random.default_rng(3).normal(size=(3, 4)),
        **{
            name: np.random.default_rng(place).uniform(1.0, 2.0, 8)
            for place, name in enumerate(("residual", "largest", "steepest_x", "steepest_u"), 4)
        },
    }
    values: dict[str, Any] = {
        "name": "made", "stop": "table", "springs": ("one", "two"), "other_stops": ("a", "b"),
        "touch_angle_rad": 0.31, "sense": -1, "travel_rad": 2.7, "gap_low": -0.013, "gap_max": 0.17,
        "inertia_residual": 1e-9, "approach_rate": -0.41, "approach_residual": 2e-9, "lever": 0.23,
        "restitution": 0.37, "stiffness": np.array([900.0, 70.0]),
        "preload": np.array([0.011, -0.4]), "gravity_m_s2": 8.0, "tolerance": 1e-11, "samples": 77,
        "arrival": unknown(WHY), **arrays,
    }  # fmt: skip
    return ReducedModel(**{**values, **changes})


def test_what_compiled_code_reads_of_a_model() -> None:
    """Every array and number in its own place."""
    model = made()
    names = {
        "travel": "travel_rad", "low": "gap_low", "high": "gap_max", "approach": "approach_rate",
        "touch_angle": "touch_angle_rad",
    }  # fmt: skip
    for name, value in model.tables._asdict().items():
        np.testing.assert_array_equal(value, getattr(model, names.get(name, name)), err_msg=name)
    assert (model.cells, model.degrees) == (3, (4, 5))
    assert all(
        getattr(model.tables, name).flags.c_contiguous for name in ("equation", "gaps", "inertia")
    )


def test_models_are_compared_by_their_numbers_and_shown_without_their_arrays() -> None:
    """Arrays are neither compared, which numpy cannot do in one word, nor written out."""
    assert made() == made()
    assert made() != made(lever=0.24)
    assert "lever=0.23" in repr(made())
    assert "array" not in repr(made())


class Recorder:
    """In the place of compiled code: keeps what it is given and returns made-up results."""

    def __init__(self, status: int, premise: int) -> None:
        self.status, self.premise = status, premise
        self.table = np.arange(COLUMNS * 4.0).reshape(COLUMNS, 4)

    def one(self, *given: Any) -> Any:
        self.given = given
        return self.status, (3.0, 1e-3, 0.6, 1e-4), self.premise, self.table

    def batch(self, *given: Any) -> None:
        self.given = given
        table, status, counts, premise, rest = given[-5:]
        assert np.isnan(table).all()
        table[:, :, :4] = self.table
        status[:], counts[:], premise[:] = (self.status, 4, self.premise)
        rest[:] = np.array([3.0, 1e-3, 0.6, 1e-4]) + np.arange(len(rest))[:, None]


@pytest.fixture
def recorder(monkeypatch: pytest.MonkeyPatch) -> Recorder:
    found = Recorder(0, HOLDS)
    # The room exports the function by the name of its module.
    asked = sys.modules["nipper_pin.reduced.transition"]
    monkeypatch.setattr(asked, "_compiled", lambda: (found.one, "grids"))
    monkeypatch.setattr(kernel, "run_batch", found.batch)
    return found


ONE = (
    ({}, {}),
    ({"speed_rpm": 600.0}, {"speed": 20.0 * math.pi}),
    ({"restitution": 0.1}, {"restitution": 0.1}),
    ({"restitution": 1}, {"restitution": 1.0}),
    ({"stiffness": 50.0}, {"stiffness": [50.0, 50.0]}),
    ({"stiffness": [50.0, 0.0]}, {"stiffness": [50.0, 0.0]}),
    ({"preload": -0.01}, {"preload": [-0.01, -0.01]}),
    ({"preload": [0.02, -3.0]}, {"preload": [0.02, -3.0]}),
    ({"gravity": -4.0}, {"gravity": -0.5}),
    ({"rest_rate": 0.02}, {"rest_rate": 0.02}),
    ({"tolerance": 1e-5}, {"tolerance": 1e-5}),
    ({"assumed": False}, {"assumed": False}),
    ({"max_collisions": 9}, {"most": 9}),
)


@pytest.mark.parametrize(("given", "expected"), ONE)
@pytest.mark.parametrize("many", [False, True])
def test_every_number_of_a_case_goes_to_its_place(
    recorder: Recorder, given: dict[str, Any], expected: dict[str, Any], many: bool
) -> None:
    """In SI units; what is not given is that of the model. A batch has one row a case."""
    model = made()
    case = {"speed_rpm": 300.0, **given}
    if many:
        case["speed_rpm"] = [case["speed_rpm"]] * 3
        if isinstance(given.get("stiffness", given.get("preload")), list):
            case = {key: [value] * 3 if key in given else value for key, value in case.items()}
        transitions(model, **case)
    else:
        transition(model, **case)
    names = (
        "grids", "tables", "y", "turn", "speed", "restitution", "stiffness", "preload", "gravity",
        "rest_rate", "tolerance", "assumed", "most",
    )  # fmt: skip
    got = dict(zip(names, recorder.given, strict=not many))
    values = {
        "speed": 10.0 * math.pi, "restitution": 0.37, "stiffness": [900.0, 70.0],
        "preload": [0.011, -0.4], "gravity": 1.0, "rest_rate": 0.0, "tolerance": 1e-10,
        "assumed": True, "most": 256, **expected,
    }  # fmt: skip
    assert got["tables"] is model.tables
    assert got["y"] is model.arrival.tables
    assert got["turn"] is model.arrival.turn
    if many:
        assert got.pop("most").shape == (3, COLUMNS, expected.get("most", 32))
        del values["most"]
    for name, value in values.items():
        row = many and name in ("speed", "restitution", "stiffness", "preload", "gravity")
        np.testing.assert_allclose(got[name], [value] * 3 if row else value, rtol=1e-14)
    assert got["assumed"] is values["assumed"]


@pytest.mark.parametrize(("premise", "holds"), [(HOLDS, True), (FAILS, False), (UNKNOWN, None)])
def test_every_result_comes_from_its_place(
    recorder: Recorder, premise: int, holds: bool | None
) -> None:
    """Rows of the table by name, and numbers of the transition."""
    recorder.premise = premise
    found = transition(made(), speed_rpm=300.0)
    assert found.premise_holds is holds
    assert (found.model, found.engine, found.collisions) == ("made", "reduced", 4)
    assert (found.duration, found.duration_error) == (3.0, 1e-3)
    assert (found.share, found.error_bound) == (0.6, 1e-4)
    names = (
        "time", "cylinder_angle", "approach_rate", "separation_rate", "impulse", "energy_lost",
        "rebound_amplitude", "rebound_time", "time_error", "rate_error", "impulse_error",
        "amplitude_error", "rebound_error",
    )  # fmt: skip
    batch = transitions(made(), speed_rpm=[300.0, 400.0])
    for place, name in enumerate(names):
        np.testing.assert_array_equal(getattr(found, name), recorder.table[place])
        np.testing.assert_array_equal(getattr(batch, name)[1, :4], recorder.table[place])
        assert np.isnan(getattr(batch, name)[1, 4:]).all()
    assert (batch.model, batch.engine) == ("made", "reduced")
    for name, values in (
        ("status", [0, 0]), ("collisions", [4, 4]), ("premise", [premise] * 2),
        ("duration", [3.0, 4.0]), ("duration_error", [1e-3, 1.001]), ("share", [0.6, 1.6]),
        ("error_bound", [1e-4, 1.0001]),
    ):  # fmt: skip
        assert getattr(batch, name) == pytest.approx(np.array(values)), name
    assert {item.name for item in fields(results.TransitionBatch)} >= {"table", "premise"}


@pytest.mark.parametrize(
    ("status", "kind", "words"),
    [
        (Status.LEFT_TRAVEL, InputError, "a travel of 2.7 rad; use the direct engine"),
        (Status.LEFT_GAP, InputError, "largest gap is 0.17; use the direct engine"),
        (Status.OTHER_STOP, SimulationError, "another stop closes during the transition"),
        (Status.NOT_PRESSED, SimulationError, "not pressed shut when it is at rest"),
        (Status.TOO_MANY_COLLISIONS, SimulationError, "not at rest after 256 collisions; raise"),
        (Status.UNRESOLVED, SimulationError, "a flight cannot be resolved"),
        (Status.UNTOLD, SimulationError, f"how the machine arrives \\({WHY}\\)"),
    ],
)
def test_a_transition_without_rest_is_refused(
    recorder: Recorder, status: Status, kind: type[NipperError], words: str
) -> None:
    recorder.status = int(status)
    with pytest.raises(kind, match=words) as caught:
        transition(made(), speed_rpm=321.5)
    assert str(caught.value).startswith("made at 321.5 r/min, after 4 collisions: ")
    evidence = {"status": status.name, "collisions": 4, "speed_rpm": 321.5}
    assert caught.value.evidence == evidence


def test_where_the_tables_are_left_before_the_touch_that_is_said(recorder: Recorder) -> None:
    recorder.status = int(Status.UNTOLD)
    with pytest.raises(SimulationError, match="its flight before the touch leaves them"):
        transition(made(arrival=unknown("")), speed_rpm=300.0)


def test_gravity_of_a_model_without_it(recorder: Recorder) -> None:
    """None can be given but none."""
    model = made(gravity_m_s2=0.0)
    transition(model, speed_rpm=300.0, gravity=0.0)
    assert recorder.given[8] == 0.0
    transition(model, speed_rpm=300.0)
    assert recorder.given[8] == 1.0
    with pytest.raises(InputError, match="sampled without gravity") as caught:
        transitions(model, speed_rpm=300.0, gravity=[0.0, 1.0])
    assert caught.value.evidence["gravity"] == [0.0, 1.0]


@pytest.mark.parametrize(
    ("key", "value"),
    [("speed_rpm", 0.0), ("speed_rpm", math.inf), ("restitution", 1.1), ("restitution", -0.1),
     ("stiffness", -1.0), ("preload", math.nan), ("gravity", math.inf)],
)  # fmt: skip
@pytest.mark.parametrize("many", [False, True])
def test_what_a_case_cannot_be_is_named(
    recorder: Recorder, key: str, value: float, many: bool
) -> None:
    """By exactly its name; no code runs."""
    with pytest.raises(InputError) as caught:
        (transitions if many else transition)(made(), **{"speed_rpm": 300.0, key: value})
    assert caught.value.evidence["key"] == key
    assert not hasattr(recorder, "given")


def test_cases_of_a_batch_go_together(recorder: Recorder) -> None:
    """One number counts for all of them; rows of two lengths do not."""
    transitions(made(), speed_rpm=300.0, gravity=[1.0, 2.0, 3.0])
    assert [item.shape for item in recorder.given[4:9]] == [(3,), (3,), (3, 2), (3, 2), (3,)]
    with pytest.raises(InputError, match="need the same number of cases"):
        transitions(made(), speed_rpm=[300.0, 400.0], gravity=[1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    ("call", "good", "bad"),
    [
        (lambda x: inputs.check_run(None, x, 1), (1e-13, 1e-3), (0.9e-13, 1.1e-3, math.nan)),
        (lambda x: inputs.check_run(None, 1e-9, x), (1, 2), (0, -1)),
        (lambda x: inputs.check_run(x, 1e-9, 1), (1e-9, None), (0.0, -1.0, math.inf, math.nan)),
    ],
)
def test_what_all_cases_share(call: Any, good: Any, bad: Any) -> None:
    for value in good:
        call(value)
    for value in bad:
        with pytest.raises(InputError) as caught:
            call(value)
        assert any(item is value or item == value for item in caught.value.evidence.values())


@pytest.mark.parametrize(
    ("value", "open_low", "expected"),
    [
        (0.5, False, [0.5]), (0.0, False, [0.0]), (2.0, False, [2.0]), (2, True, [2.0]),
        ([0.0, 2.0, 1], False, [0.0, 2.0, 1.0]), (0.0, True, None), ([1.0, 0.0], True, None),
        (-1e-9, False, None), (2.1, False, None), (math.nan, False, None), ([[1.0]], False, None),
        (math.inf, False, None),
    ],
)  # fmt: skip
def test_columns_from_0_to_2(value: Any, open_low: bool, expected: Any) -> None:
    if expected is not None:
        found = inputs.column("key", value, 0.0, 2.0, open_low=open_low)
        assert found.tolist() == expected
        if len(expected) == 1:
            assert inputs.number("key", value, 0.0, 2.0, open_low=open_low) == expected[0]
        return
    with pytest.raises(InputError) as caught:
        inputs.column("key", value, 0.0, 2.0, open_low=open_low)
    allowed = f"finite numbers {'above' if open_low else 'from'} 0 to 2, one a case"
    assert caught.value.evidence == {"key": "key", "value": value, "allowed": allowed}
    assert str(caught.value) == f"key = {value!r} cannot be used: {allowed}"
    if not isinstance(value, list):
        with pytest.raises(InputError, match="key"):
            inputs.number("key", value, 0.0, 2.0, open_low=open_low)


@pytest.mark.parametrize(
    ("value", "springs", "expected"),
    [
        (3.0, 2, [[3.0, 3.0]]), ([1.0, 2.0], 2, [[1.0, 2.0]]), ([1.0, 2.0], 1, [[1.0], [2.0]]),
        ([[1.0, 2.0], [3.0, 0.0]], 2, [[1.0, 2.0], [3.0, 0.0]]), (-1e-9, 1, None),
        ([1.0, 2.0, 3.0], 2, None), ([[1.0], [2.0]], 2, None), ([[[1.0]]], 1, None),
        ([1.0, math.nan], 1, None), (math.inf, 2, None),
    ],
)  # fmt: skip
def test_rows_of_springs(value: Any, springs: int, expected: Any) -> None:
    if expected is not None:
        assert inputs.spring_rows("key", value, springs, 0.0).tolist() == expected
        return
    with pytest.raises(InputError) as caught:
        inputs.spring_rows("key", value, springs, 0.0)
    allowed = f"finite numbers from 0 to 1e+15, one for each of {springs} springs"
    assert str(caught.value) == f"key = {value!r} cannot be used: {allowed}"
    assert caught.value.evidence["allowed"] == allowed
    assert (caught.value.evidence["key"], caught.value.evidence["value"]) == ("key", value)


@pytest.mark.parametrize(
    ("value", "expected"),
    [(None, [7.0, 8.0]), (2.0, [2.0, 2.0]), (0.0, [0.0, 0.0]), (3, [3.0, 3.0]),
     ([1.0, 2.0], [1.0, 2.0]), (-1.0, None), ([1.0], None), (math.inf, None)],
)  # fmt: skip
def test_springs_of_one_case(value: Any, expected: Any) -> None:
    default = np.array([7.0, 8.0])
    if expected is not None:
        assert inputs.one_row("key", value, default, 0.0).tolist() == expected
    else:
        with pytest.raises(InputError, match="key"):
            inputs.one_row("key", value, default, 0.0)


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


@pytest.mark.parametrize("value", [0.0, 1.0, 0.5, 0, 1, np.float32(0.25)])
def test_one_number_is_that_of_a_column(value: Any) -> None:
    """What lies plainly inside is taken as it is; all else is judged as a column is."""
    found = inputs.number("restitution", value, 0.0, 1.0)
    assert type(found) is float
    assert found == inputs.column("restitution", value, 0.0, 1.0)[0]

"""Cases of transitions in SI units, the engine that is chosen, and what is kept of each."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from nipper_pin.dynamics.system import DriveMode
from nipper_pin.errors import InputError, SimulationError
from nipper_pin.mechanism import Mechanism
from nipper_pin.reduced import Status
from nipper_pin.reduced.kernels import layout
from nipper_pin.study.cases import cases_of, spring_values
from nipper_pin.study.transitions import engine_choice
from nipper_pin.study.transitions import run as module
from nipper_pin.study.transitions.run import Run, Settings


@pytest.fixture(name="two")
def two_springs(e62: Mechanism) -> Mechanism:
    """A spring on a slide, and one on a hinge."""
    hinge = replace(e62.springs[0], name="jaw", index=e62.stop("jaw").index, stiffness=7.0,
                    preload=0.5)  # fmt: skip
    return replace(e62, springs=(*e62.springs, hinge))


def test_springs_in_the_units_of_their_files(two: Mechanism) -> None:
    """Millimetres and degrees; the others keep what they have."""
    own = two.springs[0]
    stiffness, preload = spring_values(two, {
        "stiffness_N_per_m": [8000.0, 9000.0], "preload_length_mm": None, "preload_deg": 90.0,
    })  # fmt: skip
    assert stiffness.tolist() == [[8000.0, 7.0], [9000.0, 7.0]]
    assert preload == pytest.approx(np.array([[own.preload, math.pi / 2.0]]))
    stiffness, preload = spring_values(two, {
        "stiffness_N_m_per_rad": 3.0, "preload_length_mm": [10.0, 12.0],
    })  # fmt: skip
    assert stiffness.tolist() == [[own.stiffness, 3.0]]
    assert preload == pytest.approx(np.array([[0.010, 0.5], [0.012, 0.5]]))


@pytest.mark.parametrize(
    ("key", "right", "wrong", "most", "unit"),
    [
        ("stiffness_N_per_m", 1e10, 1.01e10, 1e10, "N/m"),
        ("preload_length_mm", -999.0, 1.01e3, 1e3, "mm"),
        ("preload_deg", 3600.0, -3601.0, 3600.0, "deg"),
        ("stiffness_N_m_per_rad", 1e10, 1.01e10, 1e10, "N m/rad"),
    ],
)  # fmt: skip
def test_springs_in_another_unit(
    two: Mechanism, key: str, right: float, wrong: float, most: float, unit: str
) -> None:
    """As long as the machine, ten turns and 1e10 are plausible; more is another unit."""
    most = max(most, 1e3 * two.reach_m) if key == "preload_length_mm" else most
    spring_values(two, {key: right})
    with pytest.raises(InputError, match=f"this is in {unit}, and e62 takes") as caught:
        spring_values(two, {key: math.copysign(max(abs(wrong), 1.01 * most), wrong)})
    assert caught.value.evidence["most"] == pytest.approx(most)
    assert (caught.value.evidence["key"], caught.value.evidence["unit"]) == (key, unit)


def test_springs_that_are_not_there(e62: Mechanism, two: Mechanism) -> None:
    with pytest.raises(InputError, match="preload_deg: e62 has no spring on a joint that moves in"):
        spring_values(e62, {"preload_deg": 3.0})
    given = {"preload_length_mm": [1.0, 2.0], "preload_deg": [1.0, 2.0, 3.0]}
    with pytest.raises(InputError, match="need the same number of cases"):
        spring_values(two, given)
    with pytest.raises(InputError, match="need the same number of cases"):
        cases_of(e62, [400.0, 500.0], [0.1, 0.2, 0.3])


def test_cases_of_a_machine(e62: Mechanism) -> None:
    """Its own numbers where none are given, everything as often as the longest."""
    found = cases_of(e62, [400.0, 500.0])
    spring = e62.springs[0]
    assert found.speed_rpm.tolist() == [400.0, 500.0]
    assert found.restitution.tolist() == [e62.stop("jaw").restitution] * 2
    assert found.stiffness.tolist() == [[spring.stiffness]] * 2
    assert found.preload.tolist() == [[spring.preload]] * 2
    found = cases_of(e62, 450.0, [0.0, 1.0], [7e3, 8e3], [0.01, -0.01])
    assert found.speed_rpm.tolist() == [450.0, 450.0]
    assert found.restitution.tolist() == [0.0, 1.0]
    assert found.stiffness.tolist() == [[7e3], [8e3]]
    assert found.preload.tolist() == [[0.01], [-0.01]]
    for wrong in ((0.0,), (450.0, 1.01), (450.0, -0.01), (450.0, 0.1, -1.0)):
        with pytest.raises(InputError):
            cases_of(e62, *wrong)


@pytest.mark.parametrize(
    ("engine", "count", "unfit", "numba", "why", "reduced"),
    [
        ("direct", 99, None, True, "direct: asked for", False),
        ("reduced", 1, "unfit", False, "reduced: asked for", True),
        ("auto", 99, "two drives", True, "direct: two drives", False),
        ("auto", 31, None, True, "direct: the reduced engine pays from 32 cases on", False),
        ("auto", 32, None, True, "reduced: 32 cases of one mechanism", True),
        ("auto", 32, None, False,
         "direct: the reduced engine needs numba, which is not installed", False),
    ],
)  # fmt: skip
def test_the_engine_that_is_chosen(
    monkeypatch: pytest.MonkeyPatch, e62: Mechanism, engine: Any, count: int, unfit: str | None,
    numba: bool, why: str, reduced: bool,
) -> None:  # fmt: skip
    monkeypatch.setattr(engine_choice, "unfit", lambda *_: unfit)
    monkeypatch.setattr(engine_choice, "installed", lambda name: numba and name == "numba")
    monkeypatch.setattr(engine_choice, "reduced_model", lambda *_: "tables")
    found = engine_choice._chosen(e62, DriveMode.HELD, count, engine)
    assert found == ("tables" if reduced else None, why)

    def refused(*_: Any) -> None:
        words = "no tables"
        raise SimulationError(words)

    monkeypatch.setattr(engine_choice, "reduced_model", refused)
    if engine == "auto" and reduced:
        found = engine_choice._chosen(e62, DriveMode.HELD, count, engine)
        assert found == (None, "direct: no tables")


def batch(chosen: np.ndarray, status: list[Status], columns: int) -> Any:
    n = len(chosen)
    counts = np.array([columns if s is Status.TOO_MANY_COLLISIONS else 3 for s in status])
    table = np.arange(float(n * layout.COLUMNS * columns)).reshape(n, layout.COLUMNS, columns)
    return SimpleNamespace(
        status=np.array([int(s) for s in status]), collisions=counts, table=table,
        duration=10.0 + chosen, duration_error=20.0 + chosen, share=30.0 + chosen,
        premise=np.array([(1, 0, -1)[k % 3] for k in chosen]),
    )  # fmt: skip


@pytest.mark.parametrize("keep_all", [False, True])
def test_what_the_reduced_engine_leaves(
    monkeypatch: pytest.MonkeyPatch, e62: Mechanism, keep_all: bool
) -> None:
    """Again with more columns where there were too many collisions; the rest with its reason."""
    asked: list[dict[str, Any]] = []
    first = [Status.AT_REST, Status.TOO_MANY_COLLISIONS, Status.UNTOLD, Status.AT_REST,
             Status.TOO_MANY_COLLISIONS]  # fmt: skip

    def transitions(model: Any, **named: Any) -> Any:
        asked.append({"model": model, **named})
        chosen = (named["speed_rpm"] - 400.0).astype(int)
        again = {1: Status.AT_REST, 4: Status.TOO_MANY_COLLISIONS}
        status = first if len(chosen) == 5 else [again[k] for k in chosen]
        return batch(chosen, status, named["max_collisions"])

    monkeypatch.setattr(module, "transitions", transitions)
    cases = cases_of(e62, 400.0 + np.arange(5.0), 0.1 + 0.01 * np.arange(5.0))
    settings = Settings(DriveMode.HELD, 1e-3, 1e-8, 40, true=True)
    run = Run(e62, cases, settings)
    arrival = SimpleNamespace(asked=True, why="")
    model: Any = SimpleNamespace(arrival=arrival)
    left = run.reduced(model, keep_all=keep_all)
    assert left == ([] if keep_all else [2, 4])
    one, two = asked
    assert (one["rest_rate"], one["tolerance"], one["max_collisions"]) == (1e-3, 1e-8, 32)
    assert (one["assumed"], two["max_collisions"]) == (False, 40)
    assert two["speed_rpm"].tolist() == [401.0, 404.0]
    assert two["restitution"] == pytest.approx([0.11, 0.14])
    table = run.table("why")
    told = ["", "", "the reduced engine: cannot tell how the machine arrives", "",
            "the reduced engine: too_many_collisions"]  # fmt: skip
    assert list(table.message) == ([""] * 5 if keep_all else told)
    assert table.outcome.tolist() == ["at_rest", "at_rest", "untold", "at_rest",
                                      "too_many_collisions"]  # fmt: skip
    assert table.collisions.tolist() == [3, 3, 3, 3, 40]
    assert table.duration.tolist() == [10.0, 11.0, 12.0, 13.0, 14.0]
    assert table.duration_error.tolist() == [20.0, 21.0, 22.0, 23.0, 24.0]
    assert table.first_two_share.tolist() == [30.0, 31.0, 32.0, 33.0, 34.0]
    assert table.premise_holds.tolist() == [True, False, None, True, False]
    assert set(table.engine) == {"reduced"}
    assert table.table.shape == (5, layout.COLUMNS, 40)
    # The second batch of two cases has the first case's rows of its own.
    assert table.table[1, 0, :3].tolist() == [0.0, 1.0, 2.0]
    arrival.asked = False
    Run(e62, cases, settings).reduced(model, keep_all=True)
    assert asked[-1]["assumed"] is True

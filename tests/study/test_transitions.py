"""The table of many transitions: which engine computes what, and that it does not matter.

The two engines share the mechanism and no code of the solution: one calls Pinocchio at every node,
the other evaluates tables in compiled code. Where both state their errors, each checks the other.
"""

from __future__ import annotations

import gc
import math
import sys
import weakref
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from two_engines import STATED, agree

from nipper_pin import (
    Case,
    DriveMode,
    InputError,
    Mechanism,
    Resolution,
    load,
    simulate,
    transition_table,
)
from nipper_pin.reduced import ReducedModel, build, reduced_model, sampling, transitions
from nipper_pin.study.cases import spring_values
from nipper_pin.study.transitions import REDUCED_PAYS_FROM, TURNS_PAY_FROM

REBOUND = ("rebound_amplitude", "amplitude_error", "rebound_time", "rebound_error")


def random_cases(count: int, seed: int) -> dict[str, Any]:
    random = np.random.default_rng(seed)
    return {
        "speed_rpm": random.uniform(380.0, 680.0, count),
        "restitution": random.uniform(0.02, 0.45, count),
        "stiffness_N_per_m": random.uniform(7000.0, 12000.0, count),
        "preload_length_mm": random.uniform(9.0, 14.0, count),
    }


def test_turns_of_the_reduced_engine(e62: Mechanism) -> None:
    """Where no turn has the assumed transition, tables follow the turns from some cases on.

    The engine is named, the verdict is that of the direct engine, and so are all numbers within
    both stated errors. The first rebound is another than the assumed one by more than a tenth.
    """
    speeds = np.linspace(1000.0, 1180.0, TURNS_PAY_FROM)
    # Settings reach the turns: another restitution, a spring and an end by a rate.
    settings = {"restitution": 0.35, "stiffness_N_per_m": 9500.0, "preload_length_mm": 11.5,
                "rest_rate": 1e-3}  # fmt: skip
    found = transition_table(e62, speed_rpm=speeds, **settings)  # type: ignore[arg-type]
    few = transition_table(e62, speed_rpm=speeds[:2], **settings)  # type: ignore[arg-type]
    assert {*found.engine} == {"reduced_turn"}
    assert {*few.engine} == {"turn"}
    assert {*found.premise_holds, *few.premise_holds} == {False}
    assert set(found.message) == {"This is the transition of the turn."}
    np.testing.assert_array_equal(found.collisions[:2], few.collisions)
    agree(few, found, slice(2), slice(2))
    usual = transition_table(e62, speed_rpm=speeds[:2])
    assumed = transition_table(e62, speed_rpm=speeds[:2], engine="direct")
    changed = assumed.rebound_amplitude[:, 0] / usual.rebound_amplitude[:, 0]
    assert (np.abs(changed - 1.0) > 0.1).all()
    # Faster still the jaw does not come to rest, and the largest number of collisions holds.
    faster = np.append(speeds[:-1], 1600.0)
    many = transition_table(e62, speed_rpm=faster, max_collisions=2)
    judge = transition_table(e62, speed_rpm=faster[-2:], max_collisions=2)
    assert many.engine.tolist()[-2:] == ["reduced_turn", "turn"]
    for key in ("outcome", "collisions", "premise_holds"):
        assert getattr(many, key).tolist()[-2:] == getattr(judge, key).tolist(), key
    assert judge.outcome.tolist() == ["too_many_collisions", "no_rest"]
    assert np.isnan(many.duration).all()


def test_tables_are_built_once_for_a_mechanism(monkeypatch: pytest.MonkeyPatch) -> None:
    """Other speeds, springs and restitutions cost no tables; another machine gets its own.

    Builds are counted where they happen. What is kept gives the bits of what is built anew, and
    goes with its mechanism.
    """
    built: list[int] = []

    def counted(mechanism: Mechanism, **options: Any) -> ReducedModel:
        # Its number is enough: the mechanism itself would not be let go.
        built.append(id(mechanism))
        return build(mechanism, **options)

    monkeypatch.setattr(sampling, "build", counted)
    first, second = load(), load("e62", {"drives.tension.ratio": 2.25})
    slow = transition_table(first, speed_rpm=np.full(2, 450.0), engine="reduced")
    assert len(built) == 1
    softer = {"speed_rpm": 500.0, "stiffness_N_per_m": 8000.0}
    for cases in ({"speed_rpm": 650.0}, softer, random_cases(70, 3)):
        table = transition_table(first, **cases, engine="reduced")  # type: ignore[arg-type]
        assert (table.outcome == "at_rest").all()
    automatic = transition_table(first, speed_rpm=np.full(REDUCED_PAYS_FROM, 450.0))
    assert len(built) == 1
    other = transition_table(second, speed_rpm=450.0, engine="reduced")
    assert len(built) == 2
    assert abs(other.duration[0] / slow.duration[0] - 1.0) > 1e-3
    anew = transition_table(load(), speed_rpm=450.0, engine="reduced")
    assert len(built) == 3
    assert set([*automatic.duration, *slow.duration]) == {anew.duration[0]}
    with pytest.raises(InputError, match="held drives"):
        transition_table(first, speed_rpm=450.0, engine="reduced", drive=DriveMode.INERTIAL)
    gone = weakref.ref(reduced_model(first))
    # A table names the units of its machine, and so holds it.
    del first, slow, table, automatic
    gc.collect()
    assert gone() is None


def test_automatic_choice(e62: Mechanism) -> None:
    """Few cases and inertial shafts go to the direct engine."""
    few = transition_table(e62, speed_rpm=[450.0, 600.0])
    assert (few.engine == "direct").all()
    assert str(REDUCED_PAYS_FROM) in few.why
    many = transition_table(e62, speed_rpm=np.linspace(450.0, 600.0, REDUCED_PAYS_FROM))
    assert (many.engine == "reduced").all()
    assert many.why == f"reduced: {REDUCED_PAYS_FROM} cases of one mechanism"
    agree(few, many, slice(None), [0, -1])
    assert many.premise_holds.tolist() == [True] * REDUCED_PAYS_FROM
    assert few.premise_holds.tolist() == [True] * 2
    # The reason is the engine's own, and comes before anything is computed.
    inertial = transition_table(e62, speed_rpm=np.full(2, 500.0), drive=DriveMode.INERTIAL)
    assert (inertial.engine == "direct").all()
    assert "held drives" in inertial.why


def test_outside_the_tables(e62: Mechanism) -> None:
    """A case that leaves the tables is computed by the direct engine, bit for bit, and says so.

    A run of the direct engine by its own door is the truth; the other cases stay with the tables.
    Cases in another order give the same bits.
    """
    speeds = np.linspace(450.0, 600.0, REDUCED_PAYS_FROM)
    restitution = np.full(REDUCED_PAYS_FROM, 0.2)
    # The jaw still bounces when it is opened again, which is where the tables end.
    speeds[20], restitution[20] = 600.0, 0.7
    table = transition_table(e62, speed_rpm=speeds, restitution=restitution)
    assert np.flatnonzero(table.engine == "direct").tolist() == [20]
    assert "left_travel" in table.message[20]
    assert table.why.endswith("1 that its tables do not cover: direct")
    assert [text for text in table.message if text] == [table.message[20]]
    mechanism = load("e62", {"stops.jaw.restitution": 0.7})
    case = Case(speed_rpm=600.0, resolution=Resolution(tolerance=1e-10))
    hits = [hit for hit in simulate(mechanism, case).collisions if hit.stop == "jaw"]
    assert table.outcome[20] == "no_rest"
    assert np.isnan(table.duration[20])
    assert table.time[20, 3] == hits[3].t
    assert table.collisions[20] == len(hits)
    assert np.isfinite(table.time[20, : table.collisions[20]]).all()
    forced = transition_table(e62, speed_rpm=speeds, restitution=restitution, engine="reduced")
    assert forced.outcome[20] == "left_travel"
    assert np.isnan(forced.duration[20])
    order = np.random.default_rng(10).permutation(REDUCED_PAYS_FROM)
    mixed = transition_table(e62, speed_rpm=speeds[order], restitution=restitution[order])
    for key in ("engine", "outcome", "collisions"):
        assert np.array_equal(getattr(table, key)[order], getattr(mixed, key)), key
    for key in ("duration", "duration_error", "first_two_share", "table"):
        one, other = getattr(table, key)[order], getattr(mixed, key)
        assert np.array_equal(one, other, equal_nan=True), key


def test_failed_case_is_a_row() -> None:
    """Cases that cannot be simulated are marked with their message; nothing is raised.

    A cylinder that turns away from the closing jaw can start no transition, and has no tables.
    """
    away = load("e62", {"cylinder.direction": "counter-clockwise"})
    for count in (2, REDUCED_PAYS_FROM):
        table = transition_table(away, speed_rpm=np.linspace(400.0, 500.0, count))
        assert table.why.startswith("direct: ")
        assert (table.outcome == "failed").all()
        assert all("not closing in the touch configuration" in text for text in table.message)
        assert np.isnan(table.duration).all()
        assert (table.collisions == 0).all()
        assert table.time.shape == (count, 0)
    assert "not closing in the touch configuration" in table.why


def test_without_numba_and_without_cases(e62: Mechanism, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the compiler of the reduced engine the direct one does all, and says why."""
    monkeypatch.setitem(sys.modules, "numba", None)
    speeds = np.linspace(450.0, 500.0, REDUCED_PAYS_FROM)
    table = transition_table(e62, speed_rpm=speeds, tolerance=1e-4)
    assert "numba" in table.why
    assert (table.engine == "direct").all()
    assert (table.outcome == "at_rest").all()
    assert len(transition_table(e62, speed_rpm=[])) == 0


@pytest.mark.parametrize("engine", ["direct", "reduced"])
def test_no_case_has_more_collisions_than_are_allowed(e62: Mechanism, engine: Any) -> None:
    """Also one that would come to rest with a few more; of its last one no rebound is seen."""
    usual = transition_table(e62, speed_rpm=450.0, restitution=0.2, engine=engine)
    assert 3 < int(usual.collisions[0]) < 32
    table = transition_table(e62, speed_rpm=450.0, restitution=0.2, engine=engine, max_collisions=3)
    assert list(table.outcome) == ["too_many_collisions"]
    assert list(table.collisions) == [3]
    assert table.time.shape == (1, 3)
    assert np.isnan(table.duration).all()
    for column in (*STATED, *STATED.values(), "cylinder_angle", "energy_lost"):
        # The reduced engine follows the flight after the last one, too.
        known = 2 if column in REBOUND and engine == "direct" else 3
        assert np.flatnonzero(np.isfinite(getattr(table, column)[0])).tolist() == [0, 1, 2][:known]


def test_long_series(e62: Mechanism) -> None:
    """A series longer than the columns of a batch is solved again with more, and is the same."""
    e, rate = 0.9, 1e-5
    cases = {"speed_rpm": np.full(3, 120.0), "rest_rate": rate}
    table = transition_table(e62, restitution=[0.2, e, 0.3], engine="reduced", **cases)
    assert table.collisions[1] > 32
    single = transitions(build(e62), restitution=e, max_collisions=256, **cases)
    count = int(single.collisions[0])
    assert count == table.collisions[1]
    assert np.array_equal(table.time[1, :count], single.time[0, :count])
    assert np.isnan(table.time[0, int(table.collisions[0]) :]).all()


# --- cases in SI units ---------------------------------------------------------------------------


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
    ("key", "most", "unit"),
    [
        ("stiffness_N_per_m", 1e10, "N/m"), ("preload_length_mm", -1e3, "mm"),
        ("preload_deg", -3600.0, "deg"), ("stiffness_N_m_per_rad", 1e10, "N m/rad"),
    ],
)  # fmt: skip
def test_springs_in_another_unit(two: Mechanism, key: str, most: float, unit: str) -> None:
    """As long as the machine, ten turns and 1e10 are plausible; more is another unit."""
    most *= two.reach_m if unit == "mm" and two.reach_m > 1.0 else 1.0
    spring_values(two, {key: 0.99 * most})
    with pytest.raises(InputError, match=f"this is in {unit}, and e62 takes") as caught:
        spring_values(two, {key: 1.01 * most})
    assert caught.value.evidence["most"] == pytest.approx(abs(most))
    assert (caught.value.evidence["key"], caught.value.evidence["unit"]) == (key, unit)


def test_cases_that_no_machine_has(e62: Mechanism) -> None:
    with pytest.raises(InputError, match="preload_deg: e62 has no spring on a joint that moves in"):
        spring_values(e62, {"preload_deg": 3.0})

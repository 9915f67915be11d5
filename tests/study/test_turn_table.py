"""The table of turns: both engines against each other and against certified turns, and the choice.

The direct engine reads a turn off its own run, by Pinocchio at every node; the reduced engine adds
it up in compiled code from tables. They share the mechanism, names and units.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from runs_shown import machine_called
from two_engines import EPS, FORCE, difference

from nipper_pin import DriveMode, Mechanism, load, turn_table
from nipper_pin.hybrid.result.turns import turn_names
from nipper_pin.study.turns import TURNS_PAY_FROM


@pytest.mark.parametrize("engine", ["direct", "reduced"])
def test_certified_turns(e62: Mechanism, engine: Any) -> None:
    """An independent solution in 60 digits, at both of its speeds; the rest is read beside it."""
    text = (Path(__file__).parents[1] / "reference/e62_cycle.json").read_text(encoding="utf-8")
    cases, speeds = json.loads(text)["cases"], [450.0, 650.0]
    table = turn_table(e62, speed_rpm=speeds, engine=engine, tolerance=1e-12, turns=3)
    assert (table.why, {*table.engine}) == (f"{engine}: asked for", {engine})
    assert table.turns.tolist() == table.repeats_after.tolist() == [1, 1]
    for i, speed in enumerate(speeds):
        case = cases[f"{speed:.0f}"]
        held = next(row for row in case["phases"] if row["closed"] == "jaw")
        hits = [row for row in case["collisions"] if row["stop"] == "jaw"]
        opening = (24.0 + float(held["end_s"]) * speed / 60.0 * 40.0) % 40.0
        assert table.closing_index[i] == pytest.approx(float(hits[0]["index"]), abs=1e-10)
        assert table.opening_index[i] == pytest.approx(opening, abs=1e-10)
        highest = max(float(row["rebound_amplitude"]) for row in hits)
        most = 2.0 * table.largest_gap_error[i] + EPS * highest
        assert abs(table.largest_gap[i] - highest) <= most
        lost = float(case["energy_lost_total_J"])
        within = 1e-9 if engine == "direct" else 1e-7
        assert table.energy_lost[i] == pytest.approx(lost, rel=within)


@pytest.mark.parametrize(
    ("name", "speeds", "rate"),
    [("e62", [450.0, 1900.0], 1e-2), ("film_claw", [600.0], 1e-7),
     ("hanging_pendulum", [220.0, 280.0], 1e-2), ("e62_offset_guide", [450.0, 650.0], 1e-2)],
)  # fmt: skip
def test_engines_agree(name: str, speeds: list[float], rate: float) -> None:
    """Within the errors that both state; the E62 alternates at 1,900 r/min, the claw loses.

    A rate ends the series, so that both compute the same bounces.
    """
    mechanism = machine_called(name)
    direct, reduced = (turn_table(mechanism, speed_rpm=speeds, engine=engine, turns=3,
                                  rest_rate=rate, least_force_N=60.0, tolerance=1e-9)
                       for engine in ("direct", "reduced"))  # type: ignore[arg-type] # fmt: skip
    for key in ("turns", "repeats_after", "outcome"):
        assert getattr(direct, key).tolist() == getattr(reduced, key).tolist(), key
    for key in turn_names(mechanism):
        for i in range(len(speeds) if "error" not in key else 0):
            one, other, most = difference(direct, reduced, i, key)
            assert one == pytest.approx(other, rel=0.0, abs=most, nan_ok=True), key
    assert np.isfinite(direct.loss_index).all() == (name == "film_claw")


def test_which_engine_it_is(e62: Mechanism, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the number of cases, the machine, the drive and what is installed; it says why."""
    few = turn_table(e62, speed_rpm=[450.0, 500.0], turns=1)
    assert few.why == f"direct: the reduced engine pays from {TURNS_PAY_FROM} cases on"
    assert few.engine.tolist() == ["direct"] * 2
    speeds = np.linspace(450.0, 650.0, TURNS_PAY_FROM)
    inertial = turn_table(e62, speed_rpm=450.0, turns=1, drive=DriveMode.INERTIAL)
    assert "held drives" in inertial.why
    monkeypatch.setitem(sys.modules, "numba", None)
    coarse = {"turns": 1, "tolerance": 1e-3, "rest_rate": 0.1}
    assert "numba, which is not installed" in turn_table(e62, speed_rpm=speeds, **coarse).why


def test_cases_that_one_engine_cannot_follow(e62: Mechanism) -> None:
    """They are marked with the reason; the direct engine follows those that the tables cannot.

    A spring that is slack for 30 mm lets the steeve fly where no tables are.
    """
    for engine in ("direct", "reduced"):
        many = turn_table(e62, speed_rpm=450.0, max_collisions=3, engine=engine)  # type: ignore[arg-type]
        assert many.outcome.tolist() == ["too_many_collisions"]
        assert "max_collisions" in many.message[0]
        assert np.isnan(many.collisions["jaw"]).all()
        assert np.isnan(many.energy_lost).all()
        assert (many.turns[0], many.repeats_after[0]) == (0, 0)
    speeds, preload = np.linspace(450.0, 650.0, TURNS_PAY_FROM), np.full(TURNS_PAY_FROM, 11.0)
    preload[1] = -30.0
    cases: dict[str, Any] = {"speed_rpm": speeds, "preload_length_mm": preload, "turns": 2}
    table = turn_table(e62, **cases)
    others = TURNS_PAY_FROM - 2
    assert table.engine.tolist() == ["reduced", "direct", *["reduced"] * others]
    assert table.outcome.tolist() == ["followed"] * TURNS_PAY_FROM
    gone = "the reduced engine: a flight goes higher than the widest tables"
    assert table.message == ("", gone, *[""] * others)
    assert table.why.endswith("; 1 that it cannot follow: direct")
    assert np.isnan(table.clamping_force_error).tolist() == [False, True, *[False] * others]
    alone = turn_table(e62, speed_rpm=speeds[1], preload_length_mm=-30.0, turns=2)
    assert table.energy_lost[1] == alone.energy_lost[0]
    forced = turn_table(e62, engine="reduced", **cases)
    assert forced.outcome.tolist() == ["followed", "left_gap", *["followed"] * others]
    assert forced.turns.tolist()[:3] == [1, 0, 1]


def test_values_of_a_case_are_those_of_a_machine(e62: Mechanism) -> None:
    """Springs and restitutions of any stop, as if the machine had them; a batch is its cases."""
    given = {"restitution": {"jaw": 0.31, "steeve": 0.12}, "stiffness_N_per_m": 8700.0,
             "preload_length_mm": 12.5}  # fmt: skip
    changed = load("e62", {"stops.jaw.restitution": 0.31, "stops.steeve.restitution": 0.12,
                           "springs.steeve.stiffness_N_per_m": 8700.0,
                           "springs.steeve.preload_length_mm": 12.5})  # fmt: skip
    own = turn_table(changed, speed_rpm=500.0)
    tables = [turn_table(e62, speed_rpm=500.0, engine=engine, **given)  # type: ignore[arg-type]
              for engine in ("direct", "reduced")]  # fmt: skip
    usual = turn_table(e62, speed_rpm=500.0)
    for table in tables:
        for key in ("clamped_time", "energy_lost", "largest_gap", "largest_clamping_force"):
            value = getattr(own, key)[0]
            assert getattr(table, key)[0] == pytest.approx(value, rel=1e-7), key
            assert abs(getattr(usual, key)[0] / value - 1.0) > 1e-4, key
    many = turn_table(e62, speed_rpm=[450.0, 500.0, 550.0], engine="reduced",
                      **given)  # type: ignore[arg-type] # fmt: skip
    for key in turn_names(e62):
        assert many.quantity(key)[1].tobytes() == tables[1].quantity(key)[0].tobytes()


def test_torques_only_where_they_are_asked_for(e62: Mechanism) -> None:
    """Of both engines, alike to what the reduced one states and its own."""
    usual = turn_table(e62, speed_rpm=650.0)
    assert usual.largest_torque == usual.largest_torque_error == {}
    with pytest.raises(KeyError):
        usual.quantity("largest_torque_N_m_pendulum")
    direct, reduced = (
        turn_table(e62, speed_rpm=[450.0, 650.0], turns=1, torques=True, engine=engine)
        for engine in ("direct", "reduced")
    )  # type: ignore[arg-type]
    for drive in ("pendulum", "tension"):
        one, other = (table.largest_torque[drive] for table in (direct, reduced))
        assert (np.abs(one - other) <= reduced.largest_torque_error[drive] + FORCE * one).all()
        assert (one[1] > one[0] > 0.1).all()
        assert np.isnan(direct.largest_torque_error[drive]).all()
        name = f"largest_torque_N_m_{drive}"
        np.testing.assert_array_equal(direct.to_frame("pyarrow")[name].to_numpy(), one)


def test_a_table_in_columns(e62: Mechanism) -> None:
    table = turn_table(e62, speed_rpm=[450.0, 650.0], least_force_N=60.0)
    assert len(table) == 2
    frame = table.to_frame("pyarrow")
    parameters = [
        "speed_rpm", "stops.jaw.restitution", "stops.steeve.restitution",
        "springs.steeve.stiffness_N_per_m", "springs.steeve.preload_length_mm",
    ]  # fmt: skip
    head = ["engine", "outcome", "message", *parameters, "turns", "repeats_after"]
    names = turn_names(e62)
    assert frame.column_names == [*head, *(name for name in names if name != "repeats_after")]
    assert frame["springs.steeve.preload_length_mm"].to_pylist() == [11.0, 11.0]
    assert frame["stops.jaw.restitution"].to_pylist() == [0.2, 0.2]
    for name in names:
        np.testing.assert_array_equal(frame[name].to_numpy(), table.quantity(name))
    with pytest.raises(KeyError):
        table.quantity("impulse_sum_N_m_s_jaw")

"""How fast the nipper can run, judged by whole turns of the direct engine."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from snapshots import Words

from nipper_pin import (
    Case,
    EventKind,
    Mechanism,
    SimulationError,
    load,
    simulate,
    turn_table,
)
from nipper_pin.cli import main
from nipper_pin.mechanism.gallery import drawn
from nipper_pin.reduced.turns import TurnStatus, turn_quantities
from nipper_pin.study import speed_limit as speed_limit_module
from nipper_pin.study.speed_limit import SpeedLimit, Verdict, speed_limit
from nipper_pin.view.studies.speed_limit_report import _sentence

TURNS = 120


@pytest.fixture(scope="module")
def result(e62: Mechanism) -> SpeedLimit:
    return speed_limit(e62, low_rpm=300.0, high_rpm=1700.0, speeds=57, turns=TURNS)


def rests_of_turns(e62: Mechanism, speed: float, cycles: int) -> list[list[float]]:
    """Indices at which the jaw of the direct engine comes to rest, turn by turn."""
    case = Case(speed_rpm=speed, window="cycle", cycles=cycles, reuse_cycles=False)
    run = simulate(e62, case)
    found: list[list[float]] = [[] for _ in range(cycles)]
    for event in run.events:
        if event.kind is EventKind.REST and event.stops[0] == "jaw":
            turn = event.t * speed / 60.0
            found[int(turn)].append((24.0 + 40.0 * turn) % 40.0)
    return found


def test_the_jaw_settles_up_to_the_limit(e62: Mechanism, result: SpeedLimit) -> None:
    """A little below, the direct engine rests in each turn before it opens; above, it does not."""
    limit = result.settles_rpm
    assert limit is not None
    assert 1500.0 < limit < 1600.0
    below = rests_of_turns(e62, 0.998 * limit, 4)
    assert all(len(rests) == 1 for rests in below[1:])
    above = rests_of_turns(e62, 1.002 * limit, 6)
    assert not any(above[2:])


def test_indices_are_those_of_the_direct_engine(e62: Mechanism, result: SpeedLimit) -> None:
    """The turn that repeats, at four speeds; the margin is what is left until the jaw opens."""
    for place in (0, 14, 30, 44):
        speed = float(result.speed_rpm[place])
        *_, last = rests_of_turns(e62, speed, 3)
        assert result.rest[place] == pytest.approx(last[0], abs=1e-7)
        assert result.opening[place] == pytest.approx(7.4918, abs=1e-3)
        margin = (result.opening[place] - result.rest[place]) % 40.0
        assert result.margin[place] == pytest.approx(margin, rel=1e-12)
    settled = result.speed_rpm < result.settles_rpm
    assert np.isfinite(result.rest[settled]).all()
    assert np.isnan(result.rest[~settled]).all()
    assert np.isfinite(result.rests[settled]).sum(axis=1).tolist() == [1] * settled.sum()


def test_turns_that_differ_are_found(e62: Mechanism) -> None:
    """At 1,900 r/min every second turn is the same; the direct engine alternates likewise."""
    found = speed_limit(e62, low_rpm=1875.0, high_rpm=1925.0, speeds=3, turns=TURNS)
    assert found.repeats_after.tolist() == [1, 2, 1]
    # They repeat again further on, so no one speed is the limit.
    assert found.repeats_rpm is None
    assert [part.verdict for part in found.single] == [Verdict.YES, Verdict.NO, Verdict.YES]
    assert 1875.0 < found.single[1].low_rpm <= 1900.0 < found.single[2].low_rpm <= 1925.0
    cycles, speed = 40, 1900.0
    case = Case(speed_rpm=speed, window="cycle", cycles=cycles, reuse_cycles=False)
    first = [np.nan] * cycles
    for hit in reversed(simulate(e62, case).collisions):
        turn = hit.t * speed / 60.0
        if hit.stop == "jaw":
            first[int(turn)] = (24.0 + 40.0 * turn) % 40.0
    assert first[-1] == pytest.approx(first[-3], abs=1e-6)
    assert abs(first[-1] - first[-2]) > 0.05
    shown = found.touches[1][np.isfinite(found.touches[1])]
    np.testing.assert_allclose(np.sort(shown), np.sort(first[-2:]), atol=1e-6)
    assert min(abs(found.closing[1] - index) for index in first[-2:]) < 1e-6


def test_a_machine_that_rests_from_a_speed_on() -> None:
    """The reed of a loom rests above some 100 r/min only, as the direct engine says as well."""
    machine = drawn("loom_sley").mechanism()
    found = speed_limit(machine, low_rpm=60.0, high_rpm=300.0, speeds=4, turns=TURNS)
    assert found.settles_rpm is None
    below, above = found.settled
    assert (below.verdict, above.verdict) == (Verdict.NO, Verdict.YES)
    assert (below.low_rpm, above.high_rpm) == (60.0, 300.0)
    assert below.high_rpm == above.low_rpm
    near = [0.97 * above.low_rpm, 60.0, 300.0]
    direct = turn_table(machine, speed_rpm=near, turns=TURNS, engine="direct")
    assert np.isfinite(direct.rest_index).tolist() == [False, False, True]


def test_the_command_says_what_it_found(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    words: Words,
) -> None:
    """The reviewed text has the numbers of the document."""
    monkeypatch.setenv("COLUMNS", "80")
    given = ["speed-limit", "--from", "1500", "--to", "1600", "--speeds", "5", "--turns", "20"]
    figure = tmp_path / "limit.svg"
    figure.write_text("of before", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert main([*given, "--plot", "limit.svg", "--json", "limit.json"]) == 0
    said = capsys.readouterr().out
    words(said.replace("limit.svg", "FIGURE"))
    document = json.loads((tmp_path / "limit.json").read_text(encoding="utf-8"))
    limit = document["settles_rpm"]
    assert document["at_rest"] == [{"from_rpm": 1500.0, "to_rpm": limit}]
    assert document["not_at_rest"] == [{"from_rpm": limit, "to_rpm": 1600.0}]
    assert document["repeats"] == [{"from_rpm": 1500.0, "to_rpm": 1600.0}]
    assert (document["not_known"], document["repeats_rpm"]) == ([], None)
    assert said.endswith(f"--speed {limit:.5g} --window cycle\n")
    for row in document["speeds"]:
        settled = row["speed_rpm"] < limit
        assert (row["rest_index"] is not None) == (row["clamped_share"] > 0.0) == settled
    drawn = figure.read_text(encoding="utf-8")
    assert drawn.startswith("<?xml")
    assert len(drawn) > 10_000


def test_a_stop_also_opens_where_its_force_is_lost() -> None:
    """No other stop throws it open: its force falls to zero, where the direct engine has it."""
    machine = drawn("chebyshev").mechanism()
    found = speed_limit(machine, low_rpm=100.0, high_rpm=101.0, speeds=2, turns=30)
    run = simulate(machine, Case(speed_rpm=100.0, window="cycle", cycles=2))
    period, stop = run.shaft.period, machine.transition_stop
    (released,) = (
        event.t - period
        for event in run.events
        if event.kind is EventKind.RELEASE and stop in event.stops and event.t > period
    )
    index = (24.0 + 40.0 * released / period) % 40.0
    assert found.opening[0] == pytest.approx(index, abs=1e-6)


@pytest.mark.slow
def test_speeds_that_cannot_be_followed_are_told_of(
    e62: Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They are no speeds at which the jaw does not settle."""

    def lost(mechanism: Mechanism, **keys: Any) -> Any:
        """Turns of which none above 10,000 r/min could be followed."""
        found = turn_quantities(mechanism, **keys)
        away = np.asarray(keys["speed_rpm"]) > 1e4
        return replace(found, status=np.where(away, TurnStatus.LEFT_GAP, found.status))

    monkeypatch.setattr(speed_limit_module, "turn_quantities", lost)
    found = speed_limit(e62, low_rpm=600.0, high_rpm=1e9, speeds=2, turns=30)
    assert found.status == ("followed", "left_gap")
    assert found.settles_rpm is None
    assert found.repeats_rpm is None
    assert found.lost.startswith("At 1 of 2 speeds, the first of them 1e+09 r/min")
    said = _sentence(found)
    # Halved twelve times between 600 r/min and the speed that is lost.
    assert found.settled[-1].verdict is Verdict.UNKNOWN
    assert found.settled[-1].low_rpm <= 1e4 + 1e9 / 2**12
    assert "at every speed" not in said
    assert said.endswith(found.lost)
    with pytest.raises(SimulationError, match="at none of these speeds: a flight goes higher"):
        speed_limit(e62, low_rpm=1e8, high_rpm=1e9, speeds=3)


def test_blocks_of_speeds_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Speeds are followed some at a time, so that an interrupt is heard in between."""
    machine = load("hanging_pendulum")
    few = {"low_rpm": 100.0, "high_rpm": 300.0, "speeds": 7, "turns": 3}
    whole = speed_limit(machine, **few)
    monkeypatch.setattr("nipper_pin.study.speed_limit._BLOCK", 2)
    assert repr(speed_limit(machine, **few)) == repr(whole)
    np.testing.assert_array_equal(speed_limit(machine, **few).rests, whole.rests)

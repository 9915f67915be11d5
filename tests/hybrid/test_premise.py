"""Whether a machine arrives as a transition assumes, judged by whole turns simulated otherwise."""

from __future__ import annotations

import io
import json
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

import nipper_pin as nip
from nipper_pin.cli import main
from nipper_pin.mechanism.skeleton import write_skeleton
from nipper_pin.study.transitions import TURN
from nipper_pin.view.run import print_solution

# The steeve is thrown off its stop just before the touch.
LATE = {
    "stops.jaw.restitution": 0.18674,
    "springs.steeve.stiffness_N_per_m": 7065.98,
    "springs.steeve.preload_length_mm": 9.25486,
}
LATE_RPM = 681.27


@pytest.fixture(scope="module")
def late() -> nip.Solution:
    """A transition that no turn has."""
    return nip.simulate(nip.load("e62", LATE), nip.Case(speed_rpm=LATE_RPM))


def closing(mechanism: nip.Mechanism, speed_rpm: float) -> Any:
    """First collision of the jaw in the third turn that is computed anew."""
    case = nip.Case(speed_rpm=speed_rpm, window=nip.Window.CYCLE, cycles=3, reuse_cycles=False)
    turns = nip.simulate(mechanism, case)
    return next(
        hit for hit in turns.collisions if hit.stop == "jaw" and hit.t > 2.0 * turns.shaft.period
    )


@pytest.mark.parametrize("speed_rpm", [300.0, 450.0, 650.0])
def test_true_where_turns_have_the_transition(e62: nip.Mechanism, speed_rpm: float) -> None:
    """At 650 r/min the steeve leaves its stop with the jaw open, and is back in time."""
    solution = nip.simulate(e62, nip.Case(speed_rpm=speed_rpm))
    assert solution.premise_holds is True
    first, hit = solution.collisions[0], closing(e62, speed_rpm)
    # Both are exact but for the round-off of closures, 1e-14 of a rate.
    assert first.approach_rate == pytest.approx(hit.approach_rate, rel=1e-11)
    assert first.index == pytest.approx(hit.index, abs=1e-9)


def test_false_where_they_do_not(late: nip.Solution) -> None:
    """The machine arrives with its steeve off the stop, and hits half as fast again."""
    assert late.premise_holds is False
    assert "steeve" in late.premise.why
    hit = closing(late.mechanism, LATE_RPM)
    assert late.collisions[0].approach_rate == pytest.approx(-17.6355, abs=1e-4)
    assert hit.approach_rate == pytest.approx(-25.5185, abs=1e-4)
    # Nor where bounces of the steeve outlast the time until the touch.
    lively = nip.load("e62", {"stops.steeve.restitution": 0.97})
    solution = nip.simulate(lively, nip.Case(speed_rpm=650.0))
    assert solution.premise_holds is False
    hit = closing(lively, 650.0)
    assert abs(hit.approach_rate / solution.collisions[0].approach_rate - 1.0) > 1e-3


def test_not_asked(e62: nip.Mechanism, tmp_path: Path) -> None:
    """Whole turns assume nothing; inertial shafts and a crank at half speed cannot be asked."""
    press = nip.load(write_skeleton(tmp_path / "press"), {"drives.crank.ratio": 0.5})
    cases = {
        "assume nothing": (e62, nip.Case(speed_rpm=650.0, window=nip.Window.CYCLE)),
        "Inertial": (e62, nip.Case(speed_rpm=650.0, drive=nip.DriveMode.INERTIAL)),
        "come back": (press, nip.Case(speed_rpm=120.0)),
    }
    for word, (mechanism, case) in cases.items():
        solution = nip.simulate(mechanism, case)
        assert solution.premise_holds is None, word
        assert word in solution.premise.why


def test_a_crank_that_winds_on_is_asked(tmp_path: Path) -> None:
    """A press whose crank comes to the touch a whole turn later has the transition of its turns.

    Its collisions come from the second turn of a simulated two, an engine's path of its own.
    """
    press = nip.load(write_skeleton(tmp_path / "press"))
    alone = nip.simulate(press, nip.Case(speed_rpm=120.0))
    assert alone.premise_holds is True
    case = nip.Case(speed_rpm=120.0, window=nip.Window.CYCLE, cycles=2, reuse_cycles=False)
    hits = [hit for hit in nip.simulate(press, case).collisions if hit.stop == "anvil"]
    second = hits[len(hits) // 2 :]
    assert len(second) == len(alone.collisions)
    for ours, theirs in zip(alone.collisions, second, strict=True):
        assert ours.approach_rate == pytest.approx(theirs.approach_rate, rel=1e-9)
        assert ours.t == pytest.approx(theirs.t - second[0].t, abs=1e-11)


def test_cut_and_saved_transitions_are_judged_alike(
    late: nip.Solution, e62: nip.Mechanism, tmp_path: Path
) -> None:
    """Where few collisions are asked for, the turn is followed on all the same; and of a file."""
    for mechanism, speed_rpm, holds in ((late.mechanism, LATE_RPM, False), (e62, 650.0, True)):
        for most in (1, 2, 3):
            case = nip.Case(speed_rpm=speed_rpm, max_collisions=most)
            assert nip.simulate(mechanism, case).premise_holds is holds
    assert nip.load_solution(nip.save(late, tmp_path / "late")).premise == late.premise


def test_record_and_sentence(late: nip.Solution, e62: nip.Mechanism) -> None:
    """The document and the table on the terminal say it; a premise that holds takes no line."""
    assert nip.record(late)["transition"]["premise_holds"] is False
    stream = io.StringIO()
    print_solution(late, Console(file=stream, width=80), turns="nipper-pin " + "x" * 100)
    assert "No turn has this transition" in stream.getvalue()
    assert "\nnipper-pin " + "x" * 100 + "\n" in stream.getvalue()
    stream = io.StringIO()
    true = nip.simulate(e62, nip.Case(speed_rpm=650.0))
    assert nip.record(true)["transition"]["premise_holds"] is True
    print_solution(true, Console(file=stream, width=80))
    assert "No turn has" not in stream.getvalue()


def test_the_command_that_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    """Pasted, it simulates turns of the user's own settings, which hit as those of the test."""
    given = ["simulate", "e62", "--speed", str(LATE_RPM), "--window", "transition"]
    for path, value in LATE.items():
        given += ["--set", f"{path}={value}"]
    assert main(given) == 0
    lines = capsys.readouterr().out.splitlines()
    (line,) = [line for line in lines if line.startswith("nipper-pin ")]
    words = shlex.split(line)
    assert words[0] == "nipper-pin"
    assert main([*words[1:], "--json", "-"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["transition"]["premise_holds"] is None
    jaw = next(hit for hit in document["collisions"] if hit["stop"] == "jaw")
    assert jaw["rebound_amplitude"] == pytest.approx(12.61e-3, abs=1e-5)


def test_tables_take_the_transition_of_the_turn(late: nip.Solution) -> None:
    """Left to choose, a table holds what the machine does; asked for an engine, what is assumed."""
    speeds = np.array([LATE_RPM, 450.0])
    chosen = nip.transition_table(late.mechanism, speed_rpm=speeds)
    assumed = nip.transition_table(late.mechanism, speed_rpm=speeds, engine="direct")
    for table in (chosen, assumed):
        assert table.premise_holds.tolist() == [False, True]
        assert table.outcome.tolist() == ["at_rest", "at_rest"]
    assert chosen.engine.tolist() == [TURN, "direct"]
    assert "steeve" in chosen.message[0]
    hit = closing(late.mechanism, LATE_RPM)
    # The table was computed to 1e-10.
    assert chosen.approach_rate[0, 0] == pytest.approx(hit.approach_rate, rel=1e-8)
    assert chosen.rebound_amplitude[0, 0] == pytest.approx(hit.rebound_amplitude, rel=1e-8)
    assert assumed.approach_rate[0, 0] == pytest.approx(late.collisions[0].approach_rate, rel=1e-8)
    few = nip.transition_table(late.mechanism, speed_rpm=LATE_RPM, max_collisions=2)
    assert few.outcome[0] == "too_many_collisions"
    np.testing.assert_allclose(few.time[0], chosen.time[0, :2], rtol=1e-9)


def test_another_arrival_is_noticed(e62: nip.Mechanism) -> None:
    """A transition that starts from another state than the turn brings is not called true."""
    solution = nip.simulate(e62, nip.Case(speed_rpm=650.0))
    first = solution.events[0]
    moved = replace(first, q=first.q + 1e-3)
    assert replace(solution, events=(moved, *solution.events[1:])).premise.holds is False

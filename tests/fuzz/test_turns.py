"""Whole turns and the speed limit, asked for what cannot be: one sentence, no more than 1 GB."""

from __future__ import annotations

import math
import os
import stat
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import assert_clear

from nipper_pin import InputError, Mechanism, SimulationError, load
from nipper_pin.reduced.turns import TurnStatus, turn_quantities, turns
from nipper_pin.study import speed_limit as speed_limit_module
from nipper_pin.study.speed_limit import SpeedLimit, SpeedRange, Verdict, speed_limit
from nipper_pin.view.studies.speed_limit_plot import plot_speed_limit
from nipper_pin.view.studies.speed_limit_report import _sentence

BYTES = 10**9
STUDY = ["speed-limit"]
FEW = [*STUDY, "--from", "600", "--to", "700", "--speeds", "2", "--turns", "2"]


@pytest.mark.parametrize(
    "words",
    [
        "--speeds 1000000000", "--speeds -1", "--turns 1000000000", "--turns 0",
        "--least-force nan", "--least-force inf", "--from nan", "--to inf", "--to 1e300",
        "--from -1e-300", "--to 0",
        "--plot limit.xyz", "--plot limit", "--plot /dev/null", "--plot missing/limit.svg",
        "--json missing/limit.json", "--set stops.jaw.restitution=nan",
    ],
)  # fmt: skip
def test_what_a_speed_limit_cannot_be_asked(words: str) -> None:
    assert_clear([*STUDY, *words.split()], 2)


NUMBERS: list[dict[str, Any]] = [
    {"speed_rpm": math.nan}, {"speed_rpm": "fast"}, {"speed_rpm": 0.0}, {"speed_rpm": [[450.0]]},
    {"start_index": math.nan}, {"start_index": math.inf}, {"start_index": "x"},
    {"restitution": {"nope": 0.1}}, {"restitution": math.nan}, {"stiffness": "stiff"},
    {"preload": math.inf}, {"rest_rate": math.nan}, {"tolerance": math.nan},
    {"max_collisions": 10**12}, {"max_collisions": 2.5}, {"max_collisions": 0},
]  # fmt: skip
TURNS: list[object] = [0, 2.5, True, "3", None, 10**9, 10_001]


@pytest.mark.parametrize("given", NUMBERS, ids=repr)
def test_numbers_that_turns_cannot_have(e62: Mechanism, given: dict[str, Any]) -> None:
    for ask in (turns, turn_quantities):
        with pytest.raises(InputError) as refused:
            ask(e62, **{"speed_rpm": 450.0, **given})
        assert len(refused.value.message.splitlines()) == 1


@pytest.mark.parametrize("count", TURNS, ids=repr)
def test_numbers_of_turns(e62: Mechanism, count: Any) -> None:
    """Also together with the number of collisions, for whose events there has to be room."""
    with pytest.raises(InputError, match="cycles = "):
        turns(e62, speed_rpm=450.0, cycles=count)
    for key in ("turns", "last"):
        if key == "turns" or count not in (None, 10_001):
            with pytest.raises(InputError, match=f"{key} = "):
                turn_quantities(e62, speed_rpm=450.0, **{key: count})
    with pytest.raises(InputError, match="least_force"):
        turn_quantities(e62, speed_rpm=450.0, least_force=math.nan)
    with pytest.raises(InputError, match="together at most"):
        turns(e62, speed_rpm=450.0, cycles=100, max_collisions=100_000)


LARGEST = """
from pathlib import Path
import numpy as np
from nipper_pin import load
from nipper_pin.reduced.turns import turn_quantities, turns
e62 = load("e62")
turns(e62, speed_rpm=450.0, cycles=10_000)
turn_quantities(e62, speed_rpm=np.linspace(300.0, 600.0, 100), turns=10_000, last=8_600)
turn_quantities(e62, speed_rpm=np.linspace(300.0, 600.0, 100), max_collisions=1_000_000)
status = Path("/proc/self/status").read_text().splitlines()
print(1024 * next(int(line.split()[1]) for line in status if line.startswith("VmHWM")))
"""


@pytest.mark.slow
def test_the_most_turns() -> None:
    done = subprocess.run([sys.executable, "-c", LARGEST], capture_output=True, check=True)
    assert int(done.stdout) <= BYTES


def test_outputs_that_are_no_files(tmp_path: Path) -> None:
    """A device keeps being one, one that is full is told of, and a pipe passes the figure on."""
    assert assert_clear([*FEW, "--json", "/dev/null"]) == 0
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)
    assert_clear([*FEW, "--json", "/dev/full"], 2)
    (tmp_path / "full.svg").symlink_to("/dev/full")
    assert_clear([*FEW, "--plot", str(tmp_path / "full.svg")], 2)
    pipe = tmp_path / "limit.svg"
    os.mkfifo(pipe)
    with ThreadPoolExecutor(1) as other:
        read = other.submit(pipe.read_text)
        assert assert_clear([*FEW, "--plot", str(pipe)]) == 0
        assert read.result(20.0).startswith("<?xml")
    assert sorted(item.name for item in tmp_path.iterdir()) == ["full.svg", "limit.svg"]


def made_up(status: tuple[str, ...], name: str = "jaw") -> SpeedLimit:
    """A study of a few speeds with numbers that mean nothing."""
    count = len(status)
    row, table = np.ones(count), np.ones((count, 2))
    whole = np.ones(count, dtype=np.int64)
    return SpeedLimit(
        name, name, name, 100.0 * np.arange(1.0, count + 1), status, whole, whole, row, row, row,
        row, row, table, table, (SpeedRange(100.0, 100.0 * count, Verdict.YES),) , (),
    )  # fmt: skip


def test_names_are_no_formulas(tmp_path: Path) -> None:
    path = plot_speed_limit(made_up(("followed",) * 3, "$\\frac{$ <b>"), tmp_path / "limit.svg")
    assert "<b>" not in path.read_text(encoding="utf-8")


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
    assert made_up(("followed",) * 2).lost == ""
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

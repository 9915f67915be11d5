"""The time that `--dry-run` expects: its sums, and that it times what a sweep computes."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sweep_studies import GEOMETRY, TABLE, plan, study

from nipper_pin.cli import main
from nipper_pin.study import processes
from nipper_pin.study.sweep import estimate as module
from nipper_pin.study.sweep.estimate import Estimate, timed

SPEEDS = GEOMETRY.replace("chunk = 4\n", "").replace("values = [450.0, 650.0]", "low = 450.0\n"
                                                     "high = 650.0\npoints = 200")  # fmt: skip


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[np.ndarray]:
    """Chunks that cost 50 ms and, a scenario, 20 us; the rows that were asked for."""
    asked: list[np.ndarray] = []

    def seconds(_text: bytes, rows: np.ndarray, tally: Any) -> float:
        asked.append(rows)
        tally.engines["reduced" if len(rows) >= 32 else "direct"] += len(rows)
        return 50e-3 + 20e-6 * len(rows)

    monkeypatch.setattr(module, "_seconds", seconds)
    monkeypatch.setattr(module, "run_chunk", lambda *_: b"")
    return asked


def test_mechanisms_and_scenarios_are_told_apart(tmp_path: Path, clock: list[np.ndarray]) -> None:
    """15 mechanisms of 200 scenarios: each costs what the clock says, exactly."""
    found = plan(tmp_path, SPEEDS)
    costs = timed(found, 3000)
    assert costs.blocks == found.mechanisms == 15
    assert costs.block_s == pytest.approx(50e-3, rel=1e-9)
    assert costs.scenario_s == pytest.approx(20e-6, rel=1e-9)
    # Three mechanisms, from the first to the last of the grid, and speeds from end to end.
    assert {tuple(rows[0, :2]) for rows in clock} == {(4.0, 2.0), (5.0, 2.2), (6.0, 2.4)}
    assert {(rows[:, 2].min(), rows[:, 2].max()) for rows in clock} == {(450.0, 650.0)}


def test_mechanisms_with_few_scenarios_are_timed_whole(
    tmp_path: Path, clock: list[np.ndarray]
) -> None:
    found = plan(tmp_path, GEOMETRY)
    costs = timed(found, 4)
    assert {len(rows) for rows in clock} == {2}
    total = costs.blocks * costs.block_s + found.scenarios * costs.scenario_s
    assert total == pytest.approx(15 * (50e-3 + 2 * 20e-6), rel=1e-9)


def test_a_sequence_is_not_drawn_to_its_end(tmp_path: Path, clock: list[np.ndarray]) -> None:
    """The points that are timed are among the first million of 10^9."""
    costs = timed(plan(tmp_path, TABLE.replace("600", "1_000_000_000")), 65_536)
    assert costs.blocks == 15_259
    assert len(clock) == 2
    assert len(np.unique(clock[1], axis=0)) == 1024


def test_dry_run_says_how_long(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing is written; the sentence has the numbers of the JSON, in their units."""
    path = study(tmp_path, GEOMETRY)
    arguments = ["sweep", path, "--dry-run", "--workers", "1"]
    monkeypatch.chdir(tmp_path)
    assert main([*arguments, "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)["estimate"]
    assert found["engines"] == {"direct": 6}
    assert found["scenario_s"] > 0.0
    assert found["workers"] == 1
    assert [item.name for item in tmp_path.iterdir()] == [Path(path).name]
    fixed = Estimate(seconds=7200.0, workers=2, mechanism_s=0.04, scenario_s=2.5e-5,
                     engines={"reduced": 92, "direct": 8})  # fmt: skip
    monkeypatch.setattr(module, "estimate", lambda *_: fixed)
    monkeypatch.setenv("COLUMNS", "200")
    assert main(arguments) == 0
    assert capsys.readouterr().out == (
        "30 scenarios of 15 mechanisms in 8 chunks\n"
        "about 120 min on 2 processors here: 40 ms a mechanism, 0.025 ms a scenario "
        "(timed: 92 by the engine reduced, 8 by the engine direct)\n"
        f"Next: nipper-pin sweep {path}\n"
    )


def test_a_dry_run_of_some_chunks_is_about_those(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """15 mechanisms at 2 speeds in 8 chunks: six of the last two chunks, all but the start."""
    costs = module.Timed(blocks=15, block_s=40.0, scenario_s=1.0, engines={"direct": 6})
    monkeypatch.setattr(processes, "fresh_processes", lambda *_: Pool(costs))
    arguments = ["sweep", study(tmp_path, GEOMETRY), "--dry-run", "--workers", "1"]
    found = {}
    for words in ((), ("--chunks", "6-7")):
        assert main([*arguments, *words, "--json", "-"]) == 0
        found[words] = json.loads(capsys.readouterr().out)
    whole, part = found.values()
    assert (whole["scenarios"], whole["chunks"]) == (30, 8)
    assert (part["scenarios"], part["chunks"]) == (6, 2)
    assert whole["estimate"]["seconds"] == pytest.approx(1.5 + 15 * 40.0 + 30.0)
    assert part["estimate"]["seconds"] == pytest.approx(1.5 + 3 * 40.0 + 6.0)
    assert main([*arguments, "--chunks", "6-7"]) == 0
    assert capsys.readouterr().out.startswith("6 of 30 scenarios of 15 mechanisms in 2 of 8 chunks")
    for words, sentence in (
        (["--chunks", "8"], "there are 8 chunks, 0 to 7"),
        (["--workers", "0"], "workers = 0 cannot be used: a whole number"),
    ):
        assert main([*arguments, *words]) == 2
        assert sentence in capsys.readouterr().err


class Pool:
    """A process that has timed what it is told."""

    def __init__(self, costs: module.Timed) -> None:
        self.costs = costs

    def __enter__(self) -> Pool:
        return self

    def __exit__(self, *_: object) -> None: ...

    def map(self, *_: object, **__: object) -> Iterator[module.Timed]:
        return iter([self.costs])


def test_the_estimate_adds_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Work divided among the processes, after their start."""
    costs = module.Timed(blocks=15, block_s=0.04, scenario_s=1e-3, engines={})
    monkeypatch.setattr(processes, "fresh_processes", lambda *_: Pool(costs))
    found = module.estimate(plan(tmp_path, SPEEDS), 4)
    chunks = len(plan(tmp_path, SPEEDS).chunks())
    workers = min(4, chunks)
    assert found.workers == workers
    assert found.seconds == pytest.approx(1.5 + (15 * 0.04 + 3000 * 1e-3) / workers, rel=1e-12)


@pytest.mark.parametrize(
    ("seconds", "words"), [(1.6, "2 s"), (170.0, "170 s"), (600.0, "10 min"), (360_000.0, "100 h")]
)
def test_times_have_the_unit_that_suits_them(seconds: float, words: str) -> None:
    found = Estimate(seconds=seconds, workers=1, mechanism_s=0.0, scenario_s=0.0, engines={})
    assert found.sentence().startswith(f"about {words} on 1 processors here")

"""The time that `--dry-run` expects: its sums, its words, and what it times."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from sweep_studies import GEOMETRY, TABLE, plan, study

from nipper_pin.cli import main
from nipper_pin.study.sweep.estimate import Estimate, estimate


def test_dry_run_says_how_long(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing is written; a chunk is timed whole, and all chunks take their share of its time."""
    path = study(tmp_path, GEOMETRY)
    arguments = ["sweep", path, "--dry-run", "--workers", "1"]
    monkeypatch.chdir(tmp_path)
    assert main([*arguments, "--json", "-"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["scenarios"], document["chunks"]) == (30, 8)
    found = document["estimate"]
    assert (found["engines"], found["workers"]) == ({"direct": 4}, 1)
    assert found["seconds"] == pytest.approx(1.5 + 30 * found["scenario_s"], rel=1e-12)
    assert found["scenario_s"] > 0.0
    assert [item.name for item in tmp_path.iterdir()] == [Path(path).name]
    monkeypatch.setenv("COLUMNS", "200")
    assert main([*arguments, "--chunks", "6-7"]) == 0
    size, time, following = capsys.readouterr().out.splitlines()
    assert size == "6 of 30 scenarios of 15 mechanisms in 2 of 8 chunks"
    words = (
        r"about \S+ (s|min|h) on 1 processors here: \S+ ms a scenario \(timed: 2 by the .* direct\)"
    )
    assert re.fullmatch(words, time)
    assert following == f"Next: nipper-pin sweep {path}"
    for refused, sentence in (
        (["--chunks", "8"], "there are 8 chunks, 0 to 7"),
        (["--workers", "0"], "workers = 0 cannot be used: a whole number"),
    ):
        assert main([*arguments, *refused]) == 2
        assert sentence in capsys.readouterr().err


@pytest.mark.slow
def test_of_a_billion_a_chunk_near_the_start_is_timed(tmp_path: Path) -> None:
    """A sequence is drawn up to the chunk; as many as possible are timed in some seconds."""
    found = estimate(plan(tmp_path, TABLE.replace("600", "1_000_000_000")), 3)
    assert max(found.engines, key=lambda name: found.engines[name]) == "reduced"
    assert found.workers == 3
    assert found.seconds == pytest.approx(1.5 + 1e9 * found.scenario_s / 3, rel=1e-12)


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(1.6, "2 s"), (180.0, "180 s"), (181.0, "3 min"), (10_801.0, "3 h"), (360_000.0, "100 h")],
)
def test_words(seconds: float, words: str) -> None:
    """Times have the unit that suits them."""
    engines = {"reduced": 1024, "direct": 8}
    found = Estimate(seconds=seconds, workers=3, scenario_s=2.5e-5, engines=engines)
    assert found.sentence() == (
        f"about {words} on 3 processors here: 0.025 ms a scenario (timed: 1,024 by the engine "
        "reduced, 8 by the engine direct)"
    )
    assert found.record() == {
        "seconds": seconds, "workers": 3, "scenario_s": 2.5e-5, "engines": engines
    }  # fmt: skip

"""A stress campaign that is interrupted loses no verdict, and goes on in its folder alone."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from programs import main

from benchmarks.stress import Campaign, Verdict, run_campaign
from benchmarks.stress.store import Store
from nipper_pin import InputError

COMMAND = [sys.executable, "-m", "benchmarks"]
SEED, CASES = 7, 12


@pytest.fixture(scope="module")
def whole() -> Campaign:
    """The campaign in one go, kept nowhere."""
    return run_campaign(CASES, SEED, workers=2)


def kept(folder: Path) -> list[str]:
    file = folder / "verdicts.jsonl"
    return file.read_text(encoding="utf-8").splitlines() if file.exists() else []


def without_time(campaign: Campaign) -> dict[str, object]:
    return {**campaign.record(), "wall_s": None}


@pytest.mark.slow
def test_an_interrupted_campaign_goes_on(tmp_path: Path, whole: Campaign) -> None:
    """What is kept is not judged again, and the end is that of a campaign in one go.

    Bits of all results are in its digest. A line that an accident has cut is judged again, and the
    next one does not begin behind it.
    """
    judged = 0

    def interrupt(_: Verdict) -> None:
        nonlocal judged
        judged += 1
        if judged == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_campaign(CASES, SEED, 2, interrupt, folder=tmp_path)
    before = kept(tmp_path)
    assert len(before) == 5
    file = tmp_path / "verdicts.jsonl"
    file.write_bytes(file.read_bytes()[:-20])

    seen: list[int] = []
    result = run_campaign(CASES, SEED, 2, lambda item: seen.append(item.number), folder=tmp_path)
    after = kept(tmp_path)
    assert without_time(result) == without_time(whole)
    assert sorted(seen) == list(range(CASES))
    assert after[:4] == before[:4]
    # The cut line, and the eight that were missing.
    assert len(after) == 5 + 8
    assert result.wall_s > json.loads(before[3])["elapsed_s"] > 0.0

    # Nothing is left to do; fewer cases are a part of what is there.
    again = run_campaign(CASES, SEED, 2, folder=tmp_path)
    assert again.verdicts == whole.verdicts
    assert run_campaign(3, SEED, 2, folder=tmp_path).verdicts == whole.verdicts[:3]
    assert kept(tmp_path) == after


@pytest.mark.slow
def test_a_folder_is_of_one_campaign(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Another seed, another limit or a mended engine: refused, and nothing in the folder changes.

    A verdict says nothing of an engine that has been changed since.
    """
    run_campaign(1, SEED, 1, folder=tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(InputError, match=r"differ in: seed\)"):
        run_campaign(1, SEED + 1, 1, folder=tmp_path)
    with pytest.raises(InputError, match=r"differ in: time limit\)"):
        run_campaign(1, SEED, 1, time_limit_s=60.0, folder=tmp_path)
    assert main(["stress", "--cases", "1", "--out", str(tmp_path)]) == 2
    assert "differ in: seed" in capsys.readouterr().err
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before

    campaign = tmp_path / "campaign.json"
    document = json.loads(before[campaign.name])
    campaign.write_text(json.dumps({**document, "code": "0" * 64}))
    with pytest.raises(InputError, match=r"differ in: code\)"):
        run_campaign(1, SEED, 1, folder=tmp_path)
    campaign.write_text("{")
    with pytest.raises(InputError, match="damaged"):
        run_campaign(1, SEED, 1, folder=tmp_path)


@pytest.mark.slow
def test_an_interrupt_counts_what_is_stored(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It comes in the moment between a verdict that is kept and the note that it is."""
    put = Store.put

    def interrupted(store: Store, verdict: Verdict, elapsed_s: float) -> None:
        put(store, verdict, elapsed_s)
        if len(kept(tmp_path)) == 2:
            raise KeyboardInterrupt

    monkeypatch.setattr(Store, "put", interrupted)
    words = ["--cases", "3", "--seed", str(SEED), "--workers", "1", "--out", str(tmp_path)]
    assert main(["stress", *words]) == 130
    assert f"interrupted; 2 of 3 verdicts are in {tmp_path}" in capsys.readouterr().err


@pytest.mark.slow
def test_the_command_is_interrupted(tmp_path: Path) -> None:
    """From the keyboard, with cases left to judge: it says what it keeps, and has kept it."""
    command = [*COMMAND, "stress", "--seed", str(SEED), "--workers", "2"]
    run = subprocess.Popen(
        [*command, "--cases", "5000", "--out", str(tmp_path)],
        stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    try:
        deadline = time.monotonic() + 120.0
        while len(kept(tmp_path)) < 3 and time.monotonic() < deadline:
            time.sleep(0.05)
        os.killpg(run.pid, signal.SIGINT)
        said = run.communicate(timeout=300)[1]
    finally:
        run.kill()
    count = len(kept(tmp_path))
    assert run.returncode == 130
    assert 3 <= count < 5000
    assert said == (
        f"nipper-pin: interrupted; {count} of 5,000 verdicts are in {tmp_path}: run the same "
        "command again for the others\n"
    )
    assert not (tmp_path / "stress.json").exists()

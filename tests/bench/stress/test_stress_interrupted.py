"""A stress campaign that is interrupted loses no verdict that it has said it keeps."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

COMMAND = [sys.executable, "-m", "benchmarks"]
SEED = 7


def kept(folder: Path) -> list[str]:
    file = folder / "verdicts.jsonl"
    return file.read_text(encoding="utf-8").splitlines() if file.exists() else []


@pytest.mark.campaign
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
    assert said == (f"nipper-pin: interrupted; {count} of 5,000 verdicts are in {tmp_path}\n")
    assert not (tmp_path / "stress.json").exists()

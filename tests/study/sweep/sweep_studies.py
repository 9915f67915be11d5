"""Small studies that the tests of sweeps share."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from programs import study_text

from nipper_pin.study.sweep import Plan, read_plan
from nipper_pin.study.sweep.chunks import run_chunk
from nipper_pin.study.sweep.results import Store
from tests.refusals.bases import right

COMMAND = [sys.executable, "-c", "import sys; from nipper_pin.cli import main; sys.exit(main())"]
TABLE = study_text("sampled_sweep.toml")
GEOMETRY = study_text("sweep_of_machines.toml")
CYCLE = '[case]\nwindow = "cycle"\nturns = 3\nleast_force_N = 60.0\n'
# Every key, below those of the head.
FULL = right("sweep.toml").split("\n", 2)[2]


def study(folder: Path, text: str, name: str = "study") -> str:
    path = folder / f"{name}.toml"
    path.write_text(f'format = 1\ntitle = "test"\n{text}', encoding="utf-8")
    return str(path)


def plan(folder: Path, text: str) -> Plan:
    return read_plan(study(folder, text))


def taken_up(out: Path, found: Plan) -> Plan:
    """The plan by which a sweep begins or goes on in a folder, without computing."""
    return Store(out, found).plan


def stored(out: Path, found: Plan) -> Path:
    """A folder with all chunks of a plan, computed in this process."""
    store = Store(out, found)
    for chunk, rows in found.rows(found.chunks()):
        store.write(chunk, run_chunk(found.job.text(), chunk.start, rows))
    return out


def started(*words: str, command: Sequence[str] = COMMAND) -> subprocess.Popen[str]:
    """A sweep by the command, in a group of processes of its own."""
    return subprocess.Popen(
        [*command, "sweep", *words], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        start_new_session=True,
    )  # fmt: skip


def wait_for(condition: Callable[[], bool], seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "nothing happened"
        time.sleep(0.02)


def chunk_files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted((folder / "chunks").iterdir())}

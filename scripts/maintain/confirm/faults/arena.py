"""Commands in forked processes whose writes fail, or that are killed, at a chosen call.

As a program it is the process that they are forked from: it imports the package once, under a shim
(``failing_writes.c``) that does nothing until a child arms it. It reads one request a line.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import itertools
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import traceback
import uuid
from dataclasses import asdict, dataclass
from importlib import import_module
from multiprocessing import resource_tracker
from pathlib import Path
from types import TracebackType
from typing import Any, Self

HERE = Path(__file__).resolve().parent
SOURCE = HERE / "failing_writes.c"


class NoCompilerError(Exception):
    """There is no gcc, or it cannot make the shim."""


@dataclass(frozen=True, kw_only=True)
class Fault:
    """What happens to a command.

    Attributes:
        at: Number of the call below the folder that is disturbed, from 1; 0: none.
        code: Number of the error that it meets.
        lasting: Every later call that needs space fails, too.
        kill: The process is killed instead, in the middle of that call.
        after: Kill the process this long after its start, or after its first hidden file [s].
        hidden: Whether `after` counts from the first hidden file.
    """

    at: int = 0
    code: int = 0
    lasting: bool = False
    kill: bool = False
    after: float | None = None
    hidden: bool = False


@dataclass(frozen=True, kw_only=True)
class Ended:
    """How a command ended.

    Attributes:
        status: Exit status; below 0 the signal that killed it.
        calls: Calls that write below the folder.
        disturbed: Name of the call that was disturbed, or nothing.
        said: What it wrote to stderr.
        wall_s: Run time [s].
    """

    status: int
    calls: int
    disturbed: str
    said: str
    wall_s: float


def build(folder: Path) -> Path:
    """Compile the shim.

    Raises:
        NoCompilerError: There is no gcc, or it fails.
    """
    shim = folder / "failing_writes.so"
    gcc = shutil.which("gcc")
    if gcc is None:
        message = "no gcc to compile failing_writes.c with"
        raise NoCompilerError(message)
    command = [gcc, "-shared", "-fPIC", "-O1", "-o", str(shim), str(SOURCE), "-ldl"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        message = f"gcc cannot compile failing_writes.c: {done.stderr[:300]}"
        raise NoCompilerError(message)
    return shim


class Arena:
    """The process that commands are forked from.

    Args:
        shim: The compiled shim.
        study: Whether the published study is to be done, too.
    """

    def __init__(self, shim: Path, *, study: bool = False) -> None:
        """Start it."""
        # The date of a figure is the same in all runs.
        env = {**os.environ, "LD_PRELOAD": str(shim), "FAULT_SHIM": str(shim),
               "SOURCE_DATE_EPOCH": "0", "FAULT_STUDY": "1" if study else ""}  # fmt: skip
        words = [sys.executable, str(HERE / "arena.py")]
        self._process = subprocess.Popen(
            words, env=env, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def __enter__(self) -> Self:
        """Use it."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End it."""
        self._process.communicate()

    def run(self, words: list[str], home: Path, fault: Fault | None = None) -> Ended:
        """Run a command of ``nipper-pin``.

        Args:
            words: Its arguments.
            home: Its working directory, below which writes are counted.
            fault: What happens to it; by default nothing.
        """
        self.begin(words, home, fault or Fault())
        return self.ended()

    def begin(self, words: list[str], home: Path, fault: Fault) -> None:
        """Start a command, and do not wait for it."""
        if self._process.stdin is not None:
            asked = {"words": words, "home": str(home), "fault": asdict(fault)}
            self._process.stdin.write(json.dumps(asked) + "\n")
            self._process.stdin.flush()

    def ended(self) -> Ended:
        """Wait for a command that was started."""
        line = "" if self._process.stdout is None else self._process.stdout.readline()
        return Ended(**json.loads(line))


def _serve(shim: Any, answers: int) -> None:
    from nipper_pin.cli import main

    for line in sys.stdin:
        asked = json.loads(line)
        home, fault = asked["home"], Fault(**asked["fault"])
        said = os.memfd_create("said")
        began = time.monotonic()
        child = os.fork()
        if child == 0:
            _child(shim, main, asked["words"], home, fault, said)
        status = _awaited(child, Path(home), fault)
        ended = Ended(
            status=status,
            calls=shim.fault_calls(),
            disturbed=shim.fault_told().decode(),
            said=os.pread(said, 2**20, 0).decode(errors="replace"),
            wall_s=time.monotonic() - began,
        )
        os.close(said)
        os.write(answers, (json.dumps(asdict(ended)) + "\n").encode())


def _child(shim: Any, main: Any, words: list[str], home: str, fault: Fault, said: int) -> None:
    os.setsid()
    os.chdir(home)
    os.dup2(said, 2)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    kind = (fault.at, fault.code, int(fault.lasting), int(fault.kill))
    shim.fault_arm(os.fsencode(os.path.realpath(home)), *kind)
    try:
        status = main(words)
        sys.stdout.flush()
    except BaseException:
        traceback.print_exc()
        status = 1
    tracker: Any = resource_tracker
    if tracker._resource_tracker._fd is not None:
        # Only the interpreter's own end waits for workers, and frees what they shared.
        sys.exit(status)
    # What is forgotten half written would complain here. All else would be freed for nothing.
    gc.collect()
    sys.stderr.flush()
    os._exit(status)


def _awaited(child: int, home: Path, fault: Fault) -> int:
    """Wait for a child, and kill its group when its time has come."""
    due = None if fault.after is None or fault.hidden else time.monotonic() + fault.after
    while True:
        found, status = os.waitpid(child, os.WNOHANG if fault.after is not None else 0)
        if found:
            break
        if due is None and any(name.startswith(".") for name in _names(home)):
            due = time.monotonic() + (fault.after or 0.0)
        if due is not None and time.monotonic() >= due:
            os.killpg(child, signal.SIGKILL)
            status = os.waitpid(child, 0)[1]
            break
        time.sleep(0.0005)
    # Workers of a child that has died are to be gone, too, before anything is judged.
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
    return os.waitstatus_to_exitcode(status)


def _names(home: Path) -> list[str]:
    return [name for _, folders, files in os.walk(home) for name in (*folders, *files)]


# What commands import when they are asked; children then need not.
_EARLY = (
    "nipper_pin.cli.optimise", "nipper_pin.cli.simulate", "nipper_pin.study.identify",
    "nipper_pin.study.optimise", "nipper_pin.study.sweep", "nipper_pin.view.paper.files",
    "nipper_pin.reduced.kernels.turn_quantities", "nipper_pin.view.run.export",
    "nipper_pin.view.scene.gif", "nipper_pin.view.scene.page",
    "nipper_pin.view.studies.front_plot", "nipper_pin.view.studies.speed_limit_plot",
    "nipper_pin.view.studies.sweep_plots", "pyarrow.parquet", "rich.progress",
)  # fmt: skip


def _program() -> None:
    answers = os.dup(1)
    os.dup2(2, 1)
    shim = ctypes.CDLL(os.environ["FAULT_SHIM"])
    shim.fault_told.restype = ctypes.c_char_p
    shim.fault_share()
    for name in _EARLY:
        import_module(name)
    # Pages and figures hold random names; here every child draws the same ones.
    numbers = itertools.count(1)
    uuid.uuid1 = uuid.uuid4 = lambda *_: uuid.UUID(int=next(numbers))  # type: ignore[assignment]
    import_module("once")
    gc.freeze()
    _serve(shim, answers)


if __name__ == "__main__":
    _program()

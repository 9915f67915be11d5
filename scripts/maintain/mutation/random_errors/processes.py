"""Copies of the checkout, and runs of pytest in processes that have the libraries loaded."""

from __future__ import annotations

import json
import os
import select
import shutil
import signal
import sys
import time
import traceback
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

_LIBRARIES = (
    "numpy", "scipy.optimize", "pinocchio", "coal", "numba", "matplotlib.pyplot", "rich.table",
    "msgspec", "mpmath", "jinja2", "pyarrow.parquet", "meshcat", "PIL.Image",
)  # fmt: skip


# Exit codes of pytest: all tests passed, or some failed.
_ENDS = ("0", "1")


def load_libraries() -> None:
    """Import what the package and its tests need, once for all runs."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    os.environ["MPLBACKEND"] = "agg"
    for name in _LIBRARIES:
        with suppress(ImportError):
            import_module(name)


def copied(root: Path, home: Path) -> None:
    """Copy what the tests need; times of change are kept, machine code is not."""
    leave = shutil.ignore_patterns("__pycache__", "*.nbi", "*.nbc")
    for name in ("nipper_pin", "benchmarks", "tests", "scripts", "docs", "models"):
        shutil.copytree(root / name, home / name, ignore=leave, symlinks=True)
    for path in root.iterdir():
        if path.is_file() and not path.name.startswith(".git"):
            shutil.copy2(path, home / path.name)


@dataclass(frozen=True)
class Run:
    """How a run of tests ended.

    Attributes:
        failed: The first test that failed or did not end; empty: none did.
        why: ``fails``, ``does not end``, ``ends the process`` or empty.
        seconds: How long it took.
        tests: How many tests ended.
    """

    failed: str
    why: str
    seconds: float
    tests: int


class _Reporter:
    """Plugin of pytest: writes what starts and what fails into a pipe."""

    def __init__(self, pipe: int) -> None:
        self._pipe = pipe

    def _say(self, *words: str) -> None:
        os.write(self._pipe, (json.dumps(words) + "\n").encode())

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        """All tests that there are."""
        if session.config.option.collectonly:
            for item in session.items:
                self._say("found", item.nodeid)

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        """A test starts."""
        self._say("start", nodeid)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """A file of tests cannot be read."""
        if report.failed:
            self._say("fail", report.nodeid)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """A test fails."""
        if report.failed:
            self._say("fail", report.nodeid)


def collected(home: Path) -> set[str]:
    """Names of all tests of a copy of the checkout."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        _in_the_child(home, ["tests", "--collect-only"], writing, ())
    os.close(writing)
    with open(reading, encoding="utf-8") as stream:
        said = [json.loads(line) for line in stream]
    os.waitpid(child, 0)
    return {name for word, name in said if word == "found"}


def run_tests(
    home: Path, tests: list[str], limits: dict[str, float], plugins: tuple[Any, ...] = ()
) -> Run:
    """Run tests in a fork of this process until the first fails.

    Args:
        home: Copy of the checkout.
        tests: Tests as pytest names them, in their order.
        limits: Seconds after which a test counts as endless; 900 where there is none.
        plugins: Further plugins; with one the run goes on after failures.
    """
    reading, writing = os.pipe()
    began = time.monotonic()
    child = os.fork()
    if child == 0:
        os.close(reading)
        _in_the_child(home, tests, writing, plugins)
    os.close(writing)
    current, why, count, rest = "", "", 0, b""
    failed = ""
    deadline = time.monotonic() + 900.0
    while not why:
        ready, _, _ = select.select([reading], [], [], max(deadline - time.monotonic(), 0.0))
        if not ready:
            failed, why = current or tests[0], "does not end"
            break
        data = os.read(reading, 65536)
        if not data:
            break
        *lines, rest = (rest + data).split(b"\n")
        for line in lines:
            word, test = json.loads(line)
            if word == "end":
                current = ""
                if test not in _ENDS and not plugins:
                    # conftest.py or a module that all tests share cannot be imported.
                    failed, why = tests[0], "fails"
                    break
            elif word == "start":
                current, count = test, count + 1
                deadline = time.monotonic() + limits.get(test, 900.0)
            elif not plugins:
                failed, why = test, "fails"
                break
    if not why and current:
        failed, why = current, "ends the process"
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(child, signal.SIGKILL)
    os.close(reading)
    os.waitpid(child, 0)
    return Run(failed, why, time.monotonic() - began, count)


def _in_the_child(home: Path, tests: list[str], pipe: int, plugins: tuple[Any, ...]) -> None:
    os.setsid()
    status = 1
    try:
        os.chdir(home)
        with open(home / "output.txt", "w", encoding="utf-8") as output:
            sys.stdout.flush()
            os.dup2(output.fileno(), 1)
            os.dup2(output.fileno(), 2)
        sys.path.insert(0, str(home))
        os.environ["PYTHONPATH"] = str(home)
        os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
        options = ["-q", "-p", "no:cacheprovider", "-p", "no:xdist", "--tb=short"]
        options += [] if plugins else ["-x"]
        reporter = _Reporter(pipe)
        status = int(pytest.main([*options, *tests], plugins=[reporter, *plugins]))
        reporter._say("end", str(status))
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        os._exit(status)

"""A copy of the package that records executed statements, and a plugin that reads it by test."""

from __future__ import annotations

import ast
import json
import mmap
import os
from collections.abc import Generator
from pathlib import Path
from typing import Any

import pytest

from .statements import blocks, is_docstring, statements_of

_MODULE = "statements_that_ran"
# A shared file, so that statements in processes that a test starts are recorded, too.
_RECORDER = """
import mmap, os
_file = os.environ.get("STATEMENTS_THAT_RAN")
if _file:
    with open(_file, "r+b") as _stream:
        ran = mmap.mmap(_stream.fileno(), 0)
else:
    ran = bytearray({count})
"""


def instrument(package: Path) -> list[str]:
    """Rewrite the files of a package; returns the key of every recorded statement."""
    keys: list[str] = []
    for path in sorted(package.rglob("*.py")):
        file = path.relative_to(package).as_posix()
        tree = ast.parse(path.read_text(encoding="utf-8"))
        numbers: dict[int, int] = {}
        for statement in statements_of(file, tree):
            if statement.recorded:
                numbers[id(statement.node)] = len(keys)
                keys.append(statement.key)
        _insert(tree, numbers)
        place = sum(
            is_docstring(node) or getattr(node, "module", "") == "__future__"
            for node in tree.body[:2]
        )
        tree.body[place:place] = ast.parse(f"from {_MODULE} import ran as _ran_").body
        path.write_text(ast.unparse(ast.fix_missing_locations(tree)), encoding="utf-8")
    recorder = _RECORDER.format(count=len(keys))
    (package.parent / f"{_MODULE}.py").write_text(recorder, encoding="utf-8")
    return keys


def _insert(node: ast.AST, numbers: dict[int, int]) -> None:
    for block in blocks(node):
        for child in list(block):
            _insert(child, numbers)
            number = numbers.get(id(child))
            if number is not None and not isinstance(child, (ast.Global, ast.Nonlocal)):
                block.insert(block.index(child), ast.parse(f"_ran_[{number}] = 1").body[0])


class ByTest:
    """Plugin of pytest: what ran in each test and in the fixtures that it uses, line by line."""

    def __init__(self, keys: list[str], file: Path, results: Path) -> None:
        """Share a file with the processes that the tests start."""
        self._keys = keys
        self._results = results.open("a", encoding="utf-8")
        file.write_bytes(bytes(len(keys)))
        os.environ["STATEMENTS_THAT_RAN"] = str(file)
        with file.open("r+b") as stream:
            self._ran = mmap.mmap(stream.fileno(), 0)
        self._of_fixtures: dict[int, int] = {}
        self._passed: dict[str, bool] = {}
        self._seconds: dict[str, float] = {}

    def _take(self) -> int:
        """What ran since the last call, as bits of a number."""
        bits = int.from_bytes(self._ran[:], "big")
        self._ran[:] = bytes(len(self._keys))
        return bits

    def _give(self, bits: int) -> None:
        self._ran[:] = (int.from_bytes(self._ran[:], "big") | bits).to_bytes(len(self._keys), "big")

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: Any) -> Generator[None, Any, Any]:
        """A fixture that several tests share runs only in the first of them."""
        before = self._take()
        try:
            return (yield)
        finally:
            own = self._take()
            self._of_fixtures[id(fixturedef)] = own
            self._give(before | own)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note how long it took and how it ended."""
        name = report.nodeid
        self._seconds[name] = self._seconds.get(name, 0.0) + report.duration
        self._passed[name] = self._passed.get(name, True) and report.outcome == "passed"

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, Any, Any]:
        """Run a test and write down what ran in it."""
        self._take()
        result = yield
        bits = self._take()
        for definitions in item._fixtureinfo.name2fixturedefs.values():  # type: ignore[attr-defined]
            for definition in definitions:
                bits |= self._of_fixtures.get(id(definition), 0)
        flags = bits.to_bytes(len(self._keys), "big")
        line = {
            "test": item.nodeid,
            "passed": self._passed.get(item.nodeid, False),
            "seconds": self._seconds.get(item.nodeid, 0.0),
            "keys": [number for number, flag in enumerate(flags) if flag],
        }
        self._results.write(json.dumps(line) + "\n")
        self._results.flush()
        return result

"""A run that leaves tests out says which, and what to install, before its closing line."""

from __future__ import annotations

import not_tested
import pytest


def report(node: str, reason: str) -> pytest.TestReport:
    return pytest.TestReport(
        nodeid=node, location=(node, 0, node), keywords={}, outcome="skipped",
        longrepr=("file", 1, f"Skipped: {reason}"), when="setup",
    )  # fmt: skip


def test_missing_packages_are_gathered_by_what_installs_them() -> None:
    missing = "could not import '{0}': No module named '{0}'"
    found = not_tested.lines(
        [
            report("tests/a.py::test_one_claim[x-1]", missing.format("meshcat")),
            report("tests/a.py::test_one_claim[y]", missing.format("matplotlib")),
            report("tests/b.py::test_page", "viser is not installed (extra `live`)"),
            report("tests/b.py::test_frame", missing.format("pandas")),
            report("tests/c.py", "no tests on a Sunday"),
        ]
    )
    assert found == [
        "2 tests left out without meshcat and matplotlib: pip install -e '.[view]'",
        "  a.py: one claim (x-1, y)",
        "1 test left out without pandas: pip install pandas",
        "  b.py: frame",
        "1 test left out without viser: pip install -e '.[live]'",
        "  b.py: page",
        "1 test left out: no tests on a Sunday",
        "  c.py: the whole file",
    ]


def test_a_run_that_leaves_nothing_out_says_nothing() -> None:
    assert not_tested.lines([]) == []

"""What a run of the tests has left out because something is not installed, in words."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import PurePosixPath

import pytest

from nipper_pin.extras import EXTRAS

_IMPORT = re.compile(r"could not import '(\w+)")
_WORD = re.compile(r"\w+")
_Report = pytest.TestReport | pytest.CollectReport


def lines(reports: Iterable[_Report]) -> list[str]:
    """Lines for the end of a run: what is missing, how to get it, and what was not tested.

    Args:
        reports: Reports of the tests that were skipped.
    """
    left: dict[str, list[tuple[str, str]]] = {}
    for report in sorted(reports, key=lambda item: item.nodeid):
        missing, remedy = _remedy(_reason(report))
        left.setdefault(remedy, []).append((missing, report.nodeid))
    return [line for remedy, tests in left.items() for line in _group(remedy, tests)]


def _reason(report: _Report) -> str:
    """Why a test was skipped."""
    why = report.longrepr
    text = why[2] if isinstance(why, tuple) else str(why)
    return text.removeprefix("Skipped: ")


def _remedy(reason: str) -> tuple[str, str]:
    """What is missing and how to install it, or the reason alone where nothing is known."""
    if "no browser" in reason:
        return "Chromium", "install it (Debian, Ubuntu: apt install chromium)"
    words = set(_WORD.findall(reason))
    for extra, packages in EXTRAS.items():
        for name in packages:
            if name in words:
                return name, f"pip install -e '.[{extra}]'"
    if found := _IMPORT.match(reason):
        return found[1], f"pip install {found[1]}"
    return "", reason


def _group(remedy: str, tests: Sequence[tuple[str, str]]) -> list[str]:
    """A heading, and the claims of each file; parameters of a test stand behind it."""
    missing = " and ".join(dict.fromkeys(name for name, _ in tests if name))
    without = f" without {missing}" if missing else ""
    found = [f"{len(tests)} test{'s' if len(tests) > 1 else ''} left out{without}: {remedy}"]
    files: dict[str, dict[str, list[str]]] = {}
    for _, node in tests:
        file, _, test = node.partition("::")
        claim, _, parameters = test.partition("[")
        claims = files.setdefault(PurePosixPath(file).name, {})
        claims.setdefault(claim, []).append(parameters.removesuffix("]"))
    for file, claims in files.items():
        text = "; ".join(_words(claim, parameters) for claim, parameters in claims.items())
        found.append(f"  {file}: {text}")
    return found


def _words(claim: str, parameters: Sequence[str]) -> str:
    """The name of a test as the sentence that it is."""
    text = claim.removeprefix("test_").replace("_", " ") or "the whole file"
    each = ", ".join(item for item in parameters if item)
    return f"{text} ({each})" if each else text

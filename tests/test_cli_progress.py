"""What is said while a command works: bars on a terminal, lines elsewhere, a word on interrupt.

The commands are real and their work is small; what a person would see is read from the stream that
plays the terminal.
"""

from __future__ import annotations

import io
import os
import re
import shutil
import signal
import sys
from pathlib import Path

import pytest
from programs import STUDIES, main
from waiting import notes

from benchmarks.commands import tell

# Hours, minutes and seconds; the time left is told as unknown until there is an estimate.
GONE, LEFT = r"0:00:\d\d gone", r"(-:--:--|0:00:\d\d) left"


class Stream(io.StringIO):
    """A terminal, or another reader of stderr, whose user interrupts once a word has come."""

    def __init__(self, *, terminal: bool, interrupted_at: str = "") -> None:
        super().__init__()
        self._terminal, self._word = terminal, interrupted_at

    def isatty(self) -> bool:
        return self._terminal

    def write(self, text: str) -> int:
        size = super().write(text)
        if self._word and self._word in seen(text):
            self._word = ""
            os.kill(os.getpid(), signal.SIGINT)
        return size


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder with small studies, and a wide terminal."""
    shutil.copytree(STUDIES, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    for name, value in (("COLUMNS", "200"), ("TERM", "xterm")):
        monkeypatch.setenv(name, value)


def seen(text: str) -> str:
    """What a terminal was sent, without colours and movements of the cursor."""
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text)


def run(words: str, stream: Stream, monkeypatch: pytest.MonkeyPatch, status: int = 0) -> str:
    """What a command says on stderr; a bar leaves nothing behind it."""
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stderr", stream)
        assert main(words.split()) == status
    text = stream.getvalue()
    if "━" in text:
        # The line of the bar is deleted, and the cursor is shown again.
        begin = text.rindex("━")
        assert "\x1b[2K" in text[begin:]
        assert "\x1b[?25h" in text[begin:]
    return seen(text)


TURNS = "simulate --window cycle --json - --cycles"
FITTED = "identify fit.toml --starts 2 --workers 1 --profiles 1 --json -"
FOUND = "optimise design.toml --starts 1 --workers 1 --no-check --json -"


@pytest.mark.parametrize(
    ("words", "bars"),
    [
        (f"{TURNS} 4", [rf"turns ━.* 0 of 4 {GONE} {LEFT}", rf"turns ━.* 4 of 4 {GONE} {LEFT}"]),
        pytest.param("stress --cases 1 --workers 1", [rf"cases ━.* 0 of 1 {GONE} {LEFT}",
                     rf"cases, 0 wrong ━.* 1 of 1 {GONE} {LEFT}"], marks=pytest.mark.slow),
        # Some starts take ten times as long as others, so no time left is told.
        (FITTED, [rf"starts \(least cost [\d.e-]+\) ━.* 2 of 2 {GONE} *$",
                  rf"profiles ━.* 1 of 1 {GONE} *$"]),
        # How many parts there are is not known, so there is neither a share nor a time left.
        (FOUND, [rf"parts \(at least \d+\) ━.* \d+ done {GONE} *$"]),
    ],
    ids=["simulate", "stress", "identify", "optimise"],
)  # fmt: skip
def test_bars_on_a_terminal(words: str, bars: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    shown = run(words, Stream(terminal=True), monkeypatch)
    for bar in bars:
        assert re.search(bar, shown, re.MULTILINE), shown


@pytest.mark.parametrize(
    ("words", "terminal"),
    [(f"{TURNS} 4", False), (FOUND, False), (f"{TURNS} 2", True), ("simulate --json -", True)],
)
def test_no_bars_elsewhere_or_of_what_is_done_in_a_moment(
    words: str, terminal: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert notes(run(words, Stream(terminal=terminal), monkeypatch)) == ""


def test_bar_of_a_sweep(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rows that were there already have no rate."""
    for rate in (r", [\d,]+/s", ""):
        shown = run("sweep sweep.toml --workers 1", Stream(terminal=True), monkeypatch)
        assert re.search(rf"scenarios{rate} ━.* 3 of 3 {GONE} {LEFT}", shown)
        assert ("/s" in shown) == bool(rate)


def test_lines_of_a_sweep(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a terminal now and then a line: how far, how fast, and how long still."""
    monkeypatch.setattr("nipper_pin.view.progress._EVERY_S", 0.0)
    line = r"nipper-pin: scenarios(, [\d.,e+]+/s)?: ([0-3]) of 3 after \d+ s(, about \d+ s left)?"
    for begins in ("0", "3"):
        said = run("sweep sweep.toml --workers 1", Stream(terminal=False), monkeypatch)
        # The line after a second, if there is one, does not know yet how many there are.
        found = [re.fullmatch(line, text) for text in said.splitlines() if " done " not in text]
        assert all(found), said
        counts = [match[2] for match in found if match]
        assert (counts[0], counts[-1], counts) == (begins, "3", sorted(counts))


IN_HERE = "scenarios are in here: run the same command again for the others"


@pytest.mark.parametrize(
    ("words", "terminal", "after", "said"),
    [
        ("sweep sweep.toml --workers 1 --out here", False, "of 3", rf"[012] of 3 {IN_HERE}"),
        ("sweep sweep.toml --workers 1 --out here", True, "of 3", rf"[012] of 3 {IN_HERE}"),
        pytest.param(
            "stress --cases 99 --workers 1 --out kept", True, "1 of 99",
            r"\d+ of 99 verdicts are in kept",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "stress --cases 99 --workers 1", True, "1 of 99",
            r"\d+ of 99 verdicts are lost: --out keeps them",
            marks=pytest.mark.slow,
        ),
    ],
)  # fmt: skip
def test_an_interrupt_says_what_there_is(
    words: str, terminal: bool, after: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("nipper_pin.view.progress._EVERY_S", 0.0)
    shown = run(words, Stream(terminal=terminal, interrupted_at=after), monkeypatch, 130)
    assert re.search(rf"nipper-pin: interrupted; {said}\n", shown), shown


def test_steps_of_a_benchmark_on_a_terminal_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    for terminal in (True, False):
        stream = Stream(terminal=terminal)
        monkeypatch.setattr(sys, "stderr", stream)
        tell("tables 3 to 5")
        assert stream.getvalue() == ("tables 3 to 5 ...\n" if terminal else "")

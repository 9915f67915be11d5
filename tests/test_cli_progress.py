"""What is said while a command works: bars on a terminal, lines elsewhere, a word on interrupt.

The studies are stand-ins that report made-up progress; what a person would see is read from the
stream that plays the terminal.
"""

from __future__ import annotations

import io
import re
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from command_probe import Probe, stand_ins
from programs import main
from test_cli_options import DESIGN, FIT, STUDY

from benchmarks.stress import Verdict
from nipper_pin import Case, Window, load, simulate

Told = Callable[..., None]


# Hours, minutes and seconds; the time left is told as unknown until there is an estimate.
GONE, LEFT = r"0:00:\d\d gone", r"(-:--:--|\d:\d\d:\d\d) left"


class Terminal(io.StringIO):
    """A stream that says that it is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder with studies, a wide terminal and stand-ins for all that takes long."""
    for name, text in (("fit", FIT), ("sweep", STUDY), ("design", DESIGN)):
        filled = text.format(title="one", name="restitution") if name != "fit" else text
        (tmp_path / f"{name}.toml").write_text(filled, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    for name, value in (("COLUMNS", "200"), ("TERM", "xterm")):
        monkeypatch.setenv(name, value)
    stand_ins(Probe(monkeypatch, tmp_path / "runs"))


def seen(text: str) -> str:
    """What a terminal was sent, without colours and movements of the cursor."""
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text)


def run(words: str, monkeypatch: pytest.MonkeyPatch, status: int = 0) -> str:
    """What a command says on stderr where that is a terminal; a bar leaves nothing behind it."""
    stream = Terminal()
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


def replaced(monkeypatch: pytest.MonkeyPatch, place: str, tell: Told, *ends: bool) -> None:
    """Report progress first, and be interrupted afterwards or do what the stand-in does."""
    module, _, name = place.rpartition(".")
    done = getattr(sys.modules[module], name)

    def called(*arguments: Any, **named: Any) -> Any:
        tell(*arguments, **named)
        if any(ends):
            raise KeyboardInterrupt
        return done(*arguments, **named)

    monkeypatch.setattr(place, called)


def interrupted(*_: Any, **__: Any) -> None:
    raise KeyboardInterrupt


def test_a_reader_of_a_pipe_may_stop(monkeypatch: pytest.MonkeyPatch) -> None:
    """Status 0 and a closed stderr, so that nothing more is written to it when Python ends."""

    def broken(*_: Any, **__: Any) -> None:
        raise BrokenPipeError

    monkeypatch.setattr("nipper_pin.cli.plot._run", broken)
    stream = io.StringIO()
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stderr", stream)
        patch.setattr("nipper_pin.cli._unread", lambda: True)
        patch.setattr("nipper_pin.view.studies.sweep_plots.plot_sweep", broken)
        assert main(["plot", "folder"]) == 0
    assert stream.closed


def test_turns_of_a_simulation(monkeypatch: pytest.MonkeyPatch) -> None:
    """From three turns on, on a terminal alone."""
    case = Case(speed_rpm=400.0, window=Window.CYCLE)
    solution = simulate(load("e62"), case)
    given: list[Any] = []

    def short(_mechanism: Any, _case: Case, advance: Any) -> Any:
        given.append(advance)
        if advance is not None:
            advance(2, 8)
        return solution

    monkeypatch.setattr("nipper_pin.cli.simulate.simulate", short)
    words = "simulate --speed 400 --window cycle --json -"
    shown = run(f"{words} --cycles 8", monkeypatch)
    assert re.search(rf"turns ━.* 2 of 8 {GONE} {LEFT}", shown)
    assert "turns" in run(f"{words} --cycles 3", monkeypatch)
    assert run(f"{words} --cycles 2", monkeypatch) == ""
    assert main([*words.split(), "--cycles", "8"]) == 0
    assert run("simulate --json -", monkeypatch) == ""
    assert [item is None for item in given] == [False, False, True, True, True]


@pytest.mark.parametrize(
    ("words", "place", "shown"),
    [
        ("simulate --window cycle --cycles 8", "nipper_pin.cli.simulate.simulate", "turns"),
        ("stress --cases 9", "benchmarks.stress.run_campaign", "cases"),
    ],
)
def test_how_much_there_is_to_do_is_known_at_once(
    words: str, place: str, shown: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing of something is a share; of an unknown number there is none."""
    monkeypatch.setattr(place, interrupted)
    count = re.search(r"[89]", words)
    assert count is not None
    assert re.search(rf"{shown} ━.* 0 of {count[0]} {GONE} {LEFT}", run(words, monkeypatch, 130))


def test_starts_of_an_identification(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Starts and profiles of how many; no time left, and nothing where no terminal is."""

    def tell(*_: Any, progress: Any, **__: Any) -> None:
        progress(1, 4, 0.123456)

    import nipper_pin.study.identify  # noqa: F401

    words = "identify fit.toml --profiles 2 --json -"
    with monkeypatch.context() as patch:
        replaced(patch, "nipper_pin.study.identify.identify", tell)
        shown = run(words, monkeypatch)
        assert re.search(rf"starts \(least cost 0\.1235\) ━.* 1 of 4 {GONE}", shown)
        assert re.search(rf"profiles ━.* 2 of 2 {GONE}", shown)
        # Some starts take ten times as long as others.
        assert "left" not in shown
        capsys.readouterr()
        assert main(words.split()) == 0
        assert capsys.readouterr().err == ""


def test_parts_of_an_optimisation(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The bar, on a terminal alone."""

    def tell(*_: Any, progress: Any, **__: Any) -> None:
        progress(3, 12)

    place = "nipper_pin.study.optimise.optimise"
    with monkeypatch.context() as patch:
        replaced(patch, place, tell)
        shown = run("optimise design.toml", monkeypatch)
        # How many parts there are is not known, so there is neither a share nor a time left.
        assert re.search(rf"parts \(at least 12\) ━.* 3 done {GONE}", shown)
        assert not re.search("3 of|%|left", shown)
        capsys.readouterr()
        assert main(["optimise", "design.toml"]) == 0
        assert capsys.readouterr().err == ""


def verdict(number: int, word: str = "right") -> Verdict:
    return Verdict(number, "spring", word, "AT_REST", "", "", 0.5)


def test_cases_of_a_campaign(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The wrong ones are counted; a folder keeps the others of an interrupt."""

    def tell(_cases: int, _seed: int, _workers: Any, advance: Any, *_: Any, **__: Any) -> None:
        for item in (verdict(3), verdict(1, "refused"), verdict(7, "wrong")):
            advance(item)

    place = "benchmarks.stress.run_campaign"
    with monkeypatch.context() as patch:
        replaced(patch, place, tell)
        shown = run("stress --cases 12 --out kept", monkeypatch)
        assert re.search(rf"cases, 1 wrong ━.* 3 of 12 {GONE} {LEFT}", shown)
        capsys.readouterr()
        assert main(["stress", "--cases", "12"]) == 0
        assert capsys.readouterr().err == ""
    replaced(monkeypatch, place, tell, True)
    begin = "nipper-pin: interrupted; 3 of 1,200 verdicts are "
    lost = "lost: --out keeps them\n"
    for words, end in (("--out one", "in one\n"), ("", lost)):
        assert run(f"stress --cases 1200 {words}", monkeypatch, 130).endswith(begin + end)
    for words, end in (("--out other", "in other\n"), ("", lost)):
        assert main(["stress", "--cases", "1200", *words.split()]) == 130
        assert capsys.readouterr().err == begin + end


def test_bar_of_a_sweep(monkeypatch: pytest.MonkeyPatch) -> None:
    """Share of all scenarios, and the rate of those that were not there before."""
    now = [100.0]
    monkeypatch.setattr("nipper_pin.cli.sweep.time", SimpleNamespace(monotonic=lambda: now[0]))

    def tell(*_: Any, progress: Any, **__: Any) -> None:
        now[0] = 104.0
        progress(3000, 1000, 12_000)

    with monkeypatch.context() as patch:
        replaced(patch, "nipper_pin.study.sweep.run_sweep", tell)
        shown = run("sweep sweep.toml", monkeypatch)
        assert re.search(rf"scenarios, 500/s ━.* 3,000 of 12,000 {GONE} {LEFT}", shown)
    for done, found in ((3000, 3000), (0, 0)):
        now[0] = 100.0
        with monkeypatch.context() as patch:
            replaced(
                patch,
                "nipper_pin.study.sweep.run_sweep",
                lambda *_, progress, done=done, found=found, **__: progress(done, found, 12_000),
            )
            shown = run("sweep sweep.toml", monkeypatch)
        assert "scenarios" in shown
        assert "/s" not in shown


def test_lines_of_a_sweep(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Without a terminal a line every half minute: how far, how fast, and how long still."""
    now = [1000.0]
    monkeypatch.setattr(
        "nipper_pin.cli.sweep.time", SimpleNamespace(monotonic=lambda: now[0])
    )  # fmt: skip
    calls = (
        (1029.5, 1000, 1000, False),
        (1030.5, 1000, 1000, True),
        (1060.0, 2000, 1000, False),
        (1100.0, 3500, 1000, True),
        (1129.0, 4000, 1000, False),
        (1200.0, 5000, 1000, True),
    )
    expected = []
    for time, done, found, line in calls:
        if line:
            text = f"nipper-pin: {done:,} of 12,000 scenarios after {time - 1000:,.0f} s"
            if done > found:
                rate = (done - found) / (time - 1000.0)
                text += f", {rate:,.3g}/s, about {(12_000 - done) / rate:,.0f} s left"
            expected.append(text)

    def tell(*_: Any, progress: Any, **__: Any) -> None:
        for time, done, found, _line in calls:
            now[0] = time
            progress(done, found, 12_000)

    with monkeypatch.context() as patch:
        replaced(patch, "nipper_pin.study.sweep.run_sweep", tell)
        assert main(["sweep", "sweep.toml"]) == 0
    assert capsys.readouterr().err.splitlines() == expected
    replaced(monkeypatch, "nipper_pin.study.sweep.run_sweep", tell, True)
    now[0] = 1000.0
    assert main(["sweep", "sweep.toml", "--out", "here"]) == 130
    assert capsys.readouterr().err.splitlines()[-1] == (
        "nipper-pin: interrupted; 5,000 of 12,000 scenarios are in here: run the same command "
        "again for the others"
    )


@pytest.mark.parametrize(
    ("words", "place"),
    [
        ("run --json -", "benchmarks.run_time.benchmark.benchmark"),
        ("paper --json -", "benchmarks.paper.study.paper_study"),
    ],
)
def test_steps_of_a_benchmark(
    words: str, place: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What is being done, on a terminal alone."""

    def tell(_mechanism: Any = None, say: Any = None, **_: Any) -> None:
        say("tables 3 to 5")

    __import__(place.rpartition(".")[0])
    replaced(monkeypatch, place, tell)
    assert run(words, monkeypatch) == "tables 3 to 5 ...\n"
    assert main(words.split()) == 0
    assert capsys.readouterr().err == ""

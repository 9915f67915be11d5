"""Every text that commands print, on terminals of 60, 80 and 200 columns: no word is broken.

Sentences have the same words at every width, tables all their cells, and no line is too long.
"""

from __future__ import annotations

import io
import math
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from made_up_results import identified, optimum
from printed_parts import WIDE, Parts, faults
from rich.console import Console

from benchmarks.run_time.work_precision import Row
from benchmarks.stress import Campaign
from benchmarks.stress.judging import Verdict
from benchmarks.views.benchmark_report import print_benchmark
from benchmarks.views.stress_report import print_campaign
from nipper_pin import Case, Mechanism, Solution, Window, simulate
from nipper_pin.cli import main
from nipper_pin.study import speed_limit
from nipper_pin.study.check import ModelReport, check_model
from nipper_pin.study.identify.fitting.goodness import Verdict as Fitted
from nipper_pin.study.next_steps import NextSteps, next_steps
from nipper_pin.study.sweep.report import SweepReport
from nipper_pin.study.sweep.results import Tally
from nipper_pin.study.sweep.results.extremes import Extremes
from nipper_pin.view import console as printing
from nipper_pin.view.console import paste, say, show_table, unbroken_console
from nipper_pin.view.run.table import print_solution
from nipper_pin.view.studies.check_report import print_report
from nipper_pin.view.studies.optimise_report import print_optimum
from nipper_pin.view.studies.speed_limit_report import print_speed_limit

Write = Callable[[Console], None]
WIDTHS = (60, 80, 200)
LONG = "a/folder/with/a/name/that/is/longer/than/a/terminal/" * 3


@pytest.fixture(scope="module")
def checked(e62: Mechanism) -> ModelReport:
    return check_model(e62, 450.0)


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("name", ["transition", "cycle", "many_turns"])
def test_runs(name: str, width: int, request: pytest.FixtureRequest) -> None:
    """With forces and the command that follows."""
    run: Solution = request.getfixturevalue(name)
    turns = f"nipper-pin simulate {LONG} --window cycle"
    assert not faults(
        lambda console: print_solution(run, console, with_forces=True, following=turns), width
    )


@pytest.mark.parametrize("width", WIDTHS)
def test_runs_of_elastic_shafts(width: int, e62: Mechanism) -> None:
    """Speeds of the driven joints are a table of six columns."""
    case = Case(speed_rpm=450.0, window=Window.CYCLE, drive="inertial")
    run = simulate(e62, case)
    assert not faults(lambda console: print_solution(run, console), width)
    assert "Speeds of the driven joints" in printed(lambda out: print_solution(run, out), width)


def printed(write: Write, width: int) -> str:
    console = Parts(width)
    write(console)
    return console.text


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("provenance", [True, False])
def test_checks(provenance: bool, width: int, checked: ModelReport) -> None:
    steps = next_steps(checked, LONG, ["--set", f"{LONG}=1"])
    missing = NextSteps(("Missing: " + "one thing, " * 20,), steps.commands)
    for item in (steps, missing):
        assert not faults(
            lambda console, item=item: print_report(checked, item, console, provenance=provenance),
            width,
        )


@pytest.mark.parametrize("width", WIDTHS)
def test_speed_limits(width: int) -> None:
    places = np.arange(40.0)
    verdicts = tuple(speed_limit.Verdict) * 4
    ranges = tuple(
        speed_limit.SpeedRange(1234.5 + 100.0 * i, 1334.5 + 100.0 * i, verdict)
        for i, verdict in enumerate(verdicts)
    )
    result: Any = SimpleNamespace(
        title="a machine of a long name " * 5, stop="jaw", speed_rpm=1234.5 + 100.0 * places,
        status=["followed"] * 39 + ["lost"], repeats_after=np.array([1, 0] * 20),
        closing=34.125 + places, rest=36.5 + places, opening=55.25 - 0.1 * places,
        margin=np.where(places > 30.0, math.nan, 18.75 - places), clamped_share=0.01 * places,
        settled=ranges, single=ranges, lost="Beyond them something went wrong.",
    )  # fmt: skip
    assert not faults(lambda console: print_speed_limit(result, console), width)


@pytest.mark.parametrize("width", WIDTHS)
def test_optimisations(width: int) -> None:
    """With a front, and a control that contradicts it."""
    best = optimum().best
    for found in (
        optimum(front=(best, best), no_machine=("the links do not reach one another " * 4,)),
        optimum(contradiction="the direct engine finds another time to rest " * 3),
    ):
        assert not faults(lambda console, found=found: print_optimum(found, console), width)


@pytest.mark.parametrize("width", WIDTHS)
def test_identifications(width: int) -> None:
    name = "the time of the second rebound by that of the first at 650 r/min"
    for verdict in Fitted:
        assert not faults(identified(verdict, name=name, broken_limits={"closing": 1.5}), width)


@pytest.mark.parametrize("width", WIDTHS)
def test_campaigns(width: int) -> None:
    verdicts = tuple(
        Verdict(k, f"family {k % 7}", word, f"kind_{k}", "it gained energy " * 9, "f", 0.5)
        for k, word in enumerate(["right", "refused", "wrong"] * 20)
    )
    assert not faults(lambda console: print_campaign(Campaign(23, verdicts, 1.5), console), width)


@pytest.mark.parametrize("width", WIDTHS)
def test_benchmarks(width: int) -> None:
    """Tables too wide are parts."""

    def row(engine: str, size: float) -> Row:
        return Row(engine, "tolerance 1e-12", size, size, size, size, 30, 2e-13, 7e-13,
                   evaluations=212)  # fmt: skip

    costs = [{"what": "the kinetic energy of all links together", "wall_ms": 1.5, "cut_pins": 7,
              "fastest_ms": 1.25, "held_energy_balance": 2.5e-13,
              "inertial_energy_balance": 0.25}]  # fmt: skip
    parts = ("phases", "parts", "collisions", "turns", "links", "memory")
    result: Any = SimpleNamespace(
        engines=[row("direct", 1.125), row("direct", 22.25), row("reduced, in batches", 333.5)],
        accuracy=[], stated=[], turns=[], reduced=None,
        peers=[row("an engine of others (by hand)", 4444.5)],
        unavailable=("a peer: it cannot find a bounce of this machine, " * 3,), quick=False,
        environment={"date": "d", "platform": "p " * 50, "processor": "c", "cores": 6,
                     "python": "3", "cores_allowed": None, "load_average": None, "threads": {},
                     "versions": {}},
        cost=dict.fromkeys(parts, costs),
    )  # fmt: skip
    assert not faults(lambda console: print_benchmark(result, console), width)


# Commands that print by themselves.


@pytest.fixture
def printing_of(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[[list[str]], Write]:
    """Makes a command print on the console of a test, each time in an empty folder."""
    home = tmp_path / "home"

    def of(words: list[str]) -> Write:
        def write(console: Console) -> None:
            shutil.rmtree(home, ignore_errors=True)
            home.mkdir()
            monkeypatch.chdir(home)
            monkeypatch.setattr("nipper_pin.view.console.Terminal", lambda: console)
            monkeypatch.setattr("nipper_pin.view.console.unbroken_console", lambda: console)
            assert main(words) == 0
            monkeypatch.undo()

        return write

    return of


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize(
    "words",
    ["new --list", "new a_press", f"new {LONG[:40]}", "new --from toggle_press a_press"],
)
def test_new_models(words: str, width: int, printing_of: Callable[[list[str]], Write]) -> None:
    assert not faults(printing_of(words.split()), width)


SWEEP = """format = 1
title = "made up"
model = "e62"
quantities = ["rebound_amplitude_2"]
[parameters."drives.pendulum.crank_radius_mm"]
values = [63.0, 64.0]
[parameters."springs.steeve.preload_length_mm"]
values = [10.0, 11.0]
"""


@pytest.mark.parametrize("width", WIDTHS)
def test_sweeps(
    width: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    printing_of: Callable[[list[str]], Write],
) -> None:  # fmt: skip
    """Counts, the smallest and the largest row, and the command that plots them."""
    file = tmp_path / "study.toml"
    file.write_text(SWEEP, encoding="utf-8")

    def run_sweep(plan: Any, folder: Path, **_: Any) -> SweepReport:
        extremes = Extremes(plan.job)
        extremes.add(
            pa.table({
                "scenario": [3, 7], "rebound_amplitude_2": [1.25e-5, 3.456e-4],
                "drives.pendulum.crank_radius_mm": [63.0, 64.0],
                "springs.steeve.preload_length_mm": [10.0, 11.0],
            })
        )  # fmt: skip
        return SweepReport(
            folder=folder, scenarios=4, found=2, computed=2, chunks=1, damaged=("one", "two"),
            workers=2, wall_s=1.75, tally=Tally(), extremes=extremes,
        )  # fmt: skip

    command = printing_of(["sweep", str(file), "--out", "a_folder_of_results"])

    def write(console: Console) -> None:
        monkeypatch.setattr("nipper_pin.study.sweep.run_sweep", run_sweep)
        command(console)

    assert not faults(write, width)
    text = " ".join(printed(write, width).split())
    # 12.5 and 345.6 urad in mdeg.
    for word, value in (("Smallest", 1.25e-5), ("Largest", 3.456e-4)):
        told = re.search(rf"{word} second rebound amplitude: (\S+) mdeg", text)
        assert told is not None
        assert float(told[1]) == pytest.approx(1e3 * math.degrees(value), rel=5.1e-4)


# The checks themselves: errors that are planted are seen.


def some(console: Console) -> None:
    """A table that has to give way, and a sentence."""
    headings = ("what it is", "rebound amplitude mdeg", "rebound time ms", "energy lost mJ")
    rows = [
        (f"the {word} rebound of the jaw in the turn", "301.2345", "5.428123", "-0.0923456")
        for word in ("first", "second")
    ]
    show_table(console, headings, rows)
    say(console, "One sentence of more words than a narrow terminal has room for on one line.")
    paste(console, f"Next: nipper-pin check {LONG}")


NARROW = 36


def folded(text: str, width: int, **_: Any) -> str:
    """Break a text wherever a line is full."""
    return "\n".join(text[k : k + width] for k in range(0, len(text), width))


@pytest.mark.parametrize(
    ("place", "wrong", "said"),
    [
        ("_width", lambda *_, **__: 0, "too long|a table|a number"),
        ("_parts", lambda columns, *_: [list(columns[:2])], "a column is missing"),
        ("_widths", lambda part, _room: [5 for _ in part], "a table: "),
        ("textwrap", SimpleNamespace(fill=folded, wrap=printing.textwrap.wrap), "a sentence: "),
        ("textwrap", SimpleNamespace(fill=lambda text, *_, **__: text,
                                     wrap=printing.textwrap.wrap), "too long: "),
    ],
)  # fmt: skip
def test_planted_errors_are_seen(
    place: str, wrong: Any, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A table that is too wide, a lost column, folded cells, a folded sentence and a long line."""
    assert not faults(some, NARROW)
    sound = getattr(printing, place)

    def write(console: Console) -> None:
        # Where nothing has to give way all is as it should be.
        monkeypatch.setattr(printing, place, wrong if console.width < WIDE else sound)
        some(console)

    found = faults(write, NARROW)
    assert found
    assert re.match(said, found[0])


def test_without_a_terminal_sentences_are_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """A script that searches the output finds every sentence on a line of its own."""
    monkeypatch.setattr("sys.stdout", io.StringIO())
    monkeypatch.delenv("COLUMNS", raising=False)
    monkeypatch.setenv("TERM", "dumb")
    console = unbroken_console()
    with console.capture() as said:
        say(console, "one thing " * 500)
    assert said.get().count("\n") == 1
    monkeypatch.setenv("COLUMNS", "70")
    monkeypatch.setenv("TERM", "xterm")
    assert unbroken_console().width == 70

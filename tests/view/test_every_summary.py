"""What `identify`, `sweep` and `stress` print: every number in its sentence or cell.

The results are made up, each number another one, so that one in a wrong place or unit is seen.
"""

from __future__ import annotations

import io
import math
import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from programs import main
from rich.console import Console

import benchmarks.stress as stress
import nipper_pin.study.sweep as sweep
from benchmarks.stress import Campaign
from benchmarks.stress.judging import Verdict
from benchmarks.views.stress_report import print_campaign
from nipper_pin.study.identify.fitting.fit import Fit
from nipper_pin.study.identify.fitting.goodness import Verdict as Fitted
from nipper_pin.study.identify.fitting.limits import FORCE_SIGMA_N, INDEX_SIGMA
from nipper_pin.study.identify.problem.targets import Condition
from nipper_pin.study.sweep.job import NO_MODEL
from nipper_pin.study.sweep.report import SweepReport
from nipper_pin.study.sweep.results import Tally
from nipper_pin.study.sweep.results.extremes import Extremes
from nipper_pin.study.transitions import FAILED, TURN
from nipper_pin.view.console import paste
from nipper_pin.view.live.answer import _also
from nipper_pin.view.studies.identify_report import print_fit


def printed(write: Callable[[Console], None], width: int = 10_000) -> str:
    stream = io.StringIO()
    write(Console(file=stream, width=width))
    return stream.getvalue()


def cells(text: str, first: str) -> list[str]:
    """Cells of the row that begins with these words; blanks part them."""
    (line,) = (line for line in text.splitlines() if line.startswith(f"{first}  "))
    return line.removeprefix(first).split()


# Identify.


def target(name: str, value: float, sigma: float) -> Any:
    return SimpleNamespace(name=name, value=value, sigma=sigma, since=0.0)


def free(path: str, start: float, low: float, high: float) -> Any:
    return SimpleNamespace(path=path, start=start, low=low, high=high, width=high - low)


PATHS = ("springs.a.rate_N_per_m", "stops.b", "links.c")


def fit(**others: Any) -> Any:
    """Three numbers and two targets."""
    problem = SimpleNamespace(
        title="made up", targets=[target("one", 5.25, 0.125), target("two", 80.0, 2.5)],
        parameters=[free(PATHS[0], 11.0, 4.0, 20.0), free(PATHS[1], 0.25, 0.125, 0.5),
              free(PATHS[2], 3.5, 3.0, 8.0)],
    )  # fmt: skip
    ends = np.array([0.515625, 0.0, 0.75])
    found = {
        "objective": SimpleNamespace(problem=problem), "seed": 17,
        "descents": tuple(SimpleNamespace(cost=cost, z=ends) for cost in (1.5, 1.5001, 2.5, 9.0)),
        "predicted": np.array([5.375, 76.0]),
        "values": {PATHS[0]: 12.25, PATHS[1]: 0.125, PATHS[2]: 6.75},
        "premises": {}, "excess": np.zeros(4), **others,
    }  # fmt: skip
    return Fit(**found)


KNOWN: dict[str, Any] = {
    "identifiable_directions": 2,
    "paths": PATHS,
    "singular_values": np.array([31.5, 4.25, 0.75]),
    "determined": (PATHS[0], PATHS[1]),
    "ranked": lambda: [(PATHS[0], 0.06), (PATHS[1], 0.31), (PATHS[2], 0.88)],
    "deviations": {PATHS[0]: 0.015, PATHS[1]: 0.08, PATHS[2]: 0.22},
    "scaled_deviations": lambda scale: {PATHS[0]: 0.01 * scale, PATHS[1]: 0.2, PATHS[2]: 0.3},
    "strongest": lambda least: [(PATHS[0], PATHS[2], -0.9625)] if least <= 0.9625 else [],
}
JUDGED: dict[str, Any] = {
    "verdict": Fitted.AGREES, "sentence": lambda: "The fit agrees.", "scale": 3.0,
    "residuals": np.array([2.0, -120.5]), "outliers": (1,),
}  # fmt: skip


def told(found: Any = None, known: Any = None, profiles: tuple[Any, ...] = ()) -> str:
    facts = SimpleNamespace(**(known or KNOWN))
    judged = SimpleNamespace(**JUDGED)
    return printed(lambda console: print_fit(found or fit(), judged, facts, profiles, console))  # type: ignore[arg-type]


def test_identify_in_words() -> None:
    """Starts, cost, targets met, singular values, and numbers that are known."""
    profile = SimpleNamespace(
        path=PATHS[0], sigma=0.625, values=[11.5, 12.25], cost=[0.71875, 0.0],
        quadratic=[0.6875, 0.0],
    )  # fmt: skip
    text = told(profiles=(profile,))
    assert (
        "4 starts, seed 17: 2 of them end at the least cost 1.5; 1 of 2 targets are met within "
        "4 %, 2 within 10 %" in text
    )
    assert "\nWhat the targets determine\n2 of 3 directions" in text
    assert (
        "2 of 3 directions; singular values (sigmas over the whole range): 31.5, 4.25, 0.75" in text
    )
    assert "less than half of their range: rate of spring a, stops b\n" in text
    assert "known: rate of spring a and links c -0.963\n" in text.replace("-0.962", "-0.963")
    assert "0.5 is one sigma = 0.000625): 0.0115: 0.72 (0.69), 0.01225: 0.00 (0.00)" in text
    weak = told(known={**KNOWN, "strongest": lambda _: []})
    assert "correlated" not in weak


def test_tables_of_identify() -> None:
    """Target, wanted, sigma, found, deviation, sigmas; number, before, found, errors, bounds."""
    text = told()
    assert cells(text, "one") == ["5.25", "0.12", "5.375", "+2.38", "%", "+2.00"]
    assert cells(text, "two") == ["80", "2.5", "76", "-5.00", "%", "-120!"]
    # Errors are shares of the range: of 16, 0.375 and 5.
    assert cells(text, "rate of spring a [N/mm]") == [
        "0.011", "0.01225", "0.00024", "0.00048", "0.004..0.02", "6%",
    ]  # fmt: skip
    assert cells(text, "stops b") == ["0.25", "0.125*", "0.03", "0.075", "0.125..0.5", "31%"]
    assert cells(text, "links c") == ["3.5", "6.75", "1.1", "1.5", "3..8", "88%?"]
    assert "?: 50 % or more, not known" in text


def test_limits_and_premises_of_identify() -> None:
    """A limit that is broken by more than a sigma, and the settings whose turn is another one."""
    assert "all limits are kept" in told()
    text = told(fit(excess=np.array([0.0, -1.5, 0.0, 2.0])))
    words = (
        f"opening_index by {-1.5 * INDEX_SIGMA:+.3g}, stop_force_N by {2.0 * FORCE_SIGMA_N:+.3g}"
    )
    assert f"LIMITS ARE BROKEN: {words}\n" in text
    premises = {
        Condition(650.0, 0.25, 9500.0): SimpleNamespace(holds=False, why="late"),
        Condition(450.0): SimpleNamespace(holds=None, why="not asked"),
        Condition(550.0): SimpleNamespace(holds=True, why=""),
    }
    text = told(fit(premises=premises))
    assert (
        "650 r/min, restitution 0.25, stiffness 9500: the transition of the turn, since late"
        in text
    )
    assert "450 r/min: a transition as assumed; not asked" in text
    assert "550 r/min" not in text


# Sweep.


def tally() -> Tally:
    found = Tally()
    found.rows = 60
    found.outcomes = Counter({"completed": 41, FAILED: 12, NO_MODEL: 7})
    found.engines = Counter({TURN: 3, "direct": 9, "reduced": 48})
    found.direct = Counter({"two freedoms": 5, "light links": 4})
    found.premise = Counter({"true": 39, "false": 8, "null": 13})
    found._failed = Counter({"it jams at #": 11, "no root": 8})
    found._told = {"it jams at #": "it jams at 3.5", "no root": "no root"}
    return found


STUDY = """
format = 1
title = "made up"
model = "e62"
quantities = ["duration_s"]
[parameters.speed_rpm]
values = [450.0, 550.0, 650.0]
[parameters.restitution]
values = [0.1, 0.2]
"""


def test_sweep_in_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Found and computed scenarios, time, reasons; the folder has the name of the study."""
    file = tmp_path / "some_study.toml"
    file.write_text(STUDY, encoding="utf-8")
    asked: list[Path] = []

    def run_sweep(plan: Any, folder: Path, **_others: Any) -> SweepReport:
        asked.append(folder)
        extremes = Extremes(plan.job)
        extremes.add(
            pa.table({
                "scenario": [3, 7, 9], "duration_s": [0.0125, 0.003456, math.nan],
                "speed_rpm": [450.0, 650.0, 550.0], "restitution": [0.1, 0.2, 0.2],
            })
        )  # fmt: skip
        return SweepReport(
            folder=folder, scenarios=5, found=2, computed=3, chunks=1, damaged=("chunk 7",),
            workers=2, wall_s=1.75, tally=tally(), extremes=extremes,
        )  # fmt: skip

    monkeypatch.setattr(sweep, "run_sweep", run_sweep)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "1000")
    assert main(["sweep", str(file)]) == 0
    assert main(["sweep", str(file), "--out", "elsewhere"]) == 0
    assert asked == [Path("out") / "some_study", Path("elsewhere")]
    text = capsys.readouterr().out
    size = (
        r"^5 of 6 scenarios of 1 mechanism in out/some_study: 2 were there, 3 computed in 1.75 s$"
    )
    assert re.search(size, text, re.M)
    lines = text.splitlines()
    assert "damaged, and computed anew: chunk 7" in lines
    assert "5 by the direct engine: two freedoms" in lines
    assert "4 by the direct engine: light links" in lines
    assert (
        "8 do not arrive in the initial phase (premise_holds is false); 3 of them were computed by "
        "whole turns" in lines
    )
    assert "19 without a result, 11 because: it jams at 3.5" in lines
    # Last the rows with the smallest and the largest value, in ms, and what to run next.
    ends = [
        "Smallest time to rest: 3.456 ms (scenario 7: speed_rpm 650, restitution 0.2)",
        "Largest time to rest: 12.50 ms (scenario 3: speed_rpm 450, restitution 0.1)",
    ]
    assert lines[-3:] == [*ends, "Next: nipper-pin plot elsewhere"]
    half = len(lines) // 2
    assert lines[half - 3 : half] == [*ends, "Next: nipper-pin plot out/some_study"]


# Stress.


def verdict(number: int, family: str, word: str, kind: str, detail: str = "") -> Verdict:
    return Verdict(number, family, word, kind, detail, f"{number:04x}", 0.5)


VERDICTS = (
    *(verdict(k, "transitions", "right", "COMPLETED") for k in range(5)),
    *(verdict(k, "transitions", "refused", "InputError", "no") for k in range(5, 8)),
    verdict(8, "chains", "right", "STOPPED"),
    verdict(9, "chains", "wrong", "energy", "it [gained] 3 J"),
    verdict(10, "chains", "wrong", "hang", "for 600 s"),
)


def test_stress_in_words() -> None:
    """Right, refused and wrong cases by family and together, reasons, and each wrong case."""
    text = printed(lambda console: print_campaign(Campaign(23, VERDICTS, 12.5), console))
    assert re.search(r"family\s+right\s+refused\s+wrong", text)
    assert cells(text, "transitions") == ["5", "3", "0"]
    assert cells(text, "chains") == ["1", "0", "2"]
    assert cells(text, "all") == ["6", "3", "2"]
    assert "errors: InputError 3, energy 1, hang 1\n" in text
    assert "outcomes: COMPLETED 5, STOPPED 1\n" in text
    assert "case 9 (chains): wrong, energy: it [gained] 3 J\n" in text
    assert "case 10 (chains): wrong, hang: for 600 s\n" in text
    assert "11 cases, seed 23, 12.5 s; digest " in text
    many = tuple(verdict(k, "chains", "wrong", "hang") for k in range(27))
    text = printed(lambda console: print_campaign(Campaign(1, many, 1.0), console))
    assert text.count("wrong, hang") == 20
    assert "and 7 more\n" in text


@pytest.mark.parametrize(
    "words",
    [["--cases", "0"], ["--workers", "0"], ["--time-limit", "0"], ["--seed", "-1"]],
)
def test_campaigns_of_nothing_are_refused(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["stress", *words]) == 2
    assert capsys.readouterr().err.startswith(f"nipper-pin: {words[0]} {words[1]}")


def test_an_interrupted_campaign_counts_what_is_judged(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Three of 40 verdicts, and that they are lost without a folder."""

    def run_campaign(
        _cases: int, _seed: int, _workers: Any, advance: Any, *_others: Any, **_named: Any
    ) -> None:
        for item in VERDICTS[:3]:
            advance(item)
        raise KeyboardInterrupt

    monkeypatch.setattr(stress, "run_campaign", run_campaign)
    assert main(["stress", "--cases", "40"]) == 130
    assert "interrupted; 3 of 40 verdicts are lost: --out keeps them" in capsys.readouterr().err


# Small things.


def test_commands_are_printed_as_they_are() -> None:
    """Nothing is broken into lines, and no bracket is taken for a style."""
    command = "nipper-pin simulate '[bold]e62[/bold]' " + "--set a.b=1 " * 20
    assert printed(lambda console: paste(console, command), width=40) == f"{command}\n"


@pytest.mark.parametrize(("count", "word"), [(1, "once"), (2, "2 times"), (5, "5 times")])
def test_other_stops_of_the_live_page(count: int, word: str) -> None:
    """How often they were struck, and how long after the first collision."""
    others = [SimpleNamespace(stop="steeve", t=0.0125 + 0.001 * k) for k in range(count)]
    first = SimpleNamespace(stop="jaw", t=0.01)
    text = _also(SimpleNamespace(collisions=[first, *others]), others)  # type: ignore[arg-type]
    assert text == f" On the way the steeve struck its stop {word}, first after 2.5 ms."
    assert _also(SimpleNamespace(collisions=[first]), []) == ""  # type: ignore[arg-type]

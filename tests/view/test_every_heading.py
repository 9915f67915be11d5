"""Headings of printed tables over their columns, what is emphasised, and which turns are shown.

Rows are made up so that the text under each heading says what it is.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from made_up_results import design, identified, optimum
from rich.console import Console
from small_machines import frame, hinge, link, machine

from benchmarks.stress.judging import Verdict as Judged
from benchmarks.views.stress_report import print_verdict
from nipper_pin import Case, Mechanism, Solution, Window, simulate
from nipper_pin.hybrid.event import EventKind
from nipper_pin.study.identify.fitting.goodness import Verdict
from nipper_pin.study.optimise.result import CAUTION
from nipper_pin.view import reading
from nipper_pin.view.console import paste, say, show_table
from nipper_pin.view.scene.solids import solids
from nipper_pin.view.studies import check_report as checked
from nipper_pin.view.studies import optimise_report

BOLD, RED = "\x1b[1m", "\x1b[1;31m"


def printed(write: Callable[[Console], None], *, colours: bool = False) -> str:
    stream = io.StringIO()
    write(
        Console(
            file=stream, width=400, force_terminal=colours,
            color_system="standard" if colours else None,
        )
    )  # fmt: skip
    return stream.getvalue()


def columns(text: str, first: str, rows: int, title: str = "") -> dict[str, list[str]]:
    """Cells by heading of a table: what stands below one another.

    It is the one whose headings end with a word on their last line, or that follows its title.
    """
    lines = text.splitlines()
    begin = lines.index(title) + 1 if title else 0
    rule = next(
        k for k in range(begin + 1, len(lines))
        if lines[k].startswith("─") and (title or lines[k - 1].split()[:1] == [first])
    )  # fmt: skip
    if not title:
        # Headings of several lines: the first column, of one line, leaves room above its own.
        begin = next(k for k in range(rule - 1, -1, -1) if not lines[k - 1].startswith("  "))
    width = len(lines[rule])
    assert set(lines[rule]) == {"─"}
    heads, cells = lines[begin:rule], lines[rule + 1 : rule + 1 + rows]
    block = [line.ljust(width) for line in (*heads, *cells)]
    filled = "".join("x" if any(row[k] != " " for row in block) else " " for k in range(width))
    spans = [item.span() for item in re.finditer(r"x+(?: x+)*", filled)]
    return {
        " ".join(" ".join(row[a:b] for row in block[: len(heads)]).split()): [
            row[a:b].strip() for row in block[len(heads) :]
        ]
        for a, b in spans
    }


# Identify.


def test_tables_of_a_fit_by_heading() -> None:
    """Deviations in per cent; errors as parts of the range, by the sigmas and by the misfit."""
    text = printed(identified(Verdict.AGREES))
    assert columns(text, "target", 2) == {
        "target": ["one", "two"], "wanted": ["5.25", "80"], "+-": ["0.5", "2.5"],
        "found": ["5.375", "76"], "deviation": ["+2.50 %", "-5.00 %"],
        "sigmas": ["+0.25", "-1.60!"],
    }  # fmt: skip
    numbers = {
        "number": ["rate of spring a [N/mm]", "stops b"], "before": ["0.011", "0.25"],
        "found": ["0.01225", "0.5*"], "+-": ["0.002", "0.075"], "scaled": ["0.002", "0.22"],
        "bounds": ["0.004..0.02", "0.125..0.5"],
        "left": ["25%", "50%?"],
    }  # fmt: skip
    assert columns(text, "number", 2) == numbers
    assert "bounds and not targets decide them: stops b (high)" in text
    assert "narrowed to less than half of their range: none" in text
    assert "1 of 2 targets are met within 4 %, 2 within 10 %" in text
    assert "limits" not in text
    bare = printed(identified(Verdict.WEIGHTS_ALONE, scale=0.0, at_bounds={}))
    numbers |= {"scaled": ["-", "-"], "found": ["0.01225", "0.5"]}
    assert columns(bare, "number", 2) == numbers
    assert "decide them" not in bare


@pytest.mark.parametrize("verdict", Verdict)
def test_only_a_contradicted_fit_is_red(verdict: Verdict) -> None:
    text = printed(identified(verdict), colours=True)
    red = [line for line in text.splitlines() if RED in line]
    said = f"It is {verdict.value}."
    assert said in text
    assert red == ([f"{RED}{said}\x1b[0m"] if verdict is Verdict.CONTRADICTED else [])
    assert f"{BOLD}made up\x1b[0m" in text


def test_broken_limits_are_red() -> None:
    broken = identified(Verdict.AGREES, broken_limits={"x": 1.5, "y": -0.25}, excess=np.ones(2))
    assert f"{RED}LIMITS ARE BROKEN: x by +1.5, y by -0.25\x1b[0m" in printed(broken, colours=True)
    kept = printed(identified(Verdict.AGREES, excess=np.zeros(2)), colours=True)
    assert "all limits are kept\n" in kept
    assert RED not in kept


# Optimise.


def told(**others: Any) -> str:
    return printed(lambda console: optimise_report.print_optimum(optimum(**others), console))


def test_tables_of_an_optimum_by_heading() -> None:
    text = told()
    assert columns(text, "number", 3) == {
        "number": ["rate of spring a", "rate of spring b [N/mm]", "stops c"],
        "before": ["1", "0.002", "3"], "optimum": ["7", "0.09", "0.5"],
        "bounds": ["-1 to 10", "-0.002 to 0.02", "-3 to 30"],
    }  # fmt: skip
    quantities = {
        "quantity": ["time to rest [ms]", "first rebound amplitude [um]"],
        "before": ["500", "6e+06"], "optimum": ["250", "3e+06"], "control": ["375", "-"],
    }  # fmt: skip
    assert columns(text, "quantity", 2) == quantities
    text = told(before=None, gain=None)
    assert columns(text, "quantity", 2) == {**quantities, "before": ["-", "-"]}
    assert text.splitlines()[1] == "smallest time to rest: 250.0 ms"
    said = "smallest time to rest: 250.0 ms (-12.5 %)"
    lines = told().splitlines()
    assert lines[1] == said
    # What was found stands at the end once more, before the next command.
    assert lines[-4:] == ["", f"Found: {said}", CAUTION, "Next: do it"]
    larger = optimum()
    larger.problem.aims.reverse()
    text = printed(lambda console: optimise_report.print_optimum(larger, console))
    assert text.splitlines()[1] == "largest first rebound amplitude: 3.000e6 um (-12.5 %)"


def test_an_optimum_that_is_confirmed_or_not() -> None:
    """By which turn; or in which number not, in bold."""
    text = told()
    assert "confirmed by turn 4 of the direct engine" in text
    assert "NOT CONFIRMED" not in text
    refused = SimpleNamespace(values={"duration_s": 0.375}, turns=4, confirmed=False)
    wrong = optimum(contradiction="it differs", control=refused, before=design(2.0, inside=False))
    text = printed(lambda console: optimise_report.print_optimum(wrong, console), colours=True)
    assert f"{BOLD}NOT CONFIRMED: it differs\x1b[0m" in text
    assert "confirmed by turn" not in text
    # What the turn refuses is no gain.
    said = "no confirmed optimum; smallest time to rest of the search alone: 250.0 ms"
    assert text.count(said) == 2
    assert "(-12.5 %)" not in text
    assert "Next: do it" in text
    refused.values = {}
    assert "Next" not in printed(lambda console: optimise_report.print_optimum(wrong, console))
    # The limit whose slack is negative, and none that is just kept.
    assert "the model itself breaks: first rebound amplitude at least 2.000 um\n" in text
    assert "breaks" not in told(before=design(2.0))
    assert "breaks" not in told(before=None)


def test_the_search_for_an_optimum_in_words() -> None:
    """Feasible descents within a millionth of the best; points by engine, and those of none."""
    text = told(no_machine=("it jams", "too light"))
    assert "2 of 4 descents (seed 7) end there; 5,000 points in 1.5 s\n" in text
    assert (
        "of them 3,000 by the reduced engine, 900 by the direct engine, 80 by whole turns, 1,020 "
        "without a usable machine\n" in text
    )
    # A second of room is worth 0.5 s, so that a millisecond is worth 0.5 ms.
    limit = "time to rest at most 500.0 ms: one ms more of room is worth 0.5 ms\n"
    assert f"\nWhat holds it back\n{limit}" in text
    # And a N/m 0.25 s; the number is named by its path's words, not by its key in the study.
    bound = "stiffness of spring c at most 0.03 N/mm: one N/mm more of room is worth 2.5e+05 ms\n"
    assert f"\n{bound}" in text
    assert "stops.c <=" not in text
    assert "with room left: first rebound amplitude at least 2.000 um\n" in text
    assert "explains: 0\n" in text
    assert "some samples make no machine: it jams\n" in text
    assert "some samples make no machine: too light\n" in text
    assert "differential evolution" not in text
    check = SimpleNamespace(evaluations=1234)
    found = "differential evolution (1,234 points) found"
    assert f"{found} nothing better\n" in told(check=check, check_gain=9e-7)
    assert f"{found} a design better by 0.02 %\n" in told(check=check, check_gain=2e-4)
    text = told(check=check, check_gain=0.5)
    assert f"{found} a design better by 50 %\n" in text


def test_front_by_heading() -> None:
    """Aims and numbers in words, with their units."""
    text = told(front=(design(1.0), design(3.0)))
    assert columns(text, "", 2, "Pareto front") == {
        "time to rest [ms]": ["250", "750"], "first rebound amplitude [um]": ["3e+06", "9e+06"],
        "rate of spring a": ["7", "21"], "rate of spring b [N/mm]": ["0.09", "0.27"],
        "stops c": ["0.5", "1.5"],
    }  # fmt: skip
    text = told(front=(design(1.0),))
    words = "one design is the best by time to rest and by first rebound amplitude"
    assert f"\nNo conflict: {words}\n" in text
    assert "Pareto" not in text
    assert "Pareto" not in told()


# The console.


def test_text_is_printed_without_styles_of_its_own() -> None:
    """Numbers, paths and brackets of the user's are neither coloured nor taken for markup."""
    words = "[bold]a[/bold] 12 /a/path 'text' None True http://x.org :smile:"
    for write in (say, paste):
        text = printed(lambda console: write(console, words), colours=True)  # noqa: B023
        assert text == f"{words}\n"
    long = "word " * 200
    assert len(printed(lambda console: say(console, long)).splitlines()) > 1
    assert printed(lambda console: paste(console, long)) == f"{long}\n"
    assert printed(lambda console: say(console, "x", style="bold"), colours=True) == (
        f"{BOLD}x\x1b[0m\n"
    )
    heads, row = ("a [s]", "b[m]", ":smile:"), ("[red]x[/red]", "[/]", ":+1: 7")
    text = printed(lambda console: show_table(console, heads, [row]), colours=True)
    text = re.sub(r"\x1b\[[0-9;]*m", "", text)
    assert columns(text, "a", 1) == {head: [cell] for head, cell in zip(heads, row, strict=True)}
    # Text begins where its heading does, numbers end where theirs does.
    head, _, cells = text.splitlines()
    assert head.index("a [s]") == cells.index("[red]") == 0
    assert head.index("b[m]") + len("b[m]") == cells.rindex("[/]") + len("[/]")
    assert head.index(":smile:") + len(":smile:") == len(cells)


# Turns that are shown.


@pytest.mark.parametrize(
    ("window", "cycles", "before"),
    [
        (Window.CYCLE, 1, math.inf), (Window.CYCLE, 2, math.inf), (Window.CYCLE, 3, 0.5),
        (Window.TRANSITION, 1, math.inf), (Window.TRANSITION, 9, math.inf),
    ],
)  # fmt: skip
def test_turns_that_are_shown(window: Window, cycles: int, before: float) -> None:
    """The first two of many, of turns alone: two of 0.25 s here."""
    times = (0.1, 0.49, 0.51, 0.7)
    kinds = (EventKind.COLLISION, EventKind.REST, EventKind.REST, EventKind.COLLISION)
    run: Any = SimpleNamespace(
        case=SimpleNamespace(window=window, cycles=cycles), shaft=SimpleNamespace(period=0.25),
        segments=[SimpleNamespace(t_end=0.3), SimpleNamespace(t_end=0.75)],
        collisions=[SimpleNamespace(t=t) for t in times],
        phases=[SimpleNamespace(t_start=t, t_end=9.0) for t in times],
        transitions=[SimpleNamespace(t_start=t) for t in times],
        events=[SimpleNamespace(t=t, kind=kind) for t, kind in zip(times, kinds, strict=True)],
    )  # fmt: skip
    few = before < 1.0
    assert reading.shown_before(run) == before
    assert reading.shown_until(run) == (0.5 if few else 0.75)
    kept = list(times[:2] if few else times)
    assert [item.t for item in reading.shown_collisions(run)] == kept
    assert [item.t_start for item in reading.shown_phases(run)] == kept
    assert [item.t_start for item in reading.shown_transitions(run)] == kept
    rests = [item.t for item in reading.shown_events(run, EventKind.REST)]
    assert rests == ([0.49] if few else [0.49, 0.51])
    run.segments = []
    assert reading.shown_until(run) == 0.0


def test_transitions_are_shown_to_their_end(e62: Mechanism) -> None:
    """Though a case may name more turns than are shown."""
    run: Solution = simulate(e62, Case(speed_rpm=650.0, cycles=5))
    assert reading.shown_before(run) == math.inf
    assert reading.shown_collisions(run) == list(run.collisions)


# Bars of links without shapes.


def test_bars_reach_the_ends_of_springs_and_dampers() -> None:
    """Each frame of a link that something is fixed to has a bar to it; others have none."""
    parts = [
        link("arm", centre=(0.3, 0.1)), hinge("arm_pin", "frame", "arm"),
        frame("hook", "arm", (0.0, 0.5)), frame("unused", "arm", (0.7, 0.0)),
        frame("eye", "arm", (0.4, 0.0)), frame("wall", "frame", (0.6, 0.6)),
    ]  # fmt: skip
    made = machine(
        parts,
        1,
        springs={"coil": {"frame_a": "hook", "frame_b": "wall", "stiffness_N_per_m": 1e3,
                          "free_length_mm": 100.0}},
        dampers={"stay": {"frame_a": "wall", "frame_b": "eye", "damping_N_s_per_m": 2.0}},
    )  # fmt: skip
    assert {item.name for item in made.struts} == {"coil", "stay"}
    assert ends(made) == [[0.0, 0.5], [0.4, 0.0]]
    assert ends(machine(parts, 1)) == [[0.3, 0.1]]


def ends(mechanism: Mechanism) -> list[list[float]]:
    """Far ends of the bars of the only link, by middle and length (x, z) [m]."""
    bars = [solid for solid in solids(mechanism) if solid.kind == "cylinder"]
    found = []
    for solid in bars:
        half = 0.5 * solid.sizes[1] * solid.placement[:3, 2]
        np.testing.assert_allclose(solid.placement[:3, 3], half, atol=1e-12)
        found.append((2.0 * half)[[0, 2]].round(9).tolist())
    return sorted(found)


# Names of the user's.

ODD = "[red]a[/red] :smile: [/]"


def test_names_are_printed_as_they_are() -> None:
    """Of targets, numbers, joints, closures, models and what went wrong."""
    fit = identified(Verdict.AGREES, name=ODD)
    assert columns(printed(fit), "target", 2)["target"] == [ODD, "two"]
    mechanism: Any = SimpleNamespace(
        joints=[SimpleNamespace(index=k, name=f"{ODD}{k}", kind="revolute", parent=f"p{k}",
                                child=f"c{k}") for k in (0, 1)],
        closures=[
            SimpleNamespace(name="pin", frame_a="a", frame_b="b", slot_frame=None, slot_axis=None),
            SimpleNamespace(name=ODD, frame_a="a", frame_b="c", slot_frame="d", slot_axis="x"),
        ],
        drives=[SimpleNamespace(index=1, name="shaft")], springs=(), tabulated_springs=(),
        struts=(), dampers=(), forces=(), couplings=(),
    )  # fmt: skip
    report: Any = SimpleNamespace(
        mechanism=mechanism,
        masses=[SimpleNamespace(link="one", mass_kg=1.5), SimpleNamespace(link="two", mass_kg=2.0)],
    )
    text = printed(lambda console: checked._joints(report, console))
    assert columns(text, "joint", 4) == {
        "joint": [f"{ODD}0", f"{ODD}1", "pin", ODD],
        "kind": ["revolute", "revolute", "cut pin", "pin in a slot"],
        "parent": ["p0", "p1", "a", "d along x"], "child": ["c0", "c1", "b", "c"],
        "moved by": ["", "drive shaft", "", ""],
    }  # fmt: skip
    assert "masses in kg: one 1.5, two 2; together 3.5\n" in text
    assert "springs: none\n" in text
    assert "dampers" not in text
    wrong = Judged(7, "chains", "wrong", "energy", ODD, "00", 0.5)
    assert printed(lambda console: print_verdict(wrong, console)) == (
        f"case 7 (chains): wrong, energy: {ODD}\n"
    )
    right = Judged(8, "chains", "right", "COMPLETED", "", "00", 0.5)
    assert printed(lambda console: print_verdict(right, console)) == (
        "case 8 (chains): right, COMPLETED\n"
    )

"""Springs, dampers, slots and limits in words, as `check` and the tables of a run have them."""

from __future__ import annotations

import io

from rich.console import Console
from runs_shown import run_of, slotted, with_elements
from snapshots import Words

from nipper_pin import check
from nipper_pin.study.next_steps import NextSteps
from nipper_pin.view.run import print_solution
from nipper_pin.view.studies.check_report import print_report

NOTHING = NextSteps((), ())


def test_words_of_elements(words: Words) -> None:
    """One of each kind, with the units of people."""
    stream = io.StringIO()
    console = Console(file=stream, width=100)
    print_report(check(with_elements(), 600.0), NOTHING, console)
    print_solution(run_of("elements"), console)
    words(stream.getvalue())


def test_words_of_a_slot(words: Words) -> None:
    """Side, joint and place of every stop; the frame and the axis that a pin slides in."""
    stream = io.StringIO()
    print_report(check(slotted(), 60.0), NOTHING, Console(file=stream, width=100))
    words(stream.getvalue())

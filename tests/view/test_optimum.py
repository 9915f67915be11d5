"""An optimum as text and as a figure: what is drawn and said is what was found."""

from __future__ import annotations

import io
import json
import shlex
from dataclasses import replace

import numpy as np
import pytest
from drawn import drawn
from rich.console import Console
from snapshots import Words

from nipper_pin.cli import main
from nipper_pin.study.optimise import Limit, Optimum, optimise
from nipper_pin.study.optimise.search.samples import Found
from nipper_pin.view.studies.front_plot import front_figure
from nipper_pin.view.studies.optimise_report import print_optimum
from tests.study.optimise.designs import BALL, MASS, problem


@pytest.fixture(scope="module")
def optimum(tmp_path_factory: pytest.TempPathFactory) -> Optimum:
    """Of a ball, with a limit on its first rebound."""
    text = f'title = "A ball [bold]and[/bold] a table"{BALL}'
    text += "[limits]\nrebound_time_s_1 = { high = 0.005 }\n"
    asked = problem(tmp_path_factory.mktemp("optimum"), text)
    return optimise(asked, starts=2, points=4, check=False, workers=1)


def test_words_around_the_front(optimum: Optimum, words: Words) -> None:
    """As it was found; and with a long title and more limits, none of which a line breaks."""
    limits = [
        Limit(quantity="duration_s", side="high", value=0.25),
        *(Limit(quantity="clamping_force_N", side=side, value=value)
          for side, value in (("low", 70.0), ("high", 95.5))),
    ]  # fmt: skip
    units = {**optimum.problem.units, "clamping_force_N": "N"}
    problem = replace(optimum.problem, title="a title " * 20, limits=limits, units=units)
    long, none = (replace(optimum, problem=item) for item in (problem, replace(problem, limits=[])))
    words("\n".join(drawn(front_figure(found)) for found in (optimum, long, none)))


def test_figure_names_what_holds_each_design_back(optimum: Optimum) -> None:
    """The limit on the rebound time and the bounds of both numbers, by the formulas of a ball.

    Each is either met to a millionth, or has room: the front stops 1e-3 of its length short.
    """
    _, held, *_ = front_figure(optimum).axes
    room: dict[str, list[float]] = {}
    for item in optimum.front:
        e, lead = item.numbers.values()
        for words, share in (
            ("first rebound time at most 5 ms", 1.0 - ball(e, lead)["rebound_time_s_1"] / 0.005),
            ("restitution of stop table at least 0.05", (e - 0.05) / 0.25),
            ("restitution of stop table at most 0.3", (0.3 - e) / 0.25),
            ("lead of drive table at least 20 mm/turn", (lead - 20.0) / 80.0),
            ("lead of drive table at most 100 mm/turn", (100.0 - lead) / 80.0),
        ):
            room.setdefault(words, []).append(share)
    assert all(abs(share) < 1e-6 or share > 3e-4 for row in room.values() for share in row)
    across = 1e6 * np.array([item.values["rebound_amplitude_1"] for item in optimum.front])
    wanted = {
        words: across[np.abs(row) < 1e-6].tolist()
        for words, row in room.items() if min(map(abs, row)) < 1e-6
    }  # fmt: skip
    marks = {str(line.get_label()): list(line.get_xdata()) for line in held.lines}
    nothing = marks.pop("no limit", [])
    assert list(marks) == list(wanted)
    for words, places in wanted.items():
        assert marks[words] == pytest.approx(places, rel=1e-12)
    somewhere = {place for places in wanted.values() for place in places}
    assert nothing == [place for place in across if place not in somewhere]


# --- every number that is said, against the formulas of a bouncing ball ---------------------------


def ball(e: float, lead_mm: float) -> dict[str, float]:
    """Quantities of a ball on a table that rises by the lead in a second: u = e V.

    Rebound u^2 / 2 g after 2 u / g; rest after 2 u / (g (1 - e)).
    """
    u = e * 1e-3 * lead_mm
    return {
        "duration_s": 2.0 * u / (9.81 * (1.0 - e)),
        "rebound_amplitude_1": u**2 / (2.0 * 9.81),
        "rebound_time_s_1": 2.0 * u / 9.81,
    }


BEFORE, BEST = ball(0.5, 1500.0), ball(0.05, 20.0)


def test_values_of_the_document_are_those_of_the_formulas(optimum: Optimum) -> None:
    """Before, best, as its turn has it, and all along the front."""
    document = optimum.record()
    for place, values in (("before", BEFORE), ("optimum", BEST)):
        for name, value in values.items():
            assert document[place]["values"][name] == pytest.approx(value, rel=1e-8)
            # What is stated is more than what is true, and not much more.
            error = abs(document[place]["values"][name] - value)
            assert error <= document[place]["errors"][name] < 1e-6 * value
    told = [(document["control"], BEST)]
    for item in document["front"]:
        told += [(part, ball(*item["numbers"].values())) for part in (item, item["control"])]
    for part, values in told:
        for name, value in values.items():
            assert part["values"][name] == pytest.approx(value, rel=1e-8)
    assert document["optimum"]["slacks"] == [pytest.approx(0.005 - BEST["rebound_time_s_1"])]


def test_figure_is_in_the_units_of_its_labels(optimum: Optimum) -> None:
    """Heights in um over times in ms by the formulas; 3 m in mm would be no such curve."""
    above, *_, last = front_figure(optimum).axes
    assert above.get_ylabel().endswith("[ms]")
    assert last.get_xlabel() == "first rebound amplitude [um]"
    for (height, duration), item in zip(above.lines[0].get_xydata(), optimum.front, strict=True):
        values = ball(*item.numbers.values())
        assert height == pytest.approx(1e6 * values["rebound_amplitude_1"], rel=1e-8)
        assert duration == pytest.approx(1e3 * values["duration_s"], rel=1e-8)


def test_the_printed_command_can_be_pasted(
    optimum: Optimum, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line of a narrow terminal, as a shell reads it, simulates what is reported."""
    out = io.StringIO()
    print_optimum(optimum, Console(file=out, width=60))
    (line,) = (line for line in out.getvalue().splitlines() if line.startswith("Next: "))
    first, *words = shlex.split(line.removeprefix("Next: "))
    assert first == "nipper-pin"
    assert main([*words, "--json", "-"]) == 0
    document = json.loads(capsys.readouterr().out)
    first = document["collisions"][0]
    assert first["rebound_amplitude"] == pytest.approx(BEST["rebound_amplitude_1"], rel=1e-8)
    assert first["rebound_time_s"] == pytest.approx(BEST["rebound_time_s_1"], rel=1e-8)
    assert document["transition"]["duration_s"] == pytest.approx(BEST["duration_s"], rel=1e-8)


@pytest.mark.parametrize("width", [60, 80, 200])
def test_words_of_an_optimum(optimum: Optimum, width: int, words: Words) -> None:
    """As it was found; and one that its turn contradicts, of which little is known."""
    wrong = replace(
        optimum, before=None, front=optimum.front[:1], check_gain=2e-4, no_machine=("it jams",),
        check=Found(z=(0.5, 0.5), feasible=True, evaluations=1234, engines={"direct": 1234}),
        control=replace(optimum.control, why="no turn repeats the one before"),
    )  # fmt: skip
    out = io.StringIO()
    for found in (optimum, wrong):
        print_optimum(found, Console(file=out, width=width))
    words(out.getvalue().replace(str(MASS), "MODEL"))

"""The tables say what the solution holds, at every width."""

import dataclasses
import io
import math
import re
from collections import Counter
from types import SimpleNamespace
from typing import Any

import pytest
from rich.console import Console

from nipper_pin.hybrid.case import Case
from nipper_pin.hybrid.event import EventKind
from nipper_pin.hybrid.result.solution import Solution
from nipper_pin.hybrid.result.tables import Collision
from nipper_pin.hybrid.simulate import simulate
from nipper_pin.mechanism import load
from nipper_pin.view.run import table
from nipper_pin.view.run.table import print_solution

# Rates, impulses, amplitudes and durations are printed with four significant digits.
FOUR_DIGITS = 5.1e-4
# Times from the start and indices are printed with three decimals.
THREE_DECIMALS = 5.1e-4
# Rebounds below this part of the largest one of their stop are told in one line.
MICRO = 1e-3
MDEG_PER_RAD = 1e3 * 180.0 / math.pi


def text_of(solution: Solution, width: int = 80, *, forces: bool = False) -> str:
    stream = io.StringIO()
    print_solution(solution, Console(file=stream, width=width), with_forces=forces)
    return stream.getvalue()


def collision_rows(text: str) -> dict[int, list[float]]:
    """Rows of nine numbers, by the number of the collision."""
    rows = {}
    for line in text.splitlines():
        cells = line.split()
        if len(cells) == 9 and cells[0].isdigit():
            rows[int(cells[0])] = [math.nan if cell == "-" else float(cell) for cell in cells[1:]]
    return rows


def expected(solution: Solution, item: Collision) -> list[float]:
    """The same row, from the solution."""
    mechanism = solution.mechanism
    place = mechanism.stop(item.stop).index
    joint = next(joint for joint in mechanism.joints if joint.index == place)
    rate, amplitude = (1.0, MDEG_PER_RAD) if joint.kind == "revolute" else (1e3, 1e6)
    return [
        item.index,
        1e3 * item.t,
        rate * item.approach_rate,
        rate * item.separation_rate,
        item.impulse,
        1e3 * item.energy_lost,
        amplitude * item.rebound_amplitude,
        1e3 * item.rebound_time,
    ]


@pytest.mark.parametrize("width", [80, 120])
@pytest.mark.parametrize("name", ["transition", "cycle"])
def test_collision_rows_hold_the_numbers_of_the_solution(
    name: str, width: int, request: pytest.FixtureRequest
) -> None:
    solution: Solution = request.getfixturevalue(name)
    text = text_of(solution, width)
    rows = collision_rows(text)
    large, _ = parted(solution)
    assert sorted(rows) == sorted(item.number for item in large)
    for item in large:
        wanted, found = expected(solution, item), rows[item.number]
        assert found[:2] == pytest.approx(wanted[:2], abs=THREE_DECIMALS)
        assert found[2:] == pytest.approx(wanted[2:], rel=FOUR_DIGITS)


def parted(solution: Solution) -> tuple[list[Collision], dict[str, list[Collision]]]:
    """Collisions that have a row, and by stop those whose rebounds are too small for one."""
    large, small = [], {}
    for stop in solution.mechanism.stops:
        hits = [item for item in solution.collisions if item.stop == stop.name]
        most = max((item.rebound_amplitude for item in hits), default=0.0)
        small[stop.name] = [item for item in hits if item.rebound_amplitude < MICRO * most]
        large += [item for item in hits if item.rebound_amplitude >= MICRO * most]
    return large, small


@pytest.mark.parametrize("name", ["transition", "cycle"])
def test_small_rebounds_are_counted_and_their_limit_told(
    name: str, request: pytest.FixtureRequest
) -> None:
    """Below a thousandth of the largest of their stop; with the rows these are all collisions."""
    solution: Solution = request.getfixturevalue(name)
    text = text_of(solution, 120)
    large, small = parted(solution)
    blocks = {part.split()[0]: part for part in text.split("\nCollisions of stop ")[1:]}
    assert set(blocks) == {item.stop for item in solution.collisions}
    for stop, block in blocks.items():
        assert len(small[stop]) > 1
        told = re.findall(r"^(\d+) more rebounds below (\S+) (\S+) \(", block, flags=re.M)
        ((count, limit, unit),) = told
        assert int(count) == len(small[stop])
        amplitude = {"jaw": ("mdeg", MDEG_PER_RAD), "steeve": ("um", 1e6)}[stop]
        assert unit == amplitude[0]
        most = max(item.rebound_amplitude for item in large if item.stop == stop)
        assert float(limit) == pytest.approx(MICRO * amplitude[1] * most, rel=FOUR_DIGITS)


@pytest.mark.parametrize(
    ("parts", "line"),
    [
        ((1.0, MICRO), None),
        ((1.0, 0.999 * MICRO), "1 more rebound below 1000 mdeg "),
        ((1.0, 0.999 * MICRO, 0.0), "2 more rebounds below 1000 mdeg "),
        ((1.0, None), None),
        ((0.0, 0.0), None),
    ],
)
def test_which_rebounds_are_small(
    parts: tuple[float | None, ...], line: str | None, transition: Solution
) -> None:
    """What is at the limit has a row, as has a rebound that the window ends and one of nothing."""
    largest = 1e6 / MDEG_PER_RAD
    names = ("number", "index", "t", "approach_rate", "separation_rate", "impulse", "energy_lost",
             "rebound_time", "stop")  # fmt: skip
    hits: list[Any] = [
        SimpleNamespace(**{name: getattr(item, name) for name in names},
                        rebound_amplitude=None if part is None else part * largest)
        for part, item in zip(parts, transition.collisions, strict=False)
    ]  # fmt: skip
    stream = io.StringIO()
    table._of_stop(transition, "jaw", hits, Console(file=stream, width=120))
    text = stream.getvalue()
    rows = 1 if line else 2
    assert len(collision_rows(text)) == rows
    assert re.findall(r"^\d+ more.*(?=\()", text, re.M) == ([line] if line else [])


def test_every_stop_has_its_own_table_in_its_own_units(cycle: Solution) -> None:
    blocks = re.split(r"\nCollisions of stop ", text_of(cycle))[1:]
    units = {block.split()[0]: block for block in blocks}
    assert set(units) == {"jaw", "steeve"}
    assert "rad/s" in units["jaw"]
    assert " mdeg " in units["jaw"]
    steeve = units["steeve"].split("Phases")[0] if "Phases" in units["steeve"] else units["steeve"]
    assert "mm/s" in steeve
    assert " um " in steeve


@pytest.mark.parametrize("name", ["transition", "cycle", "many_turns"])
def test_eighty_columns_are_enough(name: str, request: pytest.FixtureRequest) -> None:
    text = text_of(request.getfixturevalue(name), forces=True)
    assert max(len(line) for line in text.splitlines()) <= 80


@pytest.mark.parametrize("width", [60, 80, 120])
def test_nothing_is_cut_short_and_nothing_is_coloured(cycle: Solution, width: int) -> None:
    text = text_of(cycle, width, forces=True)
    assert "\N{HORIZONTAL ELLIPSIS}" not in text
    assert "..." not in text
    assert "\x1b" not in text


def test_a_narrow_terminal_shows_every_cell_whole(cycle: Solution) -> None:
    """Tables that are too wide become several, each with the numbers of its rows."""

    def cells(text: str) -> Counter[str]:
        block = text[text.index("\nCollisions of stop") : text.index("\nReleases")]
        return Counter(word for word in block.split() if re.search(r"\d", word))

    narrow, wide = cells(text_of(cycle, 40)), cells(text_of(cycle, 120))
    assert not wide - narrow
    # Nothing is added but the numbers of the rows.
    assert set(narrow) == set(wide)


def test_header_names_the_case(cycle: Solution) -> None:
    text = text_of(cycle)
    assert text.startswith(cycle.mechanism.title)
    assert "650 r/min, window cycle (1 turn from index 24), held drive" in text
    assert "jaw 0.2" in text
    spring = cycle.mechanism.springs[0]
    assert f"{spring.stiffness / 1e3:g} N/mm" in text
    assert f"{spring.preload * 1e3:g} mm" in text


def test_phase_rows_hold_the_intervals_of_the_solution(cycle: Solution) -> None:
    block = text_of(cycle).split("\nPhases")[1].split("\n\n")[0]
    rows = [line.split() for line in block.splitlines() if re.search(r"\d\.\d{3}$", line)]
    # The steeve is thrown open once before the jaw closes and once after it has opened.
    numbers = [1, None, 1, 3, 2, None, 1]
    assert [int(row[0]) if row[0].isdigit() else None for row in rows] == numbers
    assert [" ".join(row[:4]) for row in rows if row[0] == "jaw"] == 2 * [
        "jaw open, steeve bounces"
    ]
    for row, item in zip(rows, cycle.phases, strict=True):
        wanted = (1e3 * item.t_start, 1e3 * (item.t_end - item.t_start))
        assert [float(cell) for cell in row[-2:]] == pytest.approx(wanted, abs=THREE_DECIMALS)


def test_transition_line_agrees_and_says_that_the_series_has_a_limit(transition: Solution) -> None:
    found = transition.transitions[0]
    text = " ".join(text_of(transition).split())
    match = re.search(r"([\d.]+) ms from the first collision to rest, (\d+) collisions", text)
    assert match is not None
    assert float(match[1]) == pytest.approx(1e3 * found.duration, rel=FOUR_DIGITS)
    assert int(match[2]) == found.collisions
    share = re.search(r"rebounds take ([\d.]+) %", text)
    assert share is not None
    assert float(share[1]) == pytest.approx(100.0 * found.first_two_share, rel=FOUR_DIGITS)
    assert "the time of rest is their limit" in text


def test_a_threshold_is_named() -> None:
    solution = simulate(load("e62"), Case(speed_rpm=650.0, rest_rate=0.02))
    assert "the first rebound slower than 0.02000 rad/s" in text_of(solution, 120)


def test_a_release_in_the_first_phase_gets_a_line(cycle: Solution) -> None:
    released = next(event for event in cycle.events if event.kind is EventKind.RELEASE)
    psi = float(cycle.shaft.angle(released.t))
    index = cycle.mechanism.cylinder.index_from_angle(psi)
    text = " ".join(text_of(cycle).split())
    assert f"The steeve leaves its stop in phase 1 at index {index:.3f}, opens by up to" in text
    assert "before the jaw collides" in text


def test_no_release_no_line() -> None:
    solution = simulate(load("e62"), Case(speed_rpm=450.0, window="cycle"))
    assert "Releases" not in text_of(solution)


def test_forces_are_printed_if_asked_and_lie_in_their_range(cycle: Solution) -> None:
    assert "clamping force" not in text_of(cycle)
    block = text_of(cycle, forces=True).split("\nForces of closed stops")[1]
    row = next(line for line in block.splitlines() if "clamping force [N]" in line).split()
    lowest, highest = float(row[-4]), float(row[-2])
    closed = next(item for item in cycle.phases if item.number == 2)
    middle = 0.5 * (closed.t_start + closed.t_end)
    force = float(cycle.trajectory.reactions(middle).contacts["jaw"][0])
    assert 0.0 < lowest < force < highest
    # The stop force of the open jaw falls to zero where the steeve leaves its stop.
    stop_row = next(line for line in block.splitlines() if "stop force [N]" in line).split()
    assert float(stop_row[-4]) == pytest.approx(0.0, abs=5.1e-3)


def test_of_many_turns_two_are_printed_and_the_rest_is_counted(many_turns: Solution) -> None:
    text = text_of(many_turns)
    per_turn = len(many_turns.collisions) // 20
    told = [int(count) for count in re.findall(r"(\d+) more rebounds below", text)]
    assert len(told) == 2
    assert len(collision_rows(text)) + sum(told) == 2 * per_turn
    assert f"{18 * per_turn} more collisions are not shown." in text
    assert many_turns.repeated_from is not None
    first = many_turns.repeated_from
    assert f"Turns {first + 1} to 20 are equal to turn {first}" in text


def test_what_a_transition_came_to_stands_before_its_tables(transition: Solution) -> None:
    """Duration and the first two rebounds, in mdeg and ms, before the first table."""
    head = " ".join(text_of(transition).split("\nCollisions of stop")[0].split())
    assert head.index(" Transition ") < head.index("from the first collision to rest")
    match = re.search(
        r"First rebound (\S+) mdeg in (\S+) ms; second rebound (\S+) mdeg in (\S+) ms\.", head
    )
    assert match is not None
    first, second = transition.collisions[:2]
    wanted = [
        value
        for item in (first, second)
        for value in (MDEG_PER_RAD * item.rebound_amplitude, 1e3 * item.rebound_time)
    ]
    assert [float(part) for part in match.groups()] == pytest.approx(wanted, rel=FOUR_DIGITS)
    assert "Times t count from the start of the run at index 34.049." in head


def test_the_next_command_is_the_last_line(transition: Solution) -> None:
    """Ready to be pasted however long it is; without one the outcome is the last line."""
    command = "nipper-pin view e62 --set '[bold]=1' " + "--set a.b=1 " * 20 + "--html e62.html"
    stream = io.StringIO()
    print_solution(transition, Console(file=stream, width=60), following=command)
    assert stream.getvalue().splitlines()[-1] == f"Next: {command}"
    assert text_of(transition).splitlines()[-1] == transition.outcome.value


def test_checks_work_and_outcome_close_the_text(cycle: Solution) -> None:
    text = text_of(cycle, 120)
    assert f"closure {cycle.checks.closure_m:.1e} m" in text
    assert f"{cycle.evaluations} evaluations" in text
    assert text.rstrip().endswith(cycle.outcome.value)


def test_square_brackets_in_names_are_no_markup(transition: Solution) -> None:
    titled = dataclasses.replace(transition.mechanism, title="[bold]nipper[/bold] [A]")
    text = text_of(dataclasses.replace(transition, mechanism=titled))
    assert text.startswith("[bold]nipper[/bold] [A]")


def test_a_run_that_ends_in_mid_rebound_says_so() -> None:
    mechanism = load("e62", {"stops.jaw.restitution": 0.9})
    text = text_of(simulate(mechanism, Case(speed_rpm=650.0)))
    assert "-: the window ends before the rebound does." in text
    assert "No transition of the jaw was completed." in text

"""What stands around the curves of a run: titles, legends, limits, numbers and labels."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from judge import press
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from nipper_pin import Case, Solution, Window, simulate
from nipper_pin.view.run.bounces import impulse_figure, transition_figure
from nipper_pin.view.run.timelines import force_figure, motion_figure, phase_figure

CASES = {
    "e62": "650 r/min, window cycle (1 turn from index 24), held drive",
    "press": "60 r/min, window cycle (1 turn from index 0), held drive",
    "start": "650 r/min, window transition, held drive",
    "turns": "650 r/min, window cycle (20 turns from index 24), held drive",
}


@pytest.fixture(scope="module", params=CASES)
def named(request: pytest.FixtureRequest, cycle: Solution, transition: Solution,
          many_turns: Solution) -> tuple[str, Solution]:  # fmt: skip
    """A turn of two machines, a part of a turn, and twenty turns, of which two are shown."""
    if request.param == "press":
        case = Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0)
        return "press", simulate(press(), case)
    runs = {"e62": cycle, "start": transition, "turns": many_turns}
    return request.param, runs[request.param]


def until(run: Solution) -> float:
    """End of what is shown: two turns at most [s]."""
    return min(run.segments[-1].t_end, 2.0 * 60.0 / run.case.speed_rpm)


def last(run: Solution) -> float:
    """Time before which events are shown: two turns of more, else all of them [s]."""
    return 2.0 * 60.0 / run.case.speed_rpm if run.case.cycles > 2 else math.inf


@dataclass(frozen=True)
class Shown:
    """A phase: closed stops, begin and end of what is shown [s], number and words."""

    closed: frozenset[str]
    begin: float
    end: float
    number: str
    words: str


def phases(run: Solution) -> list[Shown]:
    """All phases; without closed stops one is the transition only if its stop is struck in it."""
    end, main = until(run), run.mechanism.transition_stop
    table: Any = run.mechanism.description["phases"]
    known = {frozenset(item["closed"]): item for item in table}
    found = []
    for item in run.phases:
        if item.t_start >= end:
            continue
        struck = {hit.stop for hit in run.collisions if item.t_start <= hit.t < item.t_end}
        if not item.closed and main not in struck:
            # All runs of this file have one other stop, which lands again.
            (other,) = struck
            number, words = "", f"{main} open, {other} bounces"
        else:
            number = str(known[item.closed]["number"])
            words = f"phase {number} {known[item.closed]['name']}"
        found.append(Shown(item.closed, item.t_start, min(item.t_end, end), number, words))
    return found


def names(run: Solution) -> list[str]:
    """Words of all phases that are shown: by the model's order, then the others."""
    table: Any = run.mechanism.description["phases"]
    order = [f"phase {item['number']} {item['name']}" for item in table]
    seen = {item.words for item in phases(run)}
    return [words for words in order if words in seen] + sorted(seen - set(order))


def legend(figure: Figure) -> dict[str, Any]:
    """Entries with words, row by row from the left."""
    (found,) = figure.legends
    texts = [text.get_text() for text in found.get_texts()]
    columns = found._ncols
    rows = len(texts) // columns
    assert rows * columns == len(texts)
    order = [column * rows + row for row in range(rows) for column in range(columns)]
    return {texts[k]: found.legend_handles[k] for k in order if texts[k].strip()}


def test_titles(named: tuple[str, Solution]) -> None:
    """What is shown, the model's own title, the case, restitutions and springs; none too long."""
    name, run = named
    for draw, subject in (
        (motion_figure, "Motion at the stops"),
        (force_figure, "Forces of closed stops (normal, between collisions)"),
        (phase_figure, "Phases over the index"),
        (impulse_figure, "Impulses of the collisions"),
    ):
        lines = draw(run).get_suptitle().splitlines()
        assert lines[0] == subject
        assert max(len(line) for line in lines) <= 92
        text = " ".join(lines[1:])
        values = ", ".join(f"{s.name} {s.restitution:g}" for s in run.mechanism.stops)
        assert text.startswith(f"{run.mechanism.title} {CASES[name]} restitution: {values}; spr")
    if run.transitions:
        title = transition_figure(run, run.transitions[0]).get_suptitle()
        stop = run.mechanism.transition_stop
        assert title.startswith(f"Transition: rebounds of the {stop}\n")


def bands(axes: Axes) -> list[tuple[float, float, str]]:
    """Shaded stretches along the time: begin, end and colour."""
    found = []
    for patch in axes.patches:
        begin = patch.get_x()
        found.append((begin, begin + patch.get_width(), to_hex(patch.get_facecolor())))
    return found


def test_panels_along_the_time(named: tuple[str, Solution]) -> None:
    """All of the time shown; curves fill the height and are not cut; phases with their numbers."""
    _, run = named
    end = 1e3 * until(run)
    for draw in (motion_figure, force_figure):
        figure = draw(run)
        # The rebounds of a cycle have a panel of their own, with a time of their own.
        panels = [item for item in figure.axes if "enlarged" not in item.get_title()]
        for axes in panels:
            assert axes.get_xlim() == pytest.approx((0.0, end), rel=1e-12)
            y = np.concatenate([np.asarray(line.get_ydata(), dtype=float) for line in axes.lines])
            low, high = axes.get_ylim()
            if np.isfinite(y).any():
                # A force that begins or ends at zero may be below it by round-off.
                assert low <= min(0.0, np.nanmin(y)) + 1e-12 * np.nanmax(np.abs(y))
                assert high > np.nanmax(y)
                assert np.nanmax(y) - min(0.0, np.nanmin(y)) > 0.7 * (high - low)
            else:
                assert (low, high) == (0.0, 1.0)
            if draw is force_figure:
                assert low == 0.0
            numbers = [
                (0.5e3 * (item.begin + item.end), item.number)
                for item in phases(run)
                if item.number and 1e3 * (item.end - item.begin) > 0.025 * end
            ]
            found = [(text.get_position()[0], text.get_text()) for text in axes.texts]
            assert [word for _, word in found] == [word for _, word in numbers]
            np.testing.assert_allclose([x for x, _ in found], [x for x, _ in numbers], rtol=1e-9)
            # In the upper part of the panel, whatever its values are.
            for text in axes.texts:
                at = text.get_transform().transform(text.get_position())
                assert 0.9 < axes.transAxes.inverted().transform(at)[1] < 1.0
        below = [axes.xaxis.get_tick_params()["labelbottom"] for axes in panels]
        assert below == [False] * (len(below) - 1) + [True]
        first = panels[0]
        assert all(first.get_shared_x_axes().joined(first, axes) for axes in panels)


def test_entries_of_the_legends(named: tuple[str, Solution]) -> None:
    """Every phase shown by its colour, in the model's order, and every kind of event there is."""
    _, run = named
    wanted = names(run)
    kinds = [
        kind for kind in ("collision", "rest", "release")
        if any(item.kind.value == kind and item.t < last(run) for item in run.events)
    ]  # fmt: skip
    motion, force = motion_figure(run), force_figure(run)
    assert list(legend(motion)) == wanted + kinds
    assert list(legend(force)) == wanted
    whole = until(run) * run.case.speed_rpm / 60.0
    partial = abs(whole - round(whole)) > 1e-6
    found = legend(phase_figure(run))
    assert list(found) == [*wanted, "stop closed", *(["not simulated"] if partial else [])]
    for figure in (motion, force):
        drawn = bands(figure.axes[0])
        for item, (*_, colour) in zip(phases(run), drawn, strict=True):
            assert to_hex(legend(figure)[item.words].get_facecolor()) == colour
        assert len({colour for *_, colour in drawn}) == len(wanted)
    for kind in kinds:
        handle = legend(motion)[kind]
        lines = [line for axes in motion.axes for line in axes.lines[1:]]
        same = [line for line in lines if line.get_marker() == handle.get_marker()]
        events = [item for item in run.events if item.kind.value == kind]
        shown = [item for item in events if item.t < last(run)]
        assert sum(len(line.get_xdata()) for line in same) >= len(shown)
        assert {line.get_markerfacecolor() for line in same} == {handle.get_markerfacecolor()}
    if partial:
        assert found["not simulated"].get_hatch()
        assert (
            found["not simulated"].get_hatch() == phase_figure(run).axes[0].patches[0].get_hatch()
        )


def test_turns_over_the_index(named: tuple[str, Solution]) -> None:
    """Rows of each turn; bars of phases and of closed stops in it; numbers, indices and limits."""
    _, run = named
    axes = phase_figure(run).axes[0]
    period = 60.0 / run.case.speed_rpm
    turns = math.ceil(until(run) / period - 1e-6)
    rows = ["phase", *(f"{stop.name} closed" for stop in run.mechanism.stops)]
    labels = [text.get_text() for text in axes.get_yticklabels()]
    first = ["phase"] if turns == 1 else [f"turn {turn + 1}: phase" for turn in range(turns)]
    assert labels == [word for turn in range(turns) for word in (first[turn], *rows[1:])]
    places = [float(tick) for tick in axes.get_yticks()]
    # From top to bottom, and turns further apart than rows.
    steps = [one - other for one, other in pairwise(places)]
    assert min(steps) > 0.0
    assert all(steps[len(rows) * k - 1] > 1.5 * min(steps) for k in range(1, turns))
    low, high = axes.get_ylim()
    assert low < min(places) - 0.4
    assert high > max(places) + 1.0
    assert axes.get_xlim() == (0.0, 40.0)
    assert list(axes.get_xticks()) == list(range(0, 41, 2))
    cylinder = run.mechanism.cylinder
    start = cylinder.index_from_angle(float(run.shaft.angle(0.0)))
    for turn in range(turns):
        begin, end = turn * period, min((turn + 1) * period, until(run))
        parts = [
            (item, max(item.begin, begin), min(item.end, end)) for item in phases(run)
            if min(item.end, end) > max(item.begin, begin)
        ]  # fmt: skip
        for row, stop in enumerate([None, *run.mechanism.stops]):
            at = places[turn * len(rows) + row]
            wanted = []
            for item, a, b in parts:
                if stop is None or stop.name in item.closed:
                    left = (start + 40.0 * a / period) % 40.0
                    width = 40.0 * (b - a) / period
                    wanted += [(left, left + width), (left - 40.0, left - 40.0 + width)]
            bars = [
                patch for patch in axes.patches
                if abs(patch.get_y() + 0.5 * patch.get_height() - at) < 1e-9
                and not patch.get_hatch()
            ]  # fmt: skip
            found = seen((bar.get_x(), bar.get_x() + bar.get_width()) for bar in bars)
            np.testing.assert_allclose(found, seen(wanted), atol=1e-7)
            # A bar fills its row and no other.
            assert all(0.3 < bar.get_height() < 0.95 for bar in bars)
        hatched = [patch for patch in axes.patches if patch.get_hatch()]
        assert bool(hatched) == (end - begin < period * (1.0 - 1e-6))
        assert all((bar.get_x(), bar.get_width()) == (0.0, 40.0) for bar in hatched)
    check_words(axes, places[:: len(rows)], legend(phase_figure(run)))
    assert {text.get_text() for text in axes.texts if "." not in text.get_text()} <= {
        item.number for item in phases(run) if item.number
    }


def seen(stretches: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """What of some stretches lies on the scale."""
    inside = ((max(left, 0.0), min(right, 40.0)) for left, right in stretches)
    return sorted((left, right) for left, right in inside if right - left > 1e-6)


def check_words(axes: Axes, tops: list[float], entries: dict[str, Any]) -> None:
    """The number in every phase wide enough for it; indices apart from one another, above them."""
    colours = {to_hex(item.get_facecolor()): words for words, item in entries.items()}
    for top in tops:
        wide: dict[float, str] = {}
        for bar in axes.patches:
            if abs(bar.get_y() + 0.5 * bar.get_height() - top) < 1e-9 and not bar.get_hatch():
                left = max(bar.get_x(), 0.0)
                right = min(bar.get_x() + bar.get_width(), 40.0)
                words = colours[to_hex(bar.get_facecolor())].split()
                if right - left > 0.55 and words[0] == "phase":
                    wide[0.5 * (left + right)] = words[1]
        numbers = {
            text.get_position()[0]: text.get_text()
            for text in axes.texts if text.get_position()[1] == top
        }  # fmt: skip
        np.testing.assert_allclose(sorted(numbers), sorted(wide), atol=1e-9)
        assert [numbers[at] for at in sorted(numbers)] == [wide[at] for at in sorted(wide)]
        indices = [text for text in axes.texts if 0.3 < text.get_position()[1] - top < 0.7]
        places = [float(text.get_text()) for text in indices]
        assert all(abs(a - b) > 0.59 for k, a in enumerate(places) for b in places[:k])
        for bar in axes.patches:
            if abs(bar.get_y() + 0.5 * bar.get_height() - top) < 1e-9 and not bar.get_hatch():
                edge = bar.get_x() % 40.0
                gap = min(min(abs(edge - x), 40.0 - abs(edge - x)) for x in places)
                assert gap < 0.61


def test_curves_are_dense(named: tuple[str, Solution]) -> None:
    """At least 49 places in each stretch between events and 720 in a turn, closest at its ends."""
    _, run = named
    x = np.asarray(motion_figure(run).axes[0].lines[0].get_xdata())
    turn = 60e3 / run.case.speed_rpm
    assert np.diff(x).max() < 1.6 * turn / 720.0
    for segment in run.segments:
        begin, end = 1e3 * segment.t_start, 1e3 * min(segment.t_end, until(run))
        inside = x[(x >= begin - 1e-12) & (x <= end + 1e-12)]
        if end - begin > 1e-9:
            assert len(inside) >= 49
            assert len(inside) < 60 + 721 * (end - begin) / turn
            assert inside[2] - inside[1] < 0.2 * np.diff(inside).max()


def test_bounces(transition: Solution) -> None:
    """Both panels: scales, marks and words; feet of bounces are cut below 0.4 % of their height."""
    linear, log = transition_figure(transition, transition.transitions[0]).axes
    assert linear.get_xscale() == linear.get_yscale() == "linear"
    assert log.get_xscale() == log.get_yscale() == "log"
    # Time goes on to the right, as in the other panel.
    assert log.get_xlim()[0] > log.get_xlim()[1]
    assert linear.get_xlim()[0] < linear.get_xlim()[1]
    _, curve, struck, rest = linear.lines
    words = [text.get_text() for text in linear.get_legend().get_texts()]
    assert words == [struck.get_label(), rest.get_label()] == ["collision", "rest"]
    assert struck.get_marker() != rest.get_marker()
    assert rest.get_ydata()[0] == 0.0
    assert curve.get_color() == log.lines[0].get_color()
    gap, shown = np.asarray(curve.get_ydata()), np.asarray(log.lines[0].get_ydata())
    t = np.asarray(curve.get_xdata())
    hits = np.asarray(struck.get_xdata())
    assert len(hits) > 3
    for begin, end in pairwise(hits):
        inside = (t > begin) & (t < end)
        if inside.sum() > 4:
            cut = np.isnan(shown[inside])
            np.testing.assert_array_equal(cut, gap[inside] < 4e-3 * gap[inside].max())
            np.testing.assert_array_equal(shown[inside][~cut], gap[inside][~cut])
    for text, line in zip(log.texts, log.lines[1:], strict=True):
        assert text.xy[0] == line.get_xdata()[0]


def test_impulses(named: tuple[str, Solution]) -> None:
    """On a logarithmic axis that holds them all, one colour and one mark a stop, whole numbers."""
    _, run = named
    figure = impulse_figure(run)
    (axes,) = figure.axes
    shown = [item for item in run.collisions if item.impulse > 0.0
             and item.t < 2.0 * 60.0 / run.case.speed_rpm]  # fmt: skip
    sizes = [item.impulse for item in shown]
    low, high = axes.get_ylim()
    assert axes.get_yscale() == "log"
    assert 0.02 * min(sizes) < low < 0.5 * min(sizes)
    assert 2.0 * max(sizes) < high < 5.0 * max(sizes)
    first, last = axes.get_xlim()
    assert shown[0].number - 1.0 < first < shown[0].number
    assert shown[-1].number < last < shown[-1].number + 1.0
    assert axes.get_xlabel() == "number of the collision"
    assert all(tick == round(tick) for tick in axes.get_xticks())
    lines = axes.lines
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        line.get_label() for line in lines
    ]
    assert {line.get_label() for line in lines} == {f"stop {item.stop}" for item in shown}
    for name in ("get_color", "get_marker"):
        assert len({getattr(line, name)() for line in lines}) == len(lines)
    assert sum(len(line.get_xdata()) for line in lines) == len(shown)
    motion = {axes.get_ylabel().split()[0]: axes.lines[0].get_color()
              for axes in motion_figure(run).axes
              if "enlarged" not in axes.get_title()}  # fmt: skip
    for line, bar in zip(lines, axes.collections, strict=True):
        assert line.get_color() == motion[line.get_label().split()[1]]
        assert to_hex(bar.get_color()[0]) == to_hex(line.get_color())

"""Every line, mark, band and bar of the figures, every reading and arrow of the viewers.

As in ``test_every_column.py`` the values come from :mod:`judge`, which reads the run in another
way. What a label says decides the unit: a value in another one fails.
"""

from __future__ import annotations

import itertools
import math
import re
from typing import Any

import numpy as np
import pytest
from judge import Judge, press
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from nipper_pin import Case, Solution, Window, load, simulate
from nipper_pin.hybrid.event import Event
from nipper_pin.view.live.answer import answer
from nipper_pin.view.live.moment import closed_at, impulses_at, moment_text
from nipper_pin.view.live.settings import knobs
from nipper_pin.view.run.bounces import impulse_figure, transition_figure
from nipper_pin.view.run.timelines import force_figure, motion_figure, phase_figure
from nipper_pin.view.scene import Look, film
from nipper_pin.view.scene.arrows import (
    FADE,
    HELD,
    arrow_body,
    arrow_place,
    arrow_scale,
    arrow_stops,
)
from nipper_pin.view.scene.film import Film
from nipper_pin.view.scene.readings import readings
from nipper_pin.view.scene.tracks import animation

# States between nodes are interpolated here and closed again by the package.
DENSE = 1e-7
FACTOR = {"deg": 180.0 / math.pi, "mdeg": 180e3 / math.pi, "mm": 1e3, "ms": 1e3, "um": 1e6, "": 1.0,
          "N": 1.0, "N m": 1.0}  # fmt: skip


@pytest.fixture(scope="module", params=["e62", "press"])
def run(request: pytest.FixtureRequest) -> Solution:
    """A turn of a machine with a contact point, and of one with a stop at a hinge."""
    if request.param == "e62":
        return simulate(load("e62"), Case(speed_rpm=650.0, window=Window.CYCLE))
    return simulate(press(), Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0))


@pytest.fixture(scope="module")
def judge(run: Solution) -> Judge:
    """Reads it in another way."""
    return Judge(run)


@pytest.fixture(scope="module")
def shown(run: Solution) -> Film:
    """The film of the viewer."""
    return film(run, Look())


def unit_of(label: str) -> str:
    return label.rpartition("[")[2].rstrip("]")


def moment(judge: Judge, name: str) -> bool:
    return judge.stops[name].turns and judge.stops[name].lever is None


def some(values: Any, count: int = 40) -> list[int]:
    """Places spread over a line, its first and last among them."""
    return sorted({int(i) for i in np.linspace(0, len(values) - 1, count)})


def close(found: Any, wanted: Any, rel: float = DENSE) -> None:
    """Both agree to ``rel`` of the largest."""
    wanted = np.asarray(wanted, dtype=float)
    size = float(np.abs(wanted[np.isfinite(wanted)]).max(initial=1e-300))
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=rel * size)


def gaps(judge: Judge, name: str, t: Any) -> list[float]:
    """Gap of a stop at times of the run; positions have no jumps."""
    end = judge.run.segments[-1].t_end
    return [judge.gap(name, judge.state(min(float(x), end), left=True)[0]) if x > 0.0
            else judge.gap(name, judge.state(0.0, left=False)[0]) for x in t]  # fmt: skip


def of_stop(judge: Judge, name: str, kind: str) -> list[Event]:
    return [item for item in judge.run.events if item.kind.value == kind and name in item.stops]


def spans(axes: Axes) -> list[tuple[float, float, str]]:
    """Shaded phases: begin, end, colour."""
    found = []
    for patch in axes.patches:
        x = patch.get_path().vertices[:, 0] if not hasattr(patch, "get_width") else np.array(
            [patch.get_x(), patch.get_x() + patch.get_width()]
        )  # fmt: skip
        found.append((float(x.min()), float(x.max()), to_hex(patch.get_facecolor())))
    return found


def assert_phases_in_time(judge: Judge, figure: Figure, panels: list[Axes]) -> None:
    """Shading of every panel, one colour a phase, and the index above.

    Where the transition stop is open and another one bounces is no phase: it has a colour of its
    own, which stands in the legend by these words, and no number.
    """
    names = {frozenset(item["closed"]): item["number"] for item in judge.document["phases"]}
    kinds = [closed if judge.bounces(closed, a, b) else None for closed, a, b in judge.phases]
    entries = figure.legends[0]
    legend = {
        text.get_text(): to_hex(handle.get_facecolor())
        for text, handle in zip(entries.get_texts(), entries.legend_handles, strict=True)
        if isinstance(handle, Patch)
    }
    for axes in panels:
        bands = spans(axes)
        close([band[:2] for band in bands], [(1e3 * a, 1e3 * b) for _, a, b in judge.phases], 1e-12)
        colours = {kind: band[2] for kind, band in zip(kinds, bands, strict=True)}
        assert len(set(colours.values())) == len(colours)
        assert [band[2] for band in bands] == [colours[kind] for kind in kinds]
        for kind, colour in colours.items():
            (words,) = (words for words, own in legend.items() if own == colour)
            open_jaw = f"{judge.document['transition_stop']} open, "
            assert words.startswith(open_jaw if kind is None else f"phase {names[kind]} ")
        for text in axes.texts:
            t = 1e-3 * text.get_position()[0]
            place = next(k for k, (_, a, b) in enumerate(judge.phases) if a <= t <= b)
            assert text.get_text() == str(names[kinds[place]])
    top = panels[0].child_axes[0]
    assert top.get_xlabel().startswith("index")
    figure.canvas.draw()
    first, last = top.get_xlim()
    assert first == pytest.approx(judge.index(0.0), abs=1e-6)
    whole = 40.0 * judge.run.segments[-1].t_end / (60.0 / judge.run.case.speed_rpm)
    assert last - first == pytest.approx(whole, rel=1e-9)
    # Indices begin again after a turn.
    for tick, label in zip(top.get_xticks(), top.get_xticklabels(), strict=True):
        assert float(label.get_text()) == pytest.approx(tick % 40.0)
    assert max(top.get_xticks()) >= 40.0
    assert panels[-1].get_xlabel() == "time from the start of the run [ms]"


def test_motion(judge: Judge, run: Solution) -> None:
    """The gap of every stop against time in the unit of the label, its events, and rebounds."""
    figure = motion_figure(run)
    *panels, enlarged = figure.axes
    for axes, name in zip(panels, judge.stops, strict=True):
        label = axes.get_ylabel()
        assert label.startswith(f"{name} ")
        x, y = (np.asarray(values) for values in axes.lines[0].get_data())
        assert (x[0], x[-1]) == pytest.approx((0.0, 1e3 * run.segments[-1].t_end), rel=1e-12)
        places = some(x)
        factor = FACTOR["deg" if judge.stops[name].turns else "mm"]
        assert unit_of(label) == ("deg" if judge.stops[name].turns else "mm")
        close(y[places], factor * np.array(gaps(judge, name, 1e-3 * x[places])))
        marks = {line.get_marker(): line for line in axes.lines[1:]}
        shapes = {"|": "collision", "s": "rest", "o": "release"}
        for shape, kind in shapes.items():
            times = [1e3 * min(e.t, run.segments[-1].t_end) for e in of_stop(judge, name, kind)]
            assert (shape in marks) == bool(times)
            if times:
                close(marks[shape].get_xdata(), times, 1e-12)
                assert not np.any(marks[shape].get_ydata())
    assert_phases_in_time(judge, figure, panels)
    assert_rebounds(judge, enlarged)
    assert enlarged.get_title() == f"rebounds of the {judge.document['transition_stop']}, enlarged"


def test_forces(judge: Judge, run: Solution) -> None:
    """The force of every closed stop, with its sign, unit and breaks."""
    figure = force_figure(run)
    for axes, name in zip(figure.axes, judge.stops, strict=True):
        label = axes.get_ylabel()
        assert label.startswith(f"{name}:")
        assert unit_of(label) == ("N m" if moment(judge, name) else "N")
        x, y = (np.asarray(values) for values in axes.lines[0].get_data())
        closed = [s for s in run.segments if name in s.closed and s.t_end > s.t_start]
        assert int(np.isnan(y).sum()) == len(closed)
        breaks = np.flatnonzero(np.isnan(y))
        for segment, begin, end in zip(closed, [0, *(breaks[:-1] + 1)], breaks, strict=True):
            t = 1e-3 * x[begin:end]
            close((t[0], t[-1]), (segment.t_start, segment.t_end), 1e-12)
            places = some(t, 9)
            wanted = [
                judge.forces(min(float(t[i]), segment.t_end), segment.closed, left=i == len(t) - 1)
                for i in places
            ]
            close(y[begin:end][places], [item[name] for item in wanted])
    assert_phases_in_time(judge, figure, figure.axes)


def test_phases(judge: Judge, run: Solution) -> None:
    """Bands over the index: one row for the phases, one for each stop, and their boundaries."""
    axes = phase_figure(run).axes[0]
    rows = {
        label.get_text(): float(tick)
        for tick, label in zip(axes.get_yticks(), axes.get_yticklabels(), strict=True)
    }
    assert list(rows) == ["phase", *(f"{name} closed" for name in judge.stops)]
    per_s = 40.0 * run.case.speed_rpm / 60.0

    def bars(row: str) -> set[tuple[float, float]]:
        found = [
            (patch.get_x(), patch.get_width()) for patch in axes.patches
            if patch.get_y() + 0.5 * patch.get_height() == pytest.approx(rows[row])
        ]  # fmt: skip
        return {(round(x % 40.0, 5) % 40.0, round(width, 5)) for x, width in found}

    def wanted(parts: list[tuple[float, float]]) -> set[tuple[float, float]]:
        return {
            (round(judge.index(a) % 40.0, 5) % 40.0, round(per_s * (b - a), 5)) for a, b in parts
        }

    def same(one: set[tuple[float, float]], other: set[tuple[float, float]]) -> None:
        close(sorted(one), sorted(other), 1e-6)

    same(bars("phase"), wanted([(a, b) for _, a, b in judge.phases]))
    for name in judge.stops:
        same(bars(f"{name} closed"), wanted([(a, b) for c, a, b in judge.phases if name in c]))
    written = [float(text.get_text()) for text in axes.texts if "." in text.get_text()]
    edges = [judge.index(t) for _, a, b in judge.phases for t in (a, b)]
    assert written
    for value in written:
        assert min(abs(value - edge) for edge in edges) <= 0.0051
    names = {frozenset(item["closed"]): item["number"] for item in judge.document["phases"]}
    for text in axes.texts:
        if "." in text.get_text():
            assert text.get_position()[0] == pytest.approx(float(text.get_text()), abs=0.0051)
            continue
        t = (text.get_position()[0] - judge.index(0.0)) % 40.0 / per_s
        closed, begin, end = next(item for item in judge.phases if item[1] <= t <= item[2])
        assert judge.bounces(closed, begin, end)
        assert text.get_text() == str(names[closed])


def series(judge: Judge) -> list[Event]:
    """Collisions of the transition stop until its first rest, and that."""
    found = []
    for event in judge.run.events:
        if judge.document["transition_stop"] in event.stops:
            found.append(event)
            if event.kind.value == "rest":
                break
    return found


def assert_rebounds(judge: Judge, axes: Axes) -> None:
    """Gap from the first collision to rest, in mdeg or um; heights, and the gap at the contact."""
    name, events = judge.document["transition_stop"], series(judge)
    item, times = judge.stops[name], [event.t for event in events]
    assert unit_of(axes.get_ylabel()) == ("mdeg" if item.turns else "um")
    assert axes.get_xlabel() == "time from the start of the run [ms]"
    factor = FACTOR[unit_of(axes.get_ylabel())]
    ground, curve, struck, rest = axes.lines
    assert not np.any(ground.get_ydata())
    x, y = (np.asarray(values) for values in curve.get_data())
    places = some(x)
    close(y[places], factor * np.array(gaps(judge, name, 1e-3 * x[places])), 1e-6)
    close((x[0], x[-1]), (1e3 * times[0], 1e3 * times[-2]), 1e-9)
    close(struck.get_xdata(), [1e3 * t for t in times[:-1]], 1e-9)
    close(rest.get_xdata(), [1e3 * times[-1]], 1e-9)
    # Of rebounds that last less than 3 % of the whole the height is not written.
    flights = [
        (a, b) for a, b in itertools.pairwise(times[:-1])
        if b - a >= 0.03 * (times[-1] - times[0])
    ][:3]  # fmt: skip
    assert len(axes.texts) == len(flights) >= 1
    for text, (begin, end) in zip(axes.texts, flights, strict=True):
        inside = y[(1e-3 * x >= begin) & (1e-3 * x <= end)]
        value, unit = text.get_text().split()
        assert unit == unit_of(axes.get_ylabel())
        # Four digits, of a top that lies between two samples.
        assert float(value) == pytest.approx(inside.max(), rel=2e-3)
        assert text.xy == pytest.approx((5e2 * (begin + end), float(value)), rel=1e-3)
    assert len(axes.child_axes) == (item.lever is not None)
    for beside in axes.child_axes:
        axes.figure.canvas.draw()
        assert beside.get_ylabel() == "gap at the contact [um]"
        assert beside.get_ylim()[1] == pytest.approx(
            1e6 * item.lever * axes.get_ylim()[1] / factor, rel=1e-9
        )


def test_transition(judge: Judge, run: Solution) -> None:
    """The bounces against time from the start, and against time left until rest."""
    linear, log = transition_figure(run, run.transitions[0]).axes
    name, events = judge.document["transition_stop"], series(judge)
    end = events[-1].t
    factor = FACTOR[unit_of(linear.get_ylabel())]
    assert linear.get_ylabel() == log.get_ylabel()
    assert_rebounds(judge, linear)
    assert log.get_xlabel().startswith("time left until rest [ms]")
    left, gap = (np.asarray(values, dtype=float) for values in log.lines[0].get_data())
    seen = np.flatnonzero(np.isfinite(gap) & (left > 0.0))
    places = seen[some(seen)]
    wanted = factor * np.array(gaps(judge, name, end - 1e-3 * left[places]))
    np.testing.assert_allclose(gap[places], wanted, rtol=1e-4)
    lines = [float(line.get_xdata()[0]) for line in log.lines[1:]]
    close(lines, [1e3 * (end - event.t) for event in events[:-1]], 1e-9)
    order = [item.number for item in judge.hits]
    numbers = [order.index(event.number) + 1 for event in events[:-1]]
    assert [text.get_text() for text in log.texts] == [str(number) for number in numbers]


def test_impulses(judge: Judge, run: Solution) -> None:
    """A bar of the impulse for every collision, in N s at a contact and N m s at a hinge."""
    (axes,) = impulse_figure(run).axes
    units = sorted({"N m s" if moment(judge, name) else "N s" for name in judge.stops})
    assert unit_of(axes.get_ylabel()) == " or ".join(units)
    found: dict[str, Any] = {line.get_label(): line for line in axes.lines}
    bars = list(axes.collections)
    assert set(found) == {f"stop {name}" for name in judge.stops}
    for bar, name in zip(bars, judge.stops, strict=True):
        wanted = [
            (number, judge.impulses(event)[0][name] / (judge.stops[name].lever or 1.0))
            for number, event in enumerate(judge.hits, start=1)
            if event.stops[0] == name
        ]
        np.testing.assert_allclose(found[f"stop {name}"].get_xydata(), wanted, rtol=1e-8)
        ends = [segment[1] for segment in bar.get_segments()]
        np.testing.assert_allclose(ends, wanted, rtol=1e-8)
        feet = {round(float(segment[0][1]), 15) for segment in bar.get_segments()}
        assert feet == {round(axes.get_ylim()[0], 15)}
        assert max(feet) < min(value for _, value in wanted)


# What the viewers say.


def test_readings(judge: Judge, run: Solution, shown: Film) -> None:
    """Index, time, gaps, lengths at the contact and forces of every frame; phases, impulses."""
    said: Any = readings(shown)
    machine = shown.pace.machine
    frames = some(machine, 60)
    columns = {item["label"]: item for item in said["columns"]}
    assert len(columns) == len(said["columns"])
    wanted: dict[str, tuple[str, list[float]]] = {
        "index": ("", [judge.index(float(machine[i])) for i in frames]),
        "time": ("ms", [1e3 * float(machine[i]) for i in frames]),
    }
    for name, item in judge.stops.items():
        gap = np.array(gaps(judge, name, machine[frames]))
        unit = "deg" if item.turns else "mm"
        labels = [key for key in columns if re.fullmatch(f"{name} (angle|stroke|gap)", key)]
        (label,) = labels
        wanted[label] = (unit, (FACTOR[unit] * gap).tolist())
        if item.lever is not None:
            wanted[f"{name} gap at the contact"] = ("mm", (1e3 * item.lever * gap).tolist())
        forces = []
        for i in frames:
            t = float(machine[i])
            segment = [s for s in run.segments if s.t_start <= t <= s.t_end > s.t_start]
            last = t >= run.segments[-1].t_end
            closed = segment[-1].closed
            forces.append(judge.forces(t, closed, left=last)[name])
        (label,) = (key for key in columns if re.fullmatch(f"{name} .* force", key))
        wanted[label] = ("N m" if moment(judge, name) else "N", forces)
    assert set(columns) == {*wanted, "slow motion 1 :"}
    for label, (unit, values) in wanted.items():
        assert columns[label]["unit"] == unit
        found = [columns[label]["values"][i] for i in frames]
        size = max(abs(value) for value in values) or 1.0
        np.testing.assert_allclose(found, values, rtol=6e-6, atol=2e-6 * size)
    # Slow motion is what the two clocks say of one another.
    ratio = np.diff(shown.pace.playback) / np.diff(machine)
    stretch = np.array(columns["slow motion 1 :"]["values"])
    between = np.minimum(stretch[1:], stretch[:-1]) / ratio, np.maximum(stretch[1:], stretch[:-1])
    assert float(np.median(np.abs(between[0] - 1.0))) < 0.1
    assert len(said["phases"]) == len(judge.phases)
    for item, (closed, begin, end) in zip(said["phases"], judge.phases, strict=True):
        start = float(np.interp(begin, machine, shown.pace.playback))
        assert item["start"] == pytest.approx(start, rel=1e-12, abs=1e-12)
        number = next(
            str(p["number"]) for p in judge.document["phases"] if frozenset(p["closed"]) == closed
        )
        if judge.bounces(closed, begin, end):
            assert item["name"].split()[1] == number
        else:
            assert item["name"].startswith(f"{judge.document['transition_stop']} open, ")
    for number, (item, event) in enumerate(zip(said["collisions"], judge.hits, strict=True), 1):
        at = float(np.interp(event.t, machine, shown.pace.playback))
        assert item["at"] == pytest.approx(at, rel=1e-12)
        name = event.stops[0]
        impulse = judge.impulses(event)[0][name] / (judge.stops[name].lever or 1.0)
        text = item["text"]
        assert f"collision {number} ({name})" in text
        value, unit = re.search(r"impulse (\S+) (.+)$", text).groups()  # type: ignore[union-attr]
        assert float(value) == pytest.approx(impulse, rel=6e-4)
        assert unit == ("N m s" if moment(judge, name) else "N s")


def test_links_and_cylinder_of_the_film(judge: Judge, run: Solution, shown: Film) -> None:
    """Where links stand and how they are turned, and how far the cylinder has turned."""
    for i in some(shown.pace.machine, 12):
        t = float(shown.pace.machine[i])
        q = judge.state(t, left=i > 0)[0]
        places = judge.places(q)
        for column, link in enumerate(run.mechanism.links):
            x, z, angle = places[link]
            np.testing.assert_allclose(shown.position[i, column], (x, z), rtol=0.0, atol=1e-9)
            turned = (shown.angle[i, column] - angle + math.pi) % math.tau - math.pi
            assert abs(turned) < 1e-9
        touch = math.radians(judge.document["cylinder"]["angle_at_touch_deg"])
        assert shown.turned[i] == pytest.approx(judge.angle(t) - touch, abs=1e-9)


def test_arrows(judge: Judge, run: Solution, shown: Film) -> None:
    """Sizes are the impulses by the largest; places and directions those of the push."""
    drawn = arrow_stops(run.mechanism)
    assert {stop.name for stop in drawn} == {n for n in judge.stops if not moment(judge, n)}
    struck = [
        (event, judge.impulses(event)[0][event.stops[0]] / (
            judge.stops[event.stops[0]].lever or 1.0
        ))
        for event in judge.hits
    ]  # fmt: skip
    # A moment's impulse is no length of an arrow.
    largest = max(value for event, value in struck if not moment(judge, event.stops[0]))
    tracks = {item["path"]: item["clip"] for item in animation(shown, [])["animations"]}
    for stop in drawn:
        clip = next(v for path, v in tracks.items() if path.endswith(f"/impulse_{stop.name}"))
        (track,) = clip["tracks"]
        t = np.frombuffer(track["times"].data, dtype="<f4")
        size = np.frombuffer(track["values"].data, dtype="<f4").reshape(-1, 3)
        np.testing.assert_allclose(size, arrow_scale(size[:, 1].astype(float)), rtol=1e-5)
        own = [(event, impulse) for event, impulse in struck if event.stops[0] == stop.name]
        starts = np.interp([e.t for e, _ in own], shown.pace.machine, shown.pace.playback)
        checked = 0
        for (_, impulse), at, following in zip(own, starts, [*starts[1:], math.inf], strict=True):
            # Collisions a thousandth of a second apart are one jump of the arrow.
            if following - at > 2e-3:
                checked += 1
                peak = size[int(np.argmin(np.abs(t - at))), 1]
                assert peak == pytest.approx(max(impulse / largest, 1e-6), rel=1e-5)
        assert checked > len(own) // 2
        joint = next(j for j in run.mechanism.joints if j.index == stop.index)
        place = arrow_place(run.mechanism, stop)
        body = arrow_body(run.mechanism, stop)
        zero = np.zeros(len(judge.names))
        x, z, angle = (
            judge.places(zero)[run.mechanism.joints[body].child] if body >= 0 else (0.0, 0.0, 0.0)
        )
        c, s = math.cos(angle), math.sin(angle)
        at = np.array([x, z]) + np.array([[c, -s], [s, c]]) @ place[[0, 2], 3]
        way = np.array([[c, -s], [s, c]]) @ place[[0, 2], 1]
        # The push does positive work on the opening: the contact's point moves along the arrow.
        step = 1e-6
        ahead = zero.copy()
        ahead[stop.index] = step * stop.sense
        moved = np.subtract(
            judge.point(joint.child, at, zero, ahead), at
        ) / step  # fmt: skip
        rate = judge.stops[stop.name].lever or 1.0
        assert float(moved @ way) == pytest.approx(rate, rel=1e-4)


def test_live_page() -> None:
    """Numbers, gap line, times and sizes of impulses of the page, with sliders as they start."""
    mechanism = load("e62")
    controls = knobs(mechanism, 650.0)
    found = answer(mechanism, controls, {item.key: item.start for item in controls})
    assert found.solution is not None
    judge = Judge(found.solution)
    events = series(judge)
    start, stop = events[0].t, judge.stops["jaw"]
    hits = events[:-1]
    impulses = [judge.impulses(event)[0]["jaw"] / (stop.lever or 1.0) for event in hits]
    np.testing.assert_allclose(found.hit_time, [1e3 * (e.t - start) for e in hits], atol=1e-12)
    np.testing.assert_allclose(found.impulse, impulses, rtol=1e-8)
    places = some(found.time)
    wanted = 1e3 * FACTOR["deg"] * np.array(gaps(judge, "jaw", start + 1e-3 * found.time[places]))
    close(found.gap[places], wanted, 1e-6)
    duration = events[-1].t - start
    height, time = judge.rebound(hits[0], "jaw")  # type: ignore[misc]
    numbers: dict[str, tuple[str, float]] = {
        "amplitude": ("[mdeg]", 1e3 * FACTOR["deg"] * height),
        "rebound": ("[ms]", 1e3 * time),
        "duration": ("[ms]", 1e3 * duration),
        "collisions": ("", len(hits)),
        "share": ("[%]", 100.0 * (hits[2].t - start) / duration),
        "approach": ("[rad/s]", judge.rate("jaw", hits[0].v_before)),
        "impulse": ("[N s]", impulses[0]),
    }
    assert {row.key for row in found.rows} >= set(numbers)
    for key, label, value in ((row.key, row.label, row.text) for row in found.rows):
        if key in numbers:
            unit, number = numbers[key]
            assert label.endswith(unit)
            assert float(value) == pytest.approx(number, rel=6e-4)


def test_live_moments(judge: Judge, run: Solution) -> None:
    """Phase, arrows and the line of numbers at moments of the motion."""
    turn = 180.0 / math.pi
    # Of the stop that bounces small gaps, and of one with a contact point the gap there, too.
    main = judge.document["transition_stop"]
    unit_of = {
        name: (("mdeg", 1e3 * turn) if item.turns else ("um", 1e6)) if name == main
        else (("deg", turn) if item.turns else ("mm", 1e3))
        for name, item in judge.stops.items()
    }  # fmt: skip
    for closed, begin, end in judge.phases:
        t = 0.5 * (begin + end)
        assert closed_at(run, t) == closed
        q = judge.state(t, left=True)[0]
        time, index, *rest = moment_text(run, t, q).split(", ")
        assert float(time.removesuffix(" ms")) == pytest.approx(1e3 * t, abs=0.0051)
        assert float(index.removeprefix("index ")) == pytest.approx(judge.index(t), abs=6e-4)
        expected = []
        for name, item in judge.stops.items():
            unit, scale = unit_of[name]
            expected.append((name, scale * judge.gap(name, q), unit))
            if name == main and item.lever is not None:
                expected.append(("gap at the contact", 1e3 * item.lever * judge.gap(name, q), "mm"))
            if name == main:
                force = judge.forces(t, closed, left=True).get(name, 0.0)
                expected.append(("clamping force", force, "N m" if moment(judge, name) else "N"))
        assert len(rest) == len(expected)
        for text, (said, wanted, unit) in zip(rest, expected, strict=True):
            value = text.removeprefix(f"{said} ").removesuffix(f" {unit}")
            size = 1e-6 if said == "clamping force" else 1e-9
            assert float(value) == pytest.approx(wanted, rel=6e-4, abs=size)
    sizes = [
        judge.impulses(event)[0][event.stops[0]] / (judge.stops[event.stops[0]].lever or 1.0)
        for event in judge.hits
    ]
    drawn = {name for name in judge.stops if not moment(judge, name)}
    pairs = [pair for pair in zip(judge.hits, sizes, strict=True) if pair[0].stops[0] in drawn]
    for event, size in pairs:
        # Just after a collision the arrow has its full size, and half of it half way of its end.
        share = size / max(size for _, size in pairs)
        for delay, left in ((1e-12, 1.0), (1e-2 * HELD, 1.0), (1e-2 * (HELD + 0.5 * FADE), 0.5)):
            later = [e for e in judge.hits if event.t < e.t <= event.t + delay]
            shown = impulses_at(run, event.t + delay, 100.0)
            assert set(shown) <= drawn
            if not any(e.stops[0] == event.stops[0] for e in later):
                assert shown[event.stops[0]] == pytest.approx(left * share, rel=1e-8)

"""Remarks of an optimisation, tables that a narrow terminal shows, and what is drawn of a solid."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from rich.console import Console
from small_machines import SHAFT, hinge, link, machine, slide

from benchmarks.run_time.benchmark import Benchmark
from benchmarks.run_time.work_precision import Row
from benchmarks.views import benchmark_report
from benchmarks.views.work_precision_plot import work_precision_figure
from nipper_pin import InputError, Mechanism, Solution, load, simulate
from nipper_pin.cli import main
from nipper_pin.hybrid.case import Case
from nipper_pin.mechanism.gallery import GALLERY
from nipper_pin.study.optimise import Optimum
from nipper_pin.study.optimise.problem.problem import Limit, Parameter
from nipper_pin.study.sweep.axes import Target
from nipper_pin.view.console import paste, say
from nipper_pin.view.live.settings import knobs
from nipper_pin.view.run import plots, table
from nipper_pin.view.run.csv_tables import _motion
from nipper_pin.view.scene import Look
from nipper_pin.view.scene.framing import _reach
from nipper_pin.view.scene.meshes import mesh_of
from nipper_pin.view.scene.solids import FIXED, Solid, solids
from nipper_pin.view.studies import optimise_report
from nipper_pin.view.studies.front_plot import front_figure


def printed(work: Callable[[Console], None], width: int = 300) -> str:
    stream = io.StringIO()
    work(Console(file=stream, width=width))
    return stream.getvalue()


# Optimisations.


def search(**others: Any) -> Optimum:
    """Descents of which some end at the least value, some beside it and one outside."""
    ends = ((4.0, True), (4.000001, True), (4.1, True), (3.0, False))
    found = {
        "descents": [SimpleNamespace(aim=aim, feasible=kept) for aim, kept in ends],
        "seed": 19, "evaluations": 12_345, "wall_s": 6.789, "no_machine": (),
        "engines": {"reduced": 12_000, "direct": 300, "turn": 5}, "check": None, "check_gain": 0.0,
    }  # fmt: skip
    return cast("Optimum", SimpleNamespace(**{**found, **others}))


def test_remarks_on_a_search() -> None:
    """Descents that end at the best, points by engine, what the check found, and lost samples."""
    tell: Any = optimise_report._search
    lines = printed(lambda console: tell(search(), console)).splitlines()
    assert lines == [
        "2 of 4 descents (seed 19) end there; 12,345 points in 6.79 s",
        "of them 12,000 by the reduced engine, 300 by the direct engine, 5 by whole turns, "
        "40 without a usable machine",
    ]
    check = SimpleNamespace(evaluations=7_654)
    for gain, words in ((0.0, "found nothing better"), (1e-6, "found nothing better"),
                        (0.01234, "found a design better by 1.23 %")):  # fmt: skip
        optimum = search(check=check, check_gain=gain, no_machine=("it jams", "no root"))
        lines = printed(lambda console, shown=optimum: tell(shown, console)).splitlines()
        assert lines[2:] == [
            f"differential evolution (7,654 points) {words}",
            "some samples make no machine: it jams", "some samples make no machine: no root",
        ]  # fmt: skip


def front(*paths: str, points: int = 3) -> Optimum:
    parameters = [
        Parameter(name=path, target=Target(kind="model", path=path), low=1.0, high=3.0, start=2.0)
        for path in paths
    ]
    limits = [
        Limit(quantity="duration_s", side="high", value=0.25),
        *(Limit(quantity="clamping_force_N", side=side, value=value)
          for side, value in (("low", 70.0), ("high", 95.5))),
    ]  # fmt: skip
    designs = tuple(
        SimpleNamespace(
            values={"duration_s": 0.5 + k, "clamping_force_N": 80.0 - k},
            numbers={path: 1.5 + 0.25 * k + place for place, path in enumerate(paths)},
            z=[0.25 * (k + 1), 0.9 - 0.3 * k],
            holding=((str(limits[0]), f"{paths[0]} >= 1") if k == 1 else (str(limits[2]),) * k),
        )
        for k in range(points)
    )
    problem = SimpleNamespace(
        title="a title " * 20, parameters=parameters, limits=limits,
        aims=[SimpleNamespace(quantity="duration_s"), SimpleNamespace(quantity="clamping_force_N")],
        units={"duration_s": "s", "clamping_force_N": "N"},
    )  # fmt: skip
    before = SimpleNamespace(inside=True, values={"duration_s": 9.0, "clamping_force_N": 70.0})
    return cast("Optimum", SimpleNamespace(front=designs, problem=problem, before=before))


def test_tables_of_fronts() -> None:
    """Words of numbers as headings; one design that is best by both is no conflict."""
    tell: Any = optimise_report._front
    for paths, headings in (
        (("springs.a.rate", "stops.b.restitution"), ["rate of spring a", "restitution of stop b"]),
        (("springs.a.rate", "springs.b.rate"), ["rate of spring a", "rate of spring b"]),
    ):
        found = front(*paths)
        text = printed(lambda console, shown=found: tell(shown.front, shown, console))
        assert text.startswith("\nPareto front\n")
        lines = text.splitlines()
        rule = next(k for k, line in enumerate(lines) if line.startswith("─"))
        rows = [re.split(r"\s{2,}", line.strip()) for line in lines]
        words = " ".join(" ".join(lines[2:rule]).split())
        assert sorted(words.split()) == sorted(["time", "to", "rest", "[ms]", "clamping", "force",
                                                "[N]", *" ".join(headings).split()])  # fmt: skip
        assert [[float(cell) for cell in row] for row in rows[rule + 1 : rule + 4]] == [
            # Times are read in ms.
            [1e3 * (0.5 + k), 80.0 - k, 1.5 + 0.25 * k, 2.5 + 0.25 * k]
            for k in range(3)
        ]
    single = front("a", points=1)
    text = printed(lambda console: tell(single.front, single, console))
    assert text == "No conflict: one design is the best by time to rest and by clamping force\n"


def test_what_stands_around_a_front() -> None:
    """Title, limits below, legend, a row for each limit that holds, a panel for each number."""
    figure = front_figure(front("a", "b"))
    assert figure.get_suptitle() == "The best designs: time to rest against clamping force"
    lines = figure.get_supxlabel().splitlines()
    assert max(map(len, lines)) <= 104
    text = " ".join(lines).replace("\N{NO-BREAK SPACE}", " ")
    assert text.startswith("a title a title")
    limits = "Limits: time to rest at most 250 ms; clamping force 70 to 95.5 N"
    assert text.endswith(limits)
    # No limit is broken by the end of a line.
    assert "70\N{NO-BREAK SPACE}to\N{NO-BREAK SPACE}95.5\N{NO-BREAK SPACE}N" in lines[-1]
    above, held, *numbers = figure.axes
    words = [item.get_text() for item in above.get_legend().get_texts()]
    assert words == ["best designs", "the model as it is"]
    assert above.lines[1].get_linestyle() == "None"
    assert above.get_xlabel() == ""
    rows = {str(line.get_label()): line for line in held.lines}
    assert {name: line.get_xdata().tolist() for name, line in rows.items()} == {
        "time to rest at most 250 ms": [79.0], "clamping force at most 95.5 N": [78.0],
        "a at least 1": [79.0], "no limit": [80.0],
    }  # fmt: skip
    assert [float(line.get_ydata()[0]) for line in held.lines] == [0.0, -1.0, -2.0, -3.0]
    low, high = held.get_ylim()
    assert low < -3.0
    assert high > 0.5
    for axes in (above, held):
        looks = [(line.get_color(), line.get_marker()) for line in axes.lines]
        count = len(looks)
        assert len({colour for colour, _ in looks}) == len({mark for _, mark in looks}) == count
    assert [axes.get_title(loc="left") for axes in numbers] == ["a", "b"]
    for axes in numbers:
        low, high = axes.get_ylim()
        assert 0.8 < low < 1.0
        assert 3.0 < high < 3.2
        assert above.get_shared_x_axes().joined(above, axes)
    none = replace_limits(front("a", "b"))
    assert front_figure(none).get_supxlabel().endswith("Limits: none")


def replace_limits(optimum: Optimum) -> Optimum:
    problem = SimpleNamespace(**{**vars(optimum.problem), "limits": []})
    return cast("Optimum", SimpleNamespace(**{**vars(optimum), "problem": problem}))


@pytest.mark.parametrize("tell", [paste, say])
def test_numbers_in_sentences_have_no_colours(tell: Any) -> None:
    """On a terminal with colours, too: style is what the program says."""
    stream = io.StringIO()
    text = "nipper-pin simulate 'e62' --speed 12.5 [bold]x[/bold] True /a/path :smile:"
    tell(Console(file=stream, force_terminal=True, color_system="truecolor", width=300), text)
    assert stream.getvalue() == f"{text}\n"


# Benchmarks.


def row(engine: str, setting: str, start: float) -> Row:
    return Row(engine, setting, start, start + 1.0, start + 2.0, start + 3.0, 30, 2e-13 * start,
               7e-13 * start, evaluations=212)  # fmt: skip


def test_tables_of_narrow_and_wide_terminals() -> None:
    """A table too wide for its terminal is parts, each with the names; all columns are there."""
    rows = [row("direct", "1e-12", 11.0), row("direct", "1e-8", 22.0), row("other", "1e-8", 33.0)]
    costs = [{"what": "a", "wall_ms": 1.5, "cut_pins": 7}]
    result = SimpleNamespace(
        engines=rows, accuracy=[], stated=[], peers=[row("one (by hand)", "1e-6", 44.0)],
        reduced=None, unavailable=("a peer: no bounce",), quick=False,
        environment={"date": "d", "platform": "p", "processor": "c", "cores": 6, "python": "3",
                     "cores_allowed": None, "load_average": None, "threads": {}, "versions": {}},
        turns=[], cost={name: costs for name in ("phases", "parts", "collisions", "turns", "links",
                                       "memory")},
    )  # fmt: skip
    found = cast("Benchmark", result)
    sheet = benchmark_report.sheets(found)[0]
    for width in (80, 200):
        text = printed(lambda console: benchmark_report.print_benchmark(found, console), width)
        assert text.splitlines()[:2] == ["d, full run", "p, c, 6 cores (all allowed)"]
        body = text.partition(f"{sheet.title}\n")[2].partition("\n\n")[0]
        heads = [line.split() for line in body.splitlines()]
        assert set(" ".join(sheet.headings).split()) <= {word for line in heads for word in line}
        # An engine's name stands in its first row alone.
        direct = sum(line[0] == "direct" for line in heads if line)
        assert (
            direct == sum(line[0] == "other" for line in heads if line) == (1 if width > 80 else 2)
        )
        for item in rows:
            assert str(item.wall_ms)[:2] in body
    text = benchmark_report.markdown(found)
    assert text.endswith("\n\nNot measured: a peer: no bounce\n")
    assert "\n| --- | --- |" + " ---: |" * 11 + "\n| direct | 1e-12 |" in text
    assert "### Engines: one transition, 650 r/min, e = 0.2\n\n| engine | setting |" in text


def test_lines_of_work_against_precision() -> None:
    """Our own engines thick and whole, others thin and dashed; the legend has their looks."""
    names = ["direct", "reduced", "reduced, batch", "a peer (by hand)", "b peer (one way)",
             "b peer (another)"]  # fmt: skip
    found = SimpleNamespace(
        engines=[row(name, "1", 2.0 + k) for k, name in enumerate(names[:3])],
        peers=[row(name, "1", 5.0 + k) for k, name in enumerate(names[3:])],
        environment={"date": "2026-01-02T03", "processor": "chip"},
    )  # fmt: skip
    figure = work_precision_figure(cast("Benchmark", found))
    (axes,) = figure.axes
    lines, handles = axes.lines, figure.legends[0].legend_handles
    assert [line.get_linestyle() for line in lines] == ["-"] * 3 + ["--"] * 3
    own, others = ({line.get_linewidth() for line in part} for part in (lines[:3], lines[3:]))
    assert min(own) > max(others)
    looks = [(to_hex(line.get_color()), line.get_marker()) for line in lines]
    assert len(set(looks)) == 6
    for line, handle in zip(lines, handles, strict=True):
        assert (handle.get_color(), handle.get_marker()) == (line.get_color(), line.get_marker())
        assert handle.get_linestyle() == line.get_linestyle()
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    title = "One transition of the jaw of the E62 estimate, 650 r/min, restitution 0.2"
    assert axes.get_title().splitlines()[0] == f"{title} (2026-01-02, chip)"
    # No two of one name: what tells them apart stays.
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        "nipper_pin, direct engine", "nipper_pin, reduced engine",
        "nipper_pin, reduced engine, many at once", "a peer", "b peer (one way)",
        "b peer (another)",
    ]  # fmt: skip


# Machines.


def test_the_gallery_is_listed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line a machine, titles below one another; then how many, and how to take one."""
    monkeypatch.setenv("COLUMNS", "300")
    assert main(["new", "--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    width = max(len(name) for name in GALLERY) + 2
    assert lines[0].rstrip() == "machine".ljust(width) + "what it is"
    assert set(lines[1]) == {"─"}
    assert [line.rstrip() for line in lines[2:-2]] == [
        name.ljust(width) + draw().title for name, draw in GALLERY.items()
    ]
    assert lines[-2:] == [
        f"Found: {len(GALLERY)} machines to start from.",
        f"Next: nipper-pin new my_machine --from {next(iter(GALLERY))}",
    ]


@pytest.mark.parametrize("known", [True, False])
def test_a_machine_of_the_gallery_says_where_its_numbers_come_from(
    known: bool, tmp_path: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its source, or that it is an invention; and commands that can be pasted."""
    name = next(name for name, draw in GALLERY.items() if bool(draw().known) == known)
    drawing = GALLERY[name]()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "1000")
    assert main(["new", "some_press", "--from", name]) == 0
    assert capsys.readouterr().out.splitlines() == [
        f"some_press: {drawing.title}",
        drawing.known if known else drawing.invented,
        "It runs as it stands:",
        "  nipper-pin check some_press",
        "  nipper-pin simulate some_press --window cycle",
        "  nipper-pin view some_press --window cycle --html some_press.html",
    ]


def test_sliders_need_the_transition_stop(e62: Mechanism) -> None:
    """It is enough alone, and no other stop stands in for it."""
    jaw, steeve = (e62.stop(name) for name in ("jaw", "steeve"))
    assert knobs(replace(e62, stops=(jaw,)), 650.0)
    with pytest.raises(InputError, match="no transition stop"):
        knobs(replace(e62, stops=(steeve,)), 650.0)


# Runs.


def test_which_figures_a_run_has(
    cycle: Solution, transition: Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    """None of what did not happen."""
    for name in ("motion", "phase", "transition", "impulse", "force"):
        monkeypatch.setattr(plots, f"{name}_figure", lambda *_: Figure())
    every = ["motion", "phases", "transition", "impulses", "forces"]
    assert list(plots._figures(cycle)) == every
    assert list(plots._figures(transition)) == every[:4]
    dead = simulate(load("e62", {"stops.jaw.restitution": 0.0}), Case(speed_rpm=450.0))
    assert list(plots._figures(dead)) == ["impulses"]


def test_how_a_series_ends(transition: Solution) -> None:
    """Without restitution at once, else at its limit."""
    dead = simulate(load("e62", {"stops.jaw.restitution": 0.0}), Case(speed_rpm=450.0))
    said = ("Without restitution the first collision ends it.", "The bounces go on for ever")
    for run, words in ((dead, [True, False]), (transition, [False, True])):
        text = printed(lambda console, shown=run: table.print_solution(shown, console))
        assert [part in text for part in said] == words
        held = printed(
            lambda console, shown=run: table.print_solution(shown, console, with_forces=True)
        )
        assert ("No stop is closed in this window." in held) == (
            not run.segments or run is transition
        )
        count = run.transitions[0].collisions
        assert f"to rest, {count} collision{'s' if count > 1 else ''} computed" in text


def test_rows_of_the_motion(transition: Solution) -> None:
    """A hundred places evenly over each stretch between events, both its ends among them."""
    _, rows = _motion(transition)
    found = [(float(row[0]), row[1]) for row in rows]
    stretches = [item for item in transition.segments if item.t_end > item.t_start]
    assert len(found) == 100 * len(stretches)
    for place, segment in enumerate(stretches):
        part = found[100 * place : 100 * place + 100]
        wanted = np.linspace(segment.t_start, segment.t_end, 100)
        np.testing.assert_allclose([t for t, _ in part], wanted, rtol=1e-14)
        assert [side for _, side in part] == ["right"] * 99 + ["left"]


@pytest.mark.parametrize("values", [{"slow": 1.0}, {"slow": 1e5}, {"exaggerate": 50.0}])
def test_looks_up_to_their_ends(values: dict[str, float]) -> None:
    assert Look(**values)
    with pytest.raises(InputError, match=r"cannot be used: 1 to (50|100000)$|: 1 to 1e\+05"):
        Look(**{key: 1.001 * value if value > 1.0 else 0.999 for key, value in values.items()})


# Solids.


def block(turned: float, depth: float = 0.0, body: int = FIXED) -> Solid:
    """A box of 2 x 4 x 6 that is turned about the vertical."""
    place = np.eye(4)
    c, s = math.cos(turned), math.sin(turned)
    place[:2, :2], place[1, 3] = [[c, -s], [s, c]], depth
    return Solid("block", body, "box", (2.0, 4.0, 6.0), None, place, np.ones(3), (0.2, 0.4, 0.8))


def test_corners_of_round_solids() -> None:
    """Cylinders of 32 corners an end and spheres of nine rings have their radius and length."""
    points, _ = mesh_of(replace(block(0.0), kind="cylinder", sizes=(0.5, 3.0)))
    assert len(points) == 64
    assert points.max(axis=0) == pytest.approx([0.5, 0.5, 1.5])
    assert points.min(axis=0) == pytest.approx([-0.5, -0.5, -1.5])
    points, _ = mesh_of(replace(block(0.0), kind="sphere", sizes=(0.7,)))
    assert len(points) == 9 * 32 + 2
    assert points.max(axis=0) == pytest.approx([0.7, 0.7, 0.7])
    assert np.linalg.norm(points, axis=1).max() == pytest.approx(0.7)
    heights = np.unique(points[:, 2].round(9))
    assert heights == pytest.approx(0.7 * np.cos(np.pi * np.arange(10, -1, -1) / 10.0), abs=1e-9)


@pytest.mark.parametrize(
    ("kind", "sizes"), [("box", (0.2, 0.4, 0.6)), ("cylinder", (0.3, 0.8)), ("sphere", (0.25,))]
)
def test_how_far_a_solid_reaches(kind: str, sizes: tuple[float, ...]) -> None:
    """Along the axes of the world, however it is turned: as far as points all over it."""
    turns = np.linspace(0.0, math.tau, 721)
    circle = np.column_stack([np.cos(turns), np.sin(turns), np.zeros(721)])
    if kind == "box":
        points = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T
        points = points * sizes
    elif kind == "cylinder":
        points = np.concatenate([sizes[0] * circle + [0, 0, end] for end in (-0.4, 0.4)])
    else:
        points = np.array([[0.25, 0, 0], [0, 0.25, 0], [0, 0, 0.25]])
    solid = replace(block(0.0), kind=kind, sizes=sizes)
    for seed in range(4):
        turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
        wanted = np.abs(points @ turn.T).max(axis=0) if kind != "sphere" else np.full(3, 0.25)
        assert _reach(solid, turn) == pytest.approx(wanted, rel=1e-4)


def test_bars_of_links_without_shapes() -> None:
    """From a joint to all that hangs on its link, or to the centre of mass; a ball at the joint."""
    made = machine(
        [
            link("arm", centre=(0.3, 0.1)), hinge("arm_pin", "frame", "arm", (0.1, 0.2)),
            link("hand", centre=(0.0, 0.25)), hinge("hand_pin", "arm", "hand", (0.4, 0.0)),
            link("finger", centre=(0.05, 0.0)), slide("finger_x", "arm", "finger", at=(0.0, 0.5)),
        ],
        3,
        drives={"arm": {"joint": "arm_pin", "law": "constant_speed", "ratio": 1.0, **SHAFT}},
    )  # fmt: skip
    thick = 0.02 * made.reach_m
    ends: dict[str, list[Any]] = {}
    for solid in solids(made):
        name = made.joints[solid.body].child
        if solid.kind == "sphere":
            assert (solid.name, solid.sizes) == ("joint", (pytest.approx(1.6 * thick),))
            assert (solid.placement == np.eye(4)).all()
            continue
        radius, length = solid.sizes
        assert radius == pytest.approx(thick)
        half = 0.5 * length * solid.placement[:3, 2]
        np.testing.assert_allclose(solid.placement[:3, 3], half, atol=1e-12)
        assert np.linalg.det(solid.placement[:3, :3]) == pytest.approx(1.0)
        ends.setdefault(name, []).append((2.0 * half)[[0, 2]].round(9).tolist())
    assert {name: sorted(items) for name, items in ends.items()} == {
        "arm": [[0.0, 0.5], [0.4, 0.0]], "hand": [[0.0, 0.25]], "finger": [[0.05, 0.0]],
    }  # fmt: skip

"""Figures of studies, which figures a run has, what a look may be, and rows of the motion."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from benchmarks.run_time.benchmark import Benchmark
from benchmarks.run_time.work_precision import Row
from benchmarks.views.work_precision_plot import work_precision_figure
from nipper_pin import InputError, Mechanism, Solution, load, simulate
from nipper_pin.hybrid.case import Case
from nipper_pin.study.optimise import Optimum
from nipper_pin.study.optimise.problem.problem import Limit, Parameter
from nipper_pin.study.sweep.axes import Target
from nipper_pin.view.live.settings import knobs
from nipper_pin.view.run import plots
from nipper_pin.view.scene import Look
from nipper_pin.view.studies.front_plot import front_figure

# Optimisations.


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


# Benchmarks.


def row(engine: str, setting: str, start: float) -> Row:
    return Row(engine, setting, start, start + 1.0, start + 2.0, start + 3.0, 30, 2e-13 * start,
               7e-13 * start, evaluations=212)  # fmt: skip


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


@pytest.mark.parametrize("values", [{"slow": 1.0}, {"slow": 1e5}, {"exaggerate": 50.0}])
def test_looks_up_to_their_ends(values: dict[str, float]) -> None:
    assert Look(**values)
    with pytest.raises(InputError, match=r"cannot be used: 1 to (50|100000)$|: 1 to 1e\+05"):
        Look(**{key: 1.001 * value if value > 1.0 else 0.999 for key, value in values.items()})


# Solids.

"""Files and folders that views write and read, and branches that few machines take."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from rich.console import Console

from benchmarks.commands import benchmark as benchmark_command
from benchmarks.paper import report
from benchmarks.views import benchmark_report
from nipper_pin import Case, Mechanism, Solution
from nipper_pin.cli import simulate as simulate_command
from nipper_pin.errors import InputError, SingularConfigurationError
from nipper_pin.hybrid.case import Window
from nipper_pin.study.optimise import write as write_optimum
from nipper_pin.view.live import serve, shapes
from nipper_pin.view.run import export, lead, remarks, sampling
from nipper_pin.view.studies import front_plot

# The package has a function of the same name.
film: Any = import_module("nipper_pin.view.scene.film")

# Folders.


@pytest.mark.parametrize("where", ["occupied", "occupied/below"])
def test_folders_that_cannot_be_made(tmp_path: Path, where: str) -> None:
    """By any of those that write folders: said with the reason, and nothing is written."""
    (tmp_path / "occupied").write_text("mine", encoding="utf-8")
    target = tmp_path / where
    anything: Any = SimpleNamespace()
    for act in (
        lambda: export.export(anything, target),
        lambda: benchmark_report.write_benchmark(anything, target),
        lambda: report.write_paper(anything, target),
        lambda: write_optimum(anything, target),
    ):
        with pytest.raises(InputError, match=r"not a folder|cannot be made a folder") as caught:
            act()
        assert caught.value.evidence == {"folder": str(target)}
    assert (tmp_path / "occupied").read_text(encoding="utf-8") == "mine"


def test_figure_of_a_front_as_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the format of its name."""
    monkeypatch.setattr(front_plot, "front_figure", lambda _: Figure())
    optimum: Any = None
    for suffix, begin in (("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")):
        path = front_plot.plot_front(optimum, str(tmp_path / f"a.{suffix}"))
        assert path == tmp_path / f"a.{suffix}"
        assert path.read_bytes().startswith(begin)


def test_files_of_an_optimum(tmp_path: Path, e62: Mechanism) -> None:
    """Result, overrides and case; a case of the machine with these overrides."""
    overrides = {"stops.jaw.restitution": 0.25}
    case = Case(speed_rpm=612.5)
    optimum: Any = SimpleNamespace(
        problem=SimpleNamespace(model="e62"), overrides=overrides, case=case,
        record=lambda: {"result": 1},
    )  # fmt: skip
    result, told, stored = write_optimum(optimum, tmp_path / "out")
    assert [item.name for item in (result, told, stored)] == [
        "result.json", "overrides.json", "case.json",
    ]  # fmt: skip
    assert json.loads(result.read_text(encoding="utf-8")) == {"result": 1}
    assert json.loads(told.read_text(encoding="utf-8")) == overrides
    text = stored.read_text(encoding="utf-8")
    assert "612.5" in text
    assert e62.name in text
    assert "0.25" in text


def test_meshes_that_cannot_be_read(tmp_path: Path) -> None:
    file = tmp_path / "horn.stl"
    for name, text, words in (
        ("horn.stl", None, "the mesh cannot be read"),
        ("horn.xyz_", "nothing", "mesh = .* a mesh as STL, OBJ or DAE"),
    ):
        file = tmp_path / name
        if text is not None:
            file.write_text(text, encoding="utf-8")
        solid: Any = SimpleNamespace(path=file, kind="mesh")
        with pytest.raises(InputError, match=f"{name}: {words}") as caught:
            shapes.shape(solid)
        assert Path(str(caught.value.evidence["file"])).name == name


@pytest.mark.parametrize(
    ("kind", "sizes", "wanted"),
    [
        ("box", (0.2, 0.4, 0.6), (0.2, 0.4, 0.6)),
        ("sphere", (0.25,), (0.5, 0.5, 0.5)),
        ("cylinder", (0.25, 0.8), (0.5, 0.5, 0.8)),
    ],
)
def test_plain_solids_as_meshes(kind: str, sizes: Any, wanted: Any) -> None:
    """Extents of a box, twice the radius of a ball, and the length of a cylinder along z."""
    solid: Any = SimpleNamespace(path=None, kind=kind, sizes=sizes)
    assert shapes.shape(solid).extents == pytest.approx(wanted, rel=6e-3)


# The live page's server.


class Viser:
    """A server that takes another port than it is asked for."""

    def __init__(self, port: int) -> None:
        self.port, self.stopped = port, 0

    def get_port(self) -> int:
        return self.port

    def stop(self) -> None:
        self.stopped += 1
        # It announces that on stdout, which belongs to the command.
        print("viser stops")


@pytest.mark.parametrize(("asked", "given"), [(8123, 8124), (8123, 8123), (0, 8124)])
def test_ports_of_the_live_page(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], asked: int, given: int
) -> None:
    """Another port than the one that is named is refused, and its server ended."""
    made = Viser(given)
    monkeypatch.setattr(serve.viser, "ViserServer", lambda **_: made)
    monkeypatch.setattr(serve.socket, "socket", lambda: Trial())
    if asked in (0, given):
        assert serve._server(asked) is made
        assert made.stopped == 0
        return
    with pytest.raises(InputError, match=r"port 8123 cannot be used \(another") as caught:
        serve._server(asked)
    assert caught.value.evidence == {"port": 8123}
    assert made.stopped == 1
    assert capsys.readouterr().out == ""


class Trial:
    """A socket that can be bound to any port."""

    def __enter__(self) -> Trial:
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing is held."""

    def setsockopt(self, *_: object) -> None:
        """Nothing is set."""

    def bind(self, place: tuple[str, int]) -> None:
        assert place[0] == serve.HOST


# Names and units.


# Texts of a run.


def printed(write: Callable[[Console], None]) -> str:
    stream = io.StringIO()
    write(Console(file=stream, width=300))
    return stream.getvalue()


@pytest.mark.parametrize(
    ("holds", "turns"), [(False, ""), (False, "do it"), (True, ""), (None, "")]
)
def test_transitions_that_no_turn_has(holds: bool | None, turns: str) -> None:
    """With the command that finds those of turns, or how to find them."""
    solution: Any = SimpleNamespace(premise_holds=holds, premise=SimpleNamespace(why="It is late."))
    text = printed(lambda console: lead.premise(solution, console, turns))
    if holds is not False:
        assert text == ""
        return
    first, *rest = text.splitlines()
    assert first == "No turn has this transition: It is late."
    assert rest == (
        ["The one that turns have:", turns] if turns
        else ["The one that turns have is found by simulating them (window cycle)."]
    )  # fmt: skip


def test_runs_without_motion_have_no_shaft_speeds() -> None:
    """Nor a table of them."""
    solution: Any = SimpleNamespace(
        segments=[], case=SimpleNamespace(window=Window.TRANSITION, cycles=1),
        mechanism=SimpleNamespace(drives=[SimpleNamespace(name="a", index=0)]),
    )  # fmt: skip
    assert sampling.shaft_rates(solution) == {}
    assert printed(lambda console: remarks.shafts(solution, console)) == ""


# Pictures.


def test_gaps_that_cannot_be_drawn_larger(
    transition: Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    q, t = np.zeros((2, 7)), np.zeros(2)
    assert film.exaggerated(transition, t, q, 1.0) is q

    def fails(*_: Any) -> Any:
        message = "a dead centre"
        raise SingularConfigurationError(message)

    monkeypatch.setattr(film, "close_positions", fails)
    words = "gap of stop jaw cannot be drawn 12 times as large, .* .a dead centre.; use a smaller"
    with pytest.raises(InputError, match=words) as caught:
        film.exaggerated(transition, t, q, 12.0)
    assert caught.value.evidence == {"exaggerate": 12.0}
    monkeypatch.setattr(film, "bouncing_stop", lambda _: None)
    with pytest.raises(InputError, match="e62 has no transition stop whose gap") as caught:
        film.exaggerated(transition, t, q, 12.0)
    assert caught.value.evidence == {"exaggerate": 12.0}


# Commands.


class Terminal(io.StringIO):
    """A stream that says whether it is a terminal."""

    def __init__(self, terminal: bool) -> None:
        super().__init__()
        self.terminal = terminal

    def isatty(self) -> bool:
        return self.terminal


@pytest.mark.parametrize(
    ("window", "cycles", "terminal", "shown"),
    [
        ("cycle", 2, True, False), ("cycle", 3, True, True), ("cycle", 3, False, False),
        ("transition", 3, True, False),
    ],
)  # fmt: skip
def test_progress_of_turns(
    monkeypatch: pytest.MonkeyPatch, window: str, cycles: int, terminal: bool, shown: bool
) -> None:
    """From three turns on, and on a terminal alone."""
    monkeypatch.setattr(simulate_command.sys, "stderr", Terminal(terminal))
    with simulate_command._progress(Case(speed_rpm=1.0, window=window, cycles=cycles)) as bar:
        assert (bar is not None) is shown
        if bar is not None:
            bar(1, cycles)


@pytest.mark.parametrize("terminal", [True, False])
def test_what_a_benchmark_is_given(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, terminal: bool
) -> None:
    """A line for each part on a terminal, and the result where it is asked for."""
    asked: list[Any] = []
    result = SimpleNamespace(record=lambda: {"a": 1})

    def benchmark(**words: Any) -> Any:
        asked.append((words["quick"], words["repeats"]))
        words["say"]("engines")
        return result

    stderr = Terminal(terminal)
    monkeypatch.setattr("benchmarks.run_time.benchmark.benchmark", benchmark)
    monkeypatch.setattr("sys.stderr", stderr)
    file = tmp_path / "out.json"
    monkeypatch.setattr(
        "benchmarks.views.benchmark_report.print_benchmark",
        lambda *words: asked.append(words[0]),
    )
    options: Any = SimpleNamespace(quick=True, repeats=3, json=str(file), out=None)
    benchmark_command._run(options)
    assert asked == [(True, 3), result]
    assert stderr.getvalue() == ("engines ...\n" if terminal else "")
    assert json.loads(file.read_text(encoding="utf-8")) == {"a": 1}
    options.repeats = 0
    with pytest.raises(InputError, match="--repeats 0: at least 1") as caught:
        benchmark_command._run(options)
    assert caught.value.evidence == {"argument": 0}

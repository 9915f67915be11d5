"""Files and folders that views write and read, and branches that few machines take."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Callable
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from rich.console import Console

from benchmarks.commands import benchmark as benchmark_command
from benchmarks.views import benchmark_report
from nipper_pin import Case, Mechanism, Solution
from nipper_pin.cli import simulate as simulate_command
from nipper_pin.errors import InputError, SingularConfigurationError
from nipper_pin.hybrid.case import Window
from nipper_pin.study.identify.record import read_identification
from nipper_pin.study.optimise import write as write_optimum
from nipper_pin.view.live import serve, shapes
from nipper_pin.view.paper import files, kinematic_figures
from nipper_pin.view.paper.terms import terms
from nipper_pin.view.run import csv_tables, export, lead, remarks, sampling
from nipper_pin.view.studies import front_plot

# The package has a function of the same name.
film: Any = import_module("nipper_pin.view.scene.film")

# Folders.


@pytest.mark.parametrize("where", ["occupied", "occupied/below"])
def test_folders_that_cannot_be_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, where: str
) -> None:
    """By any of those that write folders: said with the reason, and nothing is written."""
    (tmp_path / "occupied").write_text("mine", encoding="utf-8")
    target = tmp_path / where
    study = made_up_study(monkeypatch)
    anything: Any = SimpleNamespace()
    for act in (
        lambda: export.export(anything, target),
        lambda: benchmark_report.write_benchmark(anything, target),
        lambda: files.write_paper(study, target),
        lambda: write_optimum(anything, target),
    ):
        with pytest.raises(InputError, match=r"not a folder|cannot be made a folder") as caught:
            act()
        assert caught.value.evidence == {"folder": str(target)}
    assert (tmp_path / "occupied").read_text(encoding="utf-8") == "mine"


def made_up_study(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A study of one figure and one table."""
    plate = SimpleNamespace(name="figure", svg="<svg/>", pdf=b"pdf")
    sheet = SimpleNamespace(name="table", csv_text=lambda: "a,b\n")
    given: list[Any] = []

    def material(*words: Any) -> Any:
        given.append(words)
        return SimpleNamespace(plates=[plate], tables=[sheet])

    monkeypatch.setattr(files, "study_plates", lambda study, _: f"plates of {study.name}")
    monkeypatch.setattr(files, "material", material)
    monkeypatch.setattr(files, "report_html", lambda *words: f"page of {len(words)}")
    return SimpleNamespace(name="study", record=lambda: {"a": 1}, given=given)


@pytest.mark.parametrize("more", [True, False])
def test_files_of_the_study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, more: bool) -> None:
    """The page first; sensitivities stand in the document where they were asked for."""
    study = made_up_study(monkeypatch)
    found = SimpleNamespace(record=lambda: {"b": 2})
    added: Any = SimpleNamespace(
        sensitivities=found if more else None,
        designer=SimpleNamespace(record=lambda: {"c": 3}) if more else None,
    )
    target = tmp_path / "new" / "folder"
    written = files.write_paper(study, target, lambda: added)
    names = ["report.html", "study.json", "figure.svg", "figure.pdf", "table.csv"]
    assert written == [target / name for name in names]
    texts = {name: (target / name).read_bytes() for name in names}
    document = json.loads(texts.pop("study.json"))
    assert document.pop("files") == {name: sha256(text).hexdigest() for name, text in texts.items()}
    assert document == {
        "a": 1,
        **({"sensitivities": {"b": 2}, "designer": {"c": 3}} if more else {}),
    }
    assert texts == {
        "report.html": b"page of 3", "figure.svg": b"<svg/>", "figure.pdf": b"pdf",
        "table.csv": b"a,b\n",
    }  # fmt: skip
    assert study.given == [(study, added, "plates of study")]


def test_files_of_an_earlier_study_go(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its document names them; of what it cannot have written nothing is touched."""
    study = made_up_study(monkeypatch)
    added: Any = SimpleNamespace(sensitivities=None, designer=None)
    target, outside = tmp_path / "folder", tmp_path / "outside.csv"
    files.write_paper(study, target, lambda: added)
    for name in ("earlier.svg", "edited.svg", "notes.txt", "../outside.csv"):
        (target / name).write_text("text", encoding="utf-8")
    document = json.loads((target / "study.json").read_bytes())
    theirs, other = sha256(b"text").hexdigest(), sha256(b"before it was edited").hexdigest()
    document["files"] |= {"edited.svg": other, "..": theirs, "": theirs} | dict.fromkeys(
        ("earlier.svg", "../outside.csv", "absent.csv"), theirs
    )
    (target / "study.json").write_text(json.dumps(document), encoding="utf-8")
    written = files.write_paper(study, target, lambda: added)
    assert {item.name for item in target.iterdir()} == {
        "edited.svg",
        "notes.txt",
        *(item.name for item in written),
    }
    assert outside.read_text(encoding="utf-8") == "text"
    (target / "study.json").write_text('{"files": [1, {}]}', encoding="utf-8")
    files.write_paper(study, target, lambda: added)


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


def test_documents_that_are_no_identifications(tmp_path: Path) -> None:
    file = tmp_path / "x.json"
    for text in ("[]", "{}", '{"goodness": 1}'):
        file.write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match="is no identification") as caught:
            read_identification(file)
        assert caught.value.evidence == {"file": str(file)}
    file.write_text("{", encoding="utf-8")
    with pytest.raises(InputError, match="cannot be read as JSON") as caught:
        read_identification(file)
    assert caught.value.evidence == {"file": str(file)}


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


@pytest.mark.parametrize(
    ("unit", "wanted"),
    [
        ("rad", ("flap angle", "deg", "rad/s", "rad/s²", 57.0, 1.0)),
        ("m", ("stroke s", "deg", "m/s", "m/s²", 57.0, 1.0)),
    ],
)
def test_the_other_stop_of_the_kinematic_figure(unit: str, wanted: Any) -> None:
    words: Any = SimpleNamespace(
        stop="flap", stroke_si=unit, stroke=SimpleNamespace(unit="deg", factor=57.0)
    )
    assert kinematic_figures._other_stop(words) == wanted


@pytest.mark.parametrize("compared", [True, False])
@pytest.mark.parametrize("spring", ["revolute", "prismatic"])
def test_terms_of_a_machine(spring: str, compared: bool) -> None:
    """Units of its spring and of the stroke of its other stop, and whose numbers they are."""
    mechanism = SimpleNamespace(
        joints=[SimpleNamespace(index=0, kind=spring), SimpleNamespace(index=1, kind="revolute")],
        springs=[SimpleNamespace(index=0)],
        stops=[],
        shortcuts={},
        stop=lambda name: SimpleNamespace(name=name, index=1 if name == "flap" else 0),
    )
    for stop, kind in (("flap", "revolute"), ("own", spring)):
        study: Any = SimpleNamespace(
            mechanism=mechanism, phase_one=SimpleNamespace(stop=stop), compared=compared
        )
        found = terms(study)
        assert (found.compared, found.stop) == (compared, stop)
        assert found.stroke_si == ("rad" if kind == "revolute" else "m")
        assert found.stroke.unit == ("deg" if kind == "revolute" else "mm")
        assert found.lift.unit == ("mdeg" if kind == "revolute" else "um")
        told = (found.rate_si, found.rate.factor, found.rate.unit, found.preload_kind,
                found.preload.factor, found.preload.unit)  # fmt: skip
        assert told == (
            ("N_m_per_rad", 1.0, "N m/rad", "angle", pytest.approx(180.0 / math.pi), "deg")
            if spring == "revolute"
            else ("N_per_m", 1e-3, "N/mm", "length", 1e3, "mm")
        )
        assert ("published ratios" in found.mark) is compared
        assert found.of_paper("figure 3") == (" (figure 3 of the paper)" if compared else "")


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


def test_forces_that_are_not_known_have_no_range(monkeypatch: pytest.MonkeyPatch) -> None:
    """The least and the largest of each phase and stop, of all its intervals together."""
    closed, other = frozenset({"b", "a"}), frozenset({"c"})
    phases = [SimpleNamespace(closed=item, t_start=n, t_end=n + 1) for n, item in
              enumerate([closed, other, closed])]  # fmt: skip
    forces = {
        ("a", 0): [3.0, 1.0, 2.0], ("a", 2): [5.0, np.nan, 0.5], ("b", 0): [np.nan] * 3,
        ("b", 2): [np.nan, -4.0, -1.0], ("c", 1): [np.nan] * 3,
    }  # fmt: skip
    monkeypatch.setattr(sampling, "shown_phases", lambda _: phases)
    monkeypatch.setattr(sampling, "shown_until", lambda _: 3)
    monkeypatch.setattr(
        sampling,
        "sample_forces",
        lambda _, start, end: {
            stop: (10.0 * start + np.arange(3.0), np.array(values))
            for (stop, number), values in forces.items()
            if start <= number < end
        },
    )
    run: Any = None
    found = [(item.closed, item.stop, item.lowest, item.t_lowest, item.highest, item.t_highest)
             for item in sampling.force_ranges(run)]  # fmt: skip
    assert found == [
        (closed, "a", 0.5, 22.0, 5.0, 20.0), (closed, "b", -4.0, 21.0, -1.0, 22.0),
    ]  # fmt: skip


def test_motion_of_a_run_leaves_empty_stretches_out(
    transition: Solution,
) -> None:
    """A segment that has no length has no rows."""
    header, rows = csv_tables._motion(transition)
    wanted = list(rows)
    empty = SimpleNamespace(t_start=0.5, t_end=0.5)
    more: Any = SimpleNamespace(
        mechanism=transition.mechanism, trajectory=transition.trajectory, shaft=transition.shaft,
        segments=[empty, *transition.segments],
    )  # fmt: skip
    again, found = csv_tables._motion(more)
    assert again == header
    assert [row[:3] for row in found] == [row[:3] for row in wanted]
    assert all(len(row) == len(header) for row in wanted)


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
    monkeypatch.setattr(benchmark_command.sys, "stderr", stderr)
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


def test_documents_of_identifications(tmp_path: Path) -> None:
    """Taken with more keys than are needed; not without one of them, wherever it is missing."""
    target = dict.fromkeys(
        ("name", "wanted", "sigma", "found", "relative_deviation", "residual_sigmas", "outlier"), 1
    )
    parameter = dict.fromkeys(
        ("path", "low", "high", "before", "identified", "standard_deviation",
         "standard_deviation_scaled", "range_left", "determined"), 1
    )  # fmt: skip
    whole: dict[str, Any] = dict.fromkeys(
        ("title", "model", "caution", "seed", "within_4_percent", "within_10_percent",
         "singular_values", "identifiable_directions", "profiles"), 1
    )  # fmt: skip
    whole |= {
        "targets": [target, {**target, "more": 2}], "parameters": [parameter],
        "goodness": {"verdict": "agrees", "sentence": "It agrees.", "more": 2}, "more": 3,
    }  # fmt: skip
    file = tmp_path / "x.json"

    def reads(document: Any) -> bool:
        file.write_text(json.dumps(document), encoding="utf-8")
        try:
            return bool(read_identification(file) == document)
        except InputError:
            return False

    assert reads(whole)
    assert reads({**whole, "targets": []})
    for key in ("targets", "parameters"):
        (row, *_) = whole[key]
        for name in row:
            assert not reads({**whole, key: [row, {k: row[k] for k in row if k != name}]}), name
        for other in (None, {}, [1], [[]]):
            assert not reads({**whole, key: other})
    for name in ("verdict", "sentence"):
        assert not reads({**whole, "goodness": {name: "x"}})
    assert not reads({**whole, "goodness": []})
    for name in ("title", "model", "caution", "seed", "within_4_percent", "goodness",
                 "singular_values", "identifiable_directions", "profiles", "targets",
                 "parameters"):  # fmt: skip
        assert not reads({k: value for k, value in whole.items() if k != name}), name

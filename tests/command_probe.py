"""One run of the command: its calls of the library, its files and its output.

The studies themselves are replaced by stand-ins that answer at once and note every argument by its
name; ``simulate`` and everything that it writes are real.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import inspect
import io
import json
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from programs import PARSERS, main

from benchmarks.stress import Campaign
from nipper_pin import Mechanism, Solution, load_solution
from nipper_pin.study.next_steps import NextSteps

Facts = dict[str, Any]
_PLAIN = (str, int, float, Path, type(None))


def options() -> Iterator[tuple[str, argparse.Action]]:
    """Every option and argument of every command, as the parsers themselves know them."""
    for parser in PARSERS:
        yield from _options(parser, "")


def _options(parser: argparse.ArgumentParser, name: str) -> Iterator[tuple[str, argparse.Action]]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for word, inner in action.choices.items():
                yield from _options(inner, f"{name} {word}".strip())
        elif not isinstance(action, argparse._HelpAction):
            for written in action.option_strings or [str(action.metavar or action.dest)]:
                yield f"{name} {written}", action


def facts(value: object, name: str) -> Facts:
    """The leaves of a value by their paths; machines are their texts."""
    if isinstance(value, Solution):
        parts = {"case": value.case, "mechanism": value.mechanism}
    elif isinstance(value, Mechanism):
        parts = {"name": value.name, "urdf": value.urdf, "description": value.description}
    elif isinstance(value, Mapping):
        parts = dict(value)
    elif isinstance(value, np.ndarray):
        return {name: value.tolist()}
    elif is_dataclass(value) and not isinstance(value, type):
        parts = {item.name: getattr(value, item.name) for item in fields(value)}
    elif isinstance(value, list | tuple):
        parts = {str(place): item for place, item in enumerate(value)}
    else:
        value = value.value if isinstance(value, Enum) else value
        # What stands in for a result, a console and the like is no setting.
        return {name: value} if isinstance(value, _PLAIN) else {}
    return {
        path: leaf
        for key, item in parts.items()
        for path, leaf in facts(item, f"{name}.{key}").items()
    }


class Probe:
    """Runs commands, each in a folder of its own, and notes what becomes of their arguments."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
        self._patch, self._folder, self._runs = monkeypatch, folder, 0
        self._asked: Facts = {}

    def stand_in(self, place: str, answer: Callable[..., Any] | None = None) -> None:
        """Note the calls of a function; it answers itself, or by what stands in for it."""
        module, _, name = place.rpartition(".")
        room = importlib.import_module(module)
        real = getattr(room, name)
        signature = inspect.signature(real)

        def called(*arguments: Any, **named: Any) -> Any:
            bound = signature.bind(*arguments, **named)
            bound.apply_defaults()
            self._asked |= {f"{name} called": True, **facts(bound.arguments, name)}
            return (real if answer is None else answer)(*arguments, **named)

        self._patch.setattr(room, name, called)

    def run(self, words: list[str]) -> Facts:
        """Facts of one run, which has to end with status 0."""
        self._runs += 1
        home = self._folder / str(self._runs)
        home.mkdir()
        self._asked = {}
        out, err = io.StringIO(), io.StringIO()
        before = Path.cwd()
        os.chdir(home)
        try:
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                status = main(words)
        finally:
            os.chdir(before)
        assert (status, err.getvalue()) == (0, ""), err.getvalue()
        # These write into a folder that is named at the end; its name is among the files.
        for name in ("plot_solution.folder", "write.folder", "plot_front.path"):
            self._asked.pop(name, None)
        return {**self._asked, **_printed(out.getvalue()), **_written(home)}


def _printed(text: str) -> Facts:
    """What stood on stdout: a document, or lines."""
    with contextlib.suppress(ValueError):
        return {"stdout": "document", **_document(json.loads(text), "document")}
    return {"stdout": "lines" if text else "nothing", "forces": "stop force" in text}


def _written(home: Path) -> Facts:
    """Files by their names; of saved cases, runs and documents what stands in them."""
    found: Facts = {}
    for path in sorted(item for item in home.rglob("*") if item.is_file()):
        name = path.relative_to(home).as_posix()
        found[f"file {name}"] = True
        if path.name == "case.json":
            found |= facts(json.loads(path.read_text(encoding="utf-8")), "saved case")
        elif path.suffix == ".npz":
            found |= facts(load_solution(path), "saved run")
        elif path.suffix == ".json":
            found |= _document(json.loads(path.read_text(encoding="utf-8")), f"in {name}")
    return found


def _document(document: Any, name: str) -> Facts:
    """A document of a run without the time that it took."""
    return {key: value for key, value in facts(document, name).items() if "wall_s" not in key}


def stand_ins(probe: Probe) -> None:
    """Stand-ins of everything that takes long, serves or draws.

    All modules are imported before the first name is replaced: one that is imported later would
    keep the stand-in of a name that it binds, for all tests that follow in this process.
    """
    for note in (_imported, probe.stand_in):
        _note_all(note)


def _imported(place: str, _answer: Callable[..., Any] | None = None) -> None:
    importlib.import_module(place.rpartition(".")[0])


def _note_all(note: Callable[..., None]) -> None:
    done = {"done": "well"}
    note("nipper_pin.cli.simulate.simulate")
    note("nipper_pin.hybrid.simulate.simulate")
    note("nipper_pin.hybrid.files.npz.load_solution")
    note("nipper_pin.mechanism.skeleton.write_skeleton")
    note("nipper_pin.mechanism.drawing.write_drawing")
    note("nipper_pin.view.run.export.plot_solution", _drawn)
    report = SimpleNamespace(record=lambda: done)
    note("nipper_pin.study.check.check_model", lambda *_: report)
    note("nipper_pin.study.next_steps.next_steps", lambda *_: NextSteps((), ("next",)))
    note("nipper_pin.view.studies.check_report.print_report", lambda *_, **__: None)
    note("nipper_pin.view.sketch.write_sketch", lambda _machine, path: Path(path).touch())
    _views(note)
    _comparisons(note, report)
    _studies(note, done, report)


def _drawn(_solution: object, folder: str | Path) -> list[Path]:
    """A picture, where the plots are to be."""
    (Path(folder) / "drawn.png").touch()
    return [Path(folder) / "drawn.png"]


def _views(note: Callable[..., None]) -> None:
    note("nipper_pin.view.scene.film", lambda *_: None)
    note("nipper_pin.view.scene.page.scene_page", lambda *_: "page")
    note("nipper_pin.view.scene.server.serve", lambda *_, **__: None)
    note("nipper_pin.view.scene.page.write_page", lambda _run, file, _look: Path(file).touch())
    note("nipper_pin.view.scene.gif.write_gif", lambda _run, file, _look: Path(file).touch())
    note("nipper_pin.view.live.serve.serve_live", lambda *_, **__: None)
    note("nipper_pin.view.studies.sweep_plots.plot_sweep", lambda *_, **__: [Path("drawn.svg")])


def _comparisons(note: Callable[..., None], report: SimpleNamespace) -> None:
    compared = SimpleNamespace(
        b=SimpleNamespace(case=SimpleNamespace(speed_rpm=450.0)), **vars(report)
    )
    note("nipper_pin.cli.compare.compare", lambda *_: compared)
    note("nipper_pin.view.compare.table.print_comparison", lambda *_, **__: None)
    note("nipper_pin.view.compare.page.write_comparison",
         lambda _comparison, file, _look: Path(file).touch())  # fmt: skip
    note("nipper_pin.view.compare.page.comparison_page", lambda *_: "page")
    note("nipper_pin.view.compare.files.write_files",
         lambda _comparison, folder: _write(Path(folder) / "table.json", {}))  # fmt: skip


def _studies(note: Callable[..., None], done: dict[str, str], report: SimpleNamespace) -> None:
    note("benchmarks.paper.study.paper_study", lambda *_: report)
    note("benchmarks.paper.report.write_paper",
         lambda _study, folder: _write(Path(folder) / "paper.json", done))  # fmt: skip
    note("benchmarks.paper.report.print_paper", lambda *_: None)
    limit = SimpleNamespace(record=lambda: done, settled=(),
                            speed_rpm=np.array([300.0, 500.0]))  # fmt: skip
    note("nipper_pin.study.speed_limit.speed_limit", lambda *_, **__: limit)
    note("nipper_pin.view.studies.speed_limit_plot.plot_speed_limit",
         lambda _result, path: _write(Path(path), done))  # fmt: skip
    note("nipper_pin.view.studies.speed_limit_plot.check_figure", lambda _: "json")
    note("nipper_pin.view.studies.speed_limit_report.print_speed_limit", lambda *_: None)
    note("benchmarks.run_time.benchmark.benchmark", lambda **_: report)
    note("benchmarks.views.benchmark_report.write_benchmark",
         lambda _result, folder: _write(Path(folder) / "all.json", done))  # fmt: skip
    note("benchmarks.views.benchmark_report.print_benchmark", lambda *_: None)
    note("benchmarks.stress.run_campaign", lambda _cases, seed, *_: Campaign(seed, (), 0.0))
    note("benchmarks.views.stress_report.print_campaign", lambda *_: None)
    swept = SimpleNamespace(scenarios=3, folder="folder", found=0, computed=3, wall_s=0.0,
                            record=lambda: done, sentences=list, check=lambda: None,
                            extremes=SimpleNamespace(sentences=list))  # fmt: skip
    expected = SimpleNamespace(record=lambda: done, sentence=lambda: "soon")
    note("nipper_pin.study.sweep.estimate.estimate", lambda *_: expected)
    note("nipper_pin.study.sweep.run_sweep", lambda *_, **__: swept)
    optimum = SimpleNamespace(front=("one", "two"), record=lambda: done, contradiction="")
    note("nipper_pin.study.optimise.optimise", lambda *_, **__: optimum)
    note("nipper_pin.study.optimise.write",
         lambda _optimum, folder: _write(Path(folder) / "result.json", done))  # fmt: skip
    note("nipper_pin.view.studies.front_plot.plot_front",
         lambda _optimum, file: _write(Path(file), {})[0])  # fmt: skip
    note("nipper_pin.view.studies.optimise_report.print_optimum", lambda *_: None)
    known = SimpleNamespace(ranked=lambda: [("a", 1), ("b", 2), ("c", 3)])
    fit = SimpleNamespace(known=known, goodness=SimpleNamespace(), check=lambda: None)
    note("nipper_pin.study.identify.identify", lambda *_, **__: fit)
    note("nipper_pin.study.identify.profile", lambda _fit, path, **_: path)
    note("nipper_pin.study.identify.write_model", lambda *_: None)
    note("nipper_pin.study.identify.record", lambda *_: done)
    note("nipper_pin.view.studies.identify_report.print_fit", lambda *_: None)


def _write(file: Path, document: Facts) -> list[Path]:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(document), encoding="utf-8")
    return [file]

"""Every option of every command changes exactly the setting that it names, and no other.

What is looked at is the call of the library in which a setting ends; the command ends there, too.
An option that is in a parser and neither in the table nor among those told elsewhere fails here.
"""

from __future__ import annotations

import argparse
import contextlib
import inspect
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from enum import Enum
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from programs import PARSERS, main

from nipper_pin import Case, Mechanism, Solution, load, save, save_case, simulate

Facts = dict[str, Any]
GONE = "gone"
"""The fact that is there without the option is not there with it."""


@dataclass(frozen=True)
class Entry:
    """One option.

    Attributes:
        words: What is added to the command line.
        effect: All arguments of the call that change, with their values.
        base: The rest of the command line, after the command.
        moves: Beginnings of arguments that have to change, by as much as the library decides.
        at: The calls, where it is not the one of the command.
        without: What stands for the words in a line that cannot do without them.
    """

    words: str
    effect: Facts = field(default_factory=dict)
    base: str = ""
    moves: tuple[str, ...] = ()
    at: tuple[str, ...] = ()
    without: str = ""


# The call of each command.
CALLS = {
    "simulate": "nipper_pin.cli.simulate.simulate",
    "view": "nipper_pin.view.show.write_page",
    "compare": "nipper_pin.cli.compare.compare",
    "live": "nipper_pin.view.live.serve.serve_live",
    "new": "nipper_pin.mechanism.skeleton.write_skeleton",
    "export": "nipper_pin.mechanism.export.export",
    "check": "nipper_pin.study.check.check_model",
    "paper": "benchmarks.paper.study.paper_study",
    "levers": "nipper_pin.study.levers.levers",
    "speed-limit": "nipper_pin.study.speed_limit.speed_limit",
    "identify": "nipper_pin.study.identify.identify",
    "optimise": "nipper_pin.study.optimise.optimise",
    "sweep": "nipper_pin.study.sweep.run_sweep",
    "plot": "nipper_pin.view.studies.sweep_plots.plot_sweep",
    "stress": "benchmarks.stress.run_campaign",
    "run": "benchmarks.run_time.benchmark.benchmark",
}
SERVE = "nipper_pin.view.scene.server.serve"
PENDULUM = "hanging_pendulum"
TURNS, PAGE, BRIEF = "--window cycle", "--window transition --html a.html", "--window transition"


def of_a_model(*places: str, base: str = "") -> dict[str, Entry]:
    """Options that change a number of a model, for a command that asks ``places`` of one."""
    return {
        name: Entry(words, {f"{place}.description.{path}": value for place in places}, base)
        for name, words, path, value in (
            ("--set", "--set preload=9.25", "springs.steeve.preload_length_mm", 9.25),
            ("--restitution", "--restitution 0.1", "stops.jaw.restitution", 0.1),
            ("--stiffness", "--stiffness 11000", "springs.steeve.stiffness_N_per_m", 11000.0),
        )
    }


def another_model(place: str, name: str = PENDULUM, **more: Any) -> Entry:
    """The argument that names a model."""
    changed = {f"{place}.mechanism.name": name, **{f"{place}.{key}": more[key] for key in more}}
    return Entry(name, changed, moves=(f"{place}.mechanism.",))


def case(words: str, key: str, value: object, base: str = "") -> Entry:
    """One field of the case that is simulated."""
    return Entry(words, {f"simulate.case.{key}": value}, base)


SIMULATE = {
    "MODEL": another_model("simulate", **{"case.speed_rpm": 220.0}),
    **of_a_model("simulate.mechanism"),
    "--speed": case("--speed 500", "speed_rpm", 500.0),
    "--window": case("--window cycle", "window", "cycle"),
    "--start-index": case("--start-index 20", "start_index", 20.0, TURNS),
    "--cycles": case("--cycles 2", "cycles", 2, TURNS),
    "--drive": case("--drive inertial", "drive", "inertial"),
    "--rest-rate": case("--rest-rate 0.5", "rest_rate", 0.5),
    "--tolerance": case("--tolerance 1e-6", "resolution.tolerance", 1e-6),
    "--no-reuse": case("--no-reuse", "reuse_cycles", False, f"{TURNS} --cycles 3"),
    "--reuse": case("--reuse", "reuse_cycles", True, f"{TURNS} --cycles 3 --no-reuse"),
    "--case": case("--case {case}", "speed_rpm", 620.0),
    "--forces": Entry("--forces", {"print_solution.with_forces": True},
                      moves=("print_solution.",), at=("nipper_pin.view.run.print_solution",)),
    "--out": Entry("--out run", {"export.folder": "run"}, without="--out a",
                   at=("nipper_pin.view.run.export.export",)),
    "--units": Entry("--units mm", {"export.units": "mm"}, "--out a",
                     at=("nipper_pin.view.run.export.export",)),
}  # fmt: skip
VIEW = {
    "MODEL": Entry(PENDULUM, {"write_page.shown.mechanism.name": PENDULUM,
                              "write_page.shown.case.speed_rpm": 220.0}, PAGE,
                   ("write_page.shown.mechanism.",)),
    **of_a_model("write_page.shown.mechanism", base=PAGE),
    "--speed": Entry("--speed 500", {"write_page.shown.case.speed_rpm": 500.0}, PAGE),
    "--window": Entry(BRIEF, {"write_page.shown.case.window": "transition"}, "--html a.html"),
    "--start-index": Entry("--start-index 20", {"write_page.shown.case.start_index": 20.0},
                           "--html a.html"),
    "--solution": Entry("--solution {run}", {"write_page.shown.case.speed_rpm": 620.0,
                                             "write_page.shown.case.window": "transition"},
                        "--html a.html"),
    "--slow": Entry("--slow 50", {"write_page.look.slow": 50.0}, PAGE),
    "--exaggerate": Entry("--exaggerate 7", {"write_page.look.exaggerate": 7.0}, PAGE),
    "--html": Entry("--html b.html", {"write_page.path": "b.html"}, BRIEF, without="--html a.html"),
    "--gif": Entry("--gif b.gif", {"write_gif.path": "b.gif"}, BRIEF, without="--gif a.gif",
                   at=("nipper_pin.view.scene.gif.write_gif",)),
    # Names inside of a page are drawn by lot.
    "--port": Entry("--port 7123", {"serve.port": 7123}, BRIEF, ("serve.page",), (SERVE,)),
    "--no-browser": Entry("--no-browser", {"serve.browser": False}, BRIEF, ("serve.page",),
                          (SERVE,)),
}  # fmt: skip
LIVE = {
    "MODEL": another_model("serve_live", speed_rpm=220.0),
    **of_a_model("serve_live.mechanism"),
    "--speed": Entry("--speed 500", {"serve_live.speed_rpm": 500.0}),
    "--port": Entry("--port 7123", {"serve_live.port": 7123}),
    "--no-browser": Entry("--no-browser", {"serve_live.browser": False}),
}


def sides(words: str, key: str, value: object, which: str = "ab", base: str = BRIEF) -> Entry:
    """One fact of both sides of a comparison, or of one."""
    return Entry(words, {f"compare.{side}.{key}": value for side in which}, base)


WRITE = "nipper_pin.view.show.write_page"
COMPARE = {
    "A": replace(sides(PENDULUM, "mechanism.name", PENDULUM), moves=("compare.",)),
    "B": replace(sides(PENDULUM, "mechanism.name", PENDULUM, "b", f"{BRIEF} e62"),
                 moves=("compare.b.",)),
    **of_a_model("compare.a.mechanism", "compare.b.mechanism", base=BRIEF),
    "--set-a": sides("--set-a speed=500", "case.speed_rpm", 500.0, "a"),
    "--set-b": sides("--set-b speed=500", "case.speed_rpm", 500.0, "b"),
    "--speed": sides("--speed 450 500", "case.speed_rpm", 500.0, "b"),
    "--window": sides(BRIEF, "case.window", "transition", base=""),
    "--start-index": sides("--start-index 20", "case.start_index", 20.0, base=""),
    "--cycles": sides("--cycles 2", "case.cycles", 2, base=""),
    "--drive": sides("--drive held inertial", "case.drive", "inertial", "b"),
    "--html": Entry("--html b.html", {"write_page.path": "b.html"}, BRIEF, at=(WRITE,),
                    without="--html a.html"),
    "--slow": Entry("--slow 50", {"write_page.look.slow": 50.0}, PAGE, at=(WRITE,)),
    "--exaggerate": Entry("--exaggerate 7", {"write_page.look.exaggerate": 7.0}, PAGE,
                          at=(WRITE,)),
    "--browser": Entry("--browser", {"serve.browser": True}, BRIEF, ("serve.",), at=(SERVE,)),
    "--out": Entry("--out here", {"write_files.folder": "here"}, BRIEF, without="--out a",
                   at=("nipper_pin.view.compare.files.write_files",)),
}  # fmt: skip
CHECK = {
    "MODEL": another_model("check_model", speed_rpm=220.0),
    **of_a_model("check_model.mechanism"),
    "--speed": Entry("--speed 500", {"check_model.speed_rpm": 500.0}),
    "--start-index": Entry("--start-index 20", {"check_model.start_index": 20.0}),
    "--provenance": Entry("--provenance", {"print_report.provenance": True},
                          at=("nipper_pin.view.studies.check_report.print_report",)),
    "--drawing": Entry("--drawing machine.svg", {"write_sketch.path": "machine.svg"},
                       without="--drawing a.svg", at=("nipper_pin.view.sketch.write_sketch",)),
}  # fmt: skip
NEW = {
    "MODEL": Entry("press", {"write_skeleton.target": "press"}, without="other"),
    "--list": Entry("--list", {"write_skeleton.target": GONE}, without="other"),
    "--from": Entry("--from toggle_press", {"new_model.target": "press"}, "press",
                    ("new_model.text", "write_skeleton."),
                    (CALLS["new"], "nipper_pin.mechanism.model_files.new_model")),
    "--urdf": Entry("--urdf a.urdf", {"take_urdf.urdf": "a.urdf", "take_urdf.folder": "press"},
                    "press", ("write_skeleton.",),
                    (CALLS["new"], "nipper_pin.mechanism.skeleton.exported.take_urdf")),
    "--study": Entry("--study sweep", {"write_study.study": "sweep", "write_study.target": "a"},
                     "a", ("write_skeleton.",),
                     (CALLS["new"], "nipper_pin.study.starts.write_study")),
}  # fmt: skip
EXPORT = {
    "MODEL": Entry("e62_identified mine", {"export.mechanism.name": "e62_identified"},
                   moves=("export.mechanism.",), without="e62 mine"),
    "FOLDER": Entry("e62 mine", {"export.folder": "mine"}, without="e62 other"),
    "--set": of_a_model("export.mechanism", base="e62 mine")["--set"],
}  # fmt: skip
PAPER = {
    "MODEL": another_model("paper_study", "e62_identified"),
    "--set": of_a_model("paper_study.mechanism")["--set"],
    "--out": Entry("--out run", {"check_outputs.folder": "run"}, without="--out a",
                   at=("benchmarks.commands.paper.check_outputs",)),
}  # fmt: skip
LEVERS = {
    "MODEL": another_model("levers"),
    **of_a_model("levers.mechanism"),
    "--speed": Entry("--speed 500", {"levers.speed_rpm": 500.0}),
}
SPEED_LIMIT = {
    "MODEL": another_model("speed_limit", "e62_identified"),
    "--set": of_a_model("speed_limit.mechanism")["--set"],
    "--from": Entry("--from 300", {"speed_limit.low_rpm": 300.0}),
    "--to": Entry("--to 700", {"speed_limit.high_rpm": 700.0}),
    "--speeds": Entry("--speeds 7", {"speed_limit.speeds": 7}),
    "--turns": Entry("--turns 9", {"speed_limit.turns": 9}),
    "--least-force": Entry("--least-force 5", {"speed_limit.least_force": 5.0}),
}  # fmt: skip
STRESS = {
    "--cases": Entry("--cases 3", {"run_campaign.cases": 3}),
    "--seed": Entry("--seed 7", {"run_campaign.seed": 7}),
    "--family": Entry("--family chain --family linkage", {
        "run_campaign.families.0": "chain", "run_campaign.families.1": "linkage"}),
    "--first": Entry("--first 5", {"run_campaign.first": 5}),
    "--workers": Entry("--workers 1", {"run_campaign.workers": 1}),
    "--out": Entry("--out run", {"begin.folder": "run"}, without="--out a",
                   at=("benchmarks.stress.begin",)),
    "--time-limit": Entry("--time-limit 50", {"run_campaign.time_limit_s": 50.0}),
}  # fmt: skip
IDENTIFY = {
    "PROBLEM.toml": Entry("{identify}", moves=("identify.problem.",)),
    "--seed": Entry("--seed 7", {"identify.seed": 7}, "{identify}"),
    "--starts": Entry("--starts 2", {"identify.starts": 2}, "{identify}"),
    "--workers": Entry("--workers 1", {"identify.workers": 1}, "{identify}"),
}
OPTIMISE = {
    "STUDY.toml": Entry("{other_optimise}", {"optimise.problem.title": "another one"},
                        moves=("optimise.problem.",), without="{optimise}"),
    "--seed": Entry("--seed 7", {"optimise.seed": 7}, "{optimise}"),
    "--starts": Entry("--starts 2", {"optimise.starts": 2}, "{optimise}"),
    "--points": Entry("--points 3", {"optimise.points": 3}, "{optimise}"),
    "--no-check": Entry("--no-check", {"optimise.check": False}, "{optimise}"),
    "--workers": Entry("--workers 1", {"optimise.workers": 1}, "{optimise}"),
}  # fmt: skip
SWEEP = {
    "STUDY.toml": Entry("{other_sweep}", {"run_sweep.folder": "out/other_sweep",
                                          "run_sweep.plan.title": "another one"},
                        without="{sweep}"),
    "--out": Entry("--out here", {"run_sweep.folder": "here"}, "{sweep}"),
    "--workers": Entry("--workers 1", {"run_sweep.workers": 1}, "{sweep}"),
    "--scheduler": Entry("--scheduler tcp://host:1", {"run_sweep.scheduler": "tcp://host:1"},
                         "{sweep}"),
    "--chunks": Entry("--chunks 1-4", {"run_sweep.chunks": GONE, "run_sweep.chunks.0": 1,
                                       "run_sweep.chunks.1": 4}, "{sweep}"),
    "--dry-run": Entry("--dry-run", {}, "{sweep}", ("estimate.", "run_sweep."),
                       (CALLS["sweep"], "nipper_pin.study.sweep.estimate.estimate")),
}  # fmt: skip
PLOT = {
    "DIR": Entry("elsewhere", {"plot_sweep.folder": "elsewhere"}, without="folder"),
    "--quantity": Entry("--quantity duration_s --quantity collisions", {
        "plot_sweep.quantities": GONE, "plot_sweep.quantities.0": "duration_s",
        "plot_sweep.quantities.1": "collisions"}, "folder"),
    "--x": Entry("--x restitution", {"plot_sweep.across": "restitution"}, "folder"),
    "--y": Entry("--y stiffness", {"plot_sweep.upwards": "stiffness"}, "folder"),
    "--format": Entry("--format png", {"plot_sweep.kind": "png"}, "folder"),
    "--out": Entry("--out here", {"plot_sweep.target": "here"}, "folder"),
}  # fmt: skip
BENCHMARK = {
    "--quick": Entry("--quick", {"benchmark.quick": True}),
    "--repeats": Entry("--repeats 7", {"benchmark.repeats": 7}),
    "--out": Entry("--out run", {"check_outputs.folder": "run"}, without="--out a",
                   at=("benchmarks.commands.benchmark.check_outputs",)),
}  # fmt: skip

TABLE = {
    f"{command} {option}": entry
    for command, entries in {
        "simulate": SIMULATE, "view": VIEW, "compare": COMPARE, "live": LIVE, "new": NEW,
        "export": EXPORT, "check": CHECK, "paper": PAPER, "levers": LEVERS,
        "speed-limit": SPEED_LIMIT,
        "identify": IDENTIFY, "optimise": OPTIMISE, "sweep": SWEEP, "plot": PLOT,
        "stress": STRESS, "run": BENCHMARK,
    }.items()
    for option, entry in entries.items()
}  # fmt: skip
# By what they write, in test_cli_endings.py, test_words.py and study/.
ELSEWHERE = {
    "identify --profiles", "identify --out", "optimise --out", "optimise --format",
    "speed-limit --plot", "--version", "check --watch",
}  # fmt: skip
STUDY = 'format = 1\nchunk = 2\ntitle = "{title}"\n[parameters.{name}]\nvalues = [0.1, 0.2, 0.3]\n'
DESIGN = """format = 1
title = "{title}"
{aims}
[parameters."{name}"]
low = 0.05
high = 0.3
"""
FIT = """format = 1
title = "fit"
model = "e62"
[parameters.restitution]
low = 0.05
high = 0.3
[[targets]]
name = "one"
quantity = "first_two_share"
at = { speed_rpm = 650.0 }
value = 0.8
sigma = 0.1
"""


def options(
    parsers: tuple[argparse.ArgumentParser, ...] = PARSERS, name: str = ""
) -> Iterator[tuple[str, argparse.Action]]:
    """Every option and argument of every command, as the parsers themselves know them."""
    for parser in parsers:
        for action in parser._actions:
            if isinstance(action, argparse._SubParsersAction):
                for word, inner in action.choices.items():
                    yield from options((inner,), f"{word} ")
            elif not isinstance(action, argparse._HelpAction):
                for written in action.option_strings or [str(action.metavar or action.dest)]:
                    yield f"{name}{written}", action


def facts(value: object, name: str) -> Facts:
    """The leaves of a value by their paths; machines are their texts."""
    parts: Mapping[Any, Any]
    if isinstance(value, Solution):
        parts = {"case": value.case, "mechanism": value.mechanism}
    elif isinstance(value, Mechanism):
        parts = {"name": value.name, "urdf": value.urdf, "description": value.description}
    elif isinstance(value, Mapping):
        parts = value
    elif is_dataclass(value) and not isinstance(value, type):
        parts = {item.name: getattr(value, item.name) for item in fields(value)}
    elif isinstance(value, list | tuple):
        parts = dict(enumerate(value))
    else:
        value = value.value if isinstance(value, Enum) else value
        value = str(value) if isinstance(value, Path) else value
        # A console and what tells of progress are no settings.
        return {name: value} if isinstance(value, str | int | float | None) else {}
    found: Facts = {}
    for key, item in parts.items():
        found |= facts(item, f"{name}.{key}")
    return found


class ReachedError(Exception):
    """The call at which a command line ends."""


@cache
def asked(line: str, places: tuple[str, ...]) -> Facts:
    """The arguments of the first of these calls; none where none is reached.

    Many options have the line without them in common.
    """
    found: Facts = {}
    with pytest.MonkeyPatch.context() as patch:
        for place in places:
            module, _, name = place.rpartition(".")
            room = import_module(module)
            signature = inspect.signature(getattr(room, name))

            def called(
                *given: Any,
                signature: inspect.Signature = signature,
                name: str = name,
                **named: Any,
            ) -> None:
                bound = signature.bind(*given, **named)
                bound.apply_defaults()
                found.update(facts(bound.arguments, name))
                raise ReachedError

            patch.setattr(room, name, called)
        with contextlib.suppress(ReachedError):
            assert main(line.split()) == 0
    return found


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Files that command lines name."""
    home = tmp_path_factory.mktemp("inputs")
    mechanism, given = load("e62"), Case(speed_rpm=620.0)
    save_case(mechanism, given, home / "case.json")
    save(simulate(mechanism, given), home / "run.npz")
    aims = 'maximise = ["clamping_force_N", "stop_force_N"]'
    texts = {
        "identify": FIT,
        "sweep": STUDY.format(title="one", name="restitution"),
        "other_sweep": STUDY.format(title="another one", name='"stops.steeve.restitution"'),
        "optimise": DESIGN.format(title="one", name="restitution", aims=aims),
        "other_optimise": DESIGN.format(
            title="another one", name="stops.steeve.restitution", aims=aims
        ),
    }
    for name, text in texts.items():
        (home / f"{name}.toml").write_text(text, encoding="utf-8")
    return {path.stem: str(path) for path in home.iterdir()}


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("simulate --speed 450 --speed 500", "argument --speed: given twice; leave one out"),
        ("check --json a --json b", "argument --json: given twice; leave one out"),
        ("compare --speed 450 --speed 500", "argument --speed: given twice; leave one out"),
        ("compare --speed 450 520 600", "--speed: one for both or two, and these are 450 520 600"),
        ("compare --drive held held held", "--drive: one for both or two"),
    ],
)
def test_what_is_given_too_often_is_refused(
    line: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """None is taken for the name of a model, and none forgotten."""
    with pytest.raises(SystemExit) as ended:
        main(line.split())
    assert ended.value.code == 2
    assert said in capsys.readouterr().err


def around(name: str, inputs: dict[str, str]) -> tuple[Facts, Facts]:
    """What is asked without an option and with it."""
    entry, command = TABLE[name], name.rpartition(" ")[0]
    before, after = (
        asked(f"{command} {entry.base} {words}".format(**inputs), entry.at or (CALLS[command],))
        for words in (entry.without, entry.words)
    )
    return before, after


def test_every_option_is_in_the_table() -> None:
    names = [name for name, _ in options()]
    assert len(names) == len(set(names))
    # That of every command is in test_cli_endings.py and view/test_page.py.
    assert {name for name in names if not name.endswith(" --json")} == {*TABLE, *ELSEWHERE}
    assert all(entry.effect or entry.moves for entry in TABLE.values())


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("name", TABLE)
def test_an_option_changes_what_it_names(name: str, inputs: dict[str, str]) -> None:
    """Nothing that its entry does not name, and all that it names."""
    entry, (before, after) = TABLE[name], around(name, inputs)
    changed = {
        key: after.get(key, GONE)
        for key in {*before, *after}
        if key not in before or key not in after or before[key] != after[key]
    }
    free = {key for key in changed if key.startswith(entry.moves) and key not in entry.effect}
    assert {key: value for key, value in changed.items() if key not in free} == entry.effect
    for beginning in entry.moves:
        assert any(key.startswith(beginning) for key in free), f"{beginning} does not move"


DEFAULTS = {
    name: told[1]
    for name, action in options()
    if (told := re.search(r"\(default ([^ ,)]+)", action.help or ""))
}
"""What help says that an option is without it."""
# Of a folder, a quantity or a number of processors it says how it is found.
NAMED = re.compile(r"[0-9.e-]+|e62|svg|held|cycle|transition")


def test_help_says_every_default_of_a_parser() -> None:
    for name, action in options():
        value = action.default
        if value is argparse.SUPPRESS or isinstance(value, bool | list | None):
            continue
        assert DEFAULTS.get(name) == (value if isinstance(value, str) else f"{value:g}"), name


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(
    "name", [name for name, text in DEFAULTS.items() if NAMED.fullmatch(text) and name in TABLE]
)
def test_without_an_option_it_is_what_help_says(name: str, inputs: dict[str, str]) -> None:
    """Of all that the option changes, as numbers or as names."""
    text, (before, _) = DEFAULTS[name], around(name, inputs)
    kind, value = (str, text) if text[0].isalpha() else ((int, float), float(text))
    own = {before[key] for key in TABLE[name].effect if isinstance(before.get(key), kind)}
    assert {fact for fact in own if not isinstance(fact, bool)} <= {value}

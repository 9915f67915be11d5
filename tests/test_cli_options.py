"""Every option of every command changes exactly the setting that it names, and no other.

What is looked at is the call of the library in which a setting ends; the command ends there, too.
The reviewed texts have each option with a line without it and one with it, and say what changes in
the call; another call than that of the command stands behind the name of the option. An option that
is in a parser and neither there nor among those told elsewhere fails here.
"""

from __future__ import annotations

import argparse
import contextlib
import inspect
import re
import shutil
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from programs import PARSERS, STUDIES, main
from snapshots import Block, Words, blocks

from nipper_pin import Case, Mechanism, Solution, load, save, save_case, simulate
from nipper_pin.mechanism import known_models

Facts = dict[str, Any]
GONE = "gone"
# With more changes a machine is another one; longer texts, some drawn by lot, are not shown.
MANY, LONG = 8, 60

# The call of each command.
CALLS = {
    "simulate": "nipper_pin.cli.simulate.simulate",
    "view": "nipper_pin.view.show.write",
    "compare": "nipper_pin.cli.compare.compare",
    "live": "nipper_pin.view.live.serve.serve_live",
    "new": "nipper_pin.mechanism.skeleton.write_skeleton",
    "export": "nipper_pin.mechanism.export.export",
    "check": "nipper_pin.study.check.check",
    "paper": "benchmarks.paper.study.paper_study",
    "levers": "nipper_pin.study.levers.levers",
    "speed-limit": "nipper_pin.study.speed_limit.speed_limit",
    "identify": "nipper_pin.study.identify.identify",
    "optimise": "nipper_pin.study.optimise.optimise",
    "sweep": "nipper_pin.study.sweep.sweep",
    "plot": "nipper_pin.view.studies.sweep_plots.plot_sweep",
    "stress": "benchmarks.stress.run_campaign",
    "run": "benchmarks.run_time.benchmark.benchmark",
}
# Below the commands: options beside a saved case, and what the sides of a comparison may be.
TABLES = {
    name: blocks(__file__, f"test_an_option_changes_what_it_names[{name}]")
    for name in (*CALLS, "cases", "sides")
}
TABLE = {block.name.partition(":")[0]: block for name in CALLS for block in TABLES[name]}
# By what they write, in test_cli_endings.py, test_words.py, bench/ and study/.
ELSEWHERE = {
    "identify --profiles", "identify --out", "optimise --out", "optimise --format",
    "speed-limit --plot", "--version", "--print-completion", "check --watch", "sweep --csv",
    "sweep --units", "run --no-slower",
}  # fmt: skip


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
    home = Path(shutil.copytree(STUDIES, tmp_path_factory.mktemp("inputs"), dirs_exist_ok=True))
    mechanism, given = load("e62"), Case(speed_rpm=620.0)
    save_case(load("e62", {"preload": 10.5}), given, home / "case.json")
    turns = Case(speed_rpm=620.0, window="cycle", cycles=3, rest_rate=0.5, reuse_cycles=False)
    save_case(mechanism, turns, home / "turns.json")
    save(simulate(mechanism, given), home / "run.npz")
    (home / "out").mkdir()
    shutil.copy(home / "run.npz", home / "out" / "solution.npz")
    (home / "mine").mkdir()
    for suffix in ("toml", "urdf"):
        shutil.copy(known_models()["e62"] / f"e62.{suffix}", home / "mine" / f"mine.{suffix}")
    shutil.copy(STUDIES / "fit.toml", home / "identify.toml")
    return {path.stem: str(path) for path in home.iterdir()}


def around(block: Block, inputs: dict[str, str]) -> tuple[Facts, Facts]:
    """What is asked without an option and with it."""
    name, _, places = block.name.partition(": ")
    calls = tuple(places.split(", ")) if places else (CALLS[name.split()[0]],)
    before, after = (asked(line.format(**inputs), calls) for line in block.edits)
    return before, after


def test_every_option_is_in_a_table() -> None:
    names = [name for name, _ in options()]
    assert len(names) == len(set(names))
    # That of every command is in test_cli_endings.py and view/test_page.py.
    assert {name for name in names if not name.endswith(" --json")} == {*TABLE, *ELSEWHERE}


def changed(before: Facts, after: Facts) -> dict[str, tuple[Any, Any]]:
    """What differs; of a problem, a plan or a machine that is another one its name alone."""
    keys = [key for key in {**before, **after} if before.get(key, GONE) != after.get(key, GONE)]
    places = [re.match(r".*?\.(mechanism|problem|plan)\.", key) for key in keys]
    others = {key for key, count in Counter(x[0] for x in places if x).items() if count > MANY}
    return {
        key: (before.get(key, GONE), after.get(key, GONE))
        for key in keys
        if not key.startswith(tuple(others)) or key.endswith((".mechanism.name", ".problem.title"))
    }


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("command", TABLES)
def test_an_option_changes_what_it_names(
    command: str, inputs: dict[str, str], words: Words
) -> None:
    """Nothing that the reviewed text does not name, and all that it names."""
    text = ""
    for block in TABLES[command]:
        found = changed(*around(block, inputs))
        assert found, block.name
        text += block.text
        for key, pair in found.items():
            shown = (item if len(item) < LONG else "..." for item in map(str, pair))
            text += f"    {key}: {' -> '.join(shown)}\n"
    for name, path in inputs.items():
        text = text.replace(path, name)
    words(text, masked=False)


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
    text, (before, after) = DEFAULTS[name], around(TABLE[name], inputs)
    kind, value = (str, text) if text[0].isalpha() else ((int, float), float(text))
    own = {fact for fact, _ in changed(before, after).values() if isinstance(fact, kind)}
    assert {fact for fact in own if not isinstance(fact, bool) and fact != GONE} <= {value}

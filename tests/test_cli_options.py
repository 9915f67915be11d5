"""Every option of every command changes exactly the setting that it names, and no other.

An option that is in a parser and not in the table fails here, as does one of the table that is in
no parser.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import re
from pathlib import Path

import pytest
from command_probe import Facts, Probe, options, stand_ins
from option_table import GONE, TABLE, Entry
from programs import main

from benchmarks.stress import judge
from benchmarks.stress.space import trial
from nipper_pin import Case, load, save, save_case, simulate

# What a run computes: it follows from the settings, and moves with them.
COMPUTED = tuple(
    f"document.{key}" for key in ("collisions", "phases", "transition", "checks", "work", "outcome")
)
STUDY = 'format = 1\nchunk = 2\ntitle = "{title}"\n[parameters.{name}]\nvalues = [0.1, 0.2, 0.3]\n'
DESIGN = """format = 1
title = "{title}"
maximise = ["clamping_force_N", "stop_force_N"]
[parameters."{name}"]
low = 0.05
high = 0.3
"""
ASKED_FOR = {
    "optimise STUDY.toml": "{optimise}",
    "sweep STUDY.toml": "{sweep}",
    "plot DIR": "folder",
    "new MODEL": "other",
    "new --list": "other",
}
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


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Files that command lines name."""
    home = tmp_path_factory.mktemp("inputs")
    case = Case(speed_rpm=620.0)
    mechanism = load("e62")
    save_case(mechanism, case, home / "case.json")
    save(simulate(mechanism, case), home / "run.npz")
    texts = {
        "identify.toml": FIT,
        "sweep.toml": STUDY.format(title="one", name="restitution"),
        "other_sweep.toml": STUDY.format(title="another one", name='"stops.steeve.restitution"'),
        "optimise.toml": DESIGN.format(title="one", name="restitution"),
        "other_optimise.toml": DESIGN.format(title="another one", name="stops.steeve.restitution"),
        "identification.json": "read by a stand-in",
    }
    for name, text in texts.items():
        (home / name).write_text(text, encoding="utf-8")
    return {path.stem: str(path) for path in home.iterdir()}


def test_every_option_is_in_the_table() -> None:
    known = [name for name, _ in options()]
    assert len(known) == len(set(known))
    assert set(known) == set(TABLE)


@pytest.fixture(scope="module")
def without() -> dict[str, Facts]:
    """Facts of command lines without the option, which many options share."""
    return {}


@pytest.mark.parametrize("name", TABLE)
def test_an_option_changes_what_it_names(
    name: str,
    inputs: dict[str, str],
    without: dict[str, Facts],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    entry, command = TABLE[name], name.rpartition(" ")[0]
    probe = Probe(monkeypatch, tmp_path)
    stand_ins(probe)
    # The one argument that a command cannot do without is replaced, all else is added.
    line = f"{command} {entry.base} {ASKED_FOR.get(name, '')}"
    if line not in without:
        without[line] = probe.run(line.format(**inputs).split())
    after = probe.run(f"{command} {entry.base} {entry.words}".format(**inputs).split())
    check(entry, without[line], after, inputs)


def check(entry: Entry, before: Facts, after: Facts, inputs: dict[str, str]) -> None:
    """Refuse a change that the entry does not name, and one that it names and is not there."""
    expected = {
        key: value.format(**inputs) if isinstance(value, str) else value
        for key, value in entry.effect.items()
    }
    changed = {
        key: after.get(key, GONE)
        for key in {*before, *after}
        if key not in before or key not in after or before[key] != after[key]
    }
    free = {key for key in changed if key.startswith((*entry.moves, *COMPUTED))}
    named = {
        key: str(value) if isinstance(value, Path) else value
        for key, value in changed.items()
        if key in expected or key not in free
    }
    assert named == expected
    for beginning in entry.moves:
        assert any(key.startswith(beginning) for key in free), f"{beginning} does not move"


DEFAULTS = {
    name: found[1]
    for name, action in options()
    if (found := re.search(r"\(default ([^ ,)]+)", action.help or ""))
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


@pytest.mark.parametrize("name", [name for name, text in DEFAULTS.items() if NAMED.fullmatch(text)])
def test_without_an_option_it_is_what_help_says(
    name: str,
    inputs: dict[str, str],
    without: dict[str, Facts],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of all that the option changes, as numbers or as names."""
    probe = Probe(monkeypatch, tmp_path)
    stand_ins(probe)
    line = f"{name.rpartition(' ')[0]} {TABLE[name].base} {ASKED_FOR.get(name, '')}"
    if line not in without:
        without[line] = probe.run(line.format(**inputs).split())
    text = DEFAULTS[name]
    kind, value = (str, text) if text[0].isalpha() else ((int, float), float(text))
    facts = {key: without[line].get(key) for key in TABLE[name].effect}
    own = {key: fact for key, fact in facts.items() if isinstance(fact, kind)}
    assert {
        key for key, fact in own.items() if fact != value and not isinstance(fact, bool)
    } == set()


@pytest.mark.campaign
def test_the_seed_of_a_campaign_reaches_its_cases(capsys: pytest.CaptureFixture[str]) -> None:
    """Without stand-ins: one case of each seed, judged here as well."""
    digests = []
    for seed in (7, 8):
        words = ["stress", "--cases", "1", "--workers", "1", "--seed", str(seed), "--json", "-"]
        assert main(words) == 0
        document = json.loads(capsys.readouterr().out)
        fingerprint = judge(trial(seed, 0)).fingerprint
        assert document["digest"] == hashlib.sha256(fingerprint.encode()).hexdigest()
        digests.append(document["digest"])
    assert digests[0] != digests[1]


def test_every_entry_says_what_it_changes() -> None:
    assert all(entry.effect or entry.moves for entry in TABLE.values())

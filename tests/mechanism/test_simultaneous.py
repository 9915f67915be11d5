"""The law of stops that touch is a choice of the model, and reaches whatever is made of it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from rows_of_balls import row

from nipper_pin import Case, Mechanism, Window, load, load_solution, save, simulate
from nipper_pin.cli import main
from nipper_pin.mechanism import with_numbers
from nipper_pin.mechanism.files import toml
from nipper_pin.reduced import build, transition

FALL = Case(speed_rpm=20.0, window=Window.CYCLE, start_index=0.0, max_collisions=1)


@pytest.fixture
def cannon(tmp_path: Path) -> Path:
    """3 kg below 1 kg, both falling: a model folder that does not write the choice."""
    made = row([3.0, 1.0], 1.0, wall=True, gravity=9.81, initial={"z0": {"at_mm": 200.0}})
    folder = tmp_path / "cannon"
    folder.mkdir()
    (folder / "cannon.urdf").write_text(made.urdf, encoding="utf-8")
    tables = {key: value for key, value in made.description.items() if key != "simultaneous"}
    (folder / "cannon.toml").write_text(toml(tables), encoding="utf-8")
    return folder


def _upper(mechanism: Mechanism) -> float:
    """Speed of the upper ball after the strike, by that before it."""
    hit = next(event for event in simulate(mechanism, FALL).events if event.t > 0.0)
    return float(hit.v_after.sum() / -hit.v_before.sum())


def test_it_may_be_left_out_written_and_changed(cannon: Path) -> None:
    """At once both leave with the speed of the fall; in sequence the upper one with twice that."""
    plain = load(cannon)
    assert plain.simultaneous == "newton"
    changed = load(cannon, {"simultaneous": "sequential"})
    assert changed.simultaneous == "sequential"
    assert [_upper(plain), _upper(changed)] == pytest.approx([1.0, 2.0], rel=1e-14)
    file = cannon / "cannon.toml"
    file.write_text('simultaneous = "sequential"\n' + file.read_text(encoding="utf-8"))
    written = load(cannon)
    assert written.simultaneous == "sequential"
    assert load(cannon, {"simultaneous": "newton"}).simultaneous == "newton"
    assert with_numbers(written, {"stops.s0.restitution": 0.5}).simultaneous == "sequential"


def test_a_saved_run_keeps_it(cannon: Path, tmp_path: Path) -> None:
    solution = simulate(load(cannon, {"simultaneous": "sequential"}), FALL)
    save(solution, tmp_path / "run.npz")
    again = load_solution(tmp_path / "run.npz")
    assert again.mechanism.simultaneous == "sequential"
    assert again.warnings == solution.warnings != ()


def test_the_command_line_says_it(
    cannon: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`check` where it is not the usual one, `simulate` where the outcome depends on it."""
    sequential = ["--set", "simultaneous=sequential"]
    said = {}
    for words in ([], sequential):
        assert main(["check", str(cannon), *words]) == 0
        said[len(words)] = " ".join(capsys.readouterr().out.split())
        document = tmp_path / "run.json"
        cycle = ["--window", "cycle", "--speed", "20", "--start-index", "0"]
        assert main(["simulate", str(cannon), *cycle, *words, "--json", str(document)]) == 0
        (warning,) = json.loads(document.read_text(encoding="utf-8"))["warnings"]
        assert " ".join(warning.split()) in " ".join(capsys.readouterr().out.split())
    assert "impulses pass from contact to contact" in said[2]
    assert "stops struck together" not in said[0]


@pytest.mark.slow
def test_laws_agree_in_the_reduced_engine(e62: Mechanism) -> None:
    """One freedom, in which the strike at the jaw throws the steeve off: both laws are one."""
    other = with_numbers(e62, {"simultaneous": "sequential"})
    found = [transition(build(item, turn=False), speed_rpm=450.0).table for item in (e62, other)]
    assert np.array_equal(*found)
    runs = [simulate(item, Case(speed_rpm=450.0)) for item in (e62, other)]
    for one, two in zip(*(run.events for run in runs), strict=True):
        assert np.array_equal(one.v_after, two.v_after)
    assert [run.warnings for run in runs] == [(), ()]

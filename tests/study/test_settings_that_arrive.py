"""Each setting of a study is that of every run that the study asks of the direct engine."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from programs import study_text
from sweep_studies import stored

from nipper_pin import Case, DriveMode, Mechanism, transition_table, turn_table
from nipper_pin.hybrid import simulation
from nipper_pin.study import identify, optimise
from nipper_pin.study.optimise.points import Evaluator
from nipper_pin.study.sweep import read_plan

Settings = dict[str, Any]
# Drives that are another machine for every design; tables would need one each.
RATIO = '[parameters."drives.tension.ratio"]\nlow = 2.1\nhigh = 2.3\n'
FIT = study_text("fit_of_settings.toml")
SWEPT = "[parameters.restitution]\nvalues = [0.1, 0.2]\n"
TURNS = {"window": "cycle", "turns": 2}


def written(folder: Path, head: str, settings: Settings, rest: str) -> Path:
    case = "".join(f"{key} = {value!r}\n" for key, value in settings.items())
    path = folder / "study.toml"
    path.write_text(f"format = 1\n{head}[case]\n{case}{rest}", encoding="utf-8")
    return path


def transitions(e62: Mechanism, _: Path, given: Settings) -> None:
    transition_table(e62, **{"speed_rpm": 500.0, "engine": "direct", **given})


def turns(e62: Mechanism, _: Path, given: Settings) -> None:
    turn_table(e62, **{"speed_rpm": 500.0, "engine": "direct", "turns": 2, **given})


def fit(_: Mechanism, folder: Path, given: Settings) -> None:
    file = written(folder, 'title = "mine"\nmodel = "e62"\n', given, FIT)
    identify.identify(identify.read_problem(file), starts=1, workers=1)


def design(minimise: str) -> Callable[[Mechanism, Path, Settings], None]:
    def evaluate(_: Mechanism, folder: Path, given: Settings) -> None:
        file = written(folder, f'minimise = "{minimise}"\n', given, RATIO)
        assert Evaluator(optimise.read_problem(file)).at(np.array([0.5])).usable

    return evaluate


def sweep(more: Settings) -> Callable[[Mechanism, Path, Settings], None]:
    def compute(_: Mechanism, folder: Path, given: Settings) -> None:
        plan = read_plan(written(folder, "", {"speed_rpm": 500.0, **more, **given}, SWEPT))
        stored(folder / plan.hash, plan)

    return compute


EVERY = {"rest_rate": 2e-3, "tolerance": 1e-7}
TABLE = {**EVERY, "max_collisions": 77, "drive": "inertial", "speed_rpm": 612.5}
STUDIES: dict[str, tuple[Callable[[Mechanism, Path, Settings], None], Settings]] = {
    "transitions": (transitions, TABLE),
    "turns": (turns, {**TABLE, "turns": 3}),
    "identify": (fit, EVERY),
    "optimise transitions": (design("duration_s"), {**EVERY, "speed_rpm": 612.5}),
    "optimise turns": (design("energy_lost_turn_J"), {**EVERY, "speed_rpm": 612.5}),
    "sweep transitions": (sweep({}), TABLE),
    "sweep turns": (sweep(TURNS), {**TABLE, "turns": 3}),
}


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Case]:
    """The cases of all runs, which are done."""
    cases: list[Case] = []
    manager = simulation.PhaseManager

    def made(system: Any, case: Case, start: Any) -> Any:
        cases.append(case)
        return manager(system, case, start)

    monkeypatch.setattr(simulation, "PhaseManager", made)
    return cases


def told(cases: list[Case]) -> dict[str, set[Any]]:
    return {
        "rest_rate": {case.rest_rate for case in cases},
        "tolerance": {case.resolution.tolerance for case in cases},
        "max_collisions": {case.max_collisions for case in cases},
        "drive": {case.drive for case in cases},
        "speed_rpm": {case.speed_rpm for case in cases},
        "turns": {case.cycles for case in cases},
    }


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("study", "key"), [(study, key) for study, (_, keys) in STUDIES.items() for key in keys]
)
def test_a_setting_arrives_in_every_run(
    study: str, key: str, e62: Mechanism, asked: list[Case], tmp_path: Path
) -> None:
    """It is that of all runs, which had another one, and no other setting is changed by it."""
    ask, values = STUDIES[study]
    ask(e62, tmp_path, {})
    before = told(asked)
    asked.clear()
    ask(e62, tmp_path, {key: values[key]})
    wanted = DriveMode(values[key]) if key == "drive" else values[key]
    assert wanted not in before[key]
    assert told(asked) == {**before, key: {wanted}}

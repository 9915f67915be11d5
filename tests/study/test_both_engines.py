"""Every kind of drive, force, restitution and stop: the answer does not depend on the engine.

Few cases are computed by the direct engine, more by the reduced one: the same cases are refused, by
the same words, and all others have the same numbers within the errors that are stated.
Each setting of a study is that of every run that it asks of the direct engine.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from programs import study_text
from small_machines import frame, hinge, link, machine, slide
from sweep_studies import stored
from two_engines import agree, difference

from nipper_pin import (
    Case,
    DriveMode,
    Mechanism,
    TransitionTable,
    TurnTable,
    transition_table,
    turn_table,
)
from nipper_pin.hybrid import simulation
from nipper_pin.hybrid.result.turns import turn_names
from nipper_pin.mechanism import Characteristic, TabulatedSpring
from nipper_pin.study import identify, optimise
from nipper_pin.study.optimise.points import Evaluator
from nipper_pin.study.sweep import read_plan
from nipper_pin.study.transitions import REDUCED_PAYS_FROM
from nipper_pin.study.transitions import TURNS_PAY_FROM as FALSE_PREMISES_PAY_FROM
from nipper_pin.study.turns import TURNS_PAY_FROM

Tables = dict[str, Any]
GRAVITY = 9.81
# At most of these speeds nothing leaves its seat.
SPEEDS = np.array([*np.linspace(60.0, 120.0, 10), 290.0, 330.0, 380.0, 440.0, 520.0, 100.0])


def sliding(tables: Tables) -> Mechanism:
    """A mass on a slide that goes up and down, between a seat and a roof."""
    parts = [
        frame("anchor", "frame", (0.0, 0.5)),
        frame("pole", "frame", (0.0, 0.0205)),
        link("base", 0.1, 1e-3),
        slide("base", "frame", "base", (0.0, 1.0)),
        link("mass", 0.8, 1e-3),
        slide("gap", "base", "mass", (0.0, 1.0)),
    ]
    return described(parts, {"law": "fourier", "cosine_mm": [-10.0, 1.0]}, {"at_mm": 12.0}, tables)


def turning(tables: Tables) -> Mechanism:
    """A flap on an arm that swings, between a seat and a roof."""
    parts = [
        frame("anchor", "frame", (0.1, 0.5)),
        link("base", 0.5, 1e-3, (0.05, 0.0)),
        hinge("base", "frame", "base"),
        link("wheel", 0.5, 1e-3),
        hinge("wheel", "frame", "wheel", (0.0, 0.3)),
        link("flap", 0.2, 3e-4, (0.05, 0.0)),
        hinge("gap", "base", "flap", (0.1, 0.0)),
    ]
    wheel = {"joint": "wheel", "law": "fourier", "cosine_rad": [0.2]}
    swing = {"law": "fourier", "cosine_rad": [-0.1, 0.01]}
    return described(parts, swing, {"at_deg": 30.0}, {"drives": {"wheel": wheel}, **tables})


def described(parts: list[str], drive: Tables, roof: Tables, tables: Tables) -> Mechanism:
    """A machine with a seat and a roof.

    Of the tables ``base`` and ``seat`` have keys of its drive and its seat, and ``moved_by`` is the
    name of the drive.
    """
    tables = dict(tables)
    name = tables.pop("moved_by", "base")
    drives = {name: {"joint": "base", **tables.pop("base", drive)}, **tables.pop("drives", {})}
    seat = {"joint": "gap", "restitution": 0.3, **tables.pop("seat", {})}
    stops = {"seat": seat, "roof": {"joint": "gap", "side": "upper", "restitution": 0.2, **roof}}
    phases = [{"number": 1, "name": "on the seat", "closed": ["seat"]},
              {"number": 2, "name": "in the air", "closed": []}]  # fmt: skip
    return machine(parts, 1 + len(drives), gravity=GRAVITY, drives=drives, stops=stops,
                   phases=phases, **tables)  # fmt: skip


def spring(**keys: Any) -> Tables:
    return {"springs": {"spring": keys}}


def rows(**keys: Any) -> Tables:
    """A spring with rows that high flights leave."""
    return spring(joint="gap", coordinate_mm=[-1.0, 1.0], force_N=[1.0, 6.0], **keys)


PRESSED = spring(joint="gap", stiffness_N_per_m=2500.0, preload_length_mm=1.4)
TWISTED = spring(joint="gap", stiffness_N_m_per_rad=0.6, preload_deg=20.0)


def pressed(**keys: Any) -> Tables:
    """A linear spring and another one."""
    return {"springs": {**PRESSED["springs"], "other": keys}}


def along_the_drive(low: float, high: float) -> Tables:
    """Beside a linear one a spring with rows from one place of the drive to another [mm]."""
    return pressed(joint="base", force_N=[0.0, 10.0], coordinate_mm=[low, high])


ANGLES = [30.0 * row for row in range(13)]
WAVE = [20.0 * math.sin(math.radians(15.0 * row)) ** 4 for row in range(13)]
TURNED = {"cylinder_angle_deg": ANGLES, "coordinate_mm": [*WAVE[:-1], WAVE[0]]}
PIECES = {"rise_deg": 100.0, "dwell_deg": 60.0, "return_deg": 120.0, "lift_mm": 20.0}
KINDS: dict[str, tuple[Callable[[Tables], Mechanism], Tables]] = {
    "linear spring": (sliding, PRESSED),
    "torsion spring": (turning, TWISTED),
    "rows": (sliding, rows()),
    "rows, smooth": (sliding, rows(interpolation="smooth")),
    "rows, linear": (sliding, rows(interpolation="linear")),
    "rows from the seat on": (sliding, spring(joint="gap", coordinate_mm=[0.0, 0.5],
                                              force_N=[3.5, 5.0])),
    "rows with a kink": (sliding, spring(joint="gap", coordinate_mm=[0.0, 0.3, 4.0],
                                         force_N=[1.0, 2.5, 30.0], interpolation="linear")),
    "rows of a hinge": (turning, spring(joint="gap", coordinate_deg=[-1.0, 3.0],
                                        torque_N_m=[0.19, 0.22])),
    "rows of the drive": (sliding, along_the_drive(-1.0, 21.0)),
    "rows as long as the stroke": (sliding, along_the_drive(0.0, 20.0)),
    "rows that the drive leaves": (sliding, along_the_drive(-1.0, 19.0)),
    "spring between points": (sliding, spring(
        frame_a="anchor", frame_b="mass", free_length_mm=512.0, stiffness_N_per_m=900.0)),
    "points that meet": (sliding, pressed(frame_a="pole", frame_b="mass", free_length_mm=5.0,
                                          stiffness_N_per_m=40.0)),
    "drive and stop of one name": (sliding, {"moved_by": "seat", **PRESSED}),
    "damper": (sliding, PRESSED | {"dampers": {"d": {"joint": "gap", "damping_N_s_per_m": 4.0}}}),
    "damper of a hinge": (turning, TWISTED | {
        "dampers": {"d": {"joint": "gap", "damping_N_m_s_per_rad": 1e-3}}}),
    "damper between points": (sliding, PRESSED | {
        # Up in another way than down: a damping of the other sign is not the same mirrored.
        "base": {"law": "fourier", "cosine_mm": [-10.0, 1.0], "sine_mm": [0.0, 2.0]},
        "dampers": {"d": {"frame_a": "anchor", "frame_b": "mass", "damping_N_s_per_m": 4.0}}}),
    "force orifice": (sliding, PRESSED | {
        "forces": {"oil": {"joint": "gap", "law": "orifice", "c_N_s2_per_m2": 3.0}}}),
    "restitution falling": (sliding, PRESSED | {
        "seat": {"restitution_law": {"law": "falling", "fast": 0.1, "scale": 0.5}}}),
    "stop screw": (sliding, PRESSED | {
        "seat": {"adjusted": {"law": "screw", "pitch_mm": 1.5, "turns": 2.0}}}),
    "stop of a hinge elsewhere": (turning, TWISTED | {"seat": {"at_deg": 2.0}}),
    "drive fourier": (turning, TWISTED),
    "drive cam": (sliding, PRESSED | {"base": {"law": "cam", "motion": "cycloidal", **PIECES}}),
    "drive table": (sliding, PRESSED | {"base": {"law": "table", **TURNED}}),
    "drive oscillating_guide": (turning, TWISTED | {
        "base": {"law": "oscillating_guide", "crank_radius_mm": 20.0, "guide_axis_mm": [0.0, 0.0],
                 "crank_axis_mm": [150.0, 0.0]}}),
    "drive geared": (turning, TWISTED | {"base": {"law": "geared", "of": "wheel", "ratio": -0.5}}),
    "drive constant_speed": (turning, TWISTED | {"base": {"law": "constant_speed", "ratio": 1.0}}),
    "drive screw": (sliding, PRESSED | {"base": {"law": "screw", "lead_mm_per_turn": 3.0}}),
}  # fmt: skip

# Machines that the reduced engine does not follow, and those with cases that neither does.
DIRECT = {"force orifice", "restitution falling", "drive screw", "points that meet"}
REFUSED = {"rows", "rows, linear", "rows, smooth", "rows from the seat on", "rows of a hinge",
           "rows that the drive leaves", "rows with a kink", "points that meet"}  # fmt: skip
QUICK = {"damper between points", "drive and stop of one name", "rows, linear",
         "rows from the seat on", "rows that the drive leaves", "stop screw"}  # fmt: skip


def both(name: str) -> tuple[TurnTable, TurnTable]:
    """A machine with as many cases as the direct engine does, and with one more."""
    make, tables = KINDS[name]
    few, many = (
        turn_table(make(tables), speed_rpm=SPEEDS[:count], turns=2, rest_rate=1e-3, torques=True)
        for count in (TURNS_PAY_FROM - 1, TURNS_PAY_FROM)
    )
    return few, many


@pytest.mark.parametrize(
    "name", [pytest.param(key, marks=[pytest.mark.campaign] * (key not in QUICK)) for key in KINDS]
)
def test_the_number_of_cases_changes_no_answer(name: str) -> None:
    few, many = both(name)
    assert few.why.startswith("direct")
    assert many.why.startswith("direct" if name in DIRECT else "reduced")
    assert ("failed" in few.outcome) == (name in REFUSED)
    for i, outcome in enumerate(few.outcome):
        assert outcome == many.outcome[i]
        if outcome == "failed":
            assert few.message[i] == many.message[i]
            continue
        for quantity in turn_names(few.mechanism, drives=True):
            if "error" not in quantity:
                one, other, most = difference(few, many, i, quantity)
                assert one == pytest.approx(other, rel=0.0, abs=most, nan_ok=True), quantity


def with_rows(e62: Mechanism, end_m: float) -> Mechanism:
    """The E62 with its spring as two rows, of which a later one ends what is known of it."""
    (linear,) = e62.springs
    ends = np.array([0.0, end_m])
    forces = linear.stiffness * (linear.preload + ends)
    rows = Characteristic(coordinate=tuple(ends), force=tuple(forces))
    table = TabulatedSpring(name="steeve", index=linear.index, characteristic=rows)
    return replace(e62, springs=(), tabulated_springs=(table,))


def test_transitions_of_rows(e62: Mechanism) -> None:
    """A table of a spring is the direct engine's, whatever the number of cases."""
    speeds = np.append([1300.0, 1200.0], np.linspace(520.0, 680.0, REDUCED_PAYS_FROM - 2))
    few, many = (
        transition_table(with_rows(e62, 3.9e-3), speed_rpm=speeds[:count], rest_rate=1e-3)
        for count in (3, REDUCED_PAYS_FROM)
    )
    assert {*few.engine, *many.engine} == {"direct"}
    assert few.outcome.tolist() == ["failed", "failed", "at_rest"]
    alike(few, many)


def test_transitions_of_turns(e62: Mechanism) -> None:
    """Where a machine does not arrive as a transition assumes, by whole turns of either engine."""
    speeds = np.append(1500.0, np.linspace(800.0, 980.0, FALSE_PREMISES_PAY_FROM))
    few, many = (
        transition_table(with_rows(e62, 4.2e-3), speed_rpm=speeds[:count], rest_rate=1e-3)
        for count in (4, FALSE_PREMISES_PAY_FROM + 1)
    )
    assert {*few.engine[1:]} == {"turn"}
    assert {*many.engine[1:]} == {"reduced_turn"}
    assert few.outcome.tolist() == ["failed", *["at_rest"] * 3]
    assert "the rows of its table go from 0 to 4.2 mm" in few.message[0]
    alike(few, many)


def alike(few: TransitionTable, many: TransitionTable) -> None:
    """Both refuse the same cases by the same words; the others agree within their errors."""
    count = len(few)
    agree(few, many, slice(count), slice(count))
    assert few.collisions.tolist() == many.collisions[:count].tolist()
    for i in np.flatnonzero(few.outcome == "failed"):
        assert few.message[i] == many.message[i]


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
    identify.identify(file, starts=1, workers=1)


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

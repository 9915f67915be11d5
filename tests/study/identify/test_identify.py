"""Identification: known numbers come back, what cannot be known is said, nonsense is refused."""

from __future__ import annotations

import json
import math
import sys
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import linear_problem
import mpmath
import numpy as np
import pytest
from linear_problem import Linear, fitted
from rich.console import Console

from nipper_pin import Case, Mechanism, SimulationError, Window, check, load, simulate
from nipper_pin.cli import main
from nipper_pin.mechanism import changed, numbers_of
from nipper_pin.study.identify import (
    Condition,
    Objective,
    Parameter,
    Target,
    determinability,
    identify,
    predict,
    read_problem,
    write_model,
)
from nipper_pin.study.identify.fitting.fit import descend
from nipper_pin.view.studies.identify_report import print_fit

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "reference"))

from events import Settings, transition
from planar import Machine

PRELOAD = "springs.steeve.preload_length_mm"
RESTITUTION = "stops.jaw.restitution"
GEAR = "drives.tension.ratio"
MASS = "links.top_nipper.mass_kg"


def problem_file(folder: Path, body: str, name: str = "problem.toml") -> Path:
    file = folder / name
    file.write_text(f'format = 1\ntitle = "test"\nmodel = "e62"\n{body}', encoding="utf-8")
    return file


def free(bounds: dict[str, tuple[float, float]]) -> str:
    return "".join(
        f'[parameters."{path}"]\nlow = {low}\nhigh = {high}\n'
        for path, (low, high) in bounds.items()
    )


BOUNDS = {PRELOAD: (8.0, 16.0), RESTITUTION: (0.1, 0.3), GEAR: (1.8, 2.6)}
TRUE = {PRELOAD: 12.3, RESTITUTION: 0.17, GEAR: 2.05}
ASKED = ("rebound_amplitude_1", "rebound_time_s_1", "rebound_time_s_2", "duration_s")


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A high-speed camera that saw the E62 with other numbers, to 13 digits."""
    folder = tmp_path_factory.mktemp("measured")
    machine = load("e62", TRUE)
    lines = ["speed_rpm,stiffness_N_per_m,quantity,value,sigma"]
    for speed, stiffness in ((450.0, ""), (650.0, ""), (650.0, "7000.0")):
        at = Condition(speed, None, float(stiffness) if stiffness else None)
        for quantity in ASKED:
            one = Target(name="", quantity=quantity, at=at, value=1.0, sigma=1.0)
            (value,) = predict(machine, [one], 1e-12, None)
            lines.append(f"{speed},{stiffness},{quantity},{value:.17g},{0.01 * value:.17g}")
    (folder / "camera.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    head = 'measured = "camera.csv"\ncase = { tolerance = 1e-11 }\n'
    return problem_file(folder, head + free(BOUNDS))


@pytest.mark.slow
def test_same_seed_same_bits_with_any_number_of_workers(measured: Path) -> None:
    """A start is a function of its point alone."""
    camera = read_problem(measured)
    short = replace(camera, targets=camera.targets[:4], tolerance=1e-8)
    one = identify(short, starts=2, seed=3, workers=1)
    two = identify(short, starts=2, seed=3, workers=2)
    assert one.values == two.values
    assert one.predicted.tolist() == two.predicted.tolist()
    for a, b in zip(one.descents, two.descents, strict=True):
        assert (a.start.tolist(), a.z.tolist(), a.cost) == (b.start.tolist(), b.z.tolist(), b.cost)


# Four of the published kind.
TARGETS = "".join(
    f'[[targets]]\nname = "{name}"\nquantity = "{name}"\nat = {{ speed_rpm = 650.0 }}\n'
    f"value = {value}\nsigma = {0.02 * value}\n{since}"
    for name, value, since in (
        ("rebound_amplitude_1", 1.14, "since = { speed_rpm = 450.0 }\n"),
        ("rebound_amplitude_2", 1.1, "since = { speed_rpm = 450.0 }\n"),
        ("rebound_time_s_1", 5.4e-3, ""), ("duration_s", 6.6e-3, ""),
    )
)  # fmt: skip


def test_weighing_all_forces_changes_nothing(tmp_path: Path) -> None:
    """Masses and stiffness times one factor: an exact symmetry that no ratio and no time can see.

    Every force of the flight, gravity included, grows by the factor, and every inertia; so the
    direction of all of them together has singular value zero, and it is the only one here. Found
    to the round-off of differences (1e-11 transitions over a step of 2e-3, times 50 per sigma).
    """
    paths = {
        "springs.steeve.stiffness_N_per_m": (6000.0, 12000.0),
        MASS: (0.8, 1.6),
        "links.steeve_lower.mass_kg": (0.1, 0.3),
        "links.steeve_upper.mass_kg": (0.1, 0.3),
    }
    # Held radii of gyration make the inertias follow their masses.
    radii = {f"links.{link}.gyration_mm": (10.0, 60.0) for link in
             ("top_nipper", "steeve_lower", "steeve_upper")}  # fmt: skip
    problem = read_problem(problem_file(tmp_path, TARGETS + free(paths | radii)))
    objective = Objective(replace(problem, tolerance=1e-11))
    known = determinability(objective, objective.start)
    direction = np.array(
        [item.start / (item.high - item.low) if item.path in paths else 0.0
         for item in problem.parameters]
    )  # fmt: skip
    assert np.abs(known.jacobian @ direction).max() < 1e-4
    single = np.abs(known.jacobian * direction).max(axis=0)[:2]
    assert single.min() > 1.0
    assert "springs.steeve.stiffness_N_per_m" not in known.determined


def test_moved_points_give_the_machine_of_the_planar_reference(e62: Mechanism) -> None:
    """Nine pins at once, the eccentric turned: the model stays assembled and is the right one.

    The reference knows nothing of trees, frames or cut joints: its machine is made of the points
    themselves. Any link frame, axis, centre of mass or guide that did not follow its point would
    change the first rebound by percents; wanted are twelve digits of the engine.
    """
    new = {
        "points.pendulum_shaft.x_mm": -192.0, "points.pendulum_shaft.z_mm": -18.5,
        "points.nipper_pivot.x_mm": -194.0, "points.rocker_pin.z_mm": 91.0,
        "points.jaw.x_mm": -71.0, "points.jaw.z_mm": 100.0, "points.rod_pin.x_mm": -25.0,
        "points.rod_pin.z_mm": 98.0, "points.tension_shaft.x_mm": -88.0,
        "points.eccentric_pin.angle_deg": 190.0, "links.top_nipper.com_x_mm": -28.0,
        "links.top_nipper.gyration_mm": 29.0, MASS: 1.3,
    }  # fmt: skip
    machine = changed(e62, new)
    # Written and read: decimal places in frames of links, hence round-off of 200 mm.
    assert numbers_of(machine, new) == pytest.approx(tuple(new.values()), rel=1e-13)
    hit = simulate(machine, Case(speed_rpm=650.0)).collisions[0]
    with mpmath.workdps(24):
        angle = mpmath.mpf(190) * mpmath.pi / 180
        changes = {
            "speed_rpm": "650", "pendulum_shaft_x_mm": "-192", "pendulum_shaft_z_mm": "-18.5",
            "pendulum_to_nipper_x_mm": "-194", "nipper_to_rocker_z_mm": "91",
            "top_nipper_pivot_x_mm": "-71", "top_nipper_pivot_z_mm": "100",
            "top_nipper_to_rod_x_mm": "-25", "top_nipper_to_rod_z_mm": "98",
            "tension_shaft_x_mm": "-88", "eccentric_pin_x_mm": str(-88 + 5 * mpmath.cos(angle)),
            "eccentric_pin_z_mm": str(mpmath.mpf("261.5") + 5 * mpmath.sin(angle)),
            "com4_x_mm": "-28", "mass4_kg": "1.3",
            "inertia4_kg_m2": str(mpmath.mpf("1.3") * mpmath.mpf("0.029") ** 2),
        }  # fmt: skip
        reference = Machine(mpmath.mp, changes)
        settings = Settings(order=16, tolerance="1e-17", shortest="1e-12")
        wanted = transition(reference, settings).collisions[0]
    assert hit.approach_rate == pytest.approx(float(wanted.approach_rate), rel=1e-11)
    assert hit.rebound_amplitude == pytest.approx(float(wanted.rebound_amplitude), rel=1e-10)
    assert hit.rebound_time == pytest.approx(float(wanted.rebound_time), rel=1e-10)
    assert hit.cylinder_angle == pytest.approx(np.radians(166.0))


def test_published_ratios_of_the_identified_model() -> None:
    """The set that comes with the package meets ten of twelve within 4 % and all within 10 %.

    Simulated anew at full accuracy from the files, with no part of the fit: a set that lived on
    the tolerance of the search, or was written with a wrong digit, fails. Timing and stop force
    are read from simulated cycles.
    """
    problem = read_problem()
    model = load("e62_identified")
    found = predict(model, problem.targets, 1e-12, None)
    wanted = np.array([target.value for target in problem.targets])
    off = np.abs(found / wanted - 1.0)
    assert len(off) == 12
    assert np.count_nonzero(off <= 0.04) >= 10
    assert off.max() <= 0.10
    report = check(model, 450.0)
    assert report.closing_index is not None
    assert report.opening_index is not None
    assert 33.0 <= report.closing_index <= 35.0
    assert 8.0 <= report.opening_index <= 11.0
    assert report.stop_force["steeve"].value > 10.0
    assert report.interferences == ()
    for item, value in zip(
        problem.parameters,
        numbers_of(model, [x.path for x in problem.parameters]),
        strict=True,
    ):
        # Files hold decimal places in frames of links: round-off of the bounds themselves.
        assert item.low - 1e-9 <= value <= item.high + 1e-9


@pytest.mark.campaign
@pytest.mark.parametrize("speed", [450.0, 550.0, 650.0])
@pytest.mark.parametrize("stiffness", [7000.0, 9000.0, 11000.0])
def test_steeve_of_the_identified_model_stays_on_its_stop(speed: float, stiffness: float) -> None:
    """In every case of the published study, by the whole phase manager: no release in phase 1.

    The released steeve is an event that the simulation looks for; the model that the search
    started from has one at 650 r/min, so the assertion can fail.
    """
    model = load("e62_identified", {"springs.steeve.stiffness_N_per_m": stiffness})
    assert [stop for stop, _ in check(model, speed).releases if stop == "steeve"] == []


@pytest.mark.slow
def test_best_point_of_the_built_in_problem_is_stationary() -> None:
    """Restarted from its result, the search stays: neither cost nor numbers move.

    One descent of a few steps; the result was reached from several starts, of which the package
    keeps the numbers only. A model whose files do not belong to the problem descends at once.
    """
    problem = read_problem()
    objective = Objective(problem)
    paths = [item.path for item in problem.parameters]
    numbers = np.array(numbers_of(load("e62_identified"), paths))
    z = np.clip((numbers - objective.low) / objective.width, 0.0, 1.0)
    before = 0.5 * float(np.sum(objective.residuals(z) ** 2))
    after = descend(objective, z, max_steps=4)
    # Numbers on a bound start a millionth of their range inside.
    assert after.cost == pytest.approx(before, rel=1e-4)


@pytest.mark.slow
def test_the_true_transition_is_fitted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The number comes back, and it is said whose transition it was.

    The first rebound of whole turns, from the usual start of a turn, is 12.6 and not 7.1 mrad.
    Without noise the search ends where its step is below 1e-6 of the range of 2 mm. The assumed
    transition, of another approach rate, would need another preload for these values.
    """
    known = {RESTITUTION: 0.18674, "springs.steeve.stiffness_N_per_m": 7065.98}
    machine = load("e62", {PRELOAD: 9.25486, **known})
    turn = simulate(machine, Case(speed_rpm=681.27, window=Window.CYCLE))
    first, second, *_ = (hit for hit in turn.collisions if hit.stop == "jaw")
    assumed = simulate(machine, Case(speed_rpm=681.27)).collisions[0].rebound_amplitude
    assert (first.rebound_amplitude or 0.0) > 1.5 * (assumed or math.inf)
    rows = [("rebound_amplitude_1", first.rebound_amplitude),
            ("rebound_time_s_1", first.rebound_time),
            ("rebound_amplitude_2", second.rebound_amplitude)]  # fmt: skip
    body = "".join(
        f'[[targets]]\nname = "{name}"\nquantity = "{name}"\nat = {{ speed_rpm = 681.27 }}\n'
        f"value = {value!r}\nrelative_sigma = 0.01\n"
        for name, value in rows
    )
    body += "[set]\n" + "".join(f'"{path}" = {value}\n' for path, value in known.items())
    problem = read_problem(problem_file(tmp_path, body + free({PRELOAD: (8.9, 11.1)})))
    fit = identify(problem, starts=1, workers=1)
    assert fit.values[PRELOAD] == pytest.approx(9.25486, abs=1e-4)
    assert {fit.premise_holds(target) for target in problem.targets} == {False}
    print_fit(fit, fit.goodness, fit.known, (), Console(width=200))
    assert "681.27 r/min: the transition of the turn" in capsys.readouterr().out


def test_a_search_without_a_machine(tmp_path: Path) -> None:
    """Nothing approaches the floor in the touch configuration, whatever the numbers."""
    ball = Path(__file__).resolve().parents[2] / "strangers" / "ball_e05"
    target = '[[targets]]\nname = "t"\nquantity = "duration_s"\nvalue = 1.0\nsigma = 0.1\n'
    body = f"{target}at = {{ speed_rpm = 60.0 }}\n{free({'stops.floor.restitution': (0.1, 0.9)})}"
    file = problem_file(tmp_path, body)
    file.write_text(file.read_text(encoding="utf-8").replace("e62", str(ball)), encoding="utf-8")
    said = r"none of 2 starts .*, nor is the model as it is: stop 'floor' is .*; change that first"
    with pytest.raises(SimulationError, match=said):
        identify(file, starts=2, workers=1)


def test_command_writes_a_model_that_simulate_accepts(
    measured: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """From a problem file to a folder to a simulation, by the command alone.

    Three numbers come back from twelve noiseless rebounds. The misfit at the truth is zero, so
    Gauss and Newton converge with the square to the tolerance of the transitions, 1e-11, by the
    inverse of singular values of some ten: 1e-8 is generous. The truth is 1.3 mm, 15 % and 7 % away
    from the model's own values, so an unchanged copy would be off by percents.
    """
    folder = tmp_path / "found"
    arguments = ["identify", str(measured), "--starts", "1", "--profiles", "0", "--workers", "1"]
    assert main([*arguments, "--out", str(folder), "--json", "-"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert main(["simulate", str(folder), "--speed", "650", "--json", "-"]) == 0
    run = json.loads(capsys.readouterr().out)
    said = {item["path"]: item["identified"] for item in result["parameters"]}
    assert said == pytest.approx(TRUE, rel=1e-7)
    truth = simulate(load("e62", TRUE), Case(speed_rpm=650.0))
    assert run["transition"]["duration_s"] == pytest.approx(truth.transitions[0].duration, rel=1e-6)
    text = (folder / "found.toml").read_text(encoding="utf-8")
    assert "never the maker's" in text.lower()
    assert "identified: 12.3" in text


@pytest.mark.parametrize("moves", [False, True])
def test_provenance_of_identified_numbers(moves: bool, tmp_path: Path) -> None:
    """Identified numbers first, then what the model said of others; meshes move with it.

    A mesh that is only drawn may be missing.
    """
    given = linear_problem.problem(np.array([1.0, 2.0]), np.array([1.0, 1.0]))
    path = "points.rod_pin.z_mm" if moves else given.parameters[0].path
    (start,) = (101.9,) if moves else (11.0,)
    free = Parameter(path=path, low=start - 3.0, high=start + 5.0, start=start, why="")
    fit = fitted(
        Linear(replace(given, parameters=(free,)), matrix=np.ones((2, 1)), offset=0.0), 0.5
    )
    found = write_model(fit, fit.goodness, tmp_path / "found")
    told = dict(found.provenance)
    assert next(iter(told)) == path
    value = f"{start + 1.0:.9g}"
    assert told.pop(path) == (
        f"identified: {value} between {start - 3.0:g} and {start + 5.0:g} (before: {start:.9g}) "
        "from 2 targets; not measured, not the maker's"
    )
    visuals = told.pop("urdf.visuals")
    old = dict(load("e62").provenance)
    assert (visuals == "illustration: the collision shapes") is moves
    assert visuals == old.pop("urdf.visuals") or moves
    assert told == {key: words for key, words in old.items() if key != path}
    meshes = sorted(item.name for item in (tmp_path / "found").rglob("*.stl"))
    drawn = ElementTree.fromstring(found.urdf).iter("mesh")
    assert meshes == sorted({Path(item.get("filename", "")).name for item in drawn})
    assert bool(meshes) is not moves
    if moves:
        # A mesh was drawn for the old places of the pins: links show their plain bodies.
        for link in ElementTree.fromstring(found.urdf).iter("link"):
            bodies, shown = (
                [ElementTree.tostring(item) for item in link.findall(f"{kind}/geometry/*")]
                for kind in ("collision", "visual")
            )
            assert shown == bodies

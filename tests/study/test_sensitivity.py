"""Sensitivities against a hand-derived planar solution in high precision, and levers made of them.

The reference (tests/reference/planar.py) shares no equation, no parametrisation and no integrator
with the package: Taylor series of a closed form in 24 digits, so that its plain central differences
are good to 1e-9. A sensitivity that is right there cannot be right here by accident: a wrong sign,
a wrong unit, a point that drags its neighbours along or a spring that is not re-aimed all show.
"""

from __future__ import annotations

import math
import re
import sys
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from small_machines import SLED, link, machine, slide

from nipper_pin import Case, Mechanism, SimulationError, load, simulate
from nipper_pin.study import sensitivity
from nipper_pin.study.identify import working_cycle
from nipper_pin.study.identify.problem.working_cycle import middle_half
from nipper_pin.study.levers import Bounce, Lever, levers
from nipper_pin.study.sensitivity import (
    QUANTITIES,
    Sensitivities,
    Sensitivity,
    every_path,
    sensitivities,
)
from nipper_pin.study.steps import step_of

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "reference"))

from events import Settings, transition
from planar import PARAMETERS, Machine

SPEED = 650.0
# Package path -> parameters of the reference that grow together with it, with their factors.
SAME = {
    "speed_rpm": {"speed_rpm": 1.0},
    "springs.steeve.preload_length_mm": {"preload_length_mm": 1.0},
    "springs.steeve.stiffness_N_per_m": {"stiffness_N_per_m": 1.0},
    "stops.jaw.restitution": {"jaw_restitution": 1.0},
    "drives.tension.ratio": {"gear_ratio": 1.0},
    "drives.pendulum.crank_radius_mm": {"crank_radius_mm": 1.0},
    "cylinder.angle_at_touch_deg": {"cylinder_angle_at_touch_deg": 1.0},
    "points.rod_pin.x_mm": {"top_nipper_to_rod_x_mm": 1.0},
    "points.jaw.z_mm": {"top_nipper_pivot_z_mm": 1.0},
    "points.pendulum_shaft.x_mm": {"pendulum_shaft_x_mm": 1.0},
    "points.eccentric_pin.angle_deg": {
        # An arc of 5 mm radius at 176 degrees.
        "eccentric_pin_x_mm": 5.0 * np.sin(np.radians(176.0)) * np.pi / -180.0,
        "eccentric_pin_z_mm": 5.0 * np.cos(np.radians(176.0)) * np.pi / 180.0,
    },
    "links.top_nipper.com_x_mm": {"com4_x_mm": 1.0},
}


@pytest.fixture(scope="module")
def found(e62: Mechanism) -> Sensitivities:
    done: list[tuple[int, int]] = []
    paths = tuple(SAME)[1::3]
    result = sensitivities(e62, SPEED, paths, progress=lambda *counts: done.append(counts))
    assert done == [(k, len(paths)) for k in range(1, len(paths) + 1)]
    return result


def reference(changes: dict[str, Any]) -> list[Any]:
    """Amplitude, transition time and mean lip force of the planar machine."""
    machine = Machine(mpmath.mp, {"speed_rpm": "650"} | {k: str(v) for k, v in changes.items()})
    trace = transition(machine, Settings(order=16, tolerance="1e-17", shortest="1e-12"))

    def stroke(t: Any) -> Any:
        return machine.phase2(machine.frame(machine.psi_touch - machine.speed * t))[0].stroke[0]

    period = 2 * mpmath.pi / machine.speed
    t_open = mpmath.findroot(stroke, (0.31 * period, 0.36 * period), solver="anderson")
    places, weights = middle_half(0.0, 1.0)
    force = mpmath.mpf(0)
    for place, weight in zip(places, weights, strict=True):
        psi = machine.psi_touch - machine.speed * t_open * mpmath.mpf(float(place))
        force += mpmath.mpf(float(weight)) * machine.phase2(machine.frame(psi))[1][0]
    lever = machine.lever
    return [trace.collisions[0].rebound_amplitude, trace.rests[0][1], force / lever]


def slopes(path: str) -> np.ndarray:
    """Relative change of the quantities of the reference by one unit of a path."""
    with mpmath.workdps(24):
        step = mpmath.mpf("1e-6")
        sides = []
        for sign in (1, -1):
            changes = {
                name: mpmath.mpf(PARAMETERS[name] if name != "speed_rpm" else "650")
                + sign * step * mpmath.mpf(float(factor))
                for name, factor in SAME[path].items()
            }
            sides.append(reference(changes))
        return np.array(
            [float((a - b) / (2 * step) / ((a + b) / 2)) for a, b in zip(*sides, strict=True)]
        )


@pytest.mark.campaign
@pytest.mark.parametrize("path", SAME)
def test_sensitivities_are_those_of_the_planar_reference(e62: Mechanism, path: str) -> None:
    """Both ways of the package against the reference.

    Richardson's extrapolation leaves f^(5) h^4 / 5 of steps of 0.05 mm on a scale of some mm
    (1e-7 of the slope) and round-off of 1e-13 over 1e-3 (1e-10); the arc of the eccentric is
    straight to 1e-6 degrees. The control is a plain difference of h = 0.025 mm or 0.1 %: f''' h^2
    / 6, 1e-5 of the largest slope.
    """
    (row,) = sensitivities(e62, SPEED, (path,)).rows
    scale = row.value if row.unit == "%" else 100.0
    wanted = scale * slopes(path)
    size = np.abs(wanted).max()
    assert np.abs(row.per - wanted).max() < 1e-6 * size
    assert np.abs(row.control - wanted).max() < 2e-5 * size


def test_two_ways_agree(e62: Mechanism, found: Sensitivities) -> None:
    """Other engine, other forces, other differences: the stated disagreement is their truncation.

    It is largest for the preload, the strongest per step; a row mixed up between the two engines
    would disagree by whole percents, and a control that repeated its values to the last bit.
    """
    assert found.clamping_force_N == working_cycle(e62, SPEED).clamping_force
    for row in found.rows:
        assert row.disagreement < 1e-5 * max(1.0, np.abs(row.per).max())
        seen = np.abs(row.per) > 1e-3
        assert seen.any()
        assert (row.per != row.control)[seen].any()


def test_every_number_is_asked_for_once(e62: Mechanism) -> None:
    """Each free dimension of the drawing appears once: 7 hinges less a cut one, 2 closures."""
    paths = every_path(e62)
    assert len(set(paths)) == len(paths)
    pins = {path.split(".")[1] for path in paths if path.startswith("points.")}
    assert pins == {"cylinder_axis", "pendulum_shaft", "nipper_pivot", "rocker_pin", "jaw",
                    "rod_pin", "tension_shaft", "eccentric_pin"}  # fmt: skip
    # A point that a crank turns by its radius and angle, others by their coordinates.
    assert [path for path in paths if "eccentric_pin" in path or "points.jaw" in path] == [
        "points.jaw.x_mm", "points.jaw.z_mm", "points.eccentric_pin.radius_mm",
        "points.eccentric_pin.angle_deg",
    ]  # fmt: skip
    assert {path.split(".")[1] for path in paths if path.startswith("links.")} == set(e62.links)
    # Inertias of shafts, places on the index scale and axes that go with their points are left out.
    heads = ("points.", "links.")
    assert {path for path in paths if not path.startswith(heads)} == {
        "speed_rpm", "cylinder.angle_at_touch_deg", "drives.pendulum.crank_radius_mm",
        "drives.pendulum.guide_offset_mm", "drives.tension.ratio", "stops.jaw.restitution",
        "springs.steeve.stiffness_N_per_m", "springs.steeve.preload_length_mm",
        "stops.steeve.restitution",
    }  # fmt: skip
    sled = {"joint": "rail", "law": "fourier", "sine_mm": [0.5], **SLED}
    small = machine([link("sled"), slide("rail", "frame", "sled")], 1, drives={"feed": sled})
    assert [path for path in every_path(small) if not path.startswith(heads)] == [
        "speed_rpm", "cylinder.angle_at_touch_deg",
    ]  # fmt: skip


def test_a_restitution_of_zero() -> None:
    """No NaN, none that spoils the ranking, no step outside: the steeve does not matter here.

    The jaw is at rest before the steeve meets its stop, so exact zeros are right for it.
    """
    paths = ("stops.steeve.restitution", "stops.jaw.restitution")
    found = sensitivities(load("e62", {paths[0]: 0.0}), 450.0, paths)
    steeve, jaw = found.rows
    assert steeve.unit == "0.01"
    assert steeve.per.tolist() == [0.0, 0.0, 0.0]
    assert found.ranked(QUANTITIES[0])[0] is jaw
    assert not jaw.doubtful


def test_a_number_near_zero_has_its_effect_by_an_amount() -> None:
    """A jaw that hardly rebounds: its amplitude goes with e^2, so e = 0.002 has a slope to find.

    One amount of 0.01 is five times the value, so linearly a change by 2 (0.01 / e) = 1000 %; the
    law is exact but for the change of the deceleration with the height, 1e-3 of it here. A jaw that
    does not rebound at all has no amplitude that could change by a percentage.
    """
    path = "stops.jaw.restitution"
    (row,) = sensitivities(load("e62", {path: 0.002}), SPEED, (path,)).rows
    assert row.unit == "0.01"
    assert row.per[0] == pytest.approx(1000.0, rel=5e-3)
    assert not row.doubtful
    with pytest.raises(SimulationError, match=QUANTITIES[0]):
        sensitivities(load("e62", {path: 0.0}), SPEED, ("speed_rpm",))


@pytest.mark.parametrize("way", ["_direct", "_other"])
def test_an_error_in_either_way_is_seen(
    e62: Mechanism, monkeypatch: pytest.MonkeyPatch, way: str
) -> None:
    """1 % of its forces, amplitudes and times follows another law: the row is called doubtful."""
    right = getattr(sensitivity, way)

    def wrong(mechanism: Mechanism, *others: Any, **named: Any) -> Any:
        off = 1.0 + 0.01 * np.sin(1e4 * mechanism.springs[0].preload)
        return right(mechanism, *others, **named) * off

    monkeypatch.setattr(sensitivity, way, wrong)
    result = sensitivities(e62, SPEED, ("springs.steeve.preload_length_mm", "speed_rpm"))
    assert [row.doubtful for row in result.rows] == [True, False]
    assert result.record()["percent_per_unit"][0]["doubtful"] is True


@pytest.mark.slow
def test_bounces_of_the_turn_where_the_machine_arrives_otherwise() -> None:
    """12.6 mrad in the turn and 7.1 as a transition assumes: slopes of the turn, by both engines.

    The lips bounce into the middle half of the closed phase there, so that the force by kinematics
    is not that of the simulated cycle: the row is doubtful for that.
    """
    machine = load("e62", {"preload": 9.25486, "stiffness": 7065.98, "restitution": 0.18674})
    found = sensitivities(machine, 681.27, ("springs.steeve.preload_length_mm",))
    (row,) = found.rows
    assert found.premise_holds is False
    assert found.record()["premise_holds"] is False
    assert found.amplitude_rad == pytest.approx(12.614e-3, rel=1e-3)
    assert row.control[:2] == pytest.approx(row.per[:2], rel=1e-3)
    assert row.doubtful


@pytest.mark.campaign
def test_any_number_of_processes_gives_the_same_bits(e62: Mechanism) -> None:
    """A row depends on its number alone; rows come back in the order that was asked for."""
    paths = ("stops.jaw.restitution", "links.top_nipper.mass_kg", "speed_rpm")
    one = sensitivities(e62, SPEED, paths)
    two = sensitivities(e62, SPEED, paths, workers=2)
    assert [row.path for row in two.rows] == list(paths)
    for a, b in zip(one.rows, two.rows, strict=True):
        assert (a.per.tolist(), a.control.tolist()) == (b.per.tolist(), b.control.tolist())


# --- what is said of rows ------------------------------------------------------------------------


def test_doubt() -> None:
    """From a thousandth of the largest effect on, or of 0.1 % where all effects are smaller."""
    for per, off, doubtful in (
        ((5.0, 1.0, 1.0), 0.0049, False), ((5.0, 1.0, 1.0), 0.0051, True),
        ((0.01, 0.0, 0.0), 0.99e-4, False), ((0.01, 0.0, 0.0), 1.01e-4, True),
        ((5.0, 1.0, math.nan), 0.0, True),
    ):  # fmt: skip
        for sign in (1.0, -1.0):
            values = sign * np.array(per)
            control = values - sign * np.array([0.0, off, 0.0])
            one = Sensitivity(path="x", value=3.0, unit="%", per=values, control=control)
            assert one.doubtful is doubtful
            assert math.isnan(per[2]) or one.disagreement == pytest.approx(off)


def test_order_and_record(found: Sensitivities) -> None:
    """By the size of what a quantity does, whatever its sign."""
    for place, name in enumerate(QUANTITIES):
        effects = [float(row.per[place]) for row in found.ranked(name)]
        assert effects == sorted(effects, key=abs, reverse=True)
    assert min(row.per[0] for row in found.rows) < 0.0
    assert found.record() == {
        "model": "e62", "speed_rpm": SPEED, "premise_holds": True,
        "rebound_amplitude_1": found.amplitude_rad, "duration_s": found.transition_time_s,
        "mean_clamping_force_N": found.clamping_force_N,
        "percent_per_unit": [
            {
                "path": row.path, "value": row.value, "unit": row.unit,
                **dict(zip(QUANTITIES, row.per.tolist(), strict=True)),
                "disagreement_of_two_ways": row.disagreement, "doubtful": False,
            }
            for row in found.rows
        ],
    }  # fmt: skip


# --- steps of differences: never zero, never outside what a number may be -------------------------


RESTITUTION = "stops.jaw.restitution"


@pytest.mark.parametrize("value", [0.0, 1e-5, 3e-4, 0.2, 0.9985, 0.9999, 1.0])
def test_restitution_stays_between_0_and_1(value: float) -> None:
    """exp(3 x), refused outside as a model refuses it; slopes to the order of the differences.

    Central differences of h leave f''' h^2 / 6, one-sided ones f''' h^2 / 3 = 9 f h^2; with
    h = 2e-3 of the value or 2e-4, at most 4e-5 f. What is extrapolated leaves the next order,
    30 f h^3 at most: 3e-7.
    """
    asked = []

    def function(x: float) -> np.ndarray:
        assert 0.0 <= x <= 1.0
        asked.append(x)
        return np.array([np.exp(3.0 * x)])

    step = step_of(RESTITUTION, value)
    true, h = 3.0 * np.exp(3.0 * value), step.half_width
    assert step.slope(function, value)[0] == pytest.approx(true, rel=4.0 * h**2 + 1e-11)
    assert abs(step.extrapolated(function, value)[0] / true - 1.0) < 30.0 * h**3 + 1e-10
    assert len(set(asked)) >= 4


@pytest.mark.parametrize(
    ("path", "value"),
    [("points.eccentric_pin.radius_mm", 0.03), ("springs.steeve.stiffness_N_per_m", 0.0),
     ("links.rocker.mass_kg", 0.0)],
)  # fmt: skip
def test_what_may_not_be_negative_is_not(path: str, value: float) -> None:
    step = step_of(path, value)

    def function(x: float) -> np.ndarray:
        assert x >= 0.0
        return np.array([x * x])

    assert step.extrapolated(function, value)[0] == pytest.approx(2.0 * value, abs=1e-9)


@pytest.mark.parametrize(
    ("path", "value", "unit", "amount", "width", "sense"),
    [
        ("points.a.x_mm", 80.0, "mm", 1.0, 0.05, 0), ("points.a.x_mm", 0.0, "mm", 1.0, 0.05, 0),
        ("points.a.radius_mm", 0.09, "mm", 1.0, 0.05, 1),
        ("points.a.angle_deg", 3.0, "deg", 1.0, 0.05, 0),
        ("stops.a.restitution", 0.5, "%", 5e-3, 1e-3, 0),
        ("stops.a.restitution", 0.0099, "0.01", 0.01, 2e-4, 0),
        ("stops.a.restitution", 3e-4, "0.01", 0.01, 2e-4, 1),
        ("stops.a.restitution", 0.997, "%", 9.97e-3, 1.994e-3, -1),
        ("stops.a.restitution", 0.995, "%", 9.95e-3, 1.99e-3, 0),
        ("springs.a.stiffness_N_per_m", 500.0, "%", 5.0, 1.0, 0),
        ("springs.a.stiffness_N_per_m", 9.0, "10 N/m", 10.0, 0.2, 0),
        ("springs.a.stiffness_N_m_per_rad", 0.0, "0.01 N m/rad", 0.01, 2e-4, 1),
        ("dampers.a.damping_N_s_per_m", 0.05, "0.1 N s/m", 0.1, 2e-3, 0),
        ("dampers.a.damping_N_m_s_per_rad", 0.0, "0.001 N m s/rad", 1e-3, 2e-5, 1),
        ("springs.a.preload_N_m", -0.001, "0.01 N m", 0.01, 2e-4, 0),
        ("springs.a.preload_N", 0.0, "1 N", 1.0, 0.02, 0),
        ("links.a.inertia_kg_m2", 0.0, "1e-7 kg m2", 1e-7, 2e-9, 1),
        ("links.a.mass_kg", 5e-5, "0.1 g", 1e-4, 2e-6, 0),
        ("speed_rpm", 0.5, "1 r/min", 1.0, 0.02, 0), ("speed_rpm", 0.0, "1 r/min", 1.0, 0.02, 1),
        ("speed_rpm", 500.0, "%", 5.0, 1.0, 0),
        ("drives.a.ratio", 0.0, "0.01", 0.01, 2e-4, 0),
        ("drives.a.ratio", -2.0, "%", -0.02, 4e-3, 0),
    ],
)  # fmt: skip
def test_units_widths_and_senses(
    path: str, value: float, unit: str, amount: float, width: float, sense: int
) -> None:
    """A percentage where there is something to take it of; an amount of its kind near zero.

    Half widths: 0.05 mm or degrees, else 0.2 % of the value and at least 2 % of the amount.
    """
    step = step_of(path, value)
    assert (step.unit, step.sense) == (unit, sense)
    assert step.amount == pytest.approx(amount)
    assert step.half_width == pytest.approx(width)


# --- levers: the strongest numbers of the nipper, changed by one unit, and in words --------------


BEFORE = Bounce(4e-3, 8e-3, 120.0)
AFTER = Bounce(3e-3, 6e-3, 126.0)


def test_a_lever_in_words() -> None:
    """What is changed, from which value to which in the unit people read, and what comes of it."""
    lever = Lever("springs.steeve.preload_length_mm", "mm", 11.0, 12.0, BEFORE, AFTER)
    assert str(lever) == (
        "preload length of spring steeve 1 mm more (11 to 12 mm): first rebound -25.0 %, time to "
        "rest -25.0 %, clamping force +5.0 %"
    )
    bare = Lever("stops.jaw.restitution", "%", 0.2, 0.198, BEFORE, BEFORE)
    assert str(bare).startswith("restitution of stop jaw 1 % less (0.2 to 0.198): first rebound +0")


@pytest.mark.parametrize(
    ("path", "unit", "old", "new", "words"),
    [
        ("points.rocker_pin.x_mm", "mm", 3.0, 2.0, "rocker pin 1 mm backward"),
        ("points.rocker_pin.z_mm", "mm", 3.0, 4.0, "rocker pin 1 mm upward"),
        ("points.jaw.x_mm", "mm", 3.0, 4.0, "pin jaw 1 mm forward"),
        ("points.nipper_pivot.radius_mm", "mm", 5.0, 4.0,
         "nipper pivot 1 mm nearer to its shaft"),
        ("points.a_pin.angle_deg", "deg", 5.0, 4.0, "a pin 1 degree clockwise about its shaft"),
        ("stops.jaw.restitution", "%", 0.2, 0.198, "restitution of stop jaw 1 % less"),
        ("links.top.mass_kg", "0.1 g", 0.0, 1e-4, "mass of top 0.1 g more"),
    ],
)  # fmt: skip
def test_changes_in_words(path: str, unit: str, old: float, new: float, words: str) -> None:
    assert Lever(path, unit, old, new, BEFORE, AFTER).words == words


CHANGEABLE = ("springs.", "points.", "drives.", "stops.jaw.")
SHAFTS = ("tension_shaft", "pendulum_shaft", "cylinder_axis")


def amplitude(path: str, value: float) -> tuple[float, float]:
    """First rebound and time to rest of the E62 with one number changed, at 650 r/min."""
    run = simulate(load("e62", {path: value}), Case(speed_rpm=650.0))
    first = run.collisions[0].rebound_amplitude
    assert first is not None
    return first, run.transitions[0].duration


def calmer(path: str, value: float, here: float) -> tuple[float, float]:
    """The lower first rebound of the two machines one unit away, and the number that gives it."""
    one = 1.0 if path.endswith(("_mm", "_deg")) else 0.01 * value
    return min((amplitude(path, value + sense * one)[0] / here, value + sense * one)
               for sense in (-1.0, 1.0))  # fmt: skip


@pytest.mark.slow
def test_levers_are_the_strongest_of_changed_models(e62: Mechanism) -> None:
    """All numbers of the nipper that can be set, each changed both ways by one unit and run."""
    chosen = [
        path for path in every_path(e62)
        if path.startswith(CHANGEABLE) and path.split(".")[1] not in SHAFTS
    ]  # fmt: skip
    found = sensitivities(e62, 650.0, ["speed_rpm", "points.tension_shaft.x_mm", *chosen])
    values = {row.path: row.value for row in found.rows}
    run = simulate(e62, Case(speed_rpm=650.0))
    here = run.collisions[0].rebound_amplitude
    assert here is not None
    tried = {path: calmer(path, values[path], here) for path in chosen}
    order = sorted(tried, key=lambda path: tried[path])
    parts = list(dict.fromkeys(path.rpartition(".")[0] for path in order))[:3]
    known = levers(e62, found)
    assert [lever.path.rpartition(".")[0] for lever in known] == parts
    for lever in known:
        assert lever.new == pytest.approx(tried[lever.path][1], rel=1e-5)
        first, duration = amplitude(lever.path, lever.new)
        assert lever.amplitude_change == pytest.approx(first / here - 1.0, abs=1e-9)
        assert lever.before.duration_s == pytest.approx(run.transitions[0].duration, rel=1e-9)
        assert lever.after.duration_s == pytest.approx(duration, rel=1e-9)
        told = re.findall(r"[-+][\d.]+(?= %)", str(lever))
        assert float(told[0]) == pytest.approx(100.0 * lever.amplitude_change, abs=0.06)
        clamping = working_cycle(load("e62", {lever.path: lever.new}), 650.0).clamping_force
        assert lever.after.clamping_force_N == pytest.approx(clamping, rel=1e-9)

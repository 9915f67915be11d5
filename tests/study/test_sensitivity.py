"""Sensitivities against a hand-derived planar solution in high precision.

The reference (tests/reference/planar.py) shares no equation, no parametrisation and no integrator
with the package: Taylor series of a closed form in 24 digits, so that its plain central differences
are good to 1e-9. A sensitivity that is right there cannot be right here by accident: a wrong sign,
a wrong unit, a point that drags its neighbours along or a spring that is not re-aimed all show.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from small_machines import SLED, link, machine, slide

from nipper_pin import Mechanism, SimulationError, load
from nipper_pin.study import sensitivity
from nipper_pin.study.identify import working_cycle
from nipper_pin.study.identify.problem.working_cycle import middle_half
from nipper_pin.study.sensitivity import (
    QUANTITIES,
    Sensitivities,
    Sensitivity,
    every_path,
    sensitivities,
)

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
    result = sensitivities(e62, SPEED, tuple(SAME), progress=lambda *counts: done.append(counts))
    assert done == [(k, len(SAME)) for k in range(1, len(SAME) + 1)]
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
def test_sensitivities_are_those_of_the_planar_reference(found: Sensitivities, path: str) -> None:
    """Both ways of the package against the reference.

    Richardson's extrapolation leaves f^(5) h^4 / 5 of steps of 0.05 mm on a scale of some mm
    (1e-7 of the slope) and round-off of 1e-13 over 1e-3 (1e-10); the arc of the eccentric is
    straight to 1e-6 degrees. The control is a plain difference of h = 0.025 mm or 0.1 %: f''' h^2
    / 6, 1e-5 of the largest slope.
    """
    row = next(item for item in found.rows if item.path == path)
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


@pytest.mark.slow
def test_a_restitution_of_one() -> None:
    """No step beyond it: a steeve that loses nothing still bounces at the touch.

    So the turn's transition is asked for, and goes with every loss of the steeve. Two ways agree.
    """
    paths = ("stops.steeve.restitution", "stops.jaw.restitution")
    found = sensitivities(load("e62", {paths[0]: 1.0}), 450.0, paths)
    assert found.premise_holds is False
    steeve, jaw = found.rows
    assert steeve.unit == "%"
    assert found.ranked(QUANTITIES[0])[0] is steeve
    for row in (steeve, jaw):
        assert np.isfinite(row.per).all()
        assert row.control[:2] == pytest.approx(row.per[:2], rel=2e-3)


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
    machine = load(
        "e62",
        {
            "springs.steeve.preload_length_mm": 9.25486,
            "springs.steeve.stiffness_N_per_m": 7065.98,
            "stops.jaw.restitution": 0.18674,
        },
    )
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

"""The planar reference: its geometry, its equation of motion, its data."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mpmath
import pytest

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from events import JAW, STEEVE, Settings, Simulation  # noqa: E402
from planar import Frame, Machine, Motion  # noqa: E402
from taylor import Series, cross, dot  # noqa: E402

# Figures for 650 r/min, e = 0.2, from the description of the machine. Two of them are not correctly
# rounded (by 1.7e-12 and 0.7e-12 relative), so they agree to one unit of the last printed digit.
PRINTED = {
    "approach_rate_rad_s": "-16.8260536165104",
    "first_rebound_amplitude_rad": "5.25680465594e-3",
    "first_rebound_time_s": "5.42797116938e-3",
    "second_approach_rate_rad_s": "-4.26168844861",
    "second_rebound_amplitude_rad": "1.971621583362e-4",
    "second_rebound_time_s": "9.17963172588e-4",
}
MODERATE = Settings(order=26, tolerance="1e-19", shortest="1e-13")


@pytest.fixture(autouse=True)
def thirty_digits() -> Iterator[None]:
    with mpmath.workdps(30):
        yield


def relative(a: Any, b: Any) -> float:
    return float(abs(a - b) / abs(b))


def data(name: str) -> dict[str, Any]:
    return json.loads((HERE / name).read_text())


def last_digit(decimal: str) -> float:
    """One unit of the last printed digit, relative."""
    return 1 / float(decimal.lstrip("-").split("e")[0].replace(".", ""))


def test_printed_check_values_come_out() -> None:
    first, second = data("e62_transition.json")["cases"]["650"]["collisions"][:2]
    found = {
        "approach_rate_rad_s": first["approach_rate"],
        "first_rebound_amplitude_rad": first["rebound_amplitude"],
        "first_rebound_time_s": first["rebound_time_s"],
        "second_approach_rate_rad_s": second["approach_rate"],
        "second_rebound_amplitude_rad": second["rebound_amplitude"],
        "second_rebound_time_s": second["rebound_time_s"],
    }
    for name, decimal in PRINTED.items():
        assert relative(mpmath.mpf(found[name]), mpmath.mpf(decimal)) < last_digit(decimal), name


def test_touch_configuration() -> None:
    machine = Machine(mpmath.mp)
    frame = machine.frame(machine.psi_touch)
    assert abs(frame.pin[0] - mpmath.mpc("-0.013", "0.0895")) < 1e-28
    assert abs(frame.pivot[0] - mpmath.mpc("-0.0726", "0.1019")) < 1e-28
    assert abs(machine.jaw_on_stop_in_phase_1(frame)[0]) < 1e-28
    assert relative(machine.lever, mpmath.sqrt(mpmath.mpf("81.8") ** 2 + 36.4**2) / 1000) < 1e-12


@pytest.mark.parametrize("degrees", [0, 77, 166, 201, 290])
def test_links_keep_their_lengths(degrees: int) -> None:
    machine = Machine(mpmath.mp)
    frame = machine.frame(mpmath.radians(degrees))
    motion, _ = machine.phase1(frame)
    bars = {
        "arm": (frame.elbow - machine.shaft, abs(machine.arm)),
        "coupler": (frame.pin - frame.elbow, abs(machine.coupler)),
        "rocker": (frame.pin, machine.rocker_length),
        "pivot": (frame.pivot - frame.elbow, abs(machine.pivot_in_bottom)),
        "eccentric": (frame.eccentric - machine.tension, abs(machine.eccentricity)),
        "top nipper": (motion.rod - frame.pivot, abs(machine.rod_in_top)),
        "steeve": (frame.eccentric - motion.rod, machine.steeve_length),
    }
    for name, (vector, length) in bars.items():
        square = dot(vector, vector)
        assert relative(square[0], length**2) < 1e-27, name
        for k in range(1, 8):
            scale = max(abs(c) for c in vector.upto(k)) ** 2 + 1
            assert abs(square[k]) < 1e-25 * scale, (name, k)


def test_guide_passes_through_the_crank_pin_and_gear_turns_faster() -> None:
    machine = Machine(mpmath.mp)
    psi = mpmath.mpf("2.1")
    frame = machine.frame(psi)
    crank = machine.radius * mpmath.expj(psi) - machine.shaft
    assert abs((frame.arm[0] * machine.guide0 / crank).imag) < 1e-25
    turn = mpmath.arg(frame.arm[0])
    gear = (frame.eccentric[0] - machine.tension) / machine.eccentricity
    assert abs(gear - mpmath.expj(machine.gear * turn)) < 1e-27


def test_index_of_the_foremost_position() -> None:
    machine = Machine(mpmath.mp)
    frame = machine.frame(machine.psi_foremost())
    arm_rate = cross(frame.arm, frame.arm.derivative())
    assert abs(arm_rate[0]) < 1e-25
    assert arm_rate[1] > 0
    assert machine.index(machine.psi_foremost()) == 24
    assert float(machine.index(machine.psi_touch)) == pytest.approx(34.0486, abs=1e-4)


def energy_and_power(machine: Machine, frame: Frame, motion: Motion) -> tuple[Series, Series]:
    """Total energy of links 4-6 and the power their two driven pins take in.

    From Newton and Euler alone: sum m (c'' + i g) = F_J + F_X; moments of links 5 and 6 about the
    rod pin and the force balance of link 5 along the steeve give F_X.
    """
    i = mpmath.mpc(0, 1)
    turn = motion.th.turn(mpmath.expj(motion.th[0]))
    top = frame.bottom * turn
    rod, axis = motion.rod, motion.axis
    centres = {
        4: frame.pivot + top * machine.com4_in_top,
        5: frame.eccentric - axis * machine.com5,
        6: rod + axis * machine.com6,
    }
    masses = {4: machine.mass4, 5: machine.mass5, 6: machine.mass6}
    rate4 = cross(top, top.derivative())
    rate56 = cross(axis, axis.derivative())
    energy = rate4 * rate4 * (machine.inertia4 / 2)
    energy = energy + rate56 * rate56 * (machine.inertia56 / 2)
    inertial = {}
    for n, c in centres.items():
        rate = c.derivative()
        energy = energy + dot(rate, rate) * (masses[n] / 2)
        energy = energy + c.imag * (masses[n] * machine.gravity)
        inertial[n] = (rate.derivative() + i * machine.gravity) * masses[n]
    shortened = motion.stroke + machine.preload
    energy = energy + shortened * shortened * (machine.stiffness / 2)
    push = shortened * machine.stiffness
    along = dot(axis, inertial[5]) - push
    moment = cross(centres[5] - rod, inertial[5]) + cross(centres[6] - rod, inertial[6])
    moment = moment + rate56.derivative() * machine.inertia56
    steeve = frame.eccentric - rod
    across = moment / dot(steeve, steeve).sqrt()
    at_eccentric = axis * (along + across * i)
    at_pivot = inertial[4] + inertial[5] + inertial[6] - at_eccentric
    power = dot(at_eccentric, frame.eccentric.derivative())
    return energy, power + dot(at_pivot, frame.pivot.derivative())


@pytest.mark.parametrize(
    ("degrees", "th", "rate"), [(166, 0.0, 3.4), (140, 0.01, -2.0), (250, 0.3, 9.0)]
)
def test_energy_of_a_flight_changes_by_the_power_of_the_drives(
    degrees: int, th: float, rate: float
) -> None:
    machine = Machine(mpmath.mp, {"speed_rpm": "650"})
    frame = machine.frame(mpmath.radians(degrees))
    motion = machine.flight(frame, mpmath.mpf(th), mpmath.mpf(rate))
    energy, power = energy_and_power(machine, frame, motion)
    change = energy.derivative()
    for k in range(6):
        assert abs(change[k] - power[k]) < 1e-22 * max(abs(change[k]), abs(power[k]), 1), k


def test_inertia_is_the_second_derivative_of_the_kinetic_energy() -> None:
    machine = Machine(mpmath.mp, {"speed_rpm": "650"})
    frame = machine.frame(mpmath.mpf("2.7"))
    th = mpmath.mpf("0.02")
    found = []
    for rate in (-3, 0, 3):
        motion = machine.flight(frame, th, mpmath.mpf(rate))
        found.append(energy_and_power(machine, frame, motion)[0][0])
    second = (found[0] - 2 * found[1] + found[2]) / 9
    assert relative(second, motion.inertia[0]) < 1e-24


def test_stop_force_of_phase_1_is_the_force_that_holds_the_stroke() -> None:
    machine = Machine(mpmath.mp, {"speed_rpm": "450"})
    frame = machine.frame(mpmath.mpf("3.5"))
    held, force = machine.phase1(frame)
    assert max(abs(c) for c in held.stroke.upto(6)) < 1e-18
    free = machine.flight(frame, held.th[0], held.th[1])
    # Without the stop force the stroke accelerates by -force / effective mass.
    acceleration = 2 * free.stroke[2]
    assert relative(acceleration * free.inertia[0], -force[0] * free.stroke_th[0] ** 2) < 1e-22


def test_steeve_collisions_lie_on_the_closed_form() -> None:
    """The integrated jaw angle at a steeve collision is where s = 0 puts it."""
    machine = Machine(mpmath.mp)
    for speed in ("450", "650"):
        case = data("e62_cycle.json")["cases"][speed]
        rows = [c for c in case["collisions"] if c["stop"] == STEEVE and float(c["th_rad"]) > 0]
        assert len(rows) > 10
        for row in rows:
            frame = machine.frame(mpmath.mpf(row["cylinder_angle_rad"]))
            closed = machine.jaw_on_stop_in_phase_1(frame)[0]
            assert relative(closed, mpmath.mpf(row["th_rad"])) < 1e-20


def test_files_are_certified_and_consistent() -> None:
    for name in ("e62_transition.json", "e62_cycle.json"):
        stored = data(name)
        assert float(stored["certified_error"]) < 1e-13
        for case in stored["cases"].values():
            e_jaw = float(case["changes"].get("jaw_restitution", "0.2"))
            for row in case["collisions"]:
                e = e_jaw if row["stop"] == JAW else 0.2
                mass, before = float(row["effective_inertia"]), float(row["approach_rate"])
                assert before < 0
                assert math.isclose(float(row["separation_rate"]), -e * before, rel_tol=1e-14)
                assert math.isclose(float(row["impulse"]), -mass * (1 + e) * before, rel_tol=1e-14)
                lost = mass * before**2 * (1 - e**2) / 2
                assert math.isclose(float(row["energy_lost_J"]), lost, rel_tol=1e-14)


def test_first_flight_against_another_integrator() -> None:
    """The same equation, integrated by a Runge-Kutta method in double precision."""
    integrate = pytest.importorskip("scipy.integrate")
    machine = Machine(mpmath.fp, {"speed_rpm": "650"})
    row = data("e62_transition.json")["cases"]["650"]["collisions"]

    def rhs(t: float, y: list[float]) -> list[float]:
        frame = machine.frame(machine.psi_touch - machine.speed * t)
        return [y[1], 2 * machine.flight(frame, y[0], y[1]).th[2]]

    end = float(row[0]["rebound_time_s"])
    start = [0.0, float(row[0]["separation_rate"])]
    found = integrate.solve_ivp(rhs, (0, end), start, method="DOP853", rtol=1e-12, atol=1e-15)
    assert abs(found.y[0, -1]) < 1e-13
    assert found.y[1, -1] == pytest.approx(float(row[1]["approach_rate"]), rel=1e-11)


def test_simulation_starts_at_the_given_angle() -> None:
    machine = Machine(mpmath.fp)
    run = Simulation(machine, MODERATE, machine.psi_touch)
    assert run.psi(0.0) == machine.psi_touch
    assert run.psi(1e-3) < machine.psi_touch


def test_unknown_parameter_is_refused() -> None:
    with pytest.raises(KeyError, match="mass9_kg"):
        Machine(mpmath.mp, {"mass9_kg": "1"})

"""The combers that come with the package: each runs, and moves as its geometry says."""

from __future__ import annotations

import cmath
import math
import re
import tomllib
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from nipper_pin import (
    Case,
    Mechanism,
    Outcome,
    Solution,
    Window,
    check,
    load,
    simulate,
    transition_table,
)
from nipper_pin.mechanism import known_models
from nipper_pin.mechanism.files.schema import model_schema
from nipper_pin.study.next_steps import next_steps

ROOT = Path(__file__).resolve().parents[1]
MODELS = sorted(known_models())
OTHERS = ["e62_offset_guide", "hanging_pendulum"]
SCHEMA = jsonschema.Draft202012Validator(model_schema())


@pytest.fixture(scope="module", params=OTHERS)
def turn(request: pytest.FixtureRequest) -> Solution:
    mechanism = load(request.param)
    rated = mechanism.cylinder.rated_speed_rpm
    return simulate(mechanism, Case(speed_rpm=rated, window=Window.CYCLE))


def coordinates(solution: Solution, count: int = 400) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Cylinder angles [rad] and every coordinate over the window, by joint."""
    times = np.linspace(*solution.trajectory.span, count)
    q = solution.trajectory.evaluate(times).q
    found = {joint.name: q[:, joint.index] for joint in solution.mechanism.joints}
    return solution.shaft.angle(times), found


@pytest.mark.parametrize("name", MODELS)
def test_numbers_are_marked_as_estimates(name: str) -> None:
    mechanism = load(name)
    assert "estimate" in mechanism.title
    assert re.search(r"not the maker's|no maker's|not a maker's", mechanism.title)
    words = " ".join(mechanism.provenance.values())
    assert "estimate" in words or "identified" in words


@pytest.mark.parametrize("name", MODELS)
def test_every_number_has_a_provenance(name: str) -> None:
    """Each leaf of springs, stops, drives and cylinder lies under a path of [provenance]."""
    mechanism = load(name)
    paths = []
    for table in ("springs", "stops", "drives"):
        for entry, values in mechanism.description[table].items():  # type: ignore[attr-defined]
            paths += [
                f"{table}.{entry}.{key}"
                for key, value in values.items()
                if isinstance(value, float | list)
            ]
    lacking = [
        path
        for path in paths
        if not any(path == key or path.startswith(f"{key}.") for key in mechanism.provenance)
    ]
    assert not lacking


def test_cycle_goes_through_all_phases_and_repeats(turn: Solution) -> None:
    """Jaw open, closing bounces, clamping, return bounces, open: five stretches of one turn.

    The order is that of the machine and not of the code; a stop whose axis has the wrong sign, or a
    wrong sense of rotation, leaves out the clamping or never ends it.
    """
    assert turn.outcome is Outcome.COMPLETED
    assert [item.number for item in turn.phases] == [1, 3, 2, 3, 1]
    jaw = turn.mechanism.transition_stop
    other = next(stop.name for stop in turn.mechanism.stops if stop.name != jaw)
    order = [hit.stop for hit in turn.collisions]
    assert order == sorted(order, key=[jaw, other].index)
    assert {jaw, other} == set(order)
    # Over a turn to round-off: 1e-12 of energy, and 1e-12 m of a machine half a metre large.
    assert turn.checks.energy_balance < 1e-12
    assert turn.checks.closure_m < 1e-12


def test_check_finds_a_usable_machine(turn: Solution) -> None:
    """Timing of a comber: closed around the rear dead centre, and nothing overlaps."""
    mechanism = turn.mechanism
    report = check(mechanism)
    assert report.speed_rpm == mechanism.cylinder.rated_speed_rpm
    assert report.closing_index == pytest.approx(34.0, abs=1.0)
    assert report.opening_index is not None
    assert 7.0 < report.opening_index < 15.0
    assert report.releases == ()
    assert report.interferences == ()
    assert report.condition.value < 50.0
    assert all(force.value > 0.0 for force in report.stop_force.values())
    steps = next_steps(report, mechanism.name)
    assert not any(step.startswith("Missing") for step in steps.missing)
    assert any("simulate" in step for step in steps.commands)


@pytest.mark.parametrize("name", OTHERS)
def test_reduced_engine_solves_them_too(name: str) -> None:
    """Two engines that share no integrator: rest times agree to 1e-9 of themselves."""
    mechanism = load(name)
    rated = mechanism.cylinder.rated_speed_rpm
    speeds = np.linspace(0.7 * rated, 1.3 * rated, 80)
    table = transition_table(mechanism, speed_rpm=speeds, restitution=0.15)
    assert set(table.engine) == {"reduced"}
    direct = transition_table(mechanism, speed_rpm=speeds[::20], restitution=0.15)
    assert set(direct.engine) == {"direct"}
    np.testing.assert_allclose(table.duration[::20], direct.duration, rtol=1e-9)


def point(mechanism: Mechanism, chain: tuple[str, ...]) -> complex:
    """Place x + i z at touch of the last joint of a chain, added up from the URDF's own text."""
    place = 0j
    for joint in chain:
        match = re.search(
            rf'<joint name="{joint}".*?<origin xyz="(\S+) (\S+) (\S+)"', mechanism.urdf, re.DOTALL
        )
        assert match is not None
        place += complex(float(match[1]), float(match[3]))
    return place


def test_hanging_pendulum_moves_as_its_circles_say() -> None:
    """The whole turn by hand: two circles for the four-bar, one more for the lifting rod.

    With P above, crank pin A = r e^(i psi), connecting rod l = |AB|: B lies on the circles about P
    and A. The swing turns jaw pivot J and tail R. While the rod is taut, R lies on the circle about
    Q; while the jaw is closed, the slack is what |QR| lacks. No tree, no cut pin, no solver. The
    URDF has the crank pin to 1e-12 m, 3e-11 rad of its 30 mm; the jaw turns by at most 0.35 of it.
    """
    mechanism = load("hanging_pendulum")
    crank = point(mechanism, ("cylinder_shaft", "crank_pin"))
    P = point(mechanism, ("swing",))
    B = point(mechanism, ("swing", "swing_pin_fixed"))
    J = point(mechanism, ("swing", "jaw"))
    R = point(mechanism, ("swing", "jaw", "rod_pin"))
    Q = point(mechanism, ("rod_bracket_fixed",))
    assert cmath.phase(crank) == pytest.approx(math.radians(-105.0), abs=5e-11)
    rod, arm, lift, tail = abs(B - crank), abs(B - P), abs(R - Q), abs(R - J)

    def meet(one: complex, first: float, two: complex, second: float, near: complex) -> complex:
        d = abs(two - one)
        along = (first**2 - second**2 + d**2) / (2.0 * d)
        off = math.sqrt(first**2 - along**2)
        both = [one + (two - one) / d * complex(along, sign * off) for sign in (1, -1)]
        return min(both, key=lambda item: abs(item - near))

    solution = simulate(mechanism, Case(speed_rpm=220.0, window=Window.CYCLE))
    psi, q = coordinates(solution)
    closed = 0
    for place, angle in enumerate(psi):
        pin = abs(crank) * cmath.exp(1j * angle)
        turned = (meet(P, arm, pin, rod, B) - P) / (B - P)
        assert q["swing"][place] == pytest.approx(cmath.phase(turned), abs=2e-11)
        pivot, end = P + turned * (J - P), P + turned * (R - P)
        if q["slack"][place] == 0.0:
            head = meet(pivot, tail, Q, lift, end)
            opening = cmath.phase((head - pivot) / (end - pivot))
            assert q["jaw"][place] == pytest.approx(opening, abs=2e-11)
        elif q["jaw"][place] == 0.0:
            closed += 1
            assert q["slack"][place] == pytest.approx(lift - abs(end - Q), abs=2e-11)
    # The jaw is closed for half of the turn, so neither branch was idle.
    assert 0.4 < closed / len(psi) < 0.6


def test_hanging_pendulum_is_foremost_at_index_24() -> None:
    """The four-bar's own extreme, seen in the motion, stands where the TOML says it does."""
    mechanism = load("hanging_pendulum")
    solution = simulate(mechanism, Case(speed_rpm=220.0, window=Window.CYCLE, start_index=20.0))
    psi, q = coordinates(solution, 20_001)
    foremost = mechanism.cylinder.index_from_angle(float(psi[np.argmax(q["swing"])]))
    # The grid has 0.002 of an index; the extreme is flat, so one place more or less.
    assert foremost == pytest.approx(24.0, abs=0.005)


def test_torsion_spring_clamps_with_its_moment() -> None:
    """Jaw closed and hardly moving: the clamping force is near preload torque by lever.

    At a tenth of the speed inertia has a hundredth of its share; what is left is the weight of the
    top nipper and of the rods on it, below 2 kg at less than 60 mm, 1.2 N m of 4.7: so the bound is
    loose, but a spring on the wrong joint, in degrees or without preload is out by far more.
    """
    mechanism = load("hanging_pendulum")
    report = check(mechanism, 22.0)
    jaw = mechanism.stop("jaw")
    torque = 6.0 * math.radians(45.0)
    assert report.stop_force["jaw"].value == pytest.approx(torque / jaw.lever, rel=0.25)


def test_offset_guide_bar_keeps_its_distance() -> None:
    """The bar's line through the crank pin passes 12 mm beside the pendulum axis, all round."""
    mechanism = load("e62_offset_guide")
    psi = np.linspace(0.0, math.tau, 97)
    pendulum, tension = mechanism.drives
    angle = pendulum.law.evaluate(psi)[0]
    pin = 0.060 * np.exp(1j * psi) - complex(-0.186, -0.018)
    # Positive to the left of the direction towards the pin: the axis lies to the right of the bar.
    across = (pin * np.exp(-1j * angle)).imag
    along = (pin * np.exp(-1j * angle)).real
    np.testing.assert_allclose(across, 0.012, rtol=0.0, atol=1e-15)
    assert along.min() > 0.0
    np.testing.assert_allclose(tension.law.evaluate(psi)[0], 1.9 * angle, rtol=1e-15)
    assert mechanism.cylinder.index_from_angle(mechanism.cylinder.reference_angle_rad) == (
        pytest.approx(24.0)
    )


@pytest.mark.parametrize("path", sorted(ROOT.glob("models/**/*.toml")), ids=lambda path: path.stem)
def test_documents_keep_to_the_schema(path: Path) -> None:
    document = tomllib.loads(path.read_text(encoding="utf-8"))
    if "cylinder" in document:
        assert [error.message for error in SCHEMA.iter_errors(document)] == []


def test_no_room_of_the_engine_knows_a_machine_by_name() -> None:
    """Names of models appear in the engine and in the viewer as the default of `load`, else not."""
    named = re.compile("|".join(MODELS), re.IGNORECASE)
    found = []
    for room in ("mechanism", "dynamics", "hybrid", "reduced", "view/scene"):
        for path in (ROOT / "nipper_pin" / room).rglob("*.py"):
            for line in path.read_text(encoding="utf-8").splitlines():
                if named.search(line):
                    found.append((path.name, line.strip()))
    assert [name for name, _ in found] == ["load.py"], found
    assert 'model: str | Path = "e62"' in found[0][1]

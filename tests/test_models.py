"""The combers that come with the package: each runs, and moves as its geometry says."""

from __future__ import annotations

import cmath
import math
import re
from pathlib import Path

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
)
from nipper_pin.mechanism import known_models
from nipper_pin.study.next_steps import next_steps

ROOT = Path(__file__).resolve().parents[1]
MODELS = sorted(known_models())
OTHERS = ["e62_offset_guide", "hanging_pendulum"]


@pytest.fixture(scope="module", params=OTHERS)
def turn(request: pytest.FixtureRequest) -> Solution:
    return simulate(load(request.param), window=Window.CYCLE)


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
    motion = solution.trajectory.evaluate(np.linspace(*solution.trajectory.span, 400))
    q, closed = motion.joints, 0
    for place, angle in enumerate(motion.cylinder_angle):
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
    assert 0.4 < closed / 400 < 0.6


def test_hanging_pendulum_is_foremost_at_index_24() -> None:
    """The four-bar's own extreme, seen in the motion, stands where the TOML says it does."""
    mechanism = load("hanging_pendulum")
    solution = simulate(mechanism, Case(speed_rpm=220.0, window=Window.CYCLE, start_index=20.0))
    motion = solution.trajectory.evaluate(np.linspace(*solution.trajectory.span, 20_001))
    angle = motion.cylinder_angle[np.argmax(motion.joints["swing"])]
    foremost = mechanism.cylinder.index_from_angle(float(angle))
    # The grid has 0.002 of an index; the extreme is flat, so one place more or less.
    assert foremost == pytest.approx(24.0, abs=0.005)


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

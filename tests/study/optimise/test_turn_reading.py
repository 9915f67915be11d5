"""Quantities that are read off a simulated turn, and where its kinematics say the same."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from designs import MASS
from driven_machines import follower

from nipper_pin import InputError, Mechanism, SimulationError, Window, load
from nipper_pin.mechanism.gallery import GALLERY, drawn
from nipper_pin.study.identify import WorkingCycle, working_cycle
from nipper_pin.study.identify.problem.working_cycle import Phase, unfit
from nipper_pin.study.optimise.control.reading import MOST_TURNS, control_turn, read
from nipper_pin.study.optimise.points.turn import differs
from nipper_pin.study.optimise.problem.quantities import (
    QUANTITIES,
    check_fit,
    cycle_values,
    lowest,
    thinned,
)
from nipper_pin.tolerances.study import QUANTITY_ROUND_OFF


@pytest.mark.parametrize(
    ("speed", "why"),
    [
        # Its bounces outlast the time in which it is pressed shut; faster still, it never arrives.
        (1600.0, "the simulated turn has no duration_s"),
        (2500.0, "the stop jaw is not hit in the simulated turn"),
    ],
)
def test_a_turn_without_a_transition(speed: float, why: str) -> None:
    """What it lacks is named, and its speed is read all the same."""
    turn = control_turn(load("e62"), speed, None)
    assert read(turn, "speed_rpm").value == pytest.approx(speed)
    for name in ("duration_s", "closing_index", "stop_force_N"):
        with pytest.raises(SimulationError) as caught:
            read(turn, name)
        if name == "duration_s":
            assert caught.value.message == why
            assert caught.value.evidence == {"stop": "jaw"}


def thrown() -> Mechanism:
    """A mass on a table that goes down twice a turn, faster than anything falls; no bounces."""
    made = follower({"law": "fourier", "cosine": [0.0, -0.3]}, sprung=False)
    return replace(made, stops=(replace(made.stops[0], restitution=0.0),))


@pytest.mark.parametrize(
    ("make", "speed", "why"),
    [
        (thrown, 230.0, "the stop cam closes more than once in a turn"),
        (lambda: drawn("film_claw").mechanism(), 600.0, "the stop claw does not open again"),
    ],
)
def test_turns_that_have_no_working_cycle(
    make: Callable[[], Mechanism], speed: float, why: str
) -> None:
    with pytest.raises(SimulationError, match=why):
        read(control_turn(make(), speed, None), "opening_index")


@pytest.mark.parametrize(("model", "turns"), [("e62", MOST_TURNS), (MASS, 1)], ids=str)
def test_turns_that_are_simulated(model: str | Path, turns: int) -> None:
    """From a quarter of a turn before the touch: until they repeat, or one if drives wind on."""
    mechanism = load(model)
    cylinder = mechanism.cylinder
    touch = cylinder.index_from_angle(cylinder.angle_at_touch_rad)
    found = control_turn(mechanism, 60.0, 1e-4)
    case = found.solution.case
    assert (case.speed_rpm, case.window, case.rest_rate) == (60.0, Window.CYCLE, 1e-4)
    assert case.start_index == pytest.approx(touch - 10.0)
    assert found.repeats
    assert found.number == case.cycles == turns


@pytest.mark.sampled(5)
@pytest.mark.parametrize("name", ["e62", "e62_offset_guide", "hanging_pendulum", *GALLERY])
def test_kinematics_and_turn_have_one_window(name: str) -> None:
    """Forces and travels of a cycle are those of the turn, where no stop bounces too long.

    Off by no more than what every second sample of the kinematics changes, and half of those of
    the turn; of a smooth curve either is several times the error of all samples.
    """
    mechanism = drawn(name).mechanism() if name in GALLERY else load(name)
    speed, asked = mechanism.cylinder.rated_speed_rpm, []
    for quantity, item in QUANTITIES.items():
        if item.source == "cycle":
            with suppress(InputError):
                check_fit([quantity], mechanism, name)
                asked.append(quantity)
    assert bool(asked) is (unfit(mechanism) is None)
    if not asked:
        return
    cycle, turn = working_cycle(mechanism, speed), control_turn(mechanism, speed, None)
    found, coarse = cycle_values(cycle), cycle_values(thinned(cycle))
    for quantity in asked:
        if differs(cycle, read(turn, "duration_s").value, frozenset({quantity})):
            continue
        seen, value = read(turn, quantity), found[quantity]
        error = abs(value - coarse[quantity]) + QUANTITY_ROUND_OFF * abs(value) + seen.error
        assert seen.value == pytest.approx(value, rel=0.0, abs=error), quantity


def cycle(least: float = 5.0, stop_force: float = 5.0, top: float = 20.0) -> WorkingCycle:
    """At 600 r/min a rest after 10 ms is 4 of 40 indices after the touch at 10."""
    at = np.linspace(10.0, 34.0, 25)
    clamping = Phase(at, 0.01 - 1e-5 * (at - top) ** 2, least + (at - 22.0) ** 2)
    waiting = Phase(at - 24.0, 0.2 - 1e-4 * (at - 24.0) ** 2, stop_force + (at - 16.0) ** 2)
    return WorkingCycle(600.0, 10.0, 34.0, waiting, clamping, 77.0)


@pytest.mark.parametrize(
    ("made", "duration", "asked", "word"),
    [
        (cycle(), 0.0149, ("clamping_force_N",), ""), (cycle(least=-0.01), 0.0, (), "closed stop"),
        (cycle(least=0.01), 0.0, (), ""),
        (cycle(stop_force=-0.01), 0.0, ("jaw_opening_deg",), "initial phase"),
        (cycle(stop_force=-0.01), 0.0, ("clamping_force_N",), ""),
        # The middle half begins at 16, 6 indices or 15 ms after the touch.
        (cycle(), 0.0151, ("clamping_force_N",), "middle half"), (cycle(), 0.0151, (), ""),
        # The sample before the widest one, at 20: 9 indices or 22.5 ms after the touch.
        (cycle(), 0.0224, ("stroke_mm",), ""), (cycle(), 0.0226, ("stroke_mm",), "stroke is"),
        (cycle(), 0.0226, ("jaw_opening_deg",), ""),
        (cycle(top=5.0), 0.0001, ("stroke_mm",), "stroke is"),
    ],
)  # fmt: skip
def test_where_turns_differ_from_kinematics(
    made: WorkingCycle, duration: float, asked: tuple[str, ...], word: str
) -> None:
    said = differs(made, duration, frozenset(asked))
    assert (word in said) if word else (said == "")


def test_least_values_of_intervals() -> None:
    """A cosine of 48 samples: its bottom between two of them to h^4 / 384, and ends elsewhere.

    h = 2 pi / 47, so 1e-6; the samples alone miss it by up to h^2 / 8 = 2e-3.
    """
    t = np.linspace(0.3, 0.3 + 2.0 * math.pi, 48)
    found = lowest(t, np.cos(t))
    place = int(np.searchsorted(t, math.pi)) - 1
    assert found[place] == pytest.approx(-1.0, abs=2e-6)
    ends = np.minimum(np.cos(t)[:-1], np.cos(t)[1:])
    np.testing.assert_array_equal(np.delete(found, place), np.delete(ends, place))

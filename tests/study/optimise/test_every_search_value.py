"""Every quantity that a search takes from turns and from kinematics, of polynomials of time."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from made_up_turn import HIT, OPENING, PERIOD, REST, index, jaw, lips, mean, solution

from nipper_pin import Mechanism
from nipper_pin.errors import SimulationError
from nipper_pin.study.identify.problem.working_cycle import Phase, WorkingCycle
from nipper_pin.study.optimise.points.turn import differs, turn_values
from nipper_pin.study.optimise.problem import quantities
from nipper_pin.study.true_transition import TrueTransition
from nipper_pin.terms import named


def true(**changes: Any) -> TrueTransition:
    run = solution(**{"shift": PERIOD, "span": (0.0, 2.0 * PERIOD), **changes})
    hits = tuple(hit for hit in run.collisions if hit.stop == "jaw")
    made: Any = TrueTransition
    return made(run, False, hits, run.transitions[0] if run.transitions else None, None)


@pytest.mark.parametrize("thin", [False, True])
def test_quantities_of_a_turn(thin: bool) -> None:
    """Splines are exact for parabolas, and Gauss' rule for their integrals; none before rest."""
    found = turn_values(true(), thin=thin)
    assert found == {
        "closing_index": 33.25,
        "opening_index": pytest.approx(index(OPENING)),
        "clamping_force_N": pytest.approx(mean(lips, REST, 0.0675) / 0.025, rel=1e-12),
        "stroke_mm": pytest.approx(4.0, rel=1e-9),
        "jaw_opening_deg": pytest.approx(math.degrees(jaw(HIT)), rel=1e-9),
    }
    # Rest before the middle half begins changes nothing of it; after its end there is no force.
    for duration, begin in ((0.01, 0.0425), (0.0126, 0.0426), (0.0376, None)):
        ended = [SimpleNamespace(t_start=PERIOD + HIT, duration=duration, collisions=2)]
        force = turn_values(true(transitions=ended))["clamping_force_N"]
        wanted = 0.0 if begin is None else mean(lips, begin, 0.0675) / 0.025
        assert force == pytest.approx(wanted, rel=1e-12)


def test_turns_that_have_no_such_quantities() -> None:
    one = SimpleNamespace(t_start=PERIOD + HIT, duration=0.02, collisions=2)
    for before, closes in ((0.0999, True), (0.1001, False), (0.01, True)):
        other = SimpleNamespace(t_start=PERIOD + HIT - before, duration=0.02, collisions=2)
        if closes:
            with pytest.raises(SimulationError, match="jaw closes more than once in a turn"):
                turn_values(true(transitions=[one, other]))
        else:
            turn_values(true(transitions=[one, other]))
    with pytest.raises(SimulationError, match="jaw does not open again in the simulated turn"):
        turn_values(true(found=solution(shift=PERIOD).events[:4]))
    none = replace(true(), transition=None, outcome=SimpleNamespace(value="no rest", name="N"))
    with pytest.raises(SimulationError, match="no rest") as caught:
        turn_values(none)
    assert caught.value.evidence == {"outcome": "N"}


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


def test_quantities_of_a_cycle() -> None:
    """Least and largest values between samples, of parabolas with their turns there."""
    at = np.linspace(10.0, 34.0, 25)
    clamping = Phase(at, 0.01 - 1e-5 * (at - 20.4) ** 2, at)
    waiting = Phase(at - 24.0, 0.2 - 1e-4 * (at - 24.3) ** 2, 5.0 + (at - 15.7) ** 2)
    made = WorkingCycle(600.0, 10.0, 34.0, waiting, clamping, 77.0)
    assert quantities.cycle_values(made) == {
        "clamping_force_N": 77.0, "closing_index": 10.0, "opening_index": 34.0,
        "stop_force_N": pytest.approx(5.0), "stroke_mm": pytest.approx(10.0),
        "jaw_opening_deg": pytest.approx(math.degrees(0.2)),
    }  # fmt: skip
    thin = quantities.thinned(made)
    for one, whole in ((thin.waiting, waiting), (thin.clamping, clamping)):
        assert one.index.tolist() == whole.index[::2].tolist()
        assert one.gap.tolist() == whole.gap[::2].tolist()
        assert one.force.tolist() == whole.force[::2].tolist()
    assert (thin.clamping_force, thin.closing_index) == (77.0, 10.0)


def test_least_values_between_samples() -> None:
    """One for every interval: its own turn where it has one, else its lower end."""
    places = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    found = quantities.lowest(places, (places - 1.25) ** 2)
    assert found == pytest.approx([0.0625, 0.0, 0.5625, 3.0625])
    assert quantities.lowest(places, -((places - 1.25) ** 2)) == pytest.approx(
        [-1.5625, -0.5625, -3.0625, -7.5625]
    )
    assert quantities.nearest_turn(39.0, 0.0) == -1.0
    assert quantities.nearest_turn(1.0, 39.0) == 41.0
    assert quantities.nearest_turn(5.0, 6.5) == 5.0


def test_names_units_and_what_fits(e62: Mechanism) -> None:
    names = tuple(quantities.QUANTITIES)
    assert quantities.units(names, e62) == {
        "rebound_amplitude_1": "rad", "rebound_time_s_1": "s", "duration_s": "s",
        "clamping_force_N": "N", "stop_force_N": "N", "closing_index": "", "opening_index": "",
        "jaw_opening_deg": "deg", "stroke_mm": "mm", "speed_rpm": "r/min", "clamped_time_s": "s",
        "clamped_share": "", "rest_index": "", "rest_margin": "", "least_clamping_force_N": "N",
        "largest_clamping_force_N": "N", "largest_gap": "rad", "energy_lost_turn_J": "J",
    }  # fmt: skip
    sources = {name: item.source for name, item in quantities.QUANTITIES.items()}
    assert [sources[name] for name in names] == (
        ["transition"] * 3 + ["cycle"] * 6 + ["setting"] + ["turn"] * 8
    )
    assert named("stroke_mm", "mm").label == "largest stroke with the transition stop closed [mm]"
    assert named("closing_index", "").label == "index of closing"
    quantities.check_fit(names, e62, "here")

"""What a run is asked, and what is read of it: cases, quantities by their names, the document."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from judge import press

import nipper_pin as nip
from nipper_pin.hybrid.result.quantities import COLLISION, TRANSITION, of_transition
from nipper_pin.study.cases import spring_values
from nipper_pin.study.identify import QUANTITIES as IDENTIFIED
from nipper_pin.study.optimise.problem.quantities import QUANTITIES as OPTIMISED
from nipper_pin.study.optimise.problem.quantities import units
from nipper_pin.study.sweep.quantities import check_quantities, default, quantity

PUSHED = ("rad", "s", "J", "N s", "N m s")


def test_choices_are_given_as_text() -> None:
    """Text becomes the typed choice, so later comparisons by identity hold; nothing is changed."""
    case = nip.Case(speed_rpm=450.0, window="cycle", drive="inertial")  # type: ignore[arg-type]
    assert case.window is nip.Window.CYCLE
    assert case.drive is nip.DriveMode.INERTIAL
    with pytest.raises(AttributeError):
        case.speed_rpm = -1.0  # type: ignore[misc]


def test_names_say_their_unit() -> None:
    """A name ends with its unit, unless that depends on the stop's coordinate or there is none."""
    every = [*COLLISION, *TRANSITION]
    assert len({item.name for item in every}) == len(every)
    for item in every:
        unit = item.term.unit
        if unit in PUSHED:
            assert item.name.endswith("_" + unit.replace(" ", "_")), item.name
        else:
            assert unit in ("", "{gap}", "{gap}/s")
            assert not item.name.endswith(("_s", "_rad", "_m", "_J", "_N"))
        assert item.read or item.column
        assert item.term.words
        assert item.term.name == item.name


def test_units_follow_the_stop(e62: nip.Mechanism) -> None:
    """A jaw with a contact point, a slide, a hinge without contact."""
    found = {item.name: item for item in COLLISION}
    machine = press()
    places = ((e62, "jaw", "rad", "N"), (e62, "steeve", "m", "N"), (machine, "flap", "rad", "N m"))
    for mechanism, stop, gap, force in places:
        assert found["rebound_amplitude"].unit_at(mechanism, stop) == gap
        assert found["approach_rate"].unit_at(mechanism, stop) == f"{gap}/s"
        assert found["impulse_N_s"].fits(mechanism, stop) == (force == "N")
        assert found["impulse_N_m_s"].fits(mechanism, stop) == (force == "N m")
    assert units(["rebound_amplitude_1", "duration_s"], e62) == {
        "rebound_amplitude_1": "rad", "duration_s": "s",
    }  # fmt: skip


def test_what_is_known_by_a_name_is_known_everywhere(e62: nip.Mechanism) -> None:
    """Names of identification and optimisation are those of tables, with the same values."""
    run = nip.simulate(e62, nip.Case(speed_rpm=600.0))
    table = nip.transition_table(e62, speed_rpm=600.0, engine="direct", tolerance=1e-12)
    own = {name for name, item in OPTIMISED.items() if item.source == "transition"}
    for name in {*IDENTIFIED, *own}:
        item, place = of_transition(name)
        value = item.read(run, run.collisions[place - 1] if place else run.transitions[0])
        assert value == pytest.approx(float(quantity(table, name)[0]), rel=1e-9), name
    assert math.isnan(quantity(table, "time_s_9999")[0])


def test_a_hinge_has_a_moments_impulse_in_sweeps(e62: nip.Mechanism) -> None:
    """The default keeps the one that the transition stop has; the other one is refused."""
    machine = press()
    assert "impulse_N_s_1" in default(e62)
    assert "impulse_N_m_s_1" in default(machine)
    assert "impulse_N_s_1" not in default(machine)
    check_quantities(default(machine), machine, "")
    check_quantities(default(e62), e62, "")
    with pytest.raises(nip.UnknownNameError, match="called 'impulse_N_m_s_2'"):
        check_quantities(["impulse_N_s_2"], machine, "")
    with pytest.raises(nip.UnknownNameError, match="known: "):
        check_quantities(["impulse_1"], machine, "")


def test_springs_by_the_names_of_the_model_file(e62: nip.Mechanism) -> None:
    """Millimetres and degrees outside, SI inside; what is not given is the model's."""
    rates, preloads = spring_values(e62, {"preload_length_mm": [10.0, 12.5]})
    np.testing.assert_array_equal(rates, [[9000.0]])
    np.testing.assert_allclose(preloads, [[0.010], [0.0125]], rtol=1e-15)
    rates, preloads = spring_values(press(), {"stiffness_N_m_per_rad": 4.0, "preload_deg": -30.0})
    np.testing.assert_array_equal(rates, [[4.0]])
    np.testing.assert_allclose(preloads, [[-math.pi / 6.0]], rtol=1e-15)
    short = nip.transition_table(e62, speed_rpm=650.0, preload_length_mm=11.0, engine="direct")
    own = nip.transition_table(e62, speed_rpm=650.0, engine="direct")
    assert short.duration[0] == pytest.approx(own.duration[0], rel=1e-12)
    with pytest.raises(nip.InputError, match="no spring"):
        spring_values(press(), {"preload_length_mm": 3.0})


FOUR_BAR = Path(__file__).parents[1] / "verification" / "models" / "four_bar"


def document_of(solution: nip.Solution) -> Any:
    """The document, as someone who reads the file gets it."""
    return json.loads(json.dumps(nip.record(solution), allow_nan=False))


@pytest.mark.parametrize("window", nip.Window)
def test_what_was_simulated_with_what_work(window: nip.Window) -> None:
    """Model, speed, window, the values behind the command line's shortcuts, residuals, work."""
    overrides = {"stops.jaw.restitution": 0.3, "springs.steeve.stiffness_N_per_m": 10_000.0}
    solution = nip.simulate(nip.load("e62", overrides), nip.Case(speed_rpm=650.0, window=window))
    document = document_of(solution)
    # The keys carry their unit, so they are the last steps of the shortcuts' paths.
    wanted = {
        "model": "e62", "speed_rpm": 650.0, "window": window.value, "drive": "held",
        "rest_rate": None, "restitution": 0.3, "stiffness_N_per_m": 10_000.0,
        "preload_length_mm": 11.0,
    }  # fmt: skip
    assert document["case"].items() >= wanted.items()
    assert set(solution.mechanism.shortcuts) == {"restitution", "stiffness", "preload"}
    checks, work = document["checks"], document["work"]
    assert 0.0 <= checks["closure_m"] <= 1e-12
    assert checks.keys() >= {"closure_rate_m_s"}
    assert 0.0 <= checks["energy_balance"] <= 1e-9
    assert work["evaluations"] == solution.evaluations > 0
    assert work["wall_s"] > 0.0


def test_an_unfinished_run_has_nulls_and_no_nan() -> None:
    document = document_of(
        nip.simulate(nip.load("e62"), nip.Case(speed_rpm=650.0, max_collisions=2))
    )
    assert document["collisions"][-1]["rebound_time_s"] is None
    assert document["collisions"][-1]["rebound_amplitude"] is None
    assert document["transition"]["duration_s"] is None
    assert document["transition"]["first_two_share"] is None
    assert document["transition"]["collisions"] == len(document["collisions"])


def test_a_run_without_collisions_counts_from_its_start() -> None:
    """A four-bar has no stops: no collisions, no transition, one phase from zero to the end."""
    case = nip.Case(speed_rpm=60.0, window=nip.Window.CYCLE, start_index=0.0)
    document = document_of(nip.simulate(nip.load(FOUR_BAR), case))
    assert document["collisions"] == []
    assert len(document["phases"]) == 1
    assert document["phases"][0]["start_s"] == 0.0
    assert document["phases"][0]["end_s"] == pytest.approx(1.0, rel=1e-15)
    assert document["transition"]["duration_s"] is None

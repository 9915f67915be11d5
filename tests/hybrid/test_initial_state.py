"""`[initial]`: coordinates and rates of the start, assembled against the closures."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from small_machines import frame, hinge, link, machine, slide, sources, turn

import nipper_pin as nip
from nipper_pin.mechanism import changed, from_sources, number_of

RADIUS, LENGTH = 0.03, 0.1


def test_an_oscillator_starts_where_and_as_fast_as_it_is_told() -> None:
    """x = x0 cos w t + v0 / w sin w t."""
    parts = [link("ram", mass=2.0), slide("ram", "frame", "ram")]
    springs = {"pull": {"joint": "ram", "stiffness_N_per_m": 800.0, "preload_length_mm": 0.0}}
    initial = {"ram": {"at_mm": 12.0, "rate_mm_per_s": -300.0}}
    solution = turn(machine(parts, 1, springs=springs, initial=initial))
    t = np.linspace(0.0, 1.0, 11)
    expected = 0.012 * np.cos(20.0 * t) - 0.015 * np.sin(20.0 * t)
    assert solution.trajectory.evaluate(t).q[:, 0] == pytest.approx(expected, abs=1e-11)


def _slider_crank(**tables: Any) -> nip.Mechanism:
    """A crank that stands to the right at touch, its ram on the x axis; nothing drives it."""
    parts = [
        link("crank"), hinge("crank", "frame", "crank"), frame("crank_pin", "crank", (RADIUS, 0.0)),
        link("ram"), slide("ram", "frame", "ram", at=(RADIUS + LENGTH, 0.0)),
        link("rod"), hinge("rod", "ram", "rod"), frame("rod_head", "rod", (-LENGTH, 0.0)),
    ]  # fmt: skip
    pin = {"pin": {"frame_a": "crank_pin", "frame_b": "rod_head"}}
    return machine(parts, 1, closures=pin, **tables)


@pytest.mark.parametrize("angle", [35.0, 160.0, -250.0])
def test_links_of_a_loop_follow_what_is_given(angle: float) -> None:
    """x = r cos a + sqrt(l2 - r2 sin2 a), and its rate."""
    initial = {"crank": {"at_deg": angle, "rate_rad_per_s": 2.0}}
    solution = turn(_slider_crank(initial=initial))
    state = solution.trajectory.evaluate(np.zeros(1))
    place = {joint.name: joint.index for joint in solution.mechanism.joints}
    a = math.radians(angle)
    root = math.sqrt(LENGTH**2 - (RADIUS * math.sin(a)) ** 2)
    x = RADIUS * math.cos(a) + root - RADIUS - LENGTH
    rate = 2.0 * (-RADIUS * math.sin(a) - RADIUS**2 * math.sin(a) * math.cos(a) / root)
    assert state.q[0, place["crank"]] == a
    assert state.q[0, place["ram"]] == pytest.approx(x, abs=1e-14)
    assert state.v[0, place["ram"]] == pytest.approx(rate, abs=1e-13)


def test_the_other_end_of_a_loop_may_be_given() -> None:
    """Crank and rod of a three-link chain stand bent, so the ram's place determines them."""
    told = turn(_slider_crank(initial={"rod": {"at_deg": 10.0}}))
    state = told.trajectory.evaluate(np.zeros(1))
    place = {joint.name: joint.index for joint in told.mechanism.joints}
    sine = LENGTH * math.sin(math.radians(10.0)) / RADIUS
    assert abs(math.sin(state.q[0, place["crank"]])) == pytest.approx(sine, abs=1e-14)


def test_a_start_can_be_set_without_being_in_the_file() -> None:
    urdf, description = sources([link("ram"), slide("ram", "frame", "ram")], 1)
    plain = from_sources("small", urdf, description, ".")
    assert plain.starts == ()
    assert number_of(plain, "initial.ram.at_mm") == 0.0
    given = changed(plain, {"initial.ram.at_mm": "3.5", "initial.ram.rate_mm_per_s": 1})
    (start,) = given.starts
    assert (start.at, start.rate) == (0.0035, 0.001)
    assert number_of(given, "initial.ram.at_mm") == 3.5
    with pytest.raises(nip.UnknownNameError, match="no joint named 'rma'"):
        changed(plain, {"initial.rma.at_mm": 1.0})
    with pytest.raises(nip.UnknownNameError, match="no key named 'at'; known: at_deg, at_mm, rate"):
        changed(plain, {"initial.ram.at": 1.0})
    assert changed(given, {"initial.ram.at_mm": 0.0}).starts[0].at == 0.0
    assert "initial" not in description


def test_a_start_on_a_stop_that_it_strikes_is_a_collision() -> None:
    parts = [link("ram"), slide("ram", "frame", "ram")]
    stops = {"floor": {"joint": "ram", "restitution": 0.5, "at_mm": -4.0}}
    initial = {"ram": {"at_mm": -4.0, "rate_mm_per_s": -100.0}}
    solution = turn(machine(parts, 1, stops=stops, initial=initial))
    (hit,) = solution.collisions
    assert hit.t == 0.0
    assert hit.separation_rate == pytest.approx(0.05, rel=1e-14)


def test_a_joint_on_its_stop_has_no_start_of_its_own() -> None:
    """Without a start free coordinates begin at touch and at rest; other mistakes: `refusals`."""
    parts = [
        link("sled"),
        slide("sled", "frame", "sled"),
        link("ball"),
        slide("ball", "sled", "ball"),
    ]
    tables: dict[str, Any] = {
        "drives": {"sled": {"joint": "sled", "law": "screw", "lead_mm_per_turn": 5.0}},
        "stops": {"floor": {"joint": "ball", "restitution": 0.5, "at_mm": -4.0}},
        "phases": [{"number": 1, "name": "open", "closed": []},
                   {"number": 2, "name": "shut", "closed": ["floor"]}],
    }  # fmt: skip
    state = turn(machine(parts, 2, **tables)).trajectory.evaluate(np.zeros(1))
    assert state.q[0, 1] == state.v[0, 1] == 0.0
    with pytest.raises(nip.InputError, match=r"stands on stop 'floor' in phase 2"):
        turn(machine(parts, 2, **tables, initial={"ball": {"at_mm": 1.0}}, initial_phase=2))


def test_more_than_is_free_is_refused() -> None:
    both = {"crank": {"at_deg": 10.0}, "ram": {"at_mm": -1.0}}
    with pytest.raises(nip.InputError, match=r"crank, ram.*are 2 coordinates.*leave 1 free"):
        turn(_slider_crank(initial=both))


def test_a_place_out_of_reach_says_by_how_much() -> None:
    """The rod is longer than the crank and turns by 17.46 degrees at most."""
    with pytest.raises(
        nip.ConvergenceError, match=r"mm remain.*closure 'pin'.*rod where .initial. says"
    ) as bad:
        turn(_slider_crank(initial={"rod": {"at_deg": 30.0}}))
    assert bad.value.evidence["residual"] > 0.0

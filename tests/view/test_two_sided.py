"""What people see of stops on the upper side and away from zero: gaps, not coordinates."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from rich.console import Console
from runs_shown import run_of
from small_machines import SHAFT, frame, hinge, link, machine, slide

from nipper_pin import Case, Window, load_solution, record, save, simulate
from nipper_pin.study.check import check_model
from nipper_pin.study.next_steps import NextSteps
from nipper_pin.view.scene import Look, film
from nipper_pin.view.scene.rebounds import rebound_flights
from nipper_pin.view.studies.check_report import print_report


def test_an_exaggerated_gap_opens_away_from_its_stop() -> None:
    """Drawn five times as large, the gap of an upper stop grows downwards from the stop's place."""
    parts = [
        link("crank", 1.0, 0.1), hinge("crank_axis", "frame", "crank", (1.0, 0.0)),
        link("hand"), slide("reach", "crank", "hand"),
    ]  # fmt: skip
    drives = {"crank": {"joint": "crank_axis", "law": "fourier", "sine_rad": [0.5], **SHAFT}}
    stop = {"joint": "reach", "restitution": 0.5, "side": "upper", "at_mm": 2.0}
    spring = {"joint": "reach", "stiffness_N_per_m": 9.0, "preload_length_mm": -4.0}
    mechanism = machine(parts, 2, drives=drives, stops={"end": stop}, springs={"s": spring})
    solution = simulate(mechanism, Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0))
    plain, large = film(solution, Look()), film(solution, Look(exaggerate=5.0))
    end = mechanism.stop("end")
    gap, drawn = end.gaps(plain.drawn), end.gaps(large.drawn)
    t, limit = plain.pace.machine, 0.03 * mechanism.reach_m
    for hit in solution.collisions[:2]:
        rebound = (t >= hit.t) & (t <= hit.t + hit.rebound_time)
        assert 0.0 < hit.rebound_amplitude < limit / 5.0
        assert drawn[rebound] == pytest.approx(5.0 * gap[rebound], rel=1e-9, abs=1e-15)
    assert drawn.min() >= -1e-15


def test_the_heights_drawn_larger_are_those_of_the_transition_stop() -> None:
    """Of two balls that fall from one height and are struck together, that of its own floor."""
    both = run_of("balls")
    e_N = both.mechanism.stop(both.mechanism.transition_stop).restitution
    assert rebound_flights(both)[0].highest == pytest.approx(e_N**2 * 0.1, rel=1e-12)


def test_a_saved_run_keeps_its_stops(tmp_path: Path) -> None:
    """Sides and places survive a file."""
    boxed = run_of("boxed")
    again = load_solution(save(boxed, tmp_path / "box"))
    stops = [(stop.name, stop.sense, stop.at) for stop in boxed.mechanism.stops]
    assert [(stop.name, stop.sense, stop.at) for stop in again.mechanism.stops] == stops
    assert record(again)["collisions"] == record(boxed)["collisions"]


def test_the_report_shows_limits_and_slots() -> None:
    """Side, joint and place of every stop; a pin in a slot with the frame and axis it slides in."""
    parts = [
        link("crank"), hinge("crank_axis", "frame", "crank"),
        frame("crank_pin", "crank", (0.05, 0.0)),
        link("yoke"), slide("yoke_x", "frame", "yoke", at=(0.05, 0.0)),
        link("mass"), slide("room", "yoke", "mass"),
    ]  # fmt: skip
    mechanism = machine(
        parts, 2,
        drives={"crank": {"joint": "crank_axis", "law": "constant_speed", "ratio": 1.0, **SHAFT}},
        closures={"slot": {"frame_a": "yoke", "frame_b": "crank_pin", "slot_axis": "z",
                           "block_mass_kg": 0.1}},
        stops={"near": {"joint": "room", "restitution": 0.5, "at_mm": -4.0},
               "far": {"joint": "room", "restitution": 0.5, "side": "upper", "at_mm": 6.0}},
    )  # fmt: skip
    text = io.StringIO()
    nothing = NextSteps((), ())
    print_report(check_model(mechanism, 60.0), nothing, Console(file=text, width=120))
    assert "stop near: restitution 0.5, lower limit of room at -4 mm;" in text.getvalue()
    assert "stop far: restitution 0.5, upper limit of room at 6 mm;" in text.getvalue()
    row = next(line for line in text.getvalue().splitlines() if "pin in a slot" in line)
    assert row.split() == ["slot", "pin", "in", "a", "slot", "yoke", "along", "z", "crank_pin"]

"""What people see of stops on the upper side and away from zero: gaps, not coordinates."""

from __future__ import annotations

import io

import numpy as np
import pytest
from boxed_mass import HEIGHT, box
from rich.console import Console
from small_machines import SHAFT, frame, hinge, link, machine, slide

from nipper_pin import Case, Solution, Window, load_solution, record, save, simulate
from nipper_pin.study.check import check_model
from nipper_pin.study.next_steps import NextSteps
from nipper_pin.view.run.table import print_solution
from nipper_pin.view.run.timelines import motion_figure
from nipper_pin.view.scene import Look, film
from nipper_pin.view.scene.arrows import arrow_place
from nipper_pin.view.scene.page import scene_page
from nipper_pin.view.scene.readings import readings
from nipper_pin.view.studies.check_report import print_report


@pytest.fixture(scope="module")
def boxed() -> Solution:
    """The box with its coordinate downwards: the floor is an upper stop at 150 mm."""
    case = Case(speed_rpm=60.0, window=Window.CYCLE, cycles=2, start_index=0.0)
    return simulate(box(-1.0, 0.15), case)


def printed(boxed: Solution) -> str:
    """The tables as text."""
    text = io.StringIO()
    print_solution(boxed, Console(file=text, width=120), with_forces=True)
    return text.getvalue()


def test_the_table_counts_rates_from_the_stop(boxed: Solution) -> None:
    """The first collision of the upper floor has a negative approach rate and a positive impulse.

    Its coordinate grows there, so a table of coordinates would show 5000 mm/s before it.
    """
    text = printed(boxed)
    assert "Collisions of stop floor" in text
    assert "Collisions of stop ceiling" in text
    first = next(line for line in text.splitlines() if line.split()[:2] == ["1", "1.200"])
    assert first.split()[3:5] == ["-5000", "3750"]
    found = record(boxed)["collisions"]
    assert all(item["approach_rate"] < 0.0 < item["separation_rate"] for item in found)
    assert all(item["impulse_N_s"] > 0.0 for item in found)


def test_figures_show_gaps(boxed: Solution) -> None:
    """Both panels of the one joint show its gaps, which add up to the height of the box."""
    panels = {axes.get_ylabel(): axes.lines[0].get_ydata() for axes in motion_figure(boxed).axes}
    floor, ceiling = (np.asarray(panels[f"{name} gap [mm]"]) for name in ("floor", "ceiling"))
    assert min(floor.min(), ceiling.min()) >= -1e-9
    assert floor + ceiling == pytest.approx(1e3 * HEIGHT, rel=1e-12)
    assert "shelf stroke [mm]" in panels


def test_the_viewer_reads_gaps_and_pushes_away_from_the_stop(boxed: Solution) -> None:
    """The page has a number for each gap; the arrow of the floor points up, of the ceiling down.

    The slide's axis points down, so the arrow along the coordinate would be the wrong way round.
    """
    shown = film(boxed, Look())
    columns = {item["label"]: item["values"] for item in readings(shown)["columns"]}
    assert min(columns["floor gap"]) >= 0.0
    assert max(columns["floor gap"]) == pytest.approx(1e3 * HEIGHT, rel=1e-2)
    for name, up in (("floor", 1.0), ("ceiling", -1.0)):
        place = arrow_place(boxed.mechanism, boxed.mechanism.stop(name))
        assert place[:3, 1] == pytest.approx([0.0, 0.0, up], abs=1e-12)
    assert len(scene_page(shown)) > 1000


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


def test_a_saved_run_keeps_its_stops(boxed: Solution, tmp_path) -> None:
    """Sides and places survive a file: every table of the run read back is the same."""
    again = load_solution(save(boxed, tmp_path / "box"))
    stops = [(stop.name, stop.sense, stop.at) for stop in boxed.mechanism.stops]
    assert [(stop.name, stop.sense, stop.at) for stop in again.mechanism.stops] == stops
    assert record(again)["collisions"] == record(boxed)["collisions"]
    assert printed(again) == printed(boxed)


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

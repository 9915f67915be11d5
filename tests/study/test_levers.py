"""Levers: the strongest numbers of a machine, changed by one unit, against machines loaded so."""

from __future__ import annotations

from pathlib import Path

import pytest
from snapshots import Words

from nipper_pin import Case, Mechanism, SimulationError, load, simulate
from nipper_pin.hybrid.result.turns import reported_turn
from nipper_pin.mechanism import number_of
from nipper_pin.study.levers import Bounce, Lever, Levers, every_path, levers

SPEED = 650.0
GALLERY = Path(__file__).parents[2] / "nipper_pin" / "mechanism" / "gallery"
CHANGEABLE = ("springs.", "points.", "drives.", "stops.jaw.")


@pytest.fixture(scope="module")
def found(e62: Mechanism) -> Levers:
    done: list[tuple[int, int]] = []
    result = levers(e62, SPEED, progress=lambda *counts: done.append(counts))
    count = len(every_path(e62))
    assert done == [(k, count) for k in range(1, count + 1)]
    return result


def test_every_number_is_asked_for_once(e62: Mechanism) -> None:
    """Each dimension that is not in the frame appears once, a cut pin under one name."""
    paths = every_path(e62)
    assert len(set(paths)) == len(paths)
    pins = [path.removeprefix("points.") for path in paths if path.startswith("points.")]
    # A point that a crank turns by its radius and angle, others by their coordinates.
    assert sorted(pins) == sorted([
        *(f"{pin}.{axis}" for pin in ("nipper_pivot", "rocker_pin", "jaw", "rod_pin")
          for axis in ("x_mm", "z_mm")),
        "eccentric_pin.radius_mm", "eccentric_pin.angle_deg",
    ])  # fmt: skip
    assert {path.split(".")[1] for path in paths if path.startswith("links.")} == set(e62.links)
    heads = ("points.", "links.")
    assert {path for path in paths if not path.startswith(heads)} == {
        "drives.pendulum.crank_radius_mm", "drives.pendulum.guide_offset_mm",
        "drives.tension.ratio", "stops.jaw.restitution", "springs.steeve.stiffness_N_per_m",
        "springs.steeve.preload_length_mm", "stops.steeve.restitution",
    }  # fmt: skip


def test_levers_are_the_strongest_of_machines_loaded_so(e62: Mechanism, found: Levers) -> None:
    """All numbers of the nipper, each changed both ways by one unit, loaded and run."""

    def bounce(path: str, value: float) -> tuple[float, float]:
        run = simulate(load("e62", {path: value}), Case(speed_rpm=SPEED))
        first = run.collisions[0].rebound_amplitude
        assert first is not None
        return first, run.transitions[0].duration

    here = simulate(e62, Case(speed_rpm=SPEED))
    assert found.bounce.amplitude == pytest.approx(here.collisions[0].rebound_amplitude, rel=1e-8)
    assert found.bounce.duration_s == pytest.approx(here.transitions[0].duration, rel=1e-8)
    assert found.approach_rate == here.collisions[0].approach_rate
    best: dict[str, tuple[float, float, str]] = {}
    for path in every_path(e62):
        if not path.startswith(CHANGEABLE):
            continue
        value = number_of(e62, path)
        unit = 1.0 if path.endswith(("_mm", "_deg")) else 0.01 * abs(value)
        for new in (value - unit, value + unit):
            try:
                lower = bounce(path, new)[0]
            except SimulationError:
                continue
            part = path.rpartition(".")[0]
            best[part] = min(best.get(part, (lower, new, path)), (lower, new, path))
    wanted = sorted(best.values())[:3]
    assert [item.path for item in found.found] == [path for _, _, path in wanted]
    for item, (lower, new, path) in zip(found.found, wanted, strict=True):
        assert item.new == pytest.approx(new, rel=1e-12)
        assert item.after.amplitude == pytest.approx(lower, rel=1e-8)
        assert item.after.duration_s == pytest.approx(bounce(path, new)[1], rel=1e-8)
        turns = Case(speed_rpm=SPEED, window="cycle", cycles=20)
        turn = reported_turn(simulate(load("e62", {path: new}), turns), least_force=0.0)
        assert item.after.clamped_time_s == pytest.approx(turn.clamped_time, rel=1e-9)


def test_a_document_holds_what_was_found(found: Levers) -> None:
    record = found.record()
    assert (record["model"], record["stop"], record["speed_rpm"]) == ("e62", "jaw", SPEED)
    assert record["premise_holds"] is True
    assert record["rebound_amplitude_1"] == found.bounce.amplitude
    for row, item in zip(record["levers"], found.found, strict=True):
        assert (row["path"], row["old"], row["new"]) == (item.path, item.old, item.new)
        told = row["rebound_amplitude_1"], row["duration_s"], row["clamped_time_s"]
        assert told == (item.after.amplitude, item.after.duration_s, item.after.clamped_time_s)
        assert item.amplitude_change < 0.0


def test_a_machine_without_transition_is_judged_by_its_turns() -> None:
    """A lever that is struck somewhere along the turn, and none in the touch configuration."""
    own = load(GALLERY / "chebyshev.toml")
    result = levers(own)
    turn = reported_turn(simulate(own, window="cycle", cycles=20), least_force=0.0)
    assert (result.bounce.amplitude, result.bounce.duration_s) == (turn.largest_gap, None)
    assert result.bounce.clamped_time_s == turn.clamped_time
    assert result.found
    for item in result.found:
        other = simulate(load(GALLERY / "chebyshev.toml", {item.path: item.new}), window="cycle",
                         cycles=20)  # fmt: skip
        after = reported_turn(other, least_force=0.0)
        assert item.after.amplitude == pytest.approx(after.largest_gap or 0.0, rel=1e-12)
        assert item.duration_change is None


@pytest.mark.slow
def test_the_bounce_of_the_turn_where_the_machine_arrives_otherwise() -> None:
    """12.6 mrad in the turn, and 7.1 as a transition assumes."""
    own = load("e62", {"preload": 9.25486, "stiffness": 7065.98, "restitution": 0.18674})
    result = levers(own, 681.27)
    assert result.premise_holds is False
    assert result.bounce.amplitude == pytest.approx(12.614e-3, rel=1e-3)


BEFORE, AFTER = Bounce(4e-3, 8e-3, 0.02), Bounce(3e-3, 6e-3, 0.03)
CHANGED = [
    ("points.rocker_pin.x_mm", "1 mm", 3.0, 2.0),
    ("points.rocker_pin.z_mm", "1 mm", 3.0, 4.0),
    ("points.jaw.x_mm", "0.1 mm", 3.0, 3.1),
    ("points.nipper_pivot.radius_mm", "1 mm", 5.0, 4.0),
    ("points.a_pin.angle_deg", "1 deg", 5.0, 4.0),
    ("springs.steeve.preload_length_mm", "1 mm", 11.0, 12.0),
    ("stops.jaw.restitution", "1 %", 0.2, 0.198),
    ("links.top.mass_kg", "0.1 g", 0.0, 1e-4),
]


def test_a_lever_in_words(words: Words) -> None:
    found = [Lever(*changed, BEFORE, AFTER) for changed in CHANGED]
    words("".join(f"{item}: {item.values}, {item.setting}\n" for item in found))
    assert (found[0].amplitude_change, found[0].duration_change) == (-0.25, pytest.approx(-0.25))

"""Two runs compared: every number by another way, signs, and what cannot be compared."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from runs_shown import run_of

import nipper_pin as nip
from nipper_pin import Case, EventKind, Mechanism, Solution
from nipper_pin.mechanism import number_of
from nipper_pin.study.compare import Change, Row

# At 650 r/min the steeve bounces before the jaw closes.
A_RPM, B_RPM = 450.0, 650.0


@pytest.fixture(scope="module")
def runs(e62: Mechanism) -> tuple[Solution, Solution]:
    """The estimate at two speeds, with another preload in the second."""
    other = nip.load("e62", {"preload": 9.25})
    cases = (Case(speed_rpm=rpm, window="cycle") for rpm in (A_RPM, B_RPM))
    return tuple(nip.simulate(*pair) for pair in zip((e62, other), cases, strict=True))


@pytest.fixture(scope="module")
def compared(runs: tuple[Solution, Solution]) -> nip.Comparison:
    return nip.compare(*runs)


def struck(run: Solution, stop: str) -> list[nip.Event]:
    return [item for item in run.events if item.kind is EventKind.COLLISION and stop in item.stops]


def by_hand(run: Solution) -> dict[str, float]:
    """The table from events and dense samples alone, without tables of collisions and turns."""
    stop = run.mechanism.stop("jaw")
    hits = struck(run, "jaw")
    rest = next(item for item in run.events if item.kind is EventKind.REST and "jaw" in item.stops)
    inner = np.linspace(hits[0].t, hits[1].t, 401)[1:-1]
    heights = stop.gaps(run.trajectory.evaluate(inner).q)
    opened = next(item for item in struck(run, "steeve") if item.t > rest.t)
    held = np.linspace(rest.t + 1e-9, opened.t - 1e-9, 501)
    force = run.trajectory.reactions(held).contacts["jaw"]
    turn = 60.0 / run.case.speed_rpm
    sums = {name: sum(item.P_N[name] for item in struck(run, name)) for name in ("jaw", "steeve")}
    return {
        "rebound_amplitude_1": heights.max(),
        "rebound_time_s_1": hits[1].t - hits[0].t,
        "rebound_time_s_2": hits[2].t - hits[1].t,
        "duration_s": rest.t - hits[0].t,
        "collisions": len(hits),
        "impulse_N_s_1": hits[0].P_N["jaw"] / stop.lever,
        "closing_index": (24.0 + 40.0 * hits[0].t / turn) % 40.0,
        "rest_index": (24.0 + 40.0 * rest.t / turn) % 40.0,
        "opening_index": (24.0 + 40.0 * opened.t / turn) % 40.0,
        "clamped_time_s": opened.t - rest.t,
        "clamped_share": (opened.t - rest.t) / turn,
        "least_clamping_force_N": force.min(),
        "largest_clamping_force_N": force.max(),
        "collisions_steeve": len(struck(run, "steeve")),
        "impulse_sum_N_s_steeve": sums["steeve"],
        "largest_impulse_N_s_jaw": hits[0].P_N["jaw"] / stop.lever,
    }


# Between 400 samples a parabola is higher by at most 1/400**2 of its height, a force likewise. Of a
# series at restitution 0.2 the bounces after the sixth have 0.2**6 / 0.8 of the first impulse.
SAMPLED = {
    "rebound_amplitude_1": 1.0 / 400.0**2,
    "least_clamping_force_N": 1.0 / 400.0**2,
    "largest_clamping_force_N": 1.0 / 400.0**2,
    "impulse_sum_N_s_steeve": 0.2**6 / 0.8,
}


def test_the_numbers_are_those_of_the_runs(
    compared: nip.Comparison, runs: tuple[Solution, Solution]
) -> None:
    one, other = by_hand(runs[0]), by_hand(runs[1])
    for name, value in one.items():
        row, within = compared.row(name), SAMPLED.get(name, 1e-9)
        assert row.a == pytest.approx(value, rel=within), name
        assert row.b == pytest.approx(other[name], rel=within), name
        assert row.difference == row.b - row.a
        percent = 100.0 * (row.b - row.a) / abs(row.a)
        # An index is a place on a scale, of which there is no percentage.
        wanted = None if name.endswith("_index") else pytest.approx(percent, abs=1e-12)
        assert row.percent == wanted
    assert not compared.same


def test_a_run_against_itself_and_its_file(runs: tuple[Solution, Solution], tmp_path: Path) -> None:
    """All differences are zero, to the last bit; also of the run that was saved."""
    for other in (runs[0], nip.load_solution(nip.save(runs[0], tmp_path / "a.npz"))):
        found = nip.compare(runs[0], other)
        assert found.same
        assert found.changes == ()
        assert found.notes == ()
        assert {row.difference for row in found.rows} == {0.0, None}
        assert {row.percent for row in found.rows} == {0.0, None}


def test_what_differs_is_named_in_the_units_of_the_files(compared: nip.Comparison) -> None:
    assert compared.changes == (
        Change("speed_rpm", A_RPM, B_RPM),
        Change("springs.steeve.preload_length_mm", 11.0, 9.25),
    )


def test_moved_points_are_named_and_round_off_is_not(e62: Mechanism) -> None:
    """A pin that is moved along its link: the other end of the rod stays, but for the last bit."""
    other = nip.load("e62", {"points.rod_pin.radius_mm": 100.0, "links.top_nipper.mass_kg": 1.5})
    case = Case(speed_rpm=A_RPM)
    changes = nip.compare(nip.simulate(e62, case), nip.simulate(other, case)).changes
    found = {item.path: (item.a, item.b) for item in changes}
    points = {path for path in found if path.startswith("points.")}
    assert points == {"points.rod_pin.x_mm", "points.rod_pin.z_mm"}
    for place in points:
        assert found[place][1] == pytest.approx(number_of(other, place), abs=1e-12)
    assert found["links.top_nipper.mass_kg"][1] == 1.5
    assert not any("inertia" in path or "rocker" in path for path in found)


def test_a_document_holds_the_table(compared: nip.Comparison) -> None:
    document = json.loads(json.dumps(compared.record(), allow_nan=False))
    rows = {row["name"]: row for row in document["rows"]}
    row = compared.row("duration_s")
    told = tuple(rows["duration_s"][key] for key in ("unit", "a", "difference_percent"))
    assert told == ("s", row.a, row.percent)
    assert rows["loss_index"]["difference"] is None
    # Without a value in A, or with zero there, no share can be told; equal zeros are equal.
    pairs = (0.0, 1.0), (None, 1.0), (0.0, 0.0), (-2.0, -3.0)
    assert [Row("x", "", *pair).percent for pair in pairs] == [None, None, 0.0, -50.0]
    assert document["a"]["speed_rpm"] == A_RPM
    assert document["changes"][0] == {"path": "speed_rpm", "a": A_RPM, "b": B_RPM}


def test_machines_of_other_parts_are_compared_as_far_as_they_go(
    runs: tuple[Solution, Solution],
) -> None:
    """Both have a jaw; the steeve of one and the rod of the other are named and left out."""
    pendulum = nip.load("hanging_pendulum")
    other = nip.simulate(pendulum, Case(speed_rpm=220.0, window="cycle"))
    found = nip.compare(runs[0], other)
    names = {row.name for row in found.rows}
    assert {"duration_s", "least_clamping_force_N", "collisions_jaw"} <= names
    assert not any("steeve" in name or "_rod" in name for name in names)
    notes = " ".join(found.notes)
    assert "Only A has the stop steeve, which is not compared." in notes
    assert "Only B has the stop rod, which is not compared." in notes
    assert "Only B has the links cylinder, connecting_rod" in notes
    assert found.row("duration_s").b == pytest.approx(other.transitions[0].duration, rel=1e-12)


def test_gaps_in_other_units_are_left_out(runs: tuple[Solution, Solution]) -> None:
    """The jaw turns and a ball slides: times can be compared, amplitudes cannot."""
    found = nip.compare(runs[0], run_of("balls"))
    names = {row.name for row in found.rows}
    assert "duration_s" in names
    assert not any("amplitude" in name or "gap" in name for name in names)
    notes = " ".join(found.notes)
    assert "The transition is that of the jaw in A and of the s1 in B." in notes
    assert "because one turns and the other slides" in notes

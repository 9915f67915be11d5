"""Whole turns of the reduced engine, judged by the certified turns and by the direct engine."""

from __future__ import annotations

import copy
from dataclasses import replace
from itertools import groupby
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from benchmarks.run_time.certified import certified_cycle
from nipper_pin import (
    Case,
    EventKind,
    InputError,
    Mechanism,
    NipperError,
    SimulationError,
    Solution,
    UnknownNameError,
    load,
    simulate,
)
from nipper_pin.mechanism import Stop, from_sources
from nipper_pin.mechanism.gallery import GALLERY, drawn
from nipper_pin.reduced.kernels import layout
from nipper_pin.reduced.tables.functions import Sampler
from nipper_pin.reduced.turns import ReducedTurns, TurnStatus, arcs, build_turns, turn_model, turns
from nipper_pin.reduced.turns import turn as module
from nipper_pin.tolerances.mechanics import EPS

PERIOD = {"450": 60.0 / 450.0, "650": 60.0 / 650.0}
KINDS = {EventKind.COLLISION: "collision", EventKind.REST: "rest", EventKind.RELEASE: "release"}
# Two stops on one side, on both sides, a damper, an upper stop, a start in flight.
FEW = ("crank_rocker", "ratchet_feed", "door_closer", "jaw_crusher", "hoeken", "bell")
# Turns that the reduced engine does not follow, of 47 machines at three speeds: a machine with two
# freedoms, one whose flight leaves the tables (twice), one that round-off decides on.
REFUSED = 6
ORIFICE = {"joint": "steeve", "law": "orifice", "c_N_s2_per_m2": 2e3}


def series(stops: Any, *columns: Any) -> list[list[tuple[Any, ...]]]:
    """Consecutive collisions of one stop."""
    rows = zip(stops, *columns, strict=True)
    return [list(group) for _, group in groupby(rows, lambda row: row[0])]


@pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-10, 1e-12])
@pytest.mark.parametrize("speed", ["450", "650"])
def test_certified_turns(e62: Mechanism, speed: str, tolerance: float) -> None:
    """Every collision, of both stops, within the stated errors and these within the tolerance.

    The reference is a solution in 60 digits that shares nothing with the package; times of the late
    bounces and their impulses, which fall by 1/5 each, do not come out right by accident.
    """
    found = turns(e62, speed_rpm=float(speed), tolerance=tolerance)
    hits = found.collisions
    stops = np.array(found.stop)[hits]
    mine = series(
        stops, found.time[hits], found.time_error[hits], found.impulse[hits],
        found.impulse_error[hits], found.approach_rate[hits], found.rate_error[hits],
        found.energy_lost[hits],
    )  # fmt: skip
    rows = certified_cycle(speed)
    true = [list(group) for _, group in groupby(rows, lambda row: row["stop"])]
    assert [group[0][0] for group in mine] == [group[0]["stop"] for group in true]
    for group, wanted in zip(mine, true, strict=True):
        assert len(group) >= 4
        for row, right in zip(group, wanted, strict=False):
            _, t, t_error, P, P_error, v, v_error, lost = row
            P_true = float(right.get("impulse_lip_N_s", right["impulse"]))
            assert abs(t - float(right["time_s"])) <= t_error
            assert abs(P - P_true) <= P_error
            assert abs(v - float(right["approach_rate"])) <= v_error
            assert lost == pytest.approx(float(right["energy_lost_J"]), rel=3.0 * v_error / abs(v))
            assert t_error <= 1e2 * tolerance * PERIOD[speed]
    rests = np.array([kind == "rest" for kind in found.kind])
    assert rests.sum() == len(true)


@pytest.mark.parametrize("speed", [450.0, 650.0, 900.0, 1200.0])
def test_turns_of_the_nipper_are_those_of_the_direct_engine(e62: Mechanism, speed: float) -> None:
    """Three turns; at 1,200 r/min the first differs from the others, and tables need more room."""
    found = turns(e62, speed_rpm=speed, cycles=3)
    direct = simulate(e62, Case(speed_rpm=speed, window="cycle", cycles=3))
    assert compared(found, direct) >= 12
    assert found.repeats_after == 1
    assert found.turns == (2 if speed == 1200.0 else 1)


def compared(found: ReducedTurns, direct: Solution) -> int:
    """Compare the events that both have; returns their number.

    A series may be ended at another bounce: its other collisions, within its own rest, are left
    out. Everything else has to come in the same order at the same stops.
    """
    errors = direct.errors
    mine = list(zip(found.kind, found.stop, found.time, found.time_error, strict=True))
    theirs = [
        (KINDS[event.kind], event.stops[0], event.t, error.time)
        for event, error in zip(direct.events, errors, strict=True)
    ]
    i = j = count = 0
    while i < len(mine) and j < len(theirs):
        if mine[i][:2] == theirs[j][:2]:
            allowed = mine[i][3] + theirs[j][3]
            assert abs(mine[i][2] - theirs[j][2]) <= allowed, (mine[i], theirs[j])
            i, j, count = i + 1, j + 1, count + 1
        elif mine[i][0] == "rest" and mine[i][1] == theirs[j][1]:
            j += 1
        else:
            assert theirs[j][0] == "rest", (mine[i], theirs[j])
            assert theirs[j][1] == mine[i][1]
            i += 1
    assert i == len(mine)
    return count


def judged(mechanism: Mechanism, factor: float) -> bool:
    """Whether the turns of a machine were followed; then they are those of the direct engine."""
    speed = factor * mechanism.cylinder.rated_speed_rpm
    try:
        found = turns(mechanism, speed_rpm=speed, cycles=2)
    except NipperError:
        return False
    direct = simulate(mechanism, Case(speed_rpm=speed, window="cycle", cycles=2))
    compared(found, direct)
    return True


@pytest.mark.parametrize("name", FEW)
def test_turns_of_machines_of_the_gallery(name: str) -> None:
    """At the rated speed, within both stated errors."""
    assert judged(drawn(name).mechanism(), 1.0)


@pytest.mark.campaign
def test_no_machine_of_the_gallery_is_followed_wrongly() -> None:
    """All machines at half, once and twice their rated speed: followed rightly, or refused."""
    refused = []
    for name in GALLERY:
        # Its tables are those of all three speeds.
        mechanism = drawn(name).mechanism()
        refused += [(name, factor) for factor in (0.5, 1.0, 2.0) if not judged(mechanism, factor)]
    assert len(refused) <= REFUSED, refused


def test_restitutions_springs_and_preloads_are_numbers_of_a_case(e62: Mechanism) -> None:
    """As if the mechanism had them: each changes the turn, and as the direct engine says."""
    base = turns(e62, speed_rpm=650.0)
    changes: list[tuple[dict[str, Any], dict[str, float]]] = [
        ({"restitution": 0.35}, {"stops.jaw.restitution": 0.35}),
        ({"restitution": {"steeve": 0.4}}, {"stops.steeve.restitution": 0.4}),
        ({"stiffness": 13000.0}, {"springs.steeve.stiffness_N_per_m": 13000.0}),
        ({"preload": 0.022}, {"springs.steeve.preload_length_mm": 22.0}),
    ]
    for keys, paths in changes:
        found = turns(e62, speed_rpm=650.0, **keys)
        changed = load("e62", paths)
        direct = simulate(changed, Case(speed_rpm=650.0, window="cycle"))
        assert compared(found, direct) >= 10
        assert found.table.tobytes() != base.table.tobytes()
        again = turns(changed, speed_rpm=650.0)
        # Tables of another mechanism differ by their own errors only.
        np.testing.assert_allclose(again.time, found.time, rtol=1e-9)


def test_a_rate_ends_series_at_the_first_slower_rebound(e62: Mechanism) -> None:
    """As the direct engine with the same threshold."""
    found = turns(e62, speed_rpm=450.0, rest_rate=1e-3)
    direct = simulate(e62, Case(speed_rpm=450.0, window="cycle", rest_rate=1e-3))
    assert found.kind == tuple(KINDS[event.kind] for event in direct.events)
    assert compared(found, direct) == len(direct.events)


def test_copies_of_a_turn_are_not_computed(e62: Mechanism) -> None:
    """A turn that begins and ends at rest repeats itself, however many are asked for."""
    one, many = (turns(e62, speed_rpm=450.0, cycles=cycles) for cycles in (1, 50))
    assert one.turns == many.turns == 1
    assert one.repeats_after == many.repeats_after == 1
    assert one.table.tobytes() == many.table.tobytes()


def test_a_turn_may_start_at_any_index_of_its_initial_phase(e62: Mechanism) -> None:
    """Ten indices earlier: the same collisions, a quarter of a turn later."""
    usual, early = (turns(e62, speed_rpm=450.0, start_index=index) for index in (24.0, 14.0))
    quarter = 0.25 * 60.0 / 450.0
    for stop in ("jaw", "steeve"):
        first, other = (
            next(t for t, name in zip(found.time, found.stop, strict=True) if name == stop)
            for found in (usual, early)
        )
        assert other == pytest.approx(first + quarter, abs=1e-13)


def test_arguments_and_machines_that_cannot_be_used(e62: Mechanism) -> None:
    """Each is refused with what is known."""
    with pytest.raises(UnknownNameError) as unknown:
        turns(e62, speed_rpm=450.0, restitution={"lip": 0.3})
    assert "steeve" in str(unknown.value)
    for keys in ({"cycles": 0}, {"speed_rpm": -1.0}, {"restitution": 1.5}, {"tolerance": 1.0}):
        with pytest.raises(InputError):
            turns(e62, **{"speed_rpm": 450.0, **keys})  # type: ignore[arg-type]
    with pytest.raises(InputError, match="and 2 are left"):
        turns(drawn("needle_bar").mechanism(), speed_rpm=60.0)
    with pytest.raises(SimulationError, match="max_collisions") as many:
        turns(e62, speed_rpm=450.0, max_collisions=3)
    assert many.value.evidence["status"] == TurnStatus.TOO_MANY_COLLISIONS.name


@pytest.mark.parametrize(
    ("section", "name", "key", "value", "reason"),
    [
        ("forces", "added", "", ORIFICE, "springs and linear dampers only, no .* 'added'"),
        ("stops", "jaw", "restitution_law", {"law": "falling", "fast": 0.1, "scale": 1.0},
         "'jaw' has a law"),
    ],
)  # fmt: skip
def test_laws_that_tables_cannot_hold_are_refused(
    e62: Mechanism, section: str, name: str, key: str, value: dict[str, Any], reason: str
) -> None:
    """Each changes the second collision of the direct engine; the tables are linear in rates."""
    data = copy.deepcopy(dict(e62.description))
    place = data.setdefault(section, {})
    if key:
        place[name][key] = value
    else:
        place[name] = value
    changed = from_sources("e62", e62.urdf, data, e62.mesh_folder)
    second, usual = (
        simulate(item, Case(speed_rpm=650.0)).collisions[1].t for item in (changed, e62)
    )
    assert abs(second - usual) > 1e-7
    with pytest.raises(InputError, match=reason):
        turns(changed, speed_rpm=650.0)


def test_a_stop_on_a_drive_is_refused(e62: Mechanism) -> None:
    """Before anything is sampled: its turns would be followed wrongly."""
    first, *others = e62.stops
    driven = replace(first, index=e62.drives[0].index)
    with pytest.raises(InputError, match="on a driven coordinate"):
        turns(replace(e62, stops=(driven, *others)), speed_rpm=450.0)


def test_a_run_ends_before_its_table_of_events_is_full(e62: Mechanism) -> None:
    """Whatever its length is: what lies beside it stays as it was."""
    model = turn_model(e62)
    run, told = module.run_of("turns", 1, None, 1e-10, 64), np.zeros((1, 4), dtype=np.int64)
    cases = module.turn_cases(model, 650.0, None, None, None)
    for most in range(1, 26):
        beside = np.full((1, most + 4, layout.COLUMNS), 7.0)
        module.follow(run, beside[:, :most], model, 1.0, cases, told, np.empty((1, 0, 0)))
        assert told[0, 3] <= most
        assert (beside[:, most:] == 7.0).all()
        assert told[0, 0] == (
            TurnStatus.TOO_MANY_COLLISIONS if most < 23 else TurnStatus.FOLLOWED
        )  # fmt: skip


@pytest.mark.parametrize("start", [24.0, 30.0])
def test_a_rebound_lasts_until_its_stop_is_struck_again(e62: Mechanism, start: float) -> None:
    """Also over the end of a turn, where another chart begins: before its top, or behind it."""
    bounces: dict[str, Any] = {"speed_rpm": 650.0, "cycles": 2, "start_index": start}
    found = turns(e62, **bounces, restitution={"steeve": 0.95})
    flown = np.flatnonzero(np.isfinite(found.rebound_time))
    ended = flown + 1
    assert (found.stop_number[flown] == found.stop_number[ended]).all()
    assert found.collisions[ended].all()
    turn = np.floor(found.travel / (2.0 * np.pi))
    apart = found.time[ended] - found.time[flown]
    round_off = 8.0 * np.finfo(float).eps * found.time[ended]
    assert (np.abs(found.rebound_time[flown] - apart) <= round_off).all()
    stated = found.time_error[ended] + found.time_error[flown]
    assert (found.rebound_error[flown] <= stated + round_off).all()
    over = turn[flown] < turn[ended]
    assert over.any()
    assert (found.rebound_error[flown] >= stated - round_off)[over].all()
    elastic = load("e62", {"stops.steeve.restitution": 0.95})
    direct = simulate(elastic, Case(window="cycle", **bounces))
    for place in flown[over]:
        hit = min(direct.collisions, key=lambda hit: abs(hit.t - found.time[place]))
        assert found.rebound_amplitude[place] == pytest.approx(hit.rebound_amplitude, rel=1e-9)


def test_charts_cover_the_turn_without_gaps(e62: Mechanism) -> None:
    """From stop to stop; where the nipper opens and closes as the direct engine has it."""
    charts = build_turns(e62).charts
    begin, travel = charts.numbers[:, [layout.BEGIN, layout.TRAVEL_MOST]].T
    assert begin[0] == 0.0
    np.testing.assert_allclose(begin[1:], (begin + travel)[:-1], rtol=1e-15)
    assert begin[-1] + travel[-1] == pytest.approx(2.0 * np.pi, rel=1e-15)
    assert charts.stops[:, layout.AFTER].tolist() == [1, 2, 0]
    direct = simulate(e62, Case(speed_rpm=450.0, window="cycle"))
    first = {hit.stop: hit for hit in reversed(direct.collisions)}
    for chart, name in ((1, "jaw"), (2, "steeve")):
        met = first[name].t * 450.0 * 2.0 * np.pi / 60.0
        assert begin[chart] == pytest.approx(met, rel=1e-13)


@pytest.mark.parametrize("depth", [1e-6, 1e-9, 1e-12, -1e-12, -1e-6])
def test_gaps_that_dip_between_two_steps(e62: Mechanism, depth: float) -> None:
    """A stop that the nipper passes by a little where it turns back, while the jaw is closed."""
    system = arcs.system_at(e62, 0.0, e62.cylinder.angle_at_touch_rad)
    sampler = Sampler(system, e62.stop("jaw"), np.zeros(len(e62.joints)))
    nipper = next(joint.index for joint in e62.joints if joint.name == "nipper_pivot")
    before = sampler.closed(0.85, np.zeros(len(e62.joints)))[0]

    def along(travel: float) -> tuple[float, float]:
        q, rates = sampler.closed(travel, before)
        return q[nipper], rates[nipper]

    lowest = brentq(lambda travel: along(travel)[1], 0.85, 0.9, xtol=1e-15)
    at = along(lowest)[0] + depth
    stop = Stop(name="beside", index=nipper, restitution=0.0, contact=None, sense=1.0, at=at)
    found = arcs._corner(sampler, stop, 0.85, 0.9, before)
    assert (found is not None) is (depth > 0.0)
    if found is not None:
        true = brentq(lambda travel: along(travel)[0] - at, 0.85, lowest, xtol=1e-15)
        # A round-off of the gap moves the place by that over its slope.
        assert abs(found[0] - true) * abs(along(true)[1]) <= 64.0 * EPS

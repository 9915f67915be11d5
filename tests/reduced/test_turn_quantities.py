"""Quantities and torques of turns, judged by certified turns and by the direct engine."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from held_turn import HeldTurn, quantities
from scipy.optimize import minimize_scalar

from nipper_pin import Case, EventKind, InputError, Mechanism, Solution, load, simulate
from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism.gallery import drawn
from nipper_pin.reduced.turns import TurnQuantities, TurnStatus, turn_quantities
from nipper_pin.reduced.turns import peak_torques as module

REFERENCE = Path(__file__).resolve().parents[1] / "reference/e62_cycle.json"
SPEEDS = {"450": 450.0, "650": 650.0}


@pytest.fixture(scope="module")
def true() -> dict[str, Any]:
    document: dict[str, Any] = json.loads(REFERENCE.read_text(encoding="utf-8"))
    return document


def both(found: TurnQuantities, quantity: str) -> tuple[FloatArray, FloatArray]:
    """Values, and bounds on their errors."""
    return getattr(found, quantity), getattr(found, f"{quantity}_error")


@pytest.mark.parametrize("name", SPEEDS)
def test_certified_quantities(e62: Mechanism, true: dict[str, Any], name: str) -> None:
    """Rests, forces at the lips and losses of an independent solution in 60 digits."""
    case = true["cases"][name]
    found = turn_quantities(e62, speed_rpm=SPEEDS[name])
    speed = SPEEDS[name] * math.pi / 30.0
    hits = [row for row in case["collisions"] if row["stop"] == "jaw"]
    held = next(row for row in case["phases"] if row["closed"] == "jaw")
    rest = next(row for row in case["rests"] if row["stop"] == "jaw")
    start, end = float(held["start_s"]), float(held["end_s"])
    for quantity, wanted in {
        "closed_at": speed * float(hits[0]["time_s"]),
        "rests_at": speed * float(rest["time_s"]),
        "opened_at": speed * end,
        "clamped": speed * (end - start),
        "clamped_time": end - start,
        "least_clamping_force": float(held["lip_force_min_N"]),
        "largest_clamping_force": float(held["lip_force_max_N"]),
        "largest_gap": max(float(row["rebound_amplitude"]) for row in hits),
        "energy_lost": float(case["energy_lost_total_J"]),
    }.items():
        (value,), (error,) = both(found, quantity)
        assert abs(value - wanted) <= error <= 1e-7 * wanted, quantity
    assert math.isnan(found.lost_at[0])
    assert found.clamping_force_error[0] == max(
        found.least_clamping_force_error[0], found.largest_clamping_force_error[0]
    )
    assert found.clamped_share[0] == pytest.approx((end - start) * SPEEDS[name] / 60.0, rel=1e-9)
    for place, stop in enumerate(("jaw", "steeve")):
        rows = [row for row in case["collisions"] if row["stop"] == stop]
        impulses = [float(row.get("impulse_lip_N_s", row["impulse"])) for row in rows]
        most = found.largest_impulse[0, place]
        assert abs(most - max(impulses)) <= found.largest_impulse_error[0, place] <= 1e-9 * most
        total = found.impulse_sum[0, place]
        error = found.impulse_sum_error[0, place]
        assert abs(total - sum(impulses)) <= error + 1e-8 * total
        assert error <= 1e-5 * total
        assert found.collisions[0, place] == 6.0 * (2 if (stop, name) == ("steeve", "650") else 1)
    assert (found.turns[0], found.repeats_after[0]) == (1, 1)


def test_a_batch_is_its_cases(e62: Mechanism) -> None:
    """To the last bit, also of cases that need tables with more room."""
    random = np.random.default_rng(8)
    speed, e_N = random.uniform(300.0, 1300.0, 12), random.uniform(0.05, 0.45, 12)
    k, p = random.uniform(8e3, 16e3, 12), random.uniform(0.015, 0.03, 12)
    many = turn_quantities(e62, speed_rpm=speed, restitution={"jaw": e_N, "steeve": 0.3},
                           stiffness=k, preload=p, turns=4)  # fmt: skip
    assert (many.status == TurnStatus.FOLLOWED).all()
    for i in range(12):
        one = turn_quantities(
            e62, speed_rpm=speed[i], restitution={"jaw": e_N[i], "steeve": 0.3},
            stiffness=k[i], preload=p[i], turns=4,
        )  # fmt: skip
        assert one.table.tobytes() == many.table[i].tobytes()
        assert one.turns[0] == many.turns[i]


@pytest.mark.parametrize("name", ["film_claw", "chebyshev"])
def test_a_force_that_falls_to_zero_is_a_loss(name: str) -> None:
    """The claw is left by its stop before any other throws it open, as the direct engine says."""
    mechanism = drawn(name).mechanism()
    speed = mechanism.cylinder.rated_speed_rpm
    found = turn_quantities(mechanism, speed_rpm=speed)
    run = simulate(mechanism, Case(speed_rpm=speed, window="cycle"))
    stop = mechanism.transition_stop
    lost = [event.t for event in run.events
            if event.kind is EventKind.RELEASE and event.stops[0] == stop]  # fmt: skip
    assert lost
    assert found.lost_at[0] == pytest.approx(speed * math.pi / 30.0 * lost[0], rel=1e-10)
    assert math.isnan(found.opened_at[0])


def test_cases_of_different_length_are_refused(e62: Mechanism) -> None:
    with pytest.raises(InputError, match="same number of cases"):
        turn_quantities(e62, speed_rpm=[450.0, 650.0], restitution=[0.1, 0.2, 0.3])
    with pytest.raises(InputError, match="turns"):
        turn_quantities(e62, speed_rpm=450.0, turns=0)


# Stated errors, against a solution in 80-bit arithmetic.

# Speed, restitutions of jaw and steeve, stiffness, preload, share of the range of the force.
TURNS = [
    pytest.param("733.3", "0.37", "0.11", "8123.5", "9.7", 0.4, marks=pytest.mark.campaign),
    ("1085.0", "0.08", "0.52", "10650.0", "13.1", 0.9),
    ("318.9", "0.61", "0.23", "6021.0", "6.4", 0.0),
]


@pytest.mark.skipif(
    np.finfo(np.longdouble).eps > 1e-18, reason="numpy.longdouble has no 80 bits on this machine"
)
@pytest.mark.parametrize(("speed", "jaw", "steeve", "k", "preload", "share"), TURNS)
def test_quantities_within_their_stated_errors(
    speed: str, jaw: str, steeve: str, k: str, preload: str, share: float
) -> None:
    """At a coarse, a usual and a fine tolerance; none is stated wastefully wide at all of them."""
    true = quantities(
        HeldTurn({"speed_rpm": speed, "jaw_restitution": jaw, "stop_restitution": steeve,
                  "stiffness_N_per_m": k, "preload_length_mm": preload}), share,
    )  # fmt: skip
    mechanism = load("e62", {
        "stops.jaw.restitution": float(jaw), "stops.steeve.restitution": float(steeve),
        "springs.steeve.stiffness_N_per_m": float(k),
        "springs.steeve.preload_length_mm": float(preload),
    })  # fmt: skip
    lever = math.hypot(0.0818, 0.0364)
    rate = np.longdouble(speed) * 8 * np.arctan(np.longdouble(1)) / 60
    ratios: dict[str, list[float]] = {}
    for tolerance in (1e-4, 1e-8, 1e-12):
        found = turn_quantities(mechanism, speed_rpm=float(speed), tolerance=tolerance,
                                least_force=true["level"])  # fmt: skip
        values = [
            (quantity, *both(found, quantity), true[key], by)
            for quantity, key, by in (
                *((name, name, rate) for name in ("closed_at", "rests_at", "lost_at", "opened_at")),
                ("clamped", "clamped", rate),
                ("clamped_time", "clamped", 1),
                ("least_clamping_force", "least_force", 1),
                ("largest_clamping_force", "most_force", 1),
                ("largest_gap", "largest_gap", 1),
                ("energy_lost", "energy_lost", 1),
            )
        ]
        for place, (stop, by) in enumerate((("jaw", 1.0 / lever), ("steeve", 1.0))):
            for key in ("impulse_sum", "largest_impulse"):
                value, error = (rows[:, place] for rows in both(found, key))
                values.append((f"{key} {stop}", value, error, true[f"{key}_{stop}"], by))
        for what, value, error, wanted, scale in values:
            if wanted is None:
                assert math.isnan(value[0]), what
                continue
            ratio = abs(value[0] - wanted * scale) / error[0]
            assert ratio <= 1.0, (what, tolerance)
            ratios.setdefault(what, []).append(float(ratio))
    assert all(max(row) > 1e-5 for row in ratios.values()), ratios


def test_the_gap_of_a_bounce_that_is_not_computed(e62: Mechanism) -> None:
    """The first one, where the series is over after its collision; a fine tolerance computes it."""
    soft = [3e-3, 1e-4, 1e-6]
    coarse, fine = (
        turn_quantities(e62, speed_rpm=450.0, restitution=soft, tolerance=tolerance)
        for tolerance in (1e-3, 1e-13)
    )
    assert (coarse.collisions[:, 0] == 1.0).all()
    assert (fine.collisions[:, 0] > 2.0).all()
    (gap, error), (true, left) = (both(found, "largest_gap") for found in (coarse, fine))
    assert (left <= 1e-11 * true).all()
    assert (np.abs(gap - true) <= error + left).all()
    assert (error <= 0.05 * true).all()


# Largest torques of the drives, judged by the forces of the direct engine.

# Forces of the direct engine between events, by their largest value.
DIRECT = 1e-9
PLACES = 60


def largest(run: Solution, drive: str, begin: float) -> float:
    """Largest torque from a time on: the peaks of a grid on every segment, refined."""
    most = 0.0
    rests = np.array([event.t for event in run.events if event.kind is EventKind.REST])
    for segment in run.segments:
        # A stretch at rest begins with the bounces that are not computed.
        inside = rests[(rests >= segment.t_start) & (rests < segment.t_end)]
        low, high = max(segment.t_start, begin, *inside), segment.t_end
        if high - low <= 1e-12 * run.shaft.period:
            continue
        t = np.linspace(low, high, PLACES + 1)
        first = run.trajectory.reactions(t[:-1]).drives[drive]
        last = run.trajectory.reactions(t[-1:], left=True).drives[drive]
        torque = np.abs([*first, *last])
        most = max(most, torque[0], torque[-1])
        for i in range(1, PLACES):
            if torque[i] >= max(torque[i - 1], torque[i + 1]) and torque[i] > 0.9 * most:

                def below(at: float) -> float:
                    return -abs(float(run.trajectory.reactions(at).drives[drive][0]))

                found = minimize_scalar(
                    below, bounds=(t[i - 1], t[i + 1]), method="bounded", options={"xatol": 1e-9}
                )
                most = max(most, -found.fun)
    return float(most)


def judged(mechanism: Mechanism, speed: float, turns: int) -> None:
    """The torques of the last turn, within the stated errors."""
    found = turn_quantities(mechanism, torques=True, speed_rpm=speed, turns=turns)
    assert found.status.tolist() == [TurnStatus.FOLLOWED]
    run = simulate(mechanism, Case(speed_rpm=speed, window="cycle", cycles=turns))
    for place, drive in enumerate(found.drives):
        true = largest(run, drive, (turns - 1) * run.shaft.period)
        value, error = found.largest_torque[0, place], found.largest_torque_error[0, place]
        assert true > 0.0
        assert abs(value - true) <= error + DIRECT * true
        assert error <= 1e-7 * true


@pytest.mark.parametrize(("speed", "turns"), [(450.0, 1), (650.0, 1), (1200.0, 3)])
def test_torques_of_the_nipper(e62: Mechanism, speed: float, turns: int) -> None:
    """Both shafts; at 1,200 r/min the largest torque comes while the jaw bounces."""
    judged(e62, speed, turns)


@pytest.mark.parametrize("name", ["ratchet_feed", "door_closer", "jaw_crusher"])
def test_torques_of_machines_of_the_gallery(name: str) -> None:
    """Springs, a damper, stops on both sides."""
    mechanism = drawn(name).mechanism()
    judged(mechanism, mechanism.cylinder.rated_speed_rpm, 1)


@pytest.mark.parametrize("restitution", [1e-6, 1e-4])
def test_the_torque_in_bounces_that_are_not_computed(restitution: float) -> None:
    """The largest of the turn, at speeds whose rests end beside their charts by round-off, too."""
    mechanism = drawn("watt_2").mechanism()
    few, many = (
        turn_quantities(mechanism, torques=True, speed_rpm=np.linspace(40.0, 180.0, 141),
                        restitution={stop.name: restitution for stop in mechanism.stops},
                        tolerance=tolerance)
        for tolerance in (1e-3, 1e-13)
    )  # fmt: skip
    assert (few.collisions == 1.0).all()
    assert (many.collisions > 1.0).all()
    off = np.abs(few.largest_torque - many.largest_torque)
    assert (off <= few.largest_torque_error + many.largest_torque_error).all()
    assert (few.largest_torque_error <= 10.0 * restitution * few.largest_torque).all()
    np.testing.assert_allclose(few.largest_torque, many.largest_torque, rtol=restitution)


def test_torques_of_a_rough_motion(e62: Mechanism) -> None:
    """Those of a much finer one within the stated errors, also where few nodes hold a panel."""
    speeds = np.linspace(300.0, 1900.0, 33)
    rough, fine = (turn_quantities(e62, torques=True, speed_rpm=speeds, tolerance=tolerance)
                   for tolerance in (1e-6, 1e-13))  # fmt: skip
    off = np.abs(rough.largest_torque - fine.largest_torque)
    assert (off <= rough.largest_torque_error + fine.largest_torque_error).all()


def test_numbers_of_a_case_change_the_torque(e62: Mechanism) -> None:
    """A stiffer spring and another preload, as if the mechanism had them."""
    changed = load(
        "e62",
        {"springs.steeve.stiffness_N_per_m": 13000.0, "springs.steeve.preload_length_mm": 22.0},
    )
    numbers = turn_quantities(e62, torques=True, speed_rpm=650.0, stiffness=13000.0, preload=0.022)
    own = turn_quantities(changed, torques=True, speed_rpm=650.0)
    np.testing.assert_allclose(numbers.largest_torque, own.largest_torque, rtol=1e-9)
    usual = turn_quantities(e62, torques=True, speed_rpm=650.0)
    assert np.abs(usual.largest_torque / own.largest_torque - 1.0).min() > 1e-3


def test_a_batch_is_its_cases_and_reports_the_last_turns(e62: Mechanism) -> None:
    """At 1,900 r/min two turns alternate, and so do their torques."""
    speeds = np.array([450.0, 1900.0, 900.0])
    many = turn_quantities(e62, torques=True, speed_rpm=speeds, turns=60, last=3)
    assert many.largest_torque.shape == many.largest_torque_error.shape == (3, 3, 2)
    for i, speed in enumerate(speeds):
        one = turn_quantities(e62, torques=True, speed_rpm=speed, turns=60, last=3)
        assert one.torques.tobytes() == many.torques[i].tobytes()
    # The turn at 450 r/min repeats at once: there is one.
    assert np.isnan(many.largest_torque[0, 1:]).all()
    last, before, earlier = many.largest_torque[1, :, 0]
    assert last == pytest.approx(earlier, rel=1e-8)
    assert abs(last - before) > 1e-7 * last


def test_cases_that_cannot_be_followed_have_no_torque(
    e62: Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Too many collisions, or more panels than there is room for, are told by the status."""
    few = turn_quantities(e62, torques=True, speed_rpm=650.0, max_collisions=3)
    # Room for four panels of a turn.
    monkeypatch.setattr(module, "BESIDE", 2 - 256)
    full = turn_quantities(e62, torques=True, speed_rpm=650.0)
    whole = turn_quantities(e62, torques=True, speed_rpm=650.0, last=1)
    for found in (few, full):
        assert found.status[0] == TurnStatus.TOO_MANY_COLLISIONS
        assert np.isnan(found.largest_torque).all()
    assert whole.largest_torque.shape == (1, 1, 2)
    with pytest.raises(InputError, match="turns"):
        turn_quantities(e62, torques=True, speed_rpm=450.0, turns=0)


@pytest.mark.campaign
def test_torques_may_have_no_tables_as_wide_as_those_of_a_flight() -> None:
    """Such a case leaves the widest tables, and does not end the others."""
    mechanism = drawn("stephenson_1").mechanism()
    speeds = mechanism.cylinder.rated_speed_rpm * np.array([1.0, 12.0])
    found = turn_quantities(mechanism, torques=True, speed_rpm=speeds, restitution=0.9)
    assert found.status.tolist() == [TurnStatus.FOLLOWED, TurnStatus.LEFT_GAP]
    assert np.isnan(found.largest_torque).tolist() == [[False], [True]]

"""Quantities of turns, judged by the certified turns and by forces of the direct engine."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nipper_pin import Case, EventKind, InputError, Mechanism, Solution, simulate
from nipper_pin.mechanism.drawing import drawn_mechanism
from nipper_pin.mechanism.gallery import GALLERY
from nipper_pin.reduced.turns import TurnStatus, turn_quantities

REFERENCE = Path(__file__).resolve().parents[1] / "reference/e62_cycle.json"
SPEEDS = {"450": 450.0, "650": 650.0}


@pytest.fixture(scope="module")
def true() -> dict[str, Any]:
    document: dict[str, Any] = json.loads(REFERENCE.read_text(encoding="utf-8"))
    return document


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
    for value, error, wanted in (
        (found.closed_at, found.closed_error, speed * float(hits[0]["time_s"])),
        (found.rests_at, found.rests_error, speed * float(rest["time_s"])),
        (found.opened_at, found.opened_error, speed * end),
        (found.clamped, found.clamped_error, speed * (end - start)),
        (found.clamped_time, found.clamped_time_error, end - start),
        (found.least_force, found.least_force_error, float(held["lip_force_min_N"])),
        (found.most_force, found.most_force_error, float(held["lip_force_max_N"])),
        (found.largest_gap, found.gap_error, max(float(row["rebound_amplitude"]) for row in hits)),
        (found.energy_lost, found.energy_lost_error, float(case["energy_lost_total_J"])),
    ):
        assert abs(value[0] - wanted) <= error[0] <= 1e-7 * wanted
    assert math.isnan(found.lost_at[0])
    assert found.force_error[0] == max(found.least_force_error[0], found.most_force_error[0])
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


def forces(run: Solution) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Times of a fine grid within the rest of the jaw, and forces at the lips there."""
    (interval,) = [item for item in run.phases if item.closed == {"jaw"}]
    t = np.linspace(interval.t_start, interval.t_end, 20001)[1:-1]
    return t, run.trajectory.reactions(t).contacts["jaw"]


@pytest.mark.slow
@pytest.mark.parametrize(
    "level",
    [55.0, pytest.param(70.0, marks=pytest.mark.slow), pytest.param(90.0, marks=pytest.mark.slow)],
)
def test_time_with_a_force_above_a_level(e62: Mechanism, level: float) -> None:
    """The share of a fine grid of the direct engine's forces, to the spacing of the grid."""
    run = simulate(e62, Case(speed_rpm=650.0, window="cycle"))
    t, force = forces(run)
    found = turn_quantities(e62, speed_rpm=650.0, least_force=level)
    above = (force >= level).mean() * (t[-1] - t[0])
    assert 0.0 < above < t[-1] - t[0]
    assert found.clamped_time[0] == pytest.approx(above, abs=4.0 * (t[1] - t[0]))


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
    mechanism = drawn_mechanism(GALLERY[name]())
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

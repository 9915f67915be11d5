"""The E62 against an independent planar solution in closed form, certified to 28 digits.

tests/reference holds the derivation: one coordinate, Taylor series of order 58, no multibody code,
and nothing shared with the engine. Agreement to twelve digits is no accident: a wrong sign,
inertia, row or event changes the first ones.

Tolerances. The engine resolves positions and event times to a relative 1e-12 on each panel, which
a few operations amplify little: 1e-11 is allowed for a collision whose flight before was long. A
short flight of length T that ends at time t can be known no better than to the round-off of time,
eps t / T: near the end of a series this grows by 1/e with every bounce and becomes the larger part.
Energies and amplitudes are squares of rates and have twice that. So do not expect 1e-10 of rates,
impulses and amplitudes where T falls below 2e-6 t; times themselves stay good to 1e-10 throughout.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nipper_pin import Case, Collision, Event, EventKind, Solution, Window, load, simulate

FOLDER = Path(__file__).parents[1] / "reference"
DOCUMENTS = {
    window: json.loads((FOLDER / f"e62_{window.value}.json").read_text(encoding="utf-8"))
    for window in Window
}
CASES = [
    pytest.param(window, name, id=f"{window.value}-{name}")
    for window, document in DOCUMENTS.items()
    for name in document["cases"]
]
# Parameters of the reference as paths of the model.
PATHS = {
    "jaw_restitution": "stops.jaw.restitution",
    "stiffness_N_per_m": "springs.steeve.stiffness_N_per_m",
}
EPS = float(np.finfo(float).eps)
TIMES = 1e-10
LONG_FLIGHT = 1e-11


@cache
def solved(window: Window, name: str) -> Solution:
    """The engine's solution of a case of the reference."""
    changes = dict(DOCUMENTS[window]["cases"][name]["changes"])
    speed = float(changes.pop("speed_rpm"))
    model = load("e62", {PATHS[key]: value for key, value in changes.items()})
    return simulate(model, Case(speed_rpm=speed, window=window))


def _series(solution: Solution) -> list[tuple[list[Collision], Event]]:
    """Collisions of every series with the rest that ends it."""
    found: list[tuple[list[Collision], Event]] = []
    current: list[Collision] = []
    by_event = {collision.event.number: collision for collision in solution.collisions}
    for event in solution.events:
        if event.kind is EventKind.COLLISION:
            current.append(by_event[event.number])
        elif event.kind is EventKind.REST:
            found.append((current, event))
            current = []
    assert not current
    return found


def _pairs(
    solution: Solution, window: Window, name: str
) -> list[tuple[Collision, dict[str, Any], float]]:
    """Collisions, their reference and the relative tolerance of their rates.

    The series are compared from their first collision on, as far as both were computed.
    """
    reference: dict[int, list[dict[str, Any]]] = {}
    for row in DOCUMENTS[window]["cases"][name]["collisions"]:
        reference.setdefault(row["series"], []).append(row)
    computed = _series(solution)
    assert len(computed) == len(reference)
    pairs = []
    for (collisions, _), rows in zip(computed, reference.values(), strict=True):
        assert len(collisions) >= 4
        flight = np.inf
        for collision, row in zip(collisions, rows, strict=False):
            assert collision.stop == row["stop"]
            tolerance = LONG_FLIGHT + 4.0 * EPS * float(row["time_s"]) / flight
            pairs.append((collision, row, tolerance))
            flight = float(row["rebound_time_s"])
    return pairs


@pytest.mark.parametrize(("window", "name"), CASES)
def test_collisions(window: Window, name: str) -> None:
    """Time, angle and index; rates, impulses (about the joint and at the lip) and losses; rebounds.

    Of the rebounds the one that a run leaves out before rest is included.
    """
    for collision, row, tolerance in _pairs(solved(window, name), window, name):
        true = {key: float(value) for key, value in row.items() if key not in ("stop", "series")}
        flight = true["rebound_time_s"]
        next_one = LONG_FLIGHT + 4.0 * EPS * (collision.t + flight) / flight
        # The steeve's stop acts along its joint: its impulse is the one at the contact.
        at_contact = true.get("impulse_lip_N_s", true["impulse"])
        for found, wanted, near in (
            (collision.t, true["time_s"], TIMES),
            (collision.cylinder_angle, true["cylinder_angle_rad"], TIMES),
            (collision.index, true["index"] % 40.0, TIMES),
            (collision.approach_rate, true["approach_rate"], tolerance),
            (collision.separation_rate, true["separation_rate"], tolerance),
            (collision.event.P_N[collision.stop], true["impulse"], tolerance),
            (collision.impulse, at_contact, tolerance),
            (collision.energy_lost, true["energy_lost_J"], 2.0 * tolerance),
            (collision.rebound_time, flight, next_one),
            (collision.rebound_amplitude, true["rebound_amplitude"], 2.0 * next_one),
        ):
            assert found == pytest.approx(wanted, rel=near)


@pytest.mark.parametrize(("window", "name"), CASES)
def test_the_other_stop_at_every_collision(window: Window, name: str) -> None:
    """Jaw angle, steeve stroke and both their rates, before and after, at every collision.

    The stop that does not collide is where a wrong closure impulse would show. Its rate carries
    the jump of the colliding one, so its tolerance is of the larger of its two rates.
    """
    solution = solved(window, name)
    places = {"th": solution.mechanism.stop("jaw").index}
    places["stroke"] = solution.mechanism.stop("steeve").index
    for collision, row, tolerance in _pairs(solution, window, name):
        event = collision.event
        for key, coordinate in (("th", "th_rad"), ("stroke", "stroke_m")):
            place = places[key]
            # A coordinate comes out of an integration of its rate up to the time of the event.
            assert event.q[place] == pytest.approx(float(row[coordinate]), rel=TIMES, abs=1e-15)
            before, after = (float(row[f"{key}_rate_{side}"]) for side in ("before", "after"))
            absolute = tolerance * max(abs(before), abs(after))
            assert event.v_before[place] == pytest.approx(before, abs=absolute)
            assert event.v_after[place] == pytest.approx(after, abs=absolute)


@pytest.mark.parametrize(("window", "name"), CASES)
def test_rests_and_total_loss(window: Window, name: str) -> None:
    """Rest times, which are limits of infinite series, and the energy lost in all of them.

    The engine closes a series after a handful of bounces; the reference sums it to 1e-19 s.
    """
    solution = solved(window, name)
    case = DOCUMENTS[window]["cases"][name]
    single = [{"stop": "jaw", "time_s": case.get("rest_time_s"), "index": case.get("rest_index")}]
    rests = case.get("rests", single)
    computed = [rest for _, rest in _series(solution)]
    assert len(computed) == len(rests)
    for event, rest in zip(computed, rests, strict=True):
        assert event.stops == (rest["stop"],)
        assert event.t == pytest.approx(float(rest["time_s"]), rel=TIMES)
        angle = float(solution.shaft.angle(event.t))
        index = solution.mechanism.cylinder.index_from_angle(angle)
        assert index == pytest.approx(float(rest["index"]) % 40.0, rel=TIMES)
    lost = sum(event.energy_lost for event in solution.events)
    assert lost == pytest.approx(float(case["energy_lost_total_J"]), rel=TIMES)
    if "first_two_share" in case:
        share = solution.transitions[0].first_two_share
        assert share == pytest.approx(float(case["first_two_share"]), rel=TIMES)


@pytest.mark.parametrize("name", DOCUMENTS[Window.CYCLE]["cases"])
def test_phases_of_the_cycle(name: str) -> None:
    """The phases follow each other as in the reference, at its times.

    At 650 r/min the steeve leaves its stop with the jaw wide open, at 450 it does not.
    """
    solution = solved(Window.CYCLE, name)
    phases = DOCUMENTS[Window.CYCLE]["cases"][name]["phases"]
    assert len(solution.phases) == len(phases)
    for phase, row in zip(solution.phases, phases, strict=True):
        assert phase.closed == frozenset([row["closed"]] if row["closed"] else [])
        assert phase.t_start == pytest.approx(float(row["start_s"]), rel=TIMES, abs=1e-15)
        assert phase.t_end == pytest.approx(float(row["end_s"]), rel=TIMES)
    released = [event for event in solution.events if event.kind is EventKind.RELEASE]
    wanted = [row for row in phases if row.get("ended_by") == "release"]
    assert len(released) == len(wanted) == (1 if name == "650" else 0)


@pytest.mark.parametrize("name", DOCUMENTS[Window.CYCLE]["cases"])
def test_motion_and_stop_forces_over_the_cycle(name: str) -> None:
    """Jaw, steeve and the force of the closed stop at every whole index.

    Forces are balances of inertia and spring, so their round-off is of the size of the largest.
    """
    solution = solved(Window.CYCLE, name)
    jaw, steeve = (solution.mechanism.stop(stop).index for stop in ("jaw", "steeve"))
    step = solution.shaft.period / 40.0
    compared = 0
    for row in DOCUMENTS[Window.CYCLE]["cases"][name]["phases"]:
        for sample in row.get("samples", []):
            # Samples with a closed stop only; the two ends of the turn belong to the window.
            t = min((float(sample["index"]) - 24.0) * step, solution.trajectory.span[1])
            motion = solution.trajectory.evaluate(t)
            found = motion.q[0, jaw], motion.v[0, jaw], motion.q[0, steeve], motion.v[0, steeve]
            keys = ("th_rad", "th_rate", "stroke_m", "stroke_rate")
            # The rates are up to 18 rad/s and 0.4 m/s, the positions below 0.4 rad and 4 mm.
            for value, key, size in zip(found, keys, (0.4, 18.0, 4e-3, 0.4), strict=True):
                assert value == pytest.approx(float(sample[key]), abs=1e-11 * size)
            force = solution.trajectory.reactions(t).stops[row["closed"]][0]
            largest = max(abs(float(row["force_min"])), abs(float(row["force_max"])))
            assert force == pytest.approx(float(sample["force"]), abs=TIMES * largest)
            compared += 1
    assert compared >= 30


@pytest.mark.parametrize(("offset", "leaves"), [(-1e-6, False), (1e-6, True)])
def test_the_steeve_leaves_its_stop_above_the_critical_speed(offset: float, leaves: bool) -> None:
    """Just below the speed at which the stop force reaches zero nothing opens; just above it does.

    Near that speed the lowest force changes sign with the speed, and the two runs are 2e-6 of it
    apart, so a force wrong by 1e-5 would fail.
    """
    critical = float(DOCUMENTS[Window.CYCLE]["speed_where_stop_force_reaches_zero_rpm"])
    case = Case(speed_rpm=critical * (1.0 + offset), window=Window.CYCLE)
    events = simulate(load("e62"), case).events
    assert any(event.kind is EventKind.RELEASE for event in events) is leaves


@pytest.mark.parametrize("name", DOCUMENTS[Window.CYCLE]["cases"])
def test_closing_and_opening_indices(name: str) -> None:
    """The jaw closes at index 34 +- 0.3 and opens between 7 and 9.5, as its class does."""
    solution = solved(Window.CYCLE, name)
    closing = next(item for item in solution.collisions if item.stop == "jaw")
    assert closing.index == pytest.approx(34.0, abs=0.3)
    opening = next(
        item for item in solution.collisions if item.stop == "steeve" and item.t > closing.t
    )
    assert "jaw" in opening.event.closed_before
    assert "jaw" not in opening.event.closed_after
    assert 7.0 <= opening.index <= 9.5


@pytest.mark.parametrize(("window", "limit"), [(Window.TRANSITION, 200), (Window.CYCLE, 600)])
def test_the_work_is_bounded(window: Window, limit: int) -> None:
    """At the table's parameters a transition takes 200 evaluations at most, a cycle 600."""
    for name in ("450", "650"):
        assert 0 < solved(window, name).evaluations <= limit

"""Quantities of a turn and their errors, read off raw runs: Pinocchio reads the URDF itself."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from judge import Judge, press
from scipy.optimize import minimize_scalar

from nipper_pin import Case, Mechanism, Solution, simulate
from nipper_pin.hybrid.result.turns import Turn, of_turn, read_of, reported_turn, turn_names
from nipper_pin.mechanism.gallery import drawn

# The judge interpolates between nodes and solves by least squares.
SHARE = 1e-8
# Times of grids on which the judge looks for forces, and torques in each phase.
FEW = 24
TIMES = 60


def turns(mechanism: Mechanism, speed: float, cycles: int, **keys: Any) -> Solution:
    return simulate(mechanism, Case(speed_rpm=speed, window="cycle", cycles=cycles, **keys))


def judged(run: Solution, number: int, level: float) -> dict[str, float | None]:
    """Every quantity of a turn by name, from its raw events and nodes."""
    judge, mechanism = Judge(run), run.mechanism
    clamp, T = mechanism.transition_stop, 60.0 / run.case.speed_rpm
    begin, end = (number - 1) * T, number * T
    events = [item for item in run.events if begin <= item.t < end]
    hits = {item.number: judge.impulses(item) for item in events if item in judge.hits}
    struck = [item for item in events if hits.get(item.number, ({}, 0))[0].get(clamp, 0.0) > 0.0]

    def index(chosen: list[Any]) -> float | None:
        return judge.index(chosen[0].t) % 40.0 if chosen else None

    def of_clamp(kind: str) -> list[Any]:
        return [item for item in events if item.kind.value == kind and clamp in item.stops]

    opened = [
        item for item in events
        if item.number in hits and clamp in item.closed_before
        and judge.rate(clamp, item.v_after) > 1e-9 * abs(item.v_after).max()
    ]  # fmt: skip
    heights = [judge.rebound(item, clamp) for item in struck if ends_there(run, judge, item, clamp)]
    unit = "N" if judge.stops[clamp].lever or not judge.stops[clamp].turns else "N_m"
    time, least, most = held(judge, clamp, begin, end, level)
    found: dict[str, float | None] = {
        "clamped_time_s": time,
        "clamped_share": time / T,
        "closing_index": index(struck),
        "rest_index": index(of_clamp("rest")),
        "loss_index": index(of_clamp("release")),
        "opening_index": index(opened),
        f"least_clamping_force_{unit}": least,
        f"largest_clamping_force_{unit}": most,
        "largest_gap": max((item[0] for item in heights if item), default=None),
    }
    lost = sum(loss for _, loss in hits.values())
    for name, stop in judge.stops.items():
        got = [pushes[name] / (stop.lever or 1.0) for pushes, _ in hits.values()
               if pushes.get(name, 0.0) > 0.0]  # fmt: skip
        e, tails = stop.restitution, series_ends(run, judge, name, events)
        further = sum(judge.impulses(item)[0][name] for item in tails) / (stop.lever or 1.0)
        lost += sum(judge.impulses(item)[1] for item in tails) * e**2 / (1.0 - e**2)
        unit = "N_s" if stop.lever or not stop.turns else "N_m_s"
        found[f"collisions_{name}"] = len(got)
        found[f"impulse_sum_{unit}_{name}"] = sum(got) + further * e / (1.0 - e)
        found[f"largest_impulse_{unit}_{name}"] = max(got, default=0.0)
    found["energy_lost_turn_J"] = lost
    for name, column in judge.drives.items():
        unit = "N_m" if judge.turning[column] else "N"
        found[f"largest_torque_{unit}_{name}"] = largest(judge, name, begin, end)
    return found


def stated(run: Solution, number: int) -> dict[str, float | None]:
    """Every stated error by name, from the errors of the events that the judge finds."""
    judge, clamp = Judge(run), run.mechanism.transition_stop
    T = 60.0 / run.case.speed_rpm
    events = [item for item in run.events if (number - 1) * T <= item.t < number * T]
    hits = {item.number: judge.impulses(item)[0] for item in events if item in judge.hits}
    first = {
        "closing": [item for item in events if hits.get(item.number, {}).get(clamp, 0.0) > 0.0],
        "rest": [e for e in events if e.kind.value == "rest" and clamp in e.stops],
        "loss": [e for e in events if e.kind.value == "release" and clamp in e.stops],
        "opening": [e for e in events if e.number in hits and clamp in e.closed_before
                    and clamp not in e.closed_after],
    }  # fmt: skip
    found: dict[str, float | None] = {
        f"{name}_index_error": 40.0 * run.errors[chosen[0].number - 1].time / T if chosen else None
        for name, chosen in first.items()
    }
    for name, stop in judge.stops.items():
        lever, e = stop.lever or 1.0, stop.restitution
        got = {item: pushes[name] / lever for item, pushes in hits.items()
               if pushes.get(name, 0.0) > 0.0}  # fmt: skip
        errors = {item: run.errors[item - 1].impulses[name] / lever for item in got}
        beyond = 0.0
        for last in series_ends(run, judge, name, events):
            rest = next(item for item in run.events[last.number :] if name in item.stops)
            uneven = got[last.number] * rest.series_error / (rest.t - last.t)
            beyond += e / (1.0 - e) * (errors[last.number] + uneven)
        unit = "N_s" if stop.lever or not stop.turns else "N_m_s"
        hardest = max(got, key=lambda item: got[item], default=None)
        found[f"largest_impulse_error_{unit}_{name}"] = errors.get(hardest, 0.0)
        found[f"impulse_sum_error_{unit}_{name}"] = sum(errors.values()) + beyond
    return found


def series_ends(run: Solution, judge: Judge, name: str, events: list[Any]) -> list[Any]:
    """Last collision of each series of a stop that ends at its limit in the turn."""
    ends = []
    for rest in (item for item in events if item.kind.value == "rest" and name in item.stops):
        before = [item for item in run.events[: rest.number - 1] if name in item.stops]
        if before and before[-1] in judge.hits and rest.t > before[-1].t:
            ends.append(before[-1])
    return ends


def largest(judge: Judge, drive: str, begin: float, end: float) -> float:
    """Largest torque of a drive: the best place of a grid on each phase, refined."""
    best, place = -1.0, (0.0, 0.0, frozenset[str]())
    for closed, first, last in judge.phases:
        first, last = max(first, begin), min(last, end)
        if not last > first:
            continue
        step = (last - first) / FEW
        for t in first + step * (np.arange(FEW) + 0.5):
            value = abs(judge.forces(float(t), closed, left=True)[drive])
            if value > best:
                best, place = value, (max(t - step, first), min(t + step, last), closed)

    def torque(t: float) -> float:
        return -abs(judge.forces(t, place[2], left=t != place[0])[drive])

    bounds = place[0] + 1e-6 * (place[1] - place[0]), place[1]
    top = minimize_scalar(torque, bounds=bounds, method="bounded", options={"xatol": 1e-12})
    return max(-float(top.fun), *(-torque(t) for t in bounds))


def ends_there(run: Solution, judge: Judge, event: Any, clamp: str) -> bool:
    """Whether a rebound was flown to its end, and that is at the same stop."""
    after = judge.following(event, clamp)
    if after is None or judge.rate(clamp, event.v_after) <= 0.0 or np.array_equal(after.q, event.q):
        return False
    between = run.events[event.number : after.number]
    return all(item.stops[0] == clamp for item in between if item in judge.hits)


def held(
    judge: Judge, clamp: str, begin: float, end: float, level: float
) -> tuple[float, float | None, float | None]:
    """Time with a force above a level, to the spacing of a grid, and the extremes, refined."""
    above, least, most = 0.0, [], []
    for closed, first, last in judge.phases:
        first, last = max(first, begin), min(last, end)
        if clamp not in closed or not last > first:
            continue

        def force(t: float, closed: frozenset[str] = closed) -> float:
            return judge.forces(t, closed, left=True)[clamp]

        t = np.linspace(first, last, TIMES + 1)[1:]
        values = np.array([force(float(x)) for x in t])
        above += float((values >= level).mean()) * (last - first)
        step = t[1] - t[0]
        for sign, kept in ((1.0, least), (-1.0, most)):
            near = t[int(np.argmin(sign * values))]
            bounds = max(near - step, first + 1e-9 * step), min(near + step, last)
            top = minimize_scalar(lambda x, s=sign: s * force(float(x)), bounds=bounds,
                                  method="bounded", options={"xatol": 1e-6 * step})  # fmt: skip
            kept.append(sign * min(float(top.fun), *(sign * force(float(x)) for x in bounds)))
    return above, min(least, default=None), max(most, default=None)


# Read or judged in other tests.
ELSEWHERE = ("repeats_after", "largest_gap_error", "energy_lost_turn_error_J")
RUNS = {
    "e62": (650.0, 1, 60.0),
    "e62 alternates": (1900.0, 3, 0.0),
    "film_claw": (600.0, 1, 0.0),
    "wiper": (100.0, 2, 5e-4),
    "press": (240.0, 2, 0.5),
}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] if name == "wiper" else []) for name in RUNS],
)
def test_every_quantity_by_another_path(name: str, e62: Mechanism) -> None:
    """A nipper, one that alternates, a claw that loses, a lip, a press with two free stops."""
    speed, cycles, level = RUNS[name]
    word = name.split()[0]
    mechanism = {"e62": e62, "press": press()}.get(word) or drawn(word).mechanism()
    run = turns(mechanism, speed, cycles)
    turn = reported_turn(run, level)
    if word != name:
        # Its rebounds end in the turn that follows, where the jaw was thrown open before.
        turn = Turn(run, 2, 0, level)
    expected = judged(run, turn.number, level) | stated(run, turn.number)
    read = {}
    for key in turn_names(mechanism, drives=True):
        item, part = of_turn(key, mechanism)
        if item.read is not None and item.name not in ELSEWHERE:
            read[key] = item.read(run, read_of(turn, item, part))
    assert read.keys() == expected.keys()
    assert sum(value is not None for value in read.values()) >= 10
    # Of each passage of the level, the grid knows the time to its spacing.
    spacing = 2.0 * reported_turn(run, 0.0).clamped_share / TIMES
    sizes = {"clamped_time_s": (0.0, spacing * 60.0 / speed), "clamped_share": (0.0, spacing)}
    for key, value in expected.items():
        rel, size = sizes.get(key, (SHARE, 1e-12))
        if "clamping_force" in key and value is not None:
            size = SHARE * max(abs(turn.largest_clamping_force or 0.0), 1e-300)
        assert (value is None) == (read[key] is None), key
        if value is not None:
            # The judge's highest point of a flight is that of a parabola through three of 201.
            rel, size = (1e-5 if key == "largest_gap" else rel), (0.0 if "error" in key else size)
            assert read[key] == pytest.approx(value, rel=rel, abs=size), key

"""What views show is read off the document and the motion of a run: both judged here.

Values come from :mod:`judge`, which reads the run in another way. Names carry the unit, so that a
value in another unit fails; that views show what stands here is what test_surfaces says.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from judge import Judge
from runs_shown import run_of

from nipper_pin import Event, record
from nipper_pin.hybrid.result.quantities import COLLISION, TRANSITION

# A cut pin's rate has a round-off of 1e-15 rad/s, which is 1e-9 of the slowest bounces here.
SLOW = 1e-8
# Gaps are sampled at 200 places a flight: the peak of the parabola through three of them.
PEAK = 1e-6
# The last flight of a series that was ended by its limit is as much off as the last but one was.
LAST = 2e-4
# States between nodes are interpolated by the judge, and closed again by the package.
DENSE = 1e-7


@pytest.fixture(scope="module", params=["e62", "press"])
def judge(request: pytest.FixtureRequest) -> Judge:
    """Turns: stops with and without contact point, on hinges and slides; two kinds of drives."""
    return Judge(run_of(request.param))


def near(value: float, rel: float, least: float = 0.0) -> Any:
    return pytest.approx(value, rel=rel, abs=least)


def struck(judge: Judge, event: Event) -> str:
    """The stop whose gap's rate changed from closing to its restitution times that."""
    found = [
        name
        for name, item in judge.stops.items()
        if judge.rate(name, event.v_before) < 0.0 < judge.rate(name, event.v_after) + 1e-300
        and judge.rate(name, event.v_after)
        == near(-item.restitution * judge.rate(name, event.v_before), SLOW)
    ]
    assert len(found) == 1
    return found[0]


def collision(judge: Judge, number: int, event: Event) -> dict[str, Any]:
    """What a collision has to say, by the name of the quantity."""
    name = struck(judge, event)
    item = judge.stops[name]
    impulses, lost = judge.impulses(event)
    moment = item.turns and item.lever is None
    back = judge.rebound(event, name)
    after = judge.following(event, name)
    rel = LAST if after is not None and after.kind.value == "rest" else PEAK
    # 1/2 v'Mv before and after are equal in most digits when a slow bounce loses little.
    whole = judge.kinetic(event.q, event.v_before)
    error = judge.run.errors[event.number - 1]
    found = {
        "number": number,
        "stop": name,
        "t_s": near(event.t, 1e-14),
        "time_s": near(event.t - judge.hits[0].t, 1e-14),
        "cylinder_angle_rad": near(judge.angle(event.t), 1e-12),
        "index": near(judge.index(event.t), 0.0, 1e-6),
        "approach_rate": near(judge.rate(name, event.v_before), 1e-12),
        "separation_rate": near(judge.rate(name, event.v_after), 1e-12),
        "energy_lost_J": near(lost, SLOW, 1e-14 * whole),
        "time_error_s": error.time,
        "impulse_error": error.impulse,
    }
    impulse = "impulse_N_m_s" if moment else "impulse_N_s"
    found[impulse] = near(impulses[name] / (item.lever or 1.0), SLOW)
    if back is not None:
        found["rebound_amplitude"] = near(back[0], rel)
        found["rebound_time_s"] = near(back[1], LAST if rel == LAST else 1e-9)
    return found


def test_document(judge: Judge) -> None:
    """Collisions, phases and the transition; times t count from the start, others from a touch."""
    document: Any = json.loads(json.dumps(record(judge.run), allow_nan=False))
    kept = {item.name for item in COLLISION if item.read} | {"number", "stop"}
    for number, (row, event) in enumerate(
        zip(document["collisions"], judge.hits, strict=True), start=1
    ):
        wanted = collision(judge, number, event)
        # Without a following event a rebound has no height and no time.
        assert {key: value for key, value in row.items() if value is not None} == wanted
        assert set(row) | {"impulse_N_s", "impulse_N_m_s"} == kept
    names = {frozenset(item["closed"]): item["number"] for item in judge.document["phases"]}
    origin = judge.hits[0].t
    assert document["phases"] == [
        {
            "phase": names.get(closed),
            "closed_stops": sorted(closed),
            "t_start_s": near(begin, 1e-14),
            "t_end_s": near(end, 1e-14),
            "start_s": near(begin - origin, 1e-12, 1e-15),
            "end_s": near(end - origin, 1e-12, 1e-15),
        }
        for closed, begin, end in judge.phases
    ]
    of_main = [e for e in judge.run.events if judge.document["transition_stop"] in e.stops]
    rest = next(k for k, event in enumerate(of_main) if event.kind.value == "rest")
    series = [e for e in of_main[: rest + 1] if e.kind.value != "release"]
    duration = series[-1].t - series[0].t
    assert set(document["transition"]) == {item.name for item in TRANSITION if item.read}
    assert document["transition"] == {
        "premise_holds": None,
        "duration_s": near(duration, 1e-14),
        "duration_error_s": judge.run.errors[series[-1].number - 1].time,
        "collisions": len(series) - 1,
        "first_two_share": near((series[2].t - series[0].t) / duration, 1e-12),
    }
    checks = document["checks"]["closure_m"]
    assert max(judge.closure(event.q) for event in judge.hits) <= checks + 1e-15


@pytest.mark.parametrize("name", ["e62", "press", "boxed"])
def test_motion(name: str) -> None:
    """States, cylinder, gaps and forces at both limits of every event and at places between.

    In the box, of stops on both sides, away from zero, whose coordinate counts downwards.
    """
    run = run_of(name)
    judge = Judge(run)
    for segment in (item for item in run.segments if item.t_end > item.t_start):
        for share in (0.0, 0.01, 0.37, 0.99, 1.0):
            t, left = segment.t_start + share * (segment.t_end - segment.t_start), share == 1.0
            q, v, _ = judge.state(t, left=left)
            motion, forces = (
                read(np.array([t]), left=left)
                for read in (run.trajectory.evaluate, run.trajectory.reactions)
            )
            np.testing.assert_allclose(motion.q[0], q, rtol=DENSE, atol=1e-10)
            np.testing.assert_allclose(motion.v[0], v, rtol=DENSE, atol=1e-8)
            assert motion.cylinder_angle[0] == near(judge.angle(t), 1e-12)
            found = {
                name: float(force[0]) for name, force in (*forces.contacts.items(),
                                                          *forces.drives.items())
            }  # fmt: skip
            wanted = judge.forces(t, segment.closed, left=left)
            assert found == {name: near(force, DENSE, 1e-6) for name, force in wanted.items()}
            for stop in run.mechanism.stops:
                assert stop.gap(motion.q[0]) == near(judge.gap(stop.name, q), DENSE, 1e-10)


def test_link_velocities(judge: Judge) -> None:
    """Turning rate and velocity of the centre of mass of every link, before and after."""
    for event in judge.hits:
        for own, v in zip(judge.run.link_velocities(event), (event.v_before, event.v_after),
                          strict=True):  # fmt: skip
            wanted = judge.links(event.q, v)
            largest = max(abs(x) for item in wanted.values() for x in item)
            assert set(own.links) == set(wanted)
            for place, link in enumerate(own.links):
                found = (own.angular[place], *own.centroid[place])
                assert found == near(wanted[link], 1e-11, 1e-13 * largest)

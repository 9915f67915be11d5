"""What views show is read off the document and the motion of a run: both judged here.

Values come from :mod:`judge`, which reads the run in another way. Names carry the unit, so that a
value in another unit fails; that views show what stands here is what test_surfaces says. Curves,
columns and texts over time show the motion, with the units that stand beside the numbers.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from judge import Judge
from runs_shown import TURNS, run_of
from units_shown import factor, force, index, kind, rows, unit_of

from nipper_pin import Event, Solution, record
from nipper_pin.hybrid.result.quantities import COLLISION, TRANSITION
from nipper_pin.view.run.bounces import transition_figure
from nipper_pin.view.run.timelines import force_figure, motion_figure
from nipper_pin.view.scene import Look, film
from nipper_pin.view.scene.readings import readings

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


# Gaps, forces, states and indices over time.


DIGITS = 5.1e-4  # four digits


class Line(NamedTuple):
    """Values that a surface shows over time.

    Attributes:
        name: What they are: ``gap``, ``contact``, ``force``, a coordinate or its rate, and of what.
        t: Times of the run [s].
        values: The values; NaN where the line is broken.
        unit: What stands beside them.
        left: Where the limit before an event is shown.
        digits: Relative error of a value that is written.
    """

    name: tuple[str, str]
    t: Any
    values: Any
    unit: str
    left: Any = None
    digits: float = 0.0


@lru_cache(maxsize=4)
def sides(name: str, read: str, t: bytes) -> tuple[Any, Any]:
    """States or forces of a run at both limits of some times."""
    read_at, times = getattr(run_of(name).trajectory, read), np.frombuffer(t)
    return read_at(times), read_at(times, left=True)


def motion(name: str, line: Line) -> tuple[Any, str]:
    """What the motion of a run has for a line, and its unit."""
    run, (what, of) = run_of(name), line.name
    t = np.clip(np.asarray(line.t, dtype=float), 0.0, run.segments[-1].t_end)
    left = np.zeros(len(t), bool) if line.left is None else np.asarray(line.left)
    left = left | (t >= run.segments[-1].t_end)
    after, before = sides(name, "evaluate", t.tobytes())
    q, v = (np.where(left[:, None], getattr(before, key), getattr(after, key)) for key in "qv")
    column = {joint.name: joint.index for joint in run.mechanism.joints}
    column |= {drive.name: drive.index for drive in run.mechanism.drives if what == "drive"}
    turning = {joint.index for joint in run.mechanism.joints if joint.kind != "prismatic"}
    if what == "time":
        return t, "s"
    if what == "index":
        return index(run, t), ""
    if what in ("q", "v"):
        length = "rad" if column[of] in turning else "m"
        states = q if what == "q" else v
        return states[:, column[of]], length if what == "q" else f"{length}/s"
    if what in ("force", "drive"):
        key = "contacts" if what == "force" else "drives"
        after, before = (getattr(side, key)[of] for side in sides(name, "reactions", t.tobytes()))
        moment = what == "drive" and column[of] in turning
        shown = force(run, of) if what == "force" else "N m" if moment else "N"
        return np.where(left, before, after), shown
    gap = run.mechanism.stop(of).gaps(q)
    return (gap, kind(run, of)) if what == "gap" else (run.mechanism.stop(of).lever * gap, "m")


def csv_motion(run: Solution) -> Iterator[Line]:
    """A hundred places evenly over each stretch between events, both its ends among them."""
    found = rows(run, "motion.csv")
    t = np.array([float(row["t_s"]) for row in found])
    moving = [item for item in run.segments if item.t_end > item.t_start]
    wanted = np.concatenate([np.linspace(item.t_start, item.t_end, 100) for item in moving])
    np.testing.assert_allclose(t, wanted, rtol=1e-14)
    left = np.array([row["limit"] == "left" for row in found])
    assert left.tolist() == ([False] * 99 + [True]) * len(moving)
    units = {
        "_rate_rad_s": ("v", "rad/s"), "_rate_m_s": ("v", "m/s"),
        "_contact_torque_N_m": ("force", "N m"), "_contact_force_N": ("force", "N"),
        "_torque_N_m": ("drive", "N m"), "_force_N": ("drive", "N"),
        "_rad": ("q", "rad"), "_m": ("q", "m"),
    }  # fmt: skip
    for key in found[0]:
        if key in ("t_s", "limit"):
            continue
        values = np.array([float(row[key]) for row in found])
        if key.startswith("cylinder_angle_"):
            psi = run.shaft.angle(t)
            np.testing.assert_allclose(
                values, psi if key.endswith("rad") else np.degrees(psi), rtol=1e-14
            )
        elif key == "index":
            yield Line(("index", ""), t, values, "", left)
        else:
            end = next(end for end in units if key.endswith(end))
            yield Line((units[end][0], key.removesuffix(end)), t, values, units[end][1], left)


def motion_lines(run: Solution) -> Iterator[Line]:
    """The panel of each stop, and the rebounds enlarged."""
    for axes in motion_figure(run).axes:
        label = axes.get_ylabel()
        stop = run.mechanism.transition_stop if axes.get_title() else label.split()[0]
        line = axes.lines[1 if axes.get_title() else 0]
        x, y = (np.asarray(values, dtype=float) for values in line.get_data())
        if not axes.get_title():
            assert (x[0], x[-1]) == pytest.approx((0.0, 1e3 * run.segments[-1].t_end), rel=1e-12)
        yield Line(("gap", stop), 1e-3 * x, y, unit_of(label))
        for beside in axes.child_axes:
            if beside.get_ylabel():
                axes.figure.draw_without_rendering()
                high = beside.get_ylim()[1] / axes.get_ylim()[1]
                yield Line(("contact", stop), 1e-3 * x, high * y, unit_of(beside.get_ylabel()))


def force_lines(run: Solution) -> Iterator[Line]:
    """Broken where a stop is open; its last value is that before it opens."""
    for axes in force_figure(run).axes:
        stop = axes.get_ylabel().split(":")[0]
        x, y = (np.asarray(values, dtype=float) for values in axes.lines[0].get_data())
        closed = [s for s in run.segments if stop in s.closed and s.t_end > s.t_start]
        breaks = np.flatnonzero(np.isnan(y))
        assert len(breaks) == len(closed)
        t, last = 1e-3 * x, np.zeros(len(x), bool)
        for begin, end, segment in zip([0, *(breaks + 1)], breaks - 1, closed, strict=False):
            ends = segment.t_start, segment.t_end
            assert (t[begin], t[end]) == pytest.approx(ends, rel=1e-12, abs=1e-15)
            # Those that the figure has in milliseconds are round-off beside the event.
            t[begin], t[end], last[end] = *ends, True
        yield Line(("force", stop), t, y, unit_of(axes.get_ylabel()), last)


def log_lines(run: Solution) -> Iterator[Line]:
    """The bounces against the time left until rest."""
    for found in run.transitions[:1]:
        log = transition_figure(run, found).axes[1]
        left, gap = (np.asarray(values, dtype=float) for values in log.lines[0].get_data())
        seen = np.isfinite(gap) & (left > 0.0)
        # Of a gap that grows from zero: the relative error of a time that is a difference.
        t = found.t_start + found.duration - 1e-3 * left[seen]
        yield Line(("gap", run.mechanism.transition_stop), t, gap[seen], unit_of(log.get_ylabel()))


def page_columns(run: Solution) -> Iterator[Line]:
    """Numbers of every frame."""
    shown = film(run, Look(exaggerate=1.0))
    said: Any = readings(shown)["columns"]
    t = shown.pace.machine
    for item in said:
        label, values = item["label"], np.array(item["values"])
        stop, _, noun = label.partition(" ")
        what = {"gap at the contact": "contact", "clamping force": "force", "stop force": "force",
                "angle": "gap", "stroke": "gap", "gap": "gap"}.get(noun)  # fmt: skip
        if label == "slow motion 1 :":
            # It is what the two clocks say of one another.
            ratio = np.diff(shown.pace.playback) / np.diff(t)
            assert float(np.median(abs(np.sqrt(values[1:] * values[:-1]) / ratio - 1.0))) < 0.01
        elif label in ("index", "time"):
            yield Line((label, ""), t, values, item["unit"], digits=5e-6)
        else:
            yield Line((str(what), stop), t, values, item["unit"], digits=5e-6)


LINES = {
    "csv": csv_motion, "motion": motion_lines, "forces": force_lines, "transition": log_lines,
    "page": page_columns,
}  # fmt: skip


@pytest.mark.parametrize("surface", LINES)
@pytest.mark.parametrize("name", TURNS)
def test_lines(name: str, surface: str) -> None:
    """Every value is that of the motion; of each stop all is there that the surface shows."""
    run = run_of(name)
    seen = set()
    for line in LINES[surface](run):
        wanted, own = motion(name, line)
        if line.name == ("index", ""):
            wanted = wanted + 40.0 * np.round((line.values - wanted) / 40.0)
        wanted = factor(own, line.unit) * wanted
        shown = np.isfinite(line.values)
        assert shown.all() or surface == "forces"
        size = float(np.abs(wanted[shown]).max(initial=0.0))
        np.testing.assert_allclose(
            line.values[shown], wanted[shown], rtol=line.digits + 1e-9,
            atol=1e-9 * size + 1e-12, err_msg=str(line.name),
        )  # fmt: skip
        seen.add(line.name)
    mechanism = run.mechanism
    stops, main = {stop.name for stop in mechanism.stops}, mechanism.transition_stop
    levers = {("contact", stop.name) for stop in mechanism.stops if stop.contact is not None}
    gaps, forces = ({(what, stop) for stop in stops} for what in ("gap", "force"))
    joints = {(what, joint.name) for what in "qv" for joint in mechanism.joints}
    drives = {("drive", drive.name) for drive in mechanism.drives}
    assert seen == {
        "csv": joints | drives | forces | {("index", "")},
        "motion": gaps | (levers if run.transitions else set()),
        "forces": forces, "transition": {("gap", main)} if run.transitions else set(),
        "page": gaps | levers | forces | {("index", ""), ("time", "")},
    }[surface]  # fmt: skip

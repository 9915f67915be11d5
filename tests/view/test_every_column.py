"""Every column of every file, every key of the document and every number of the printed tables.

What stands there is compared with :mod:`judge`, which reads the run in another way; a column that
no line here speaks of fails as well. Names carry the unit, so that a value in another unit fails.
"""

from __future__ import annotations

import csv
import io
import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from judge import Judge, press
from rich.console import Console

from nipper_pin import Case, Solution, Window, load, record, simulate
from nipper_pin.hybrid.event import Event
from nipper_pin.hybrid.result.quantities import COLLISION, TRANSITION
from nipper_pin.view.run.export import export
from nipper_pin.view.run.table import print_solution

# A cut pin's rate has a round-off of 1e-15 rad/s, which is 1e-9 of the slowest bounces here.
SLOW = 1e-8
# Gaps are sampled at 200 places a flight: the peak of the parabola through three of them.
PEAK = 1e-6
# The last flight of a series that was ended by its limit is as much off as the last but one was.
LAST = 2e-4
# Dense states are interpolated here and closed again by the package.
DENSE = 1e-8
# Rebounds below this part of the largest one of their stop have no row in a printed table.
MICRO = 1e-3


@pytest.fixture(scope="module", params=["e62", "press"])
def run(request: pytest.FixtureRequest) -> Solution:
    """A turn: stops with and without contact point, on hinges and slides; two kinds of drives."""
    if request.param == "e62":
        return simulate(load("e62"), Case(speed_rpm=650.0, window=Window.CYCLE))
    case = Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0)
    return simulate(press(), case)


@pytest.fixture(scope="module")
def judge(run: Solution) -> Judge:
    """Reads it in another way."""
    return Judge(run)


@pytest.fixture(scope="module")
def files(run: Solution, tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Any]]:
    """Rows of all CSV files by name, each a dictionary of texts."""
    folder = tmp_path_factory.mktemp("files")
    with pytest.MonkeyPatch.context() as patch:
        # The pictures have tests of their own.
        patch.setattr("nipper_pin.view.run.export.plot_solution", lambda *_: [])
        export(run, folder)
    return {path.stem: rows(path) for path in folder.glob("*.csv")}


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


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


def collision(judge: Judge, event: Event) -> dict[str, Any]:
    """What a collision has to say, by the name of the quantity."""
    name = struck(judge, event)
    item = judge.stops[name]
    impulses, lost = judge.impulses(event)
    impulse = near(impulses[name] / (item.lever or 1.0), SLOW)
    moment = item.turns and item.lever is None
    back = judge.rebound(event, name)
    after = judge.following(event, name)
    rel = LAST if after is not None and after.kind.value == "rest" else PEAK
    psi = judge.angle(event.t)
    # 1/2 v'Mv before and after are equal in most digits when a slow bounce loses little.
    whole = judge.kinetic(event.q, event.v_before)
    return {
        "stop": name,
        "t_s": near(event.t, 1e-14),
        "time_s": near(event.t - judge.hits[0].t, 1e-14),
        "cylinder_angle_rad": near(psi, 1e-12),
        "cylinder_angle_deg": near(math.degrees(psi), 1e-12),
        "index": near(judge.index(event.t), 0.0, 1e-6),
        "approach_rate": near(judge.rate(name, event.v_before), 1e-12),
        "separation_rate": near(judge.rate(name, event.v_after), 1e-12),
        "impulse_N_s": None if moment else impulse,
        "impulse_N_m_s": impulse if moment else None,
        "energy_lost_J": near(lost, SLOW, 1e-14 * whole),
        "rebound_amplitude": None if back is None else near(back[0], rel),
        "rebound_time_s": None if back is None else near(back[1], LAST if rel == LAST else 1e-9),
    }


def read(text: str) -> Any:
    """A cell: nothing, a number or a word."""
    if not text:
        return None
    try:
        return float(text)
    except ValueError:
        return text


def test_collisions_csv(judge: Judge, files: dict[str, list[Any]]) -> None:
    """Every column of every row; units of impulses by stop, both columns where both occur."""
    found = files["collisions"]
    assert len(found) == len(judge.hits)
    for number, (row, event) in enumerate(zip(found, judge.hits, strict=True), start=1):
        wanted = collision(judge, event) | {"number": number}
        wanted |= {
            "time_error_s": read(row["time_error_s"]),
            "impulse_error": read(row["impulse_error"]),
        }
        missing = {key for key in set(wanted) - set(row) if wanted[key] is not None}
        assert not missing
        assert {key: read(text) for key, text in row.items()} == {key: wanted[key] for key in row}


def test_document(judge: Judge, run: Solution) -> None:
    """The JSON document says the same; times t count from the start, others from a collision."""
    document = json.loads(json.dumps(record(run), allow_nan=False))
    origin = judge.hits[0].t
    kept = {item.name for item in COLLISION if item.read} | {"number", "stop"}
    for number, (row, event) in enumerate(
        zip(document["collisions"], judge.hits, strict=True), start=1
    ):
        wanted = collision(judge, event) | {"number": number}
        del wanted["cylinder_angle_deg"]
        wanted = {key: value for key, value in wanted.items() if value is not None or key in row}
        errors = {key: row.pop(key) for key in ("time_error_s", "impulse_error")}
        error = run.errors[event.number - 1]
        assert errors == {"time_error_s": error.time, "impulse_error": error.impulse}
        assert row == wanted
        assert set(row) | set(errors) == kept - (
            {"impulse_N_s"} if "impulse_N_m_s" in row else {"impulse_N_m_s"}
        )
    names = {frozenset(item["closed"]): item["number"] for item in judge.document["phases"]}
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
    assert set(document["transition"]) == {item.name for item in TRANSITION if item.read}
    series = list(transition(judge))
    duration = series[-1].t - series[0].t
    assert document["transition"] == {
        "premise_holds": None,
        "duration_s": near(duration, 1e-14),
        "duration_error_s": near(run.errors[series[-1].number - 1].time, 0.0),
        "collisions": len(series) - 1,
        "first_two_share": near((series[2].t - series[0].t) / duration, 1e-12),
    }


def transition(judge: Judge) -> Iterator[Event]:
    """Collisions of the transition stop until its first rest, and that."""
    stop = judge.document["transition_stop"]
    for event in judge.run.events:
        if stop in event.stops:
            yield event
            if event.kind.value == "rest":
                return


def test_phases_csv(judge: Judge, files: dict[str, list[Any]]) -> None:
    """Numbers, stops, ends in seconds and as indices."""
    names = {frozenset(item["closed"]): item["number"] for item in judge.document["phases"]}
    wanted = [
        {
            "phase": names.get(closed),
            "closed_stops": " ".join(sorted(closed)) or None,
            "t_start_s": near(begin, 1e-14),
            "t_end_s": near(end, 1e-14),
            "start_index": near(judge.index(begin), 0.0, 1e-6),
            "end_index": near(judge.index(end), 0.0, 1e-6),
        }
        for closed, begin, end in judge.phases
    ]
    found = [{key: read(text) for key, text in row.items()} for row in files["phases"]]
    assert found == wanted


def test_link_velocities_csv(judge: Judge, files: dict[str, list[Any]]) -> None:
    """Turning rate and velocity of the centre of mass of every link, before and after."""
    found = {(read(row["collision"]), row["link"]): row for row in files["link_velocities"]}
    assert len(found) == len(files["link_velocities"]) == len(judge.hits) * len(judge.names)
    for number, event in enumerate(judge.hits, start=1):
        before, after = (judge.links(event.q, v) for v in (event.v_before, event.v_after))
        for link in before:
            row = {key: read(text) for key, text in found[number, link].items()}
            wanted: dict[str, Any] = {"collision": number, "link": link}
            for word, all_links in (("before", before), ("after", after)):
                names = (
                    f"angular_{word}_rad_s", f"centroid_x_{word}_m_s", f"centroid_z_{word}_m_s"
                )  # fmt: skip
                largest = max(abs(x) for item in all_links.values() for x in item)
                for name, value in zip(names, all_links[link], strict=True):
                    wanted[name] = near(value, 1e-11, 1e-13 * largest)
            assert row == wanted


def test_motion_csv(judge: Judge, files: dict[str, list[Any]]) -> None:
    """States, forces and torques, at both limits of every event and at places between."""
    found = [{key: read(text) for key, text in row.items()} for row in files["motion"]]
    moving = [item for item in judge.run.segments if item.t_end > item.t_start]
    assert len(found) == 100 * len(moving)
    force = {True: "torque_N_m", False: "force_N"}
    for number, segment in enumerate(moving):
        for place in (0, 1, 37, 98, 99):
            row = found[100 * number + place]
            t, left = row["t_s"], place == 99
            share = place / 99.0
            q, v, _ = judge.state(t, left=left)
            forces = judge.forces(t, segment.closed, left=left)
            wanted: dict[str, Any] = {
                "t_s": near(segment.t_start + share * (segment.t_end - segment.t_start), 1e-13),
                "limit": "left" if left else "right",
                "cylinder_angle_rad": near(judge.angle(t), 1e-12),
                "cylinder_angle_deg": near(math.degrees(judge.angle(t)), 1e-12),
                "index": near(judge.index(t), 0.0, 1e-6),
            }
            for column, name in enumerate(judge.names):
                unit = "rad" if judge.turning[column] else "m"
                wanted[f"{name}_{unit}"] = near(q[column], DENSE, 1e-10)
                wanted[f"{name}_rate_{unit}_s"] = near(v[column], DENSE, 1e-8)
            for name, item in judge.stops.items():
                moment = item.turns and item.lever is None
                wanted[f"{name}_contact_{force[moment]}"] = near(forces[name], 1e-7, 1e-6)
            for name, column in judge.drives.items():
                kind = force[judge.turning[column]]
                wanted[f"{name}_{kind}"] = near(forces[name], 1e-7, 1e-6)
            assert row == wanted


# Names as printed: what it is, its unit, and the factor from the SI value.
PRINTED: dict[bool, dict[str, tuple[str, float]]] = {
    True: {
        "approach_rate": ("rad/s", 1.0), "separation_rate": ("rad/s", 1.0),
        "rebound_amplitude": ("mdeg", 1e3 * 180.0 / math.pi),
    },
    False: {
        "approach_rate": ("mm/s", 1e3), "separation_rate": ("mm/s", 1e3),
        "rebound_amplitude": ("um", 1e6),
    },
}  # fmt: skip
HEADINGS = (
    "no.", "index", "t", "rate before", "rate after", "impulse", "energy lost",
    "rebound amplitude", "rebound time",
)  # fmt: skip
KEYS = (
    "number", "index", "t_s", "approach_rate", "separation_rate", "impulse", "energy_lost_J",
    "rebound_amplitude", "rebound_time_s",
)  # fmt: skip


def printed(run: Solution) -> str:
    stream = io.StringIO()
    print_solution(run, Console(file=stream, width=200), with_forces=True)
    return stream.getvalue()


def table(text: str, title: str) -> list[list[str]]:
    """Rows of numbers of a printed table."""
    block = text.split(title, 1)[1].split("─\n", 1)[1]
    found = []
    for line in block.splitlines():
        # A line of words ends it, too.
        if not re.match(r"\s*\d+ (?!more)", line):
            break
        found.append(line.split())
    return found


def heads(text: str, title: str) -> list[str]:
    """Headings of a printed table of numbers, those of several lines put together.

    Numbers end at the right end of their column, so that a row tells where columns end.
    """
    above, below = text.split(title, 1)[1].split("───", 1)
    row = below.split("\n", 2)[1]
    ends = [match.end() for match in re.finditer(r"\S+", row)]
    lines = above.splitlines()[1:]
    starts = [0, *ends[:-1]]
    return [
        " ".join(" ".join(line[one:other] for line in lines).split())
        for one, other in zip(starts, ends, strict=True)
    ]


def test_printed_collisions(judge: Judge, run: Solution) -> None:
    """Nine columns for each stop, in the units of their headings; small rebounds are counted."""
    text = printed(run)
    for name, item in judge.stops.items():
        events = [
            (number, collision(judge, event) | {"number": number})
            for number, event in enumerate(judge.hits, start=1)
            if struck(judge, event) == name
        ]
        force = "N m s" if item.turns and item.lever is None else "N s"
        units = PRINTED[item.turns] | {
            "t_s": ("ms", 1e3), "impulse": (force, 1.0), "energy_lost_J": ("mJ", 1e3),
            "rebound_time_s": ("ms", 1e3),
        }  # fmt: skip
        title = f"Collisions of stop {name}"
        assert heads(text, title) == [
            f"{words} {units.get(key, ('', 1.0))[0]}".rstrip()
            for words, key in zip(HEADINGS, KEYS, strict=True)
        ]
        backs = [values["rebound_amplitude"] for _, values in events]
        limit = MICRO * max(back.expected for back in backs if back is not None)
        told = [pair for pair in events if pair[1]["rebound_amplitude"].expected >= limit]
        assert_small(text, title, len(events) - len(told), limit, units["rebound_amplitude"])
        found = table(text, title)
        assert len(found) == len(told)
        for cells, (number, values) in zip(found, told, strict=True):
            values["impulse"] = values[f"impulse_{force.replace(' ', '_')}"]
            for key, cell in zip(KEYS, cells, strict=True):
                value = getattr(values[key], "expected", values[key])
                scaled = value * units.get(key, ("", 1.0))[1]
                least = {"index": 6e-4, "t_s": 6e-4}.get(key, 0.0)
                # The loss of a late bounce is judged as a difference of kinetic energies.
                judged = 1e3 * values[key].abs if key == "energy_lost_J" else 0.0
                digits = near(scaled, 0.0 if least else 6e-4, max(least, judged))
                assert float(cell) == digits, (key, number)


def assert_small(text: str, title: str, count: int, limit: float, unit: tuple[str, float]) -> None:
    """The line below a table counts the rebounds that have no row, and tells their limit."""
    block = text.split(title, 1)[1].split("\n\n", 1)[0]
    told = re.findall(r"^(\d+) more rebounds? below (\S+) (\S+) \(all of them: ", block, re.M)
    assert len(told) == (1 if count else 0)
    for number, value, word in told:
        assert int(number) == count
        assert word == unit[0]
        assert float(value) == near(limit * unit[1], 6e-4)


def test_printed_phases_transition_and_forces(judge: Judge, run: Solution) -> None:
    """Indices and lengths of phases, the transition's numbers, the ranges of forces."""
    text = printed(run)
    block = text.split("\nPhases", 1)[1].split("─\n", 1)[1].split("\n\n", 1)[0]
    rows = [line.split() for line in block.splitlines() if line]
    for row, (closed, begin, end) in zip(rows, judge.phases, strict=True):
        assert float(row[-4]) == near(judge.index(begin), 0.0, 6e-4)
        assert float(row[-3]) == near(judge.index(end), 0.0, 6e-4)
        assert float(row[-2]) == near(1e3 * begin, 0.0, 6e-4)
        assert float(row[-1]) == near(1e3 * (end - begin), 0.0, 6e-4)
        assert set(" ".join(row[:-4]).replace(",", "").split()) >= set(closed or {"none"})
    series = list(transition(judge))
    duration = series[-1].t - series[0].t
    share = 100.0 * (series[2].t - series[0].t) / duration
    said = text.split("\nTransition\n")[1]
    assert float(said.split()[0]) == near(1e3 * duration, 6e-4)
    assert f"{len(series) - 1} collisions computed" in said
    assert float(said.split("first two rebounds take ")[1].split()[0]) == near(share, 6e-4)
    ranges = forces(judge)
    found = table(text, "Forces of closed stops")
    assert len(found) == len(ranges)
    for row in found:
        name = row[-5]
        stop = judge.stops[name]
        assert f"[{'N m' if stop.turns and stop.lever is None else 'N'}]" in " ".join(row)
        number = float(row[0])
        low, t_low, high, t_high = ranges[number, name]
        size = abs(high) + 1e-9
        assert float(row[-4]) == near(low, 0.0, 0.006 + 2e-3 * size)
        assert float(row[-2]) == near(high, 0.0, 0.006 + 2e-3 * size)
        # At a flat place the extreme may be read at a neighbour.
        if high - low > 0.1 * size:
            assert float(row[-3]) == near(judge.index(t_low), 0.0, 0.1)
            assert float(row[-1]) == near(judge.index(t_high), 0.0, 0.1)


def forces(judge: Judge) -> dict[tuple[float, str], tuple[float, float, float, float]]:
    """Lowest and highest force with their times, by number of the phase and stop."""
    names = {frozenset(item["closed"]): item["number"] for item in judge.document["phases"]}
    found: dict[tuple[float, str], list[tuple[float, float]]] = {}
    for segment in judge.run.segments:
        if segment.t_end <= segment.t_start:
            continue
        count = 60
        for step in range(count + 1):
            t = segment.t_start + (segment.t_end - segment.t_start) * step / count
            here = judge.forces(min(t, segment.t_end), segment.closed, left=step == count)
            for name in segment.closed:
                key = (float(names[segment.closed]), name)
                found.setdefault(key, []).append((here[name], t))
    return {key: (*min(values), *max(values)) for key, values in found.items()}


def test_printed_checks(judge: Judge, run: Solution) -> None:
    """Closures hold to round-off, and the printed figures are those of the document."""
    text, checks = printed(run), record(run)["checks"]
    for name in ("closure_m", "closure_rate_m_s", "energy_balance"):
        assert f"{checks[name]:.1e}" in text
    assert max(judge.closure(event.q) for event in judge.hits) <= checks["closure_m"] + 1e-15

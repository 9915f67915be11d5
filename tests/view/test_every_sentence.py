"""Every number in the sentences and small tables of `simulate` and `check`.

They are read from the printed text and compared with the run's raw events and states, Pinocchio's
own distances and the model's document (:mod:`judge`).
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable
from itertools import pairwise
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest
from judge import Judge, press
from rich.console import Console
from small_machines import SHAFT, hinge, link, machine, slide

from nipper_pin import Case, Mechanism, Window, load, simulate
from nipper_pin.mechanism import from_sources
from nipper_pin.study.check import ModelReport, check_model
from nipper_pin.study.next_steps import NextSteps
from nipper_pin.view.run.table import print_solution
from nipper_pin.view.studies.check_report import print_report

Array = Any


def printed(write: Callable[[Console], None]) -> str:
    """What is printed where no line is too long."""
    stream = io.StringIO()
    write(Console(file=stream, width=10_000))
    return stream.getvalue()


def twins() -> Mechanism:
    """Two equal blocks on parallel slides of a crank: both let go where it no longer lifts them."""
    stop = {"restitution": 0.3, "side": "lower", "at_mm": 0.0}
    parts = [
        link("crank", 2.0, 0.01, (0.01, 0.0)), hinge("shaft", "frame", "crank"),
        link("one", 0.5), slide("one_x", "crank", "one", at=(0.05, 0.1)),
        link("two", 0.5), slide("two_x", "crank", "two", at=(0.05, -0.1)),
    ]  # fmt: skip
    return machine(
        parts, 3, gravity=9.81,
        drives={"shaft": {"joint": "shaft", "law": "constant_speed", "ratio": 1.0, **SHAFT}},
        stops={"one": {"joint": "one_x", **stop}, "two": {"joint": "two_x", **stop}},
        phases=[{"number": 1, "name": "held", "closed": ["one", "two"]}],
    )  # fmt: skip


MACHINES = {"e62": (lambda: load("e62"), 650.0), "press": (press, 60.0), "twins": (twins, 60.0)}


@pytest.fixture(scope="module", params=sorted(MACHINES))
def judge(request: pytest.FixtureRequest) -> Judge:
    """A turn of stops with a contact, of one at a hinge, and of two that let go together."""
    make, speed = MACHINES[request.param]
    start = {"e62": 24.0}.get(request.param, 0.0)
    case = Case(speed_rpm=speed, window=Window.CYCLE, start_index=start)
    return Judge(simulate(make(), case))


@pytest.fixture(scope="module")
def text(judge: Judge) -> str:
    """What `simulate --forces` prints."""
    return printed(lambda console: print_solution(judge.run, console, with_forces=True))


def unit(judge: Judge, name: str) -> str:
    """Unit of a stop's force."""
    item = judge.stops[name]
    return "N m" if item.turns and item.lever is None else "N"


def four(value: float) -> Any:
    """A number that is printed with four digits."""
    return pytest.approx(value, rel=5.1e-4)


def springs(judge: Judge) -> list[tuple[str, list[float], str]]:
    """Name, rate, preload and force of linear springs by the document; the unit of the rate."""
    found = []
    for name, item in judge.document.get("springs", {}).items():
        if "stiffness_N_m_per_rad" in item:
            k, p = item["stiffness_N_m_per_rad"], item["preload_deg"]
            found.append((name, [k, p, k * math.radians(p)], "N m/rad"))
        else:
            k, p = item["stiffness_N_per_m"], item["preload_length_mm"]
            found.append((name, [1e-3 * k, p, 1e-3 * k * p], "N/mm"))
    return found


def test_head(judge: Judge, text: str) -> None:
    """Speed, window, restitutions, zero of time, every spring with rate, preload and force."""
    case = judge.run.case
    turn = f"{case.speed_rpm:g} r/min, window cycle (1 turn from index {case.start_index:g}), held"
    assert text.splitlines()[1].startswith(turn)
    line = next(line for line in text.splitlines() if line.startswith("restitution: "))
    wanted = [f"{name} {item['restitution']:g}" for name, item in judge.document["stops"].items()]
    assert line == f"restitution: {', '.join(wanted)}"
    line = next(line for line in text.splitlines() if line.startswith("springs: "))
    told = re.search(r"Times t count from the start of the run at index (\S+)\.$", text, re.M)
    assert told is not None
    assert float(told[1]) == pytest.approx(case.start_index, abs=6e-4)
    for name, values, of in springs(judge):
        pattern = rf"{name} (\S+) {of}, preload (\S+) (mm|deg) \((\S+) (N|N m)\)"
        match = re.search(pattern, line)
        assert match is not None
        assert [float(match[1]), float(match[2]), float(match[4])] == [four(x) for x in values]
        assert (match[3] == "mm") == (match[5] == "N") == (of == "N/mm")


def rows(text: str, title: str) -> list[list[str]]:
    """Rows of a table below a headline; cells are two blanks apart or more."""
    block = re.split(rf"^{title}$", text, flags=re.M)[1].split("\n\n")[0]
    lines = block.split("\n")
    rule = next(
        i for i, item in enumerate(lines) if item.startswith("\N{BOX DRAWINGS LIGHT HORIZONTAL}")
    )
    return [re.split(r"\s{2,}", item.strip()) for item in lines[rule + 1 :] if item.strip()]


def test_phases(judge: Judge, text: str) -> None:
    """Number, closed stops, indices of both ends, beginning and duration.

    A stretch without closed stops in which the transition stop is not struck is no transition: it
    has no number, and says what bounces.
    """
    main = judge.document.get("transition_stop", "")
    struck = [event for event in judge.run.events if event.kind.value == "collision"]
    known = {frozenset(p["closed"]): str(p["number"]) for p in judge.document["phases"]}
    found = rows(text, "Phases")
    assert len(found) == len(judge.phases)
    for cells, (closed, begin, end) in zip(found, judge.phases, strict=True):
        there = {stop for event in struck if begin <= event.t < end for stop in event.stops}
        if closed or not main or main in there:
            assert cells[0].split()[0] == known.get(closed, "without")
        else:
            assert cells[0].startswith(f"{main} open, {' and '.join(sorted(there))}")
        assert cells[1] == (", ".join(sorted(closed)) or "none")
        for cell, t in ((cells[2], begin), (cells[3], end)):
            gone = (float(cell) - judge.index(t) + 20.0) % 40.0 - 20.0
            assert abs(gone) < 6e-4
        assert float(cells[4]) == pytest.approx(1e3 * begin, abs=6e-4)
        assert float(cells[5]) == pytest.approx(1e3 * (end - begin), abs=6e-4)


def test_transition(judge: Judge, text: str) -> None:
    """Time from the first collision of the stop to its rest, collisions, and the share of two."""
    stop = judge.document["transition_stop"]
    series = [event for event in judge.run.events if stop in event.stops]
    series = [event for event in series if event.kind.value != "release"]
    match = re.search(r"(\S+) ms from the first collision to rest, (\d+) collisions? comp", text)
    if not series:
        assert match is None
        assert f"No transition of the {stop} was completed." in text
        return
    assert match is not None
    last = next(i for i, event in enumerate(series) if event.kind.value == "rest")
    duration = series[last].t - series[0].t
    assert float(match[1]) == four(1e3 * duration)
    assert int(match[2]) == last
    share = re.search(r"the first two rebounds take (\S+) % of it", text)
    assert share is not None
    wanted = 100.0 * (series[2].t - series[0].t) / duration
    assert float(share[1]) == four(wanted)
    # What it came to is told before its first table.
    assert text.index("from the first collision to rest") < text.index("\nCollisions of stop")
    turns = judge.stops[stop].turns
    unit_of_rebounds, factor = ("mdeg", 1e3 * 180.0 / math.pi) if turns else ("um", 1e6)
    told = re.search(
        rf"^First rebound (\S+) {unit_of_rebounds} in (\S+) ms; second rebound (\S+) "
        rf"{unit_of_rebounds} in (\S+) ms\.$", text, re.M,
    )  # fmt: skip
    assert told is not None
    for place in (0, 1):
        back = judge.rebound(series[place], stop)
        assert back is not None
        assert float(told[1 + 2 * place]) == four(factor * back[0])
        assert float(told[2 + 2 * place]) == four(1e3 * back[1])


def time_of(judge: Judge, index: float, closed: frozenset[str]) -> tuple[float, bool]:
    """Time in a phase with these closed stops, and whether that is its end [s]."""
    rate = 40.0 * judge.run.case.speed_rpm / 60.0
    near = 6e-4 / rate
    t = (index - judge.index(0.0)) % 40.0 / rate
    for now, begin, end in judge.phases:
        for place in (t, t - 40.0 / rate, t + 40.0 / rate):
            if now == closed and begin - near <= place <= end + near:
                return min(max(place, begin), end), place >= end - near
    raise AssertionError(index)


def test_forces(judge: Judge, text: str) -> None:
    """Least and largest force of each stop in each phase: at the index beside it, and nowhere more.

    An index has three decimals, within which the force changes by less than what is added.
    """
    found = {}
    known = {frozenset(p["closed"]): f"{p['number']} " for p in judge.document["phases"]}
    every = {now: [] for now, _, _ in judge.phases if now}  # type: ignore[var-annotated]
    for now, begin, end in judge.phases:
        if now:
            every[now].append((begin, end))
    for cells in rows(text, "Forces of closed stops"):
        found[cells[0], cells[2]] = (cells[1], [float(cell) for cell in cells[3:]])
    assert len(found) == sum(len(now) for now in every)
    for closed, parts in every.items():
        samples = [
            judge.forces(float(t), closed, left=t == end)
            for begin, end in parts
            for t in np.linspace(begin, end, 40)
        ]
        for name in closed:
            words, (low, at_low, high, at_high) = next(
                item
                for (phase, stop), item in found.items()
                if stop == name and phase.startswith(known.get(closed, "without"))
            )
            assert words.endswith(f"[{unit(judge, name)}]")
            assert words.startswith("clamping") == (name == judge.document["transition_stop"])
            values = [sample[name] for sample in samples]
            slack = 0.006 + 2e-3 * float(np.ptp(values))
            assert low <= min(values) + 0.006
            assert high >= max(values) - 0.006
            for value, index in ((low, at_low), (high, at_high)):
                t, last = time_of(judge, index, closed)
                assert value == pytest.approx(judge.forces(t, closed, left=last)[name], abs=slack)


def test_releases(judge: Judge, text: str) -> None:
    """Which stops open, at which index, how far and for how long."""
    lines = [
        line for line in text.splitlines() if re.search(r"(leaves its|leave their) stop", line)
    ]
    number = judge.document["initial_phase"]
    first = next(p["closed"] for p in judge.document["phases"] if p["number"] == number)
    # A phase may end as it begins.
    phases = [(frozenset(first), 0.0, 0.0), *judge.phases]
    lifted = []
    for (before, _, end), (after, _, _) in pairwise(phases):
        gone = [name for name in judge.stops if name in before - after]
        struck = [event for event in judge.hits if event.t == end]
        if gone and not struck:
            lifted.append((gone, before, end))
    assert len(lines) == len(lifted)
    if "two" in judge.stops:
        assert [gone for gone, _, _ in lifted] == [["one", "two"]] * 2
    known = {frozenset(p["closed"]): p["number"] for p in judge.document["phases"]}
    for line, (gone, before, t) in zip(lines, lifted, strict=True):
        match = re.match(r"The (.*) leaves? (?:its stop|their stops)(?: in phase (\d+))? at "
                         r"index (\d+\.\d+)", line)  # fmt: skip
        assert match is not None
        assert match[1].split(" and ") == gone
        assert match[2] == (str(known[before]) if before in known else None)
        assert float(match[3]) == pytest.approx(judge.index(t) % 40.0, abs=6e-4)
        pull = "would need a force that pulls" in line
        waits = judge.document["transition_stop"] not in before
        assert pull == (waits and known.get(before) == number)
        if pull:
            assert f"to hold the {' and '.join(gone)} closed" in line
        told = re.search(r"opens by up to (\S+) (\S+) and collides (\S+) ms later", line)
        later = [event for event in judge.run.events if event.t > t and gone[0] in event.stops]
        assert (told is not None) == (len(gone) == 1 and bool(later))
        if told is not None:
            times = np.linspace(t, later[0].t, 400)[1:]
            gaps = [judge.gap(gone[0], judge.state(float(x), left=True)[0]) for x in times]
            turns = judge.stops[gone[0]].turns
            assert told[2] == ("mdeg" if turns else "um")
            assert float(told[1]) == pytest.approx(
                max(gaps) * (1e3 * 180.0 / math.pi if turns else 1e6), rel=2e-3
            )
            assert float(told[3]) == pytest.approx(1e3 * (later[0].t - t), abs=6e-4)


def test_work(judge: Judge, text: str) -> None:
    """Errors of the closures and of the energy, evaluations, and time."""
    run = judge.run
    match = re.search(r"closure (\S+) m, closure rate (\S+) m/s, energy balance (\S+) of the", text)
    assert match is not None
    checks = run.checks
    wanted = [checks.closure_m, checks.closure_rate_m_s, checks.energy_balance]
    assert [float(part) for part in match.groups()] == pytest.approx(wanted, rel=0.06)
    match = re.search(r"direct engine: (\d+) evaluations of the dynamics, (\S+) ms", text)
    assert match is not None
    assert int(match[1]) == run.evaluations
    assert float(match[2]) == pytest.approx(1e3 * run.wall_s, abs=0.06)


def test_threshold() -> None:
    """A threshold is told in the unit of the stop's rate."""
    found = simulate(load("e62"), Case(speed_rpm=650.0, rest_rate=0.02))
    text = printed(lambda console: print_solution(found, console))
    assert "slower than 0.02000 rad/s" in text
    # The series is ended in the same way by a stop along a slide, whose rates are in mm/s.
    document = {**found.mechanism.description, "transition_stop": "steeve"}
    mechanism = from_sources("e62", found.mechanism.urdf, document, found.mechanism.mesh_folder)
    case = Case(speed_rpm=650.0, rest_rate=0.02, window=Window.CYCLE)
    run = simulate(mechanism, case)
    assert "slower than 20.00 mm/s" in printed(lambda console: print_solution(run, console))


# What `check` says.


STEPS = NextSteps(
    ("Missing: the [first] thing.", "Missing: the second."),
    ("Run next: nipper-pin 'a b' " + "--set c.d=1 " * 900, "Then: nipper-pin [red]x[/red]"),
)


@pytest.fixture(scope="module", params=["e62", "press"])
def checked(request: pytest.FixtureRequest) -> tuple[Judge, ModelReport, str]:
    """A turn, the findings, and their text."""
    make, speed = MACHINES[request.param]
    mechanism = make()
    report = check_model(mechanism, speed)
    judge = Judge(simulate(mechanism, Case(speed_rpm=speed, window=Window.CYCLE)))
    text = printed(lambda console: print_report(report, STEPS, console, provenance=True))
    return judge, report, text


def test_stops_of_check(checked: tuple[Judge, ModelReport, str]) -> None:
    """Limit, contact in millimetres, lever, and the smallest force with its unit and index."""
    judge, report, text = checked
    for name, item in judge.stops.items():
        line = next(line for line in text.splitlines() if line.startswith(f"stop {name}: "))
        side = "lower" if item.sense > 0.0 else "upper"
        at = math.degrees(item.at) if item.turns else 1e3 * item.at
        joint = judge.names[item.column]
        assert f"restitution {item.restitution:g}, {side} limit of {joint} at {at:g} " in line
        assert f"{at:g} {'deg' if item.turns else 'mm'}" in line
        contact = report.mechanism.stop(name).contact
        match = re.search(
            r"meeting at \((\S+), (\S+)\) mm, normal \((\S+), (\S+)\), lever (\S+) mm", line
        )
        assert (match is None) == (item.lever is None)
        if match is not None and contact is not None and item.lever is not None:
            wanted = [*(1e3 * contact.point[[0, 2]]), *contact.normal[[0, 2]], 1e3 * item.lever]
            assert [float(part) for part in match.groups()] == pytest.approx(wanted, abs=6e-3)
        told = re.search(r"smallest force while closed (\S+) (N|N m) at index (\S+)$", line)
        assert told is not None
        assert told[2] == unit(judge, name)
        key = "smallest_stop_force_N" if told[2] == "N" else "smallest_stop_moment_N_m"
        kept = report.record()[key][name]
        assert float(told[1]) == pytest.approx(kept["value"], abs=0.06)
        assert float(told[3]) == pytest.approx(kept["index"], abs=6e-3)
        values = {
            (closed, float(t), t == end): 0.0
            for closed, begin, end in judge.phases
            if name in closed
            for t in np.linspace(begin, end, 60)
        }
        for closed, t, last in values:
            values[closed, t, last] = judge.forces(t, closed, left=last)[name]
        least = min(values, key=lambda key: values[key])
        assert float(told[1]) == pytest.approx(values[least], abs=0.06)
        assert float(told[3]) == pytest.approx(judge.index(least[1]) % 40.0, abs=0.2)


def test_timing_of_check(checked: tuple[Judge, ModelReport, str]) -> None:
    """Where the transition stop closes and opens, and where stops let go."""
    judge, _, text = checked
    stop = judge.document["transition_stop"]
    speed = f"at {judge.run.case.speed_rpm:g} r/min: "
    line = next(line for line in text.splitlines() if line.startswith(speed))
    first = next(event for event in judge.hits if event.stops[0] == stop)
    closes = re.search(rf"stop {stop} closes at index (\S+)", line)
    assert closes is not None
    assert float(closes[1]) == pytest.approx(judge.index(first.t) % 40.0, abs=6e-4)
    opened = [
        end
        for (before, _, end), (after, _, _) in pairwise(judge.phases)
        if stop in before and stop not in after
    ]
    opens = re.search(r"opens at index (\S+)", line)
    assert (opens is None) == (not opened)
    if opens is not None:
        assert float(opens[1]) == pytest.approx(judge.index(opened[0]) % 40.0, abs=6e-4)
    told = re.findall(r"^stop (\S+) lets go at index (\S+): its force falls", text, re.M)
    gone = [
        (name, end)
        for (before, _, end), (after, _, _) in pairwise(judge.phases)
        for name in before - after
        if not any(event.t == end for event in judge.hits)
    ]
    assert [name for name, _ in told] == [name for name, _ in gone]
    for (_, index), (_, t) in zip(told, gone, strict=True):
        assert float(index) == pytest.approx(judge.index(t) % 40.0, abs=6e-4)


def test_conditions_of_check(checked: tuple[Judge, ModelReport, str]) -> None:
    """Condition of the closures over a turn, by Pinocchio's Jacobians; places of both."""
    judge, report, text = checked
    match = re.search(
        r"condition of the closures: at most (\S+), at index (\S+); of the impact matrix (\S+), "
        r"at index (\S+)$", text, re.M,
    )  # fmt: skip
    assert match is not None
    free = [i for i in range(len(judge.names)) if i not in judge.drives.values()]
    end = judge.run.segments[-1].t_end
    if judge.document.get("closures"):
        found = {
            float(t): float(
                np.linalg.cond(judge.closures(judge.state(float(t), left=t > 0.0)[0])[:, free])
            )
            for t in np.linspace(0.0, end, 241)
        }
        worst = max(found, key=lambda t: found[t])
        assert float(match[1]) == pytest.approx(found[worst], rel=6e-3)
        assert float(match[2]) == pytest.approx(judge.index(worst) % 40.0, abs=0.3)
    else:
        assert float(match[1]) == 1.0
    impact = report.impact_condition
    assert [float(match[3]), float(match[4])] == pytest.approx(
        [impact.value, impact.index], rel=6e-3
    )


def test_clearances_of_check(checked: tuple[Judge, ModelReport, str]) -> None:
    """Distances in millimetres at their index, by Pinocchio's own distance of both shapes."""
    judge, _, text = checked
    told = re.findall(
        r"^(clear|meet|INTERFERENCE): \S+ \((\S+)\) and \S+ \((\S+)\), (\S+) mm at index (\S+)$",
        text, re.M,
    )  # fmt: skip
    geometry = pin.buildGeomFromUrdfString(judge.model, judge.run.mechanism.urdf, pin.COLLISION)
    names = shape_names(judge.run.mechanism.urdf)
    assert len(told) == (0 if not names else 5)
    for word, one, other, distance, index in told:
        pair = [geometry.getGeometryId(names[name]) for name in (one, other)]
        geometry.addCollisionPair(pin.CollisionPair(*pair))
        data = geometry.createData()
        rate = 40.0 * judge.run.case.speed_rpm / 60.0
        t = (float(index) - judge.index(0.0)) % 40.0 / rate
        q = judge.full(judge.state(t, left=False)[0])
        pin.updateGeometryPlacements(judge.model, judge.data, geometry, data, q)
        place = len(geometry.collisionPairs) - 1
        wanted = 1e3 * pin.computeDistance(geometry, data, place).min_distance
        # Two decimals of an index; lips that meet move fast.
        assert float(distance) == pytest.approx(wanted, abs=0.02), (one, other)
        assert (word == "meet") == (abs(wanted) < 0.02)


def shape_names(urdf: str) -> dict[str, str]:
    """Pinocchio's names of collision shapes by those of the URDF."""
    return {
        str(item.get("name")): f"{owner.get('name')}_{place}"
        for owner in ElementTree.fromstring(urdf).findall("link")
        for place, item in enumerate(owner.findall("collision"))
    }


def test_what_a_model_is(checked: tuple[Judge, ModelReport, str]) -> None:
    """Counts, the kind of every joint, what moves it, and where numbers come from."""
    judge, _, text = checked
    document = judge.document
    cut = len(document.get("closures", {}))
    count = len(judge.names)
    assert (
        f"{count} moving links, {count} tree joints, {cut} cut joints, "
        f"mobility {count - 2 * cut}, {len(judge.drives)} of it driven" in text
    )
    for column, name in enumerate(judge.names):
        cells = next(line.split() for line in text.splitlines() if line.split()[:1] == [name])
        assert cells[1] == ("revolute" if judge.turning[column] else "prismatic")
        moved = [drive for drive, place in judge.drives.items() if place == column]
        assert cells[4:] == (["drive", moved[0]] if moved else [])
    for path, words in document.get("provenance", {}).items():
        if isinstance(words, str):
            assert f"{path}: {words}" in text


def test_what_is_wrong_leads_and_what_is_next_ends(
    checked: tuple[Judge, ModelReport, str],
) -> None:
    """Under the title what is missing; last the commands, each on one line however long."""
    _, report, text = checked
    lines = text.splitlines()
    assert lines[:6] == [report.mechanism.title, "", "To do", *STEPS.missing, ""]
    assert lines[6] == "Mechanism"
    assert lines[-4:] == ["", "Next", *STEPS.commands]
    whole = NextSteps((), STEPS.commands)
    lines = printed(lambda console: print_report(report, whole, console)).splitlines()
    assert lines[1:3] == ["Nothing is missing: the model can be simulated.", ""]


def test_provenance_on_request(checked: tuple[Judge, ModelReport, str]) -> None:
    """Every source where asked for, and else their number and how to ask."""
    judge, report, text = checked
    brief = printed(lambda console: print_report(report, STEPS, console))
    sources = judge.document.get("provenance", {})
    assert sources.keys() == report.mechanism.provenance.keys()
    assert brief.count("--provenance") == bool(sources)
    if sources:
        assert f"\nWhere {len(sources)} of its numbers come from: --provenance.\n" in brief
    assert "\nProvenance\n" in text
    assert "Provenance" not in brief
    for words in sources.values():
        assert str(words) in text
        assert str(words) not in brief

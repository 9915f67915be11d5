"""The benchmark as a whole, its peers, its phases and its clock, with measurements made up."""

from __future__ import annotations

import math
from dataclasses import asdict
from types import SimpleNamespace
from typing import Any

import pytest
from made_up_clock import Clock

from benchmarks.peers import Four, Setting
from benchmarks.run_time import benchmark as module
from benchmarks.run_time import cost, peer_work, phase_cost
from benchmarks.run_time.certified import Certified, certified, certified_names
from benchmarks.run_time.turns import TurnRow
from benchmarks.run_time.work_precision import Row, Stated
from nipper_pin import Case, Mechanism, Window, simulate
from nipper_pin.errors import SimulationError

ROW = Row("direct", "1e-9", 1.0, 2.0, 0.5, 0.1, 3, 1e-9, math.nan)
BOUNCE, SCENE = "no bounce", "no such scene"


@pytest.fixture(name="clock")
def made_up_clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    found = Clock()
    for place in (peer_work, phase_cost):
        monkeypatch.setattr(place, "timed", found.timed)
    return found


def peer(name: str, solve: Any, *settings: Setting) -> tuple[SimpleNamespace, str]:
    return SimpleNamespace(NAME=name, SETTINGS=settings, prepare=solve), f"{name}.1"


def test_peers(clock: Clock, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each setting graded by what it found; what fails is named and the others go on."""
    reference = certified()
    first, second = reference.rebound_times[:2]
    asked: list[tuple[str, float]] = []

    def good(mechanism: Mechanism, speed: float) -> Any:
        asked.append((mechanism.name, speed))

        def solve(setting: Setting) -> Four:
            if setting.label == "coarse":
                raise SimulationError(BOUNCE)
            e = setting.value
            return Four(
                first * (1.0 + e), second * (1.0 - 2.0 * e), reference.amplitudes[0] * (1 + 3 * e),
                reference.transition_time * (1.0 - 4.0 * e), 77,
            )  # fmt: skip

        return solve

    def bad(*_: Any) -> Any:
        raise ValueError(SCENE)

    def found() -> Any:
        yield peer("broken", bad, Setting("1", 1.0))
        yield peer(
            "good", good, Setting("1e-2", 1e-2), Setting("coarse", 1.0),
            Setting("1e-3", 1e-3, quick=False), Setting("nan", math.nan),
        )  # fmt: skip

    monkeypatch.setattr(peer_work, "available", found)
    budgets = []
    for quick, labels in ((True, ["1e-2", "nan"]), (False, ["1e-2", "1e-3", "nan"])):
        said: list[str] = []
        clock.all.clear()
        rows, failed = peer_work.peer_rows(reference, quick=quick, repeats=4, say=said.append)
        assert said == ["peer broken", "peer good"]
        assert failed == ["broken: no such scene", "good, coarse: no bounce"]
        assert [row.setting for row in rows] == labels
        for row, measured in zip(rows, clock.all, strict=True):
            assert (row.engine, row.version, row.evaluations) == ("good", "good.1", 77)
            times = (row.first_ms, row.wall_ms, row.fastest_ms, row.spread_ms, row.runs)
            n = float(measured.number)
            assert times == (100.0 + n, n, n / 8.0, n / 64.0, 4)
            if row.setting == "nan":
                assert row.error_duration is row.error_worst is None
            else:
                off = pytest.approx(4.0 * float(row.setting), rel=1e-9)
                assert row.error_duration == off
                assert row.error_worst == off
        assert {item.repeats for item in clock.all} == {4}
        (budget,) = {item.budget_s for item in clock.all}
        budgets.append(budget)
    assert 0.0 < budgets[0] < budgets[1]
    assert set(asked) == {("e62", 650.0)}


def test_phases_of_a_turn(clock: Clock, e62: Mechanism) -> None:
    """Every segment belongs to the phase that its closed stops make; rows add up to the turn."""
    rows = phase_cost.phase_cost(e62, 450.0, 5)
    run = simulate(e62, Case(speed_rpm=450.0, window=Window.CYCLE))
    assert {item.repeats for item in clock.all} == {5}
    *phases, rest, total = rows
    # The whole turn is measured first, then the segments in their order.
    wanted: dict[str, list[float]] = {}
    for number, segment in enumerate(run.segments, 2):
        phase = e62.phase_of(segment.closed)
        name = "other" if phase is None else f"phase {phase.number}, {phase.name}"
        wanted.setdefault(name, []).append(float(number))
    assert [row["what"] for row in phases] == list(wanted)
    assert len(phases) > 1
    for row in phases:
        assert row["wall_ms"] == sum(wanted[row["what"]])
        assert row["segments"] == len(wanted[row["what"]])
        # The closures determine the motion of a phase without freedom: only flights need forces.
        assert (row["evaluations"] > 0) == row["what"].startswith("phase 3")
    evaluations = sum(row["evaluations"] for row in phases)
    assert rest == {
        "what": "start, impacts, changes of phase", "wall_ms": 0.0, "segments": 0,
        "evaluations": run.evaluations - evaluations,
    }  # fmt: skip
    assert total == {
        "what": "whole turn", "wall_ms": 1.0, "evaluations": run.evaluations,
        "segments": len(run.segments),
    }  # fmt: skip
    # A segment followed alone needs what it needed in the run; starts and impacts are the rest.
    assert abs(rest["evaluations"]) < 0.1 * run.evaluations


def test_parts_of_a_transition(
    clock: Clock, monkeypatch: pytest.MonkeyPatch, e62: Mechanism
) -> None:
    """Times of flights, nodes and impacts in their places, and what the run needs beside them."""
    clock_of = clock.timed

    def longest_first(function: Any, repeats: int, budget_s: float = math.inf) -> Any:
        found = clock_of(function, repeats, budget_s)
        # 1000 ms for the run, 500 for its flights, 333.3 for the nodes, 250 for the impacts.
        return type(found)(0.0, 1000.0 / found.median_ms, 0.0, 0.0, repeats)

    monkeypatch.setattr(phase_cost, "timed", longest_first)
    rows = phase_cost.transition_parts(e62, 650.0, 4, tolerance=1e-10)
    run, flights, nodes, impacts = clock.all
    assert {item.repeats for item in clock.all} == {4}
    solution: Any = run.result
    assert solution.case.resolution.tolerance == 1e-10
    assert solution.case.speed_rpm == 650.0
    segments = [item for item in solution.segments if not item.kinematic]
    assert [item.segment.t_end for item in flights.result] == pytest.approx(  # type: ignore[attr-defined]
        [item.t_end for item in segments], abs=1e-14
    )
    places = [panel for item in segments for panel in item.panels]
    # Accelerations at the nodes are those of the panels.
    for found, panel in zip(nodes.result, places, strict=True):  # type: ignore[call-overload]
        assert found == pytest.approx(panel.a, rel=1e-8, abs=1e-5)
    hits = [item.event for item in solution.collisions]
    for impact, event in zip(impacts.result, hits, strict=True):  # type: ignore[call-overload]
        assert impact.v_after == pytest.approx(event.v_after, abs=1e-10)
    counted = sum(len(panel.q) for panel in places)
    responding = 1000.0 / 3.0 * solution.evaluations / counted
    assert [row["what"] for row in rows] == [
        "evaluations of the dynamics", "flights without them", "impacts",
        "start, limit of the bounces, record", "whole transition",
    ]  # fmt: skip
    assert [row["wall_ms"] for row in rows] == pytest.approx(
        [responding, 500.0 - responding, 250.0, 250.0, 1000.0]
    )
    assert [row["count"] for row in rows] == [solution.evaluations, len(segments), len(hits), 1, 1]


@pytest.mark.parametrize("quick", [True, False])
def test_costs_in_their_places(
    monkeypatch: pytest.MonkeyPatch, e62: Mechanism, quick: bool
) -> None:
    """Every table under its own name, with the numbers of the short or of the long form."""
    names = ("phase_cost", "transition_parts", "collision_cost", "turn_cost",
             "link_cost", "memory")  # fmt: skip
    for name in names:
        monkeypatch.setattr(cost, name, lambda *a, name=name, **k: (name, *a, *k.values()))
    found = cost.costs(e62, quick=quick, repeats=5)
    budget = found["collisions"][-1]
    assert found == {
        "phases": ("phase_cost", e62, 450.0, 5),
        "parts": ("transition_parts", e62, 650.0, 5),
        "collisions": ("collision_cost", 5, budget),
        "turns": ("turn_cost", e62, (1, 3, 10) if quick else (1, 3, 10, 30, 100), 5, budget),
        "links": ("link_cost", (1, 2, 5, 10) if quick else (1, 2, 5, 10, 20, 40), 5, budget),
        "memory": ("memory", 10 if quick else 100),
    }
    assert budget < 1.0 if quick else budget > 1.0


@pytest.mark.parametrize(
    ("quick", "repeats", "count"), [(True, None, 10), (False, None, 30), (False, 4, 4)]
)
def test_the_whole(
    monkeypatch: pytest.MonkeyPatch, quick: bool, repeats: int | None, count: int
) -> None:
    """What each part is asked, where its answer goes, and the order in which it is told."""
    asked: dict[str, Any] = {}

    def part(name: str, answer: Any) -> None:
        def called(*arguments: Any, **named: Any) -> Any:
            asked[name] = (arguments, named)
            return answer

        monkeypatch.setattr(module, name, called)

    graded: list[tuple[str, str, float]] = []

    def accuracy(case: Certified, mechanism: Mechanism, tolerance: float) -> Row:
        graded.append((case.name, mechanism.name, tolerance))
        return ROW

    reduced = Row("reduced", "1e-9", 1.0, 2.0, 0.5, 0.1, 3, 1e-9, 1e-9)
    other = Row("peer", "1e-9", 1.0, 2.0, 0.5, 0.1, 3, 1e-9, 1e-9)
    part("direct_rows", [ROW])
    part("reduced_work", ([reduced], {"build_ms": math.inf}))
    turn = TurnRow("direct", "450 r/min, 1e-09", 13.0, 1e-12, math.nan, 77.0, None)
    part("turn_rows", [turn])
    part("peer_rows", ([other], ["gone"]))
    part("costs", {"memory": [{"peak_MB": 1.0}]})
    part("environment", {"cores": 2})
    part("true_over_stated", [Stated("650", 1e-4, 0.5, 0.25)])
    monkeypatch.setattr(module, "accuracy", accuracy)
    said: list[str] = []

    result = module.benchmark(quick=quick, repeats=repeats, say=said.append)
    assert said == ["direct engine", "reduced engine", "whole turns", "peers", "costs"]
    for name in ("direct_rows", "reduced_work", "peer_rows"):
        (reference,), named = asked[name]
        assert reference.name == "650"
        assert (named["quick"], named["repeats"]) == (quick, count)
    (mechanism,), named = asked["costs"]
    assert mechanism.name == "e62"
    assert (named["quick"], named["repeats"]) == (quick, count)
    assert "mujoco" in asked["environment"][0][0]
    assert graded == [(name, "e62", 1e-12) for name in certified_names()]
    document = result.record()
    assert document["quick"] is quick
    assert document["environment"] == {"cores": 2}
    assert [row["engine"] for row in document["engines"]] == ["direct", "reduced"]
    assert [row["engine"] for row in document["peers"]] == ["peer"]
    assert len(document["accuracy"]) == len(certified_names())
    assert document["accuracy"][0] == {**asdict(ROW), "error_worst": None}
    assert document["stated"] == [
        {"case": "650", "tolerance": 1e-4, "times": 0.5, "impulses": 0.25}
    ]
    assert document["unavailable"] == ["gone"]
    assert document["reduced"] == {"build_ms": None}
    assert document["cost"] == {"memory": [{"peak_MB": 1.0}]}

"""The benchmark as a whole, its peers and its costs, with measurements made up."""

from __future__ import annotations

import math
from dataclasses import asdict
from types import SimpleNamespace
from typing import Any

import pytest
from made_up_clock import Clock

from benchmarks.peers import Four, Setting
from benchmarks.run_time import benchmark as module
from benchmarks.run_time import cost, peer_work
from benchmarks.run_time.certified import Certified, certified, certified_names
from benchmarks.run_time.turns import TurnRow
from benchmarks.run_time.work_precision import Row
from nipper_pin import Mechanism
from nipper_pin.errors import SimulationError

ROW = Row("direct", "1e-9", 1.0, 2.0, 0.5, 0.1, 3, 1e-9, math.nan)
BOUNCE, SCENE = "no bounce", "no such scene"


@pytest.fixture(name="clock")
def made_up_clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    found = Clock()
    monkeypatch.setattr(peer_work, "timed", found.timed)
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


@pytest.mark.parametrize("quick", [True, False])
def test_costs_in_their_places(
    monkeypatch: pytest.MonkeyPatch, e62: Mechanism, quick: bool
) -> None:
    """Every table under its own name, with the numbers of the short or of the long form."""
    for name in ("turn_cost", "link_cost"):
        monkeypatch.setattr(cost, name, lambda *a, name=name, **k: (name, *a, *k.values()))
    found = cost.costs(e62, quick=quick, repeats=5)
    budget = found["turns"][-1]
    assert found == {
        "turns": ("turn_cost", e62, (1, 3, 10) if quick else (1, 3, 10, 30, 100), 5, budget),
        "links": ("link_cost", (1, 2, 5, 10) if quick else (1, 2, 5, 10, 20, 40), 5, budget),
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
    part("costs", {"turns": [{"turns": 1.0}]})
    part("environment", {"cores": 2})
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
    assert document["unavailable"] == ["gone"]
    assert document["reduced"] == {"build_ms": None}
    assert document["cost"] == {"turns": [{"turns": 1.0}]}

"""The list of what is skipped: what is run with and without each thing, how often, and its name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin
import pytest
from made_up_clock import Clock

from benchmarks.run_time import skips
from benchmarks.run_time.skips import Skip
from nipper_pin import Case, Mechanism, Window, simulate
from nipper_pin.dynamics.multibody import Multibody
from nipper_pin.hybrid.result.trajectory import Trajectory

TRANSITION = Case(speed_rpm=650.0)
TURN = Case(speed_rpm=650.0, window=Window.CYCLE)


@pytest.fixture(name="clock")
def watching_clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    found = Clock()
    monkeypatch.setattr(skips, "timed", found.timed)
    for name in ("simulate", "again", "integrate", "multipliers", "closure_residuals"):
        found.watch(monkeypatch, skips, name)
    return found


def cases(clock: Clock, median_ms: float) -> list[Case]:
    return [arguments[1] for arguments in clock.of(median_ms).named("simulate")]


def test_the_list(monkeypatch: pytest.MonkeyPatch, e62: Mechanism) -> None:
    """Every line once, in its order, with the repeats that are asked for or fewer of long ones."""
    asked: list[tuple[str, tuple[Any, ...]]] = []
    single = ("_kinematic", "_repeating", "_refinement", "_contact_search", "_dead_rows", "_plots")
    for name in (*single, "_asked_for", "_prescribed"):

        def line(_: Mechanism, *rest: Any, name: str = name) -> Any:
            asked.append((name, rest))
            return Skip(name, 1.0, 2.0) if name in single else [Skip(name, 1.0, 2.0)] * 2

        monkeypatch.setattr(skips, name, line)
    monkeypatch.setattr(
        skips, "left_out", lambda count: [("rich", 10.0 * count, 20.0), ("numba", 3.0, 4.0)]
    )

    def picture(*_: Any) -> None:
        pytest.fail("drawn")

    for quick, repeats, turns, drawn, fresh in ((True, 3, 10, 1, 2), (False, 30, 100, 3, 5)):
        asked.clear()
        found = skips.skips(e62, quick=quick, repeats=repeats, pictures=picture)
        assert [item.what for item in found] == [
            "_kinematic", "_repeating", "_asked_for", "_asked_for", "_prescribed", "_prescribed",
            "_refinement", "_contact_search", "_dead_rows", "_plots",
            "import of rich (start of the command)", "import of numba (start of the command)",
        ]  # fmt: skip
        assert found[-2:] == [
            Skip("import of rich (start of the command)", 10.0 * fresh, 20.0),
            Skip("import of numba (start of the command)", 3.0, 4.0),
        ]
        wanted = {name: (repeats,) for name in (*single, "_asked_for", "_prescribed")}
        # A fifth of the repeats, and at least one.
        wanted |= {"_repeating": (turns, {3: 1, 30: 6}[repeats]), "_plots": (picture, drawn)}
        assert dict(asked) == wanted
    names = [item.what for item in skips.skips(e62, quick=True, repeats=3)]
    assert "_plots" not in names
    assert len(names) == 11


@pytest.mark.parametrize(("repeats", "fewer"), [(9, 3), (2, 1)])
def test_kinematic_phases(clock: Clock, e62: Mechanism, repeats: int, fewer: int) -> None:
    """The same segments, those without a freedom, followed again and integrated."""
    line = skips._kinematic(e62, repeats)
    assert (line.with_ms, line.without_ms) == (1.0, 2.0)
    assert [item.repeats for item in clock.all] == [repeats, fewer]
    followed, integrated = clock.all[0].named("again"), clock.all[1].named("integrate")
    assert [id(item[1]) for item in followed] == [id(item[1]) for item in integrated]
    run = simulate(e62, TURN)
    assert [item[1].t_end for item in followed] == [s.t_end for s in run.segments if s.kinematic]


def test_turns_that_repeat(clock: Clock, e62: Mechanism) -> None:
    line = skips._repeating(e62, 2, 4)
    assert line.what == "turns that repeat exactly (2 turns)"
    for value, reuse in ((line.with_ms, True), (line.without_ms, False)):
        (case,) = cases(clock, value)
        assert (case.cycles, case.reuse_cycles, case.window) == (2, reuse, Window.CYCLE)
        assert case.speed_rpm == 650.0
        assert clock.of(value).repeats == 4


def test_what_is_asked_for(clock: Clock, monkeypatch: pytest.MonkeyPatch, e62: Mechanism) -> None:
    """The same run alone and with the question, which sees the run."""
    monkeypatch.setattr(skips, "_SAMPLES", 30)
    for name in ("evaluate", "reactions"):
        clock.watch(monkeypatch, Trajectory, name)
    rows = skips._asked_for(e62, 7)
    told = {
        "amplitudes and rebound times (transition)": "",
        "dense motion, 30 samples (turn)": "evaluate",
        "reactions in all joints, 30 samples (turn)": "reactions",
        "stated errors of all events (transition)": "", "energy balance (turn)": "",
        "closure check (turn)": "closure_residuals",
    }  # fmt: skip
    assert [row.what for row in rows] == list(told)
    run = simulate(e62, TURN)
    for row in rows:
        wanted = TURN if row.what.endswith("(turn)") else TRANSITION
        assert cases(clock, row.with_ms) == cases(clock, row.without_ms) == [wanted]
        bare, asked = clock.of(row.with_ms), clock.of(row.without_ms)
        assert bare.repeats == asked.repeats == 7
        assert len(bare.calls) == 1
        if name := told[row.what]:
            (call,) = [item for item in asked.named(name) if len(item) > 1][:1]
            if name != "closure_residuals":
                assert call[1] == pytest.approx(np.linspace(0.0, run.shaft.period, 30))
    assert len({row.without_ms for row in rows}) == 6
    rebounds, _, _, errors, energy, closed = (clock.of(row.without_ms).result for row in rows)
    transition = simulate(e62, TRANSITION)
    assert [item.t for item in rebounds] == [item.t for item in transition.collisions]  # type: ignore[attr-defined]
    assert errors == transition.errors
    assert type(energy) is type(run.energy)
    # Relative to the links, and to their rates: round-off.
    assert 0.0 < max(closed) < 1e-10  # type: ignore[call-overload]


def test_links_that_move_as_prescribed(
    clock: Clock, monkeypatch: pytest.MonkeyPatch, e62: Mechanism
) -> None:
    """Torques at every panel of a transition; reactions at every node, too."""
    clock.watch(monkeypatch, Multibody, "joint_wrenches")
    torques, both = skips._prescribed(e62, 7)
    assert torques.what == "links whose motion is prescribed: torques (transition)"
    assert both.what.endswith("torques and reactions (transition; all joints at once)")
    assert torques.with_ms == both.with_ms
    panels = [panel for item in simulate(e62, TRANSITION).segments for panel in item.panels]
    for value, multipliers, wrenches in (
        (torques.with_ms, 0, 0),
        (torques.without_ms, len(panels), 0),
        (both.without_ms, len(panels), sum(panel.order for panel in panels)),
    ):
        found = clock.of(value)
        assert found.repeats == 7
        assert cases(clock, value) == [TRANSITION]
        assert len(found.named("multipliers")) == multipliers
        assert len(found.named("joint_wrenches")) == wrenches
    nodes = [(q, v, a) for p in panels for q, v, a in zip(p.q, p.v, p.a, strict=True)]
    calls = clock.of(both.without_ms).named("joint_wrenches")
    for call, node in zip(calls, nodes, strict=True):
        assert all(np.array_equal(one, other) for one, other in zip(call[1:4], node, strict=True))


def test_refinement(clock: Clock, monkeypatch: pytest.MonkeyPatch, e62: Mechanism) -> None:
    """Accelerations at the nodes, and the same once more refined, of what was found there."""
    clock.watch(monkeypatch, Multibody, "refined")
    line = skips._refinement(e62, 7)
    assert line.what == "refinement of accelerations (dynamics at the nodes of a transition)"
    plain, refined = clock.of(line.with_ms), clock.of(line.without_ms)
    assert (plain.repeats, refined.repeats) == (7, 7)
    panels = [panel for item in simulate(e62, TRANSITION).segments for panel in item.panels]
    assert not plain.calls
    calls = refined.named("refined")
    for (_, q, v, a, armature), panel in zip(calls, panels, strict=True):
        assert np.array_equal(q, panel.q)
        assert np.array_equal(v, panel.v)
        assert a == pytest.approx(panel.a, rel=1e-9, abs=1e-6)
        # Held drives have an armature beyond all masses.
        assert armature.max() > 1e20


def test_contact_of_the_lips(clock: Clock, monkeypatch: pytest.MonkeyPatch, e62: Mechanism) -> None:
    """One query by the engine's evaluations, each of two lips as far apart as the jaw is open."""
    geometry, pair = skips._lips(e62)
    assert [geometry.geometryObjects[item].name for item in pair] == ["bottom_lip", "top_lip"]
    found: list[float] = []
    real = coal.distance

    def distance(*arguments: Any) -> float:
        found.append(real(*arguments))
        return found[-1]

    with monkeypatch.context() as patched:
        patched.setattr(coal, "distance", distance)
        line = skips._contact_search(e62, 7)
    # Before, pairs of shapes at the jaw are compared, to find the lips.
    run = simulate(e62, TRANSITION)
    found = found[-run.evaluations :]
    assert (line.with_ms, line.without_ms) == (1.0, 2.0)
    assert [item.repeats for item in clock.all] == [7, 7]
    assert line.what.startswith("search for the contact of the lips (transition;")
    states = [q for item in run.segments for p in item.panels for q in p.q[: p.order]]
    # The search for the nearest points ends where it gains less than 1e-6.
    alone = pin.GeometryModel()
    for item in pair:
        alone.addGeometryObject(geometry.geometryObjects[item])
    alone.addCollisionPair(pin.CollisionPair(0, 1))
    data, shapes = e62.model.createData(), alone.createData()
    for number, own in enumerate(found):
        pin.computeDistances(e62.model, data, alone, shapes, states[number % len(states)])
        assert own == pytest.approx(shapes.distanceResults[0].min_distance, abs=1e-6)
    assert np.ptp(found) > 1e-5


def test_rows_out_of_the_plane(
    clock: Clock, monkeypatch: pytest.MonkeyPatch, e62: Mechanism
) -> None:
    """Both systems give the velocities after the first collision; one has a row more a pin."""
    clock.watch(monkeypatch, pin, "impulseDynamics")
    line = skips._dead_rows(e62, 7)
    assert line.what == "out-of-plane rows of the cut pins (1000 impacts)"
    event = simulate(e62, TRANSITION).events[0]
    pins = len(e62.closures)
    for value, rows, damping in ((line.with_ms, 2 * pins, 0.0), (line.without_ms, 3 * pins, 1e-12)):
        found = clock.of(value)
        assert found.repeats == 7
        calls = found.named("impulseDynamics")
        assert len(calls) == 1000
        _, _, q, v, jacobian, restitution, damped = calls[-1]
        assert jacobian.shape == (rows + 1, e62.model.nv)
        assert (restitution, damped) == (0.0, damping)
        assert np.array_equal(q, event.q)
        assert np.array_equal(v, event.v_before)
        assert np.count_nonzero(jacobian[-1]) == 1
        assert jacobian[-1, e62.stop("jaw").index] == 1.0


def test_plots(clock: Clock, e62: Mechanism) -> None:
    drawn: list[tuple[float, Path]] = []

    def picture(solution: Any, folder: Path) -> None:
        assert folder.is_dir()
        drawn.append((solution.case.speed_rpm, folder))

    assert skips._plots(e62, picture, 2) == Skip("plots (transition)", 1.0, 2.0)
    assert [item.repeats for item in clock.all] == [2, 2]
    assert cases(clock, 1.0) == cases(clock, 2.0) == [TRANSITION]
    ((speed, folder),) = drawn
    assert speed == 650.0
    assert not folder.exists()

"""Limits to which the power of springs and dampers, tables and struts are held, found anew."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from machine_of_all_elements import everything
from made_up_runs import EPS, Said, compared, mechanism, watched

from benchmarks.stress.checks import elements as element_invariants
from benchmarks.stress.mechanics.planar_tree import PlanarTree
from nipper_pin.mechanism import Mechanism, from_sources

# Springs, dampers, tables, struts, how stiff the struts are and how fast all moves.
ELEMENTS: dict[str, tuple[int, int, int, int, float, float]] = {
    "all": (2, 2, 2, 2, 1.0, 1.0), "springs": (2, 0, 0, 0, 1.0, 1.0),
    "dampers": (0, 2, 0, 0, 1.0, 1.0), "tables": (0, 0, 2, 0, 1.0, 1.0),
    "struts": (0, 0, 0, 2, 1.0, 1.0), "stiff struts": (1, 1, 1, 2, 1e12, 1.0),
    "slow": (2, 1, 1, 2, 1.0, 1e-9), "none": (0, 0, 0, 0, 1.0, 1.0),
}  # fmt: skip


@pytest.mark.parametrize("case", ELEMENTS)
def test_limits_of_powers(monkeypatch: pytest.MonkeyPatch, case: str) -> None:
    springs, dampers, tables, struts, stiff, fast = ELEMENTS[case]
    rng = np.random.default_rng(7)
    q, v = rng.normal(size=(3, 5)), fast * rng.normal(size=(3, 5))
    named = SimpleNamespace
    machine = mechanism(
        springs=[named(stiffness=3.0, preload=-1.5, index=1), named(stiffness=2e7, preload=0.5,
                       index=4)][:springs],
        dampers=[named(damping=0.5, index=0), named(damping=7.0, index=3)][:dampers],
        tabulated_springs=[named(name=f"t{k}", index=k, characteristic=named(
            coordinate=(k, 1.0), force=(k, 2.0), forces=lambda x, k=k: np.cos(x) + k))
            for k in (2, 3)][:tables],
        struts=[named(stiffness=stiff * 20.0, free_length=1.5, damping=4.0, k=0),
                named(stiffness=stiff * 0.3, free_length=0.1, damping=0.2, k=1)][:struts],
    )  # fmt: skip
    system: Any = SimpleNamespace(
        body=SimpleNamespace(reach_m=0.7),
        applied_forces=lambda q, v: np.sin(q) + v**2, dissipation=lambda _, v: -v.sum(axis=1) - 3.0,
    )  # fmt: skip

    def line(of: Any, reach_m: float, strut: Any, q: Any, v: Any) -> tuple[float, float, float]:
        assert (of, reach_m) == ("the tree", 0.7)
        return 1.0 + q[strut.k] ** 2, fast * (-2.0 + strut.k), 1e-9 * abs(v[0] + strut.k)

    rows: list[tuple[Any, ...]] = []
    monkeypatch.setattr(element_invariants, "_line", line)
    tree = SimpleNamespace(of=lambda told: "the tree" if told is machine else "")
    monkeypatch.setattr(element_invariants, "PlanarTree", tree)
    monkeypatch.setattr(element_invariants, "_between_rows", lambda *a: rows.append(a) or ["row"])
    times = np.array([0.1, 0.2, 0.3])
    segment = SimpleNamespace(t_start=0.5)
    monkeypatch.setattr(element_invariants, "samples", lambda _: [(segment, None, times)])
    said = watched(monkeypatch, element_invariants)
    evaluate = {id(times): SimpleNamespace(q=q, v=v)}
    run: Any = SimpleNamespace(mechanism=machine, system=system, trajectory=SimpleNamespace(
        evaluate=lambda t: evaluate[id(t)]))  # fmt: skip
    where = "segment at 0.5 s"
    assert list(element_invariants.elements(run)) == 3 * tables * ["row"]
    assert rows == [
        (where, t.name, state[t.index], np.cos(state[t.index]) + t.index, (t.index, 1.0),
         (t.index, 2.0)) for state in q for t in machine.tabulated_springs
    ]  # fmt: skip
    wanted: list[Said] = []
    for state, rate in zip(q, v, strict=True):
        given, taken, unsure = [], [], 0.0
        for s in machine.springs:
            given.append(-s.stiffness * (s.preload + state[s.index]) * rate[s.index])
            full = s.stiffness * (abs(s.preload) + abs(state[s.index])) * abs(rate[s.index])
            unsure += 8.0 * EPS * full
        taken += [d.damping * rate[d.index] ** 2 for d in machine.dampers]
        given += [-(np.cos(state[t.index]) + t.index) * rate[t.index]
                  for t in machine.tabulated_springs]  # fmt: skip
        for s in machine.struts:
            length, opening, error = line("the tree", 0.7, s, state, rate)
            spring = s.stiffness * (length - s.free_length)
            given.append(-spring * opening)
            taken.append(s.damping * opening**2)
            unsure += abs(spring + s.damping * opening) * error
            unsure += s.damping * (abs(opening) + error) * error
            unsure += 64.0 * EPS * 0.7 * s.stiffness * abs(opening)
        power = float((np.sin(state) + rate**2) @ rate)
        heat, lost = -sum(rate) - 3.0, sum(taken)
        most = 1e-9 * (sum(map(abs, given)) + lost) + unsure
        off = abs(power - sum(given) + lost)
        wanted += [(f"{where}: power of springs and dampers [W]", off, most),
                   (f"{where}: power that dampers take [W]", abs(heat - lost),
                    1e-9 * lost + unsure),
                   (f"{where}: power that dampers give [W]", -heat, 0.0)]  # fmt: skip
    compared(said, wanted)


ROWS, FORCES = (-2.0, -1.5, 0.5, 2.0), (5.0, -8.0, -2.0, 1.0)


@pytest.mark.parametrize(
    ("x", "place"),
    [(-2.5, 0), (-2.0, 0), (-1.75, 0), (-1.5, 0), (-0.75, 1), (0.5, 1), (1.0, 2), (2.0, 2),
     (2.25, 2)],
)  # fmt: skip
@pytest.mark.parametrize("force", [-9.0, 3.0])
def test_limits_of_tables(
    monkeypatch: pytest.MonkeyPatch, x: float, place: int, force: float
) -> None:
    """Of the two rows beside a place; beyond the ends three times the steepest slope counts."""
    said = watched(monkeypatch, element_invariants)
    found = element_invariants._between_rows("here", "t", x, force, ROWS, FORCES)
    assert list(found) == []
    low, high = sorted(FORCES[place : place + 2])
    beyond = max(-2.0 - x, x - 2.0)
    most = 1e-9 * 8.0 + 3.0 * 26.0 * max(beyond, 0.0)
    over = max(low - force, force - high)
    compared(said, [("here: t leaves its table by [rad or m]", beyond, 1e-8 * 4.0),
                    ("here: t overshoots its rows by", over, most)])  # fmt: skip


@pytest.fixture(scope="module")
def machine() -> Mechanism:
    source = everything()
    return from_sources(source.name, source.urdf, source.description, source.folder)


@pytest.mark.parametrize("fast", [1.0, 1e-6])
@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("far", [1.0, 9.0])
def test_lines_of_struts(machine: Mechanism, fast: float, swapped: bool, far: float) -> None:
    """Length and rate by Pinocchio's frames; the points are far apart, near, or one on another."""
    (strut, *_) = machine.struts
    tree, model, reach_m = PlanarTree.of(machine), machine.model, far * machine.reach_m
    data = model.createData()
    ends = (strut.frame_b, strut.frame_a) if swapped else (strut.frame_a, strut.frame_b)
    for names in (ends, ("frame", ends[1]), (ends[0], "frame"), (ends[0], ends[0])):
        item: Any = SimpleNamespace(frame_a=names[0], frame_b=names[1])
        for seed in range(4):
            rng = np.random.default_rng(seed)
            q, v = rng.normal(size=model.nv), fast * rng.normal(size=model.nv)
            v[seed % model.nv] = -5.0 * fast
            pin.forwardKinematics(model, data, q, v)
            pin.updateFramePlacements(model, data)
            frames = [model.getFrameId(name, pin.FrameType.BODY) for name in names]
            places = [data.oMf[frame].translation[[0, 2]] for frame in frames]
            axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
            rates = [pin.getFrameVelocity(model, data, k, axes).linear[[0, 2]] for k in frames]
            line, moving = places[1] - places[0], rates[1] - rates[0]
            length = float(np.hypot(*line))
            reach = reach_m + max(abs(x) for place in places for x in place)
            error = 64.0 * EPS * max(abs(v)) * max(reach, 1.0)
            error *= 1.0 + reach / max(length, EPS * reach)
            told = element_invariants._line(tree, reach_m, item, q, v)
            assert told[0] == pytest.approx(length, rel=1e-12, abs=0.0)
            rate = float(line @ moving) / length if length else 0.0
            assert told[1] == pytest.approx(rate, rel=1e-11, abs=1e-11 * fast)
            assert told[2] == pytest.approx(error, rel=1e-12, abs=0.0)

"""Limits to which closures, gaps, forces and rates between events are held, worked out anew."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from made_up_runs import EPS, STOPS, Body, Said, compared, mechanism, watched

from benchmarks.stress.checks import invariants
from benchmarks.stress.observations import Shown

STRUTS = (SimpleNamespace(stiffness=4e9), SimpleNamespace(stiffness=3e8))
# What follows moves in the same way, at other speeds and lengths of panels.
CASES: dict[str, dict[str, Any]] = {
    "held": {},
    "inertial": {"held": False},
    "struts": {"struts": STRUTS, "held": False},
    "stiff train": {"held": False, "train": 3e12},
    "large": {"reach": 1.8, "struts": STRUTS},
    "fast": {"fast": 300.0},
    "slow": {"fast": 1e-9, "springs": 0.0},
    "at rest": {"fast": 1e-14, "h": 2e-6, "springs": 0.0},
    "springs": {"fast": 1e-9, "springs": 5e9},
    "wound": {"fast": 1e-9, "springs": 0.0, "held": False, "train": 1e9},
    "coarse": {"tolerance": 1e-4},
    "late": {"tolerance": 1e-14, "end": 5e4},
    "open": {"closed": frozenset()},
    "no drives": {"drives": 0},
    "free": {"drives": 0, "held": False, "fast": 1e-9, "springs": 0.0},
    "no closures": {"rows": 0},
    "weightless": {"fast": 1e-7, "springs": 0.0, "struts": STRUTS[:1], "weight": 0.0},
}


class Equations:
    """Forces and closures of the judge, made up, too."""

    def __init__(self, springs: float, train: float, drives: int, rows: int) -> None:
        rng = np.random.default_rng(8)
        self.forces = self
        self.k, self.d = springs * rng.normal(size=5), springs * rng.normal(size=5)
        self.stiffness = train * np.array([0.5, 1.0][:drives])
        self.G = rng.normal(size=(rows, 5))

    def closures(self, q: Any) -> Any:
        rows = self.G * (1.0 + q[..., 1, None, None] ** 2)
        return 1e-3 * (q[..., : len(self.G)] - 0.5), rows

    def of_elements(self, q: Any, v: Any) -> Any:
        return -self.k * q - self.d * v, np.full(q.shape, np.nan)

    def tension(self, q: Any, v: Any) -> float:
        return float(np.abs(q).sum() + 3.0 * np.abs(v).sum())


class Run:
    """One panel of a made-up run with one or two of its stops closed."""

    def __init__(self, fast: float = 1.0, h: float = 0.04, springs: float = 2.0, drives: int = 2,
                 tolerance: float = 1e-12, held: bool = True, struts: Any = (), train: float = 70.0,
                 end: float = 2.5, closed: frozenset[str] = frozenset({"low", "high"}),
                 reach: float = 0.7, rows: int = 2, weight: float = 9.0) -> None:  # fmt: skip
        rng = np.random.default_rng(4)
        driven = np.array([0, 4][:drives], dtype=int)
        self.equations: Any = Equations(springs, train, drives, rows)
        self.seen = Shown(
            *(rng.normal(size=(3, 5)) * scale for scale in (1.0, fast, fast)),
            closures=fast * rng.normal(size=(3, rows)), drives=fast * rng.normal(size=(3, drives)),
            stops={stop.name: fast * rng.normal(size=3) for stop in STOPS if stop.name in closed},
        )  # fmt: skip
        # What moves away from its start the fastest, and accelerates most, does it backwards.
        self.seen.v[1, 3], self.seen.q[2, 3] = -8.0 * fast, -6.0
        for stop in STOPS[:2]:
            if stop.name in closed:
                self.seen.q[:, stop.index] = stop.at
        q, v, a = rng.normal(size=(3, 6, 5)) * np.array([1.0, fast, fast])[:, None, None]
        q[3, 2], v[2, 1], a[4, 0] = -7.0, -5.0 * fast, -11.0 * fast
        self.panel: Any = SimpleNamespace(
            t=1.0, h=h, q=q, v=v, a=a, order=6, times=1.0 + h * np.linspace(0.0, 1.0, 6)
        )
        self.segment: Any = SimpleNamespace(t_start=0.75, t_end=end, closed=closed, kinematic=True)
        self.body = Body(5, reach_m=reach)
        self.body.w *= springs
        self.held, self.driven, self.drives = held, driven, drives
        self.inertia = np.array([30.0, 0.5][:drives])
        self.weight = weight
        self.equations.tree = SimpleNamespace(
            masses=np.array([0.0, 3.0, 0.25]), gravity=5.0 * weight,
            inverse_dynamics=self.body.inverse_dynamics, kinetic_energy=self.body.kinetic_energy,
        )  # fmt: skip
        self.struts, self.tolerance, self.train = struts, tolerance, train

    @property
    def solution(self) -> Any:
        system = SimpleNamespace(
            held=self.held, body=self.body, driven=self.driven, inertia=self.inertia,
            driven_columns=self.driven, train_torques=self.torques,
            shaft=SimpleNamespace(driven=lambda t: 2.0 * t),
        )  # fmt: skip
        return SimpleNamespace(
            mechanism=mechanism(struts=self.struts), system=system,
            shaft=SimpleNamespace(period=0.2),
            case=SimpleNamespace(resolution=SimpleNamespace(tolerance=self.tolerance)),
        )  # fmt: skip

    def torques(self, motion: Any, q: Any, v: Any) -> Any:
        """Of trains that are wound up; at rest nothing damps."""
        numbers = np.array([-5.0, 2.0][: self.drives])
        wound = motion[:, None] * numbers + q[:, self.driven]
        return self.train * (wound + 1e9 * v[:, self.driven])

    def said(self, patch: pytest.MonkeyPatch) -> list[Said]:
        patch.setattr(invariants, "samples", lambda _: [(self.segment, self.panel, np.zeros(3))])
        patch.setattr(invariants, "shown", self.shown)
        patch.setattr(invariants, "Equations", lambda _: self.equations)
        patch.setattr(invariants, "slope", lambda values: 3.0 * values)
        said = watched(patch, invariants)
        assert list(invariants._motion(self.solution)) == []
        return said

    def shown(self, _solution: Any, closed: Any, t: Any) -> Shown:
        assert closed == self.segment.closed
        assert len(t) == 3
        return self.seen

    def wanted(self) -> list[Said]:
        seen, body, where = self.seen, self.body, "segment at 0.75 s"
        gaps = [self.equations.closures(q)[0] for q in seen.q]
        rows = [self.equations.closures(q)[1] for q in seen.q]
        most = 300.0 * EPS * body.reach_m
        found = [(f"{where}: closure gap [m]", largest(gaps), most)]
        rates = [[sum(row * v) for row in G] for G, v in zip(rows, seen.v, strict=True)]
        sizes = [[sum(abs(row * v)) for row in G] for G, v in zip(rows, seen.v, strict=True)]
        found.append((f"{where}: closure rate [m/s]", largest(rates), 1e-10 * largest(sizes)))
        for stop in STOPS:
            if stop.name not in self.segment.closed:
                deep = max(-stop.sense * (q[stop.index] - stop.at) for q in seen.q)
                ends = max(abs(q[stop.index] - stop.at) for q in self.panel.q)
                clock = 16.0 * EPS * self.segment.t_end * largest(seen.v[:, stop.index])
                text = f"{where}: stop {stop.name} penetrates [rad or m]"
                found.append((text, deep, 2.0 * self.tolerance * ends + clock + 1e-13))
        return [*found, *self.balance(where, rows), self.rising(where)]

    def balance(self, where: str, rows: Any) -> list[Said]:
        seen, body = self.seen, self.body
        wound = 0.0
        if not self.held:
            angles = largest(seen.q[:, self.driven])
            wound = 64.0 * EPS * max(self.equations.stiffness, default=0.0) * angles
        moving = [(v**2).sum() * (1.0 + q[0] ** 2) for q, v in zip(seen.q, seen.v, strict=True)]
        acting = 3.25 * 5.0 * self.weight
        acting += self.equations.tension(seen.q, seen.v) * len(self.struts)
        acting += body.reach_m * sum(item.stiffness for item in self.struts)
        acting += 2.0 * max(moving) / min(body.reach_m, 1.0)
        shares, size_of = [], []
        for k, (q, v, a) in enumerate(zip(*seen[:3], strict=True)):
            inverse = body.A.T @ a + body.B.T @ v**2 + body.w * np.cos(q)
            coasting = body.B.T @ v**2 + body.w * np.cos(q)
            spring = self.equations.of_elements(q, v)[0]
            pulls = [row * force for row, force in zip(rows[k], seen.closures[k], strict=True)]
            left = inverse - spring - sum(pulls)
            size = abs(inverse) + abs(spring) + abs(coasting) + sum(map(abs, pulls)) + wound
            size = size + 4.0 * EPS / 1e-8 * acting * max(body.reach_m, 1.0)
            for name, force in seen.stops.items():
                stop = next(item for item in STOPS if item.name == name)
                left[stop.index] -= stop.sense * force[k]
            for place, force in zip(self.driven, seen.drives[k], strict=True):
                left[place] -= force
            if not self.held:
                for place, inertia in zip(self.driven, self.inertia, strict=True):
                    left[place] += inertia * a[place]
            shares.append(max(abs(left)) / max(size))
            size_of.append(size)
        found = [(f"{where}: equations of motion [share]", max(shares), 1e-8)]
        if seen.stops:
            held = 64.0 * EPS * sum(s.stiffness for s in self.struts)
            held *= body.reach_m * max(body.reach_m, 1.0)
            pull = max(
                -(force[k] + held + wound) / max(size[place] for size in size_of)
                for name, force in seen.stops.items() for k in range(3)
                for place in [s.index for s in STOPS if s.name == name]
            )  # fmt: skip
            most = 10.0 * self.tolerance**0.5 + 1e-9
            found.append((f"{where}: a closed stop pulls [share]", pull, most))
        return found

    def rising(self, where: str) -> Said:
        panel, body = self.panel, self.body
        size = largest(panel.a) + largest(panel.v) / panel.h
        size += 1e5 * EPS * (1.0 + largest(panel.q)) / panel.h**2
        start = panel.q[0]
        pulls = abs(self.equations.k * start) + abs(body.w * np.cos(start))
        if not self.held:
            end = np.array([2.0 * panel.times[-1]])
            torques = self.torques(end, start[None], np.zeros((1, 5)))[0]
            for place, torque in zip(self.driven, torques, strict=True):
                pulls[place] += abs(torque)
        inertias = np.diag(body.M) * (1.0 + start[0] ** 2)
        size += 1e7 * EPS * max(pulls / inertias)
        off = largest(3.0 * panel.v / panel.h - panel.a)
        text = f"{where}: rate of the velocity is not the acceleration [share]"
        return text, off / size, 1e-5 + 10.0 * self.tolerance**0.5


def largest(values: Any) -> float:
    return max((abs(x) for x in np.ravel(values)), default=0.0)


@pytest.mark.parametrize("case", CASES)
def test_limits_of_motion(monkeypatch: pytest.MonkeyPatch, case: str) -> None:
    run = Run(**CASES[case])
    compared(run.said(monkeypatch), run.wanted())


def test_panels_without_a_slope(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of flights, and those that are no longer than 1e-9 of a turn."""
    for kinematic, h, looked in ((False, 0.04, False), (True, 1.5e-10, False), (True, 3e-10, True)):
        run = Run(h=h)
        run.segment.kinematic = kinematic
        texts = [what for what, _, _ in run.said(monkeypatch)]
        assert texts[-1].endswith("acceleration [share]") is looked
        assert len(texts) == 5 + looked


def test_stops_that_are_open_and_what_is_not_finite(monkeypatch: pytest.MonkeyPatch) -> None:
    run = Run()
    run.said(monkeypatch)
    run.seen.q[2, 1] += 1e-300 + 0.25
    assert list(invariants._motion(run.solution)) == ["segment at 0.75 s: closed stop low is open"]
    for values in (*run.seen[:5], *run.seen.stops.values()):
        kept = values.flat[0]
        values.flat[0] = np.inf
        assert list(invariants._motion(run.solution)) == ["segment at 0.75 s: not finite"]
        values.flat[0] = kept

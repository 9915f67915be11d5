"""Limits to which flights, rebounds and the built machine are held, worked out anew."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from made_up_runs import EPS, STOPS, Said, compared, mechanism, watched

from benchmarks.stress.checks import flights as flight_invariants
from benchmarks.stress.checks import model as model_invariants
from benchmarks.stress.checks import rebounds as rebound_invariants
from nipper_pin.hybrid.event import EventKind

CLOSED = frozenset({"low"})


class Equations:
    """Accelerations and their round-off: any functions of time and state."""

    def __init__(self, noise: float, stiff: float, size: float, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.size = size
        self.noise = noise * rng.uniform(0.5, 2.0, 5)
        self.A, self.B = stiff * rng.normal(size=(2, 5, 5))

    def accelerations(self, t: Any, q: Any, v: Any, closed: Any) -> Any:
        assert closed == CLOSED
        late = 9.0 * np.asarray(t)[..., None]
        return late + q @ self.A.T + v @ self.B.T + 0.1 * v[..., ::-1] ** 2 + 0.2 * q**2

    def round_off(self, t: Any, q: Any, v: Any, closed: Any) -> Any:
        assert closed == CLOSED
        return self.noise * (np.asarray(t)[..., None] + abs(q) + 2.0 * abs(v))

    def sizes(self, q: Any) -> Any:
        return self.size * (q + np.arange(5.0))

    def loose(self, closed: Any) -> list[int]:
        return [0, 2, 3] if closed == CLOSED else []


class Flight:
    """Two panels in flight, of which the first one is looked at."""

    def __init__(self, seed: int, noise: float, stiff: float, tolerance: float, h: float,
                 fast: float, size: float = 1.0) -> None:  # fmt: skip
        rng = np.random.default_rng(seed)
        self.equations = Equations(noise, stiff, size, seed)
        self.panel: Any = SimpleNamespace(
            t=2.0, h=h, order=7, v=fast * rng.normal(size=(7, 5)), a=rng.normal(size=(7, 5)),
            integrated=True, split=SimpleNamespace(independent=(1, 3)),
        )  # fmt: skip
        self.panel.a[4] = -8.0
        self.panel.v[:, 2] = -3.0 * fast
        panels = [self.panel, SimpleNamespace(h=4.0 * h), SimpleNamespace(h=2.0 * h)]
        self.segment = SimpleNamespace(t_start=2.0, closed=CLOSED, panels=panels)
        self.t = 2.0 + h * np.linspace(0.05, 0.8, 5)
        self.evaluated: list[float] = []
        case = SimpleNamespace(resolution=SimpleNamespace(tolerance=tolerance))
        self.solution: Any = SimpleNamespace(
            case=case, trajectory=SimpleNamespace(evaluate=self.evaluate),
            system=SimpleNamespace(body=SimpleNamespace(reach_m=0.7)),
        )  # fmt: skip

    @staticmethod
    def state(t: Any) -> tuple[Any, Any]:
        rates = np.arange(5.0)
        return np.cos(np.multiply.outer(t, 1.0 + rates)), np.sin(np.multiply.outer(t, rates - 2.5))

    def evaluate(self, t: Any) -> Any:
        self.evaluated = t.tolist()
        q, v = self.state(t)
        return SimpleNamespace(q=q, v=v)

    def shares(self) -> list[float]:
        """At each time by how much loose coordinates are off, in units of what they move."""
        panel, h, asked = self.panel, self.panel.h, self.equations
        found = []
        for t in self.evaluated:
            q, v = self.state(t)
            # The polynomial through the nodes, by Lagrange's formula.
            s, sigma = 0.5 * (1.0 - np.cos(np.pi * np.arange(7) / 6)), (t - 2.0) / h
            told = sum(
                panel.a[i] * np.prod([(sigma - s[j]) / (s[i] - s[j]) for j in range(7) if j != i])
                for i in range(7)
            )
            there = asked.accelerations(t, q, v, CLOSED)
            unsure = asked.round_off(t, q, v, CLOSED)
            off = abs(told - there)
            drifted = v + h * off * np.array([1.0, 0.0, 1.0, 0.0, 1.0])
            aside = q + 4.0 * EPS * asked.sizes(q)
            # The longest panel of the segment has four times the length of this one.
            rates = 2.0 * 4.0 * h * unsure
            fed = q + 0.5 * 4.0 * h * rates, v + rates
            noise = unsure.copy()
            for state in ((aside, v), fed):
                noise += abs(asked.accelerations(t, *state, CLOSED) - there)
            many = 2.0 + 2.0 / np.pi * np.log(7.0)
            off = off - many * noise - abs(asked.accelerations(t, q, drifted, CLOSED) - there)
            moved = abs(h * panel.v[0]) + h**2 * abs(panel.a).max(axis=0) + EPS * 0.7
            found.append(max((off * h**2 / moved)[[0, 2, 3]]))
        return found


FLIGHTS = {
    "exact": (0.0, 0.0, 1e-12, 0.1, 1.0), "noisy": (1e-2, 0.1, 1e-12, 0.1, 1.0),
    "stiff": (1e-6, 40.0, 1e-8, 0.1, 1.0), "drifting": (0.0, 2.0, 1e-12, 0.1, 1e-3),
    "round-off": (0.0, 1e9, 1e-12, 1e-9, 0.0), "short": (0.0, 1.0, 1e-3, 1e-9, 1e-9),
    "noise": (0.02, 0.3, 0.0, 0.1, 1e-2), "sums": (1e-6, 0.3, 1e-12, 0.1, 1.0, 1e14),
}  # fmt: skip


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("case", FLIGHTS)
def test_limits_of_flights(monkeypatch: pytest.MonkeyPatch, case: str, seed: int) -> None:
    run = Flight(seed, *FLIGHTS[case])
    monkeypatch.setattr(flight_invariants, "Equations", lambda _: run.equations)
    monkeypatch.setattr(flight_invariants, "samples", lambda _: [(run.segment, run.panel, run.t)])
    said = watched(monkeypatch, flight_invariants)
    assert list(flight_invariants.flights(run.solution)) == []
    halfway = 0.5 * (1.0 - np.cos(np.pi * (np.arange(6) + 0.5) / 6))
    inside = [2.0 + run.panel.h * s for s in halfway if 0.05 < s < 0.8]
    assert run.evaluated == pytest.approx([*run.t, *inside], rel=1e-14, abs=0.0)
    tolerance = run.solution.case.resolution.tolerance
    most = 40.0 * 14.0**2 * tolerance + 1e4 * EPS
    text = "flight at 2 s: equations between nodes [share]"
    (what, found, limit) = said.pop()
    assert (what, said) == (text, [])
    assert limit == pytest.approx(most, rel=1e-12, abs=0.0)
    # Of short panels times have few digits left, and so have places on them.
    assert found == pytest.approx(max(0.0, *run.shares()), rel=1e-9 if run.panel.h > 1e-3 else 1e-4)
    run.panel.integrated = False
    assert list(flight_invariants.flights(run.solution)) == said == []


def test_flights_in_which_nothing_is_loose(monkeypatch: pytest.MonkeyPatch) -> None:
    run = Flight(9, *FLIGHTS["exact"])
    monkeypatch.setattr(run.equations, "loose", lambda _: [])
    monkeypatch.setattr(flight_invariants, "Equations", lambda _: run.equations)
    monkeypatch.setattr(flight_invariants, "samples", lambda _: [(run.segment, run.panel, run.t)])
    said = watched(monkeypatch, flight_invariants)
    assert list(flight_invariants.flights(run.solution)) == []
    assert said[0][1] == 0.0


def event(number: int, t: float, *stops: str) -> Any:
    """A collision at which the lower stop leaves and the upper one is left behind."""
    rng = np.random.default_rng(number)
    v_after = rng.normal(size=5)
    v_after[1], v_after[2] = 3.0, -2.0
    return SimpleNamespace(
        number=number, t=t, P_N=dict.fromkeys(stops, -1.5 * number), q=rng.normal(size=5),
        v_before=rng.normal(size=5), v_after=v_after, energy_lost=-0.25 * number,
        kind=EventKind.COLLISION,
    )  # fmt: skip


def hit(of: Any, stop: str, amplitude: float | None, time: float | None, off: float = 0.0) -> Any:
    """A row of the table of collisions whose numbers are off by a little."""
    found = next(item for item in STOPS if item.name == stop)
    rate = found.sense * of.v_before[found.index]
    return SimpleNamespace(
        number=of.number, stop=stop, event=of, t=of.t + off, energy_lost=of.energy_lost + 4.0 * off,
        impulse=of.P_N[stop] / found.lever + 3.0 * off, approach_rate=rate + off,
        separation_rate=found.sense * of.v_after[found.index] + 2.0 * off,
        rebound_amplitude=amplitude, rebound_time=time,
    )  # fmt: skip


def table(of: Any, stop: str, row: Any, rows: list[Any]) -> list[Said]:
    found, where = next(item for item in STOPS if item.name == stop), f"collision {of.number}"
    told = {
        "approach rate": (row.approach_rate, found.sense * of.v_before[found.index]),
        "separation rate": (row.separation_rate, found.sense * of.v_after[found.index]),
        "impulse": (row.impulse * found.lever, of.P_N[stop]),
        "time": (row.t, of.t),
    }  # fmt: skip
    own = [item.energy_lost for item in rows if item.event is of]
    lost = abs(math.fsum(own) - of.energy_lost), 8.0 * EPS * len(own) * abs(of.energy_lost)
    return [
        *((f"{where}: {name} is not that of its event", abs(one - other), 8.0 * EPS * abs(other))
          for name, (one, other) in told.items()),
        (f"{where}: energy lost is not that of its event", *lost),
    ]  # fmt: skip


@pytest.mark.parametrize(("size", "tolerance"), [(1.0, 1e-3), (1e5, 1e-14), (1e-4, 1e-14)])
def test_limits_of_rebounds(monkeypatch: pytest.MonkeyPatch, size: float, tolerance: float) -> None:
    """Times and amplitudes up to the next event of the same stop, where there is one."""
    events = [event(1, 1.0, "low"), event(2, 1.5, "high"), event(3, 1.75, "low", "high"),
              event(4, 2.5, "high", "low"), event(5, 9.0, "low")]  # fmt: skip
    rows = [hit(events[0], "low", 0.5 * size, 0.7, 0.25), hit(events[1], "high", 0.4 * size, 0.3),
            hit(events[2], "low", 0.6 * size, 0.1, -0.125), hit(events[2], "high", None, 0.2),
            hit(events[3], "high", 0.6, 0.1), hit(events[4], "low", 1.0, None)]  # fmt: skip
    # One falls to where it was, and one after the end of the window.
    rows.append(hit(events[3], "low", 0.6, 0.1))
    asked = []

    def highest(_solution: Any, stop: Any, begin: float, end: float) -> float:
        asked.append((stop.name, begin, end))
        return 7.0 * size

    monkeypatch.setattr(rebound_invariants, "_highest", highest)
    said = watched(monkeypatch, rebound_invariants)
    case = SimpleNamespace(resolution=SimpleNamespace(tolerance=tolerance))
    run: Any = SimpleNamespace(events=events, trajectory=SimpleNamespace(span=(0.0, 8.0)),
                               collisions=rows, mechanism=mechanism(), case=case)  # fmt: skip
    assert list(rebound_invariants.rebounds(run)) == []
    flown = {0: (1.75, 0.3), 1: (1.75, 0.2), 2: (2.5, 0.3)}
    wanted: list[Said] = []
    for place, row in enumerate(rows):
        wanted += table(row.event, row.stop, row, rows)
        if place not in flown:
            continue
        end, stands = flown[place]
        where, clock = f"collision {row.number}", 16.0 * EPS * end
        wanted.append((f"{where}: rebound time is not that to the next event [s]",
                       abs(row.rebound_time - (end - row.t)), clock))  # fmt: skip
        amplitude = row.rebound_amplitude
        most = 1e-8 * amplitude + 16.0 * EPS * (stands + amplitude) + clock * row.separation_rate
        most += 4.0 * EPS + 10.0 * tolerance * amplitude
        wanted.append((f"{where}: rebound amplitude is not that of the motion [rad or m]",
                       abs(amplitude - 7.0 * size), most))  # fmt: skip
    compared(said, wanted)
    assert asked == [(row.stop, row.t, flown[k][0]) for k, row in enumerate(rows) if k in flown]
    # Nothing is followed where the same place or no later time is told.
    for change in ({"q": events[0].q}, {"t": rows[0].t}, {"t": 8.5}):
        said.clear()
        run.collisions = rows[:1]
        run.events = [events[0], SimpleNamespace(**{**vars(events[2]), **change, "number": 2})]
        assert list(rebound_invariants.rebounds(run)) == []
        compared(said, table(events[0], "low", rows[0], rows[:1]))
    events[0].v_after[1] = 0.0
    said.clear()
    run.events = events
    assert list(rebound_invariants.rebounds(run)) == []
    assert len(said) == 5


def test_rebounds_that_are_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    """Twelve of many, evenly chosen."""
    said = watched(monkeypatch, rebound_invariants)
    events = [event(number, float(number), "low") for number in range(1, 41)]
    rows = [hit(item, "low", None, 0.1) for item in events]
    run: Any = SimpleNamespace(events=events, trajectory=SimpleNamespace(span=(0.0, 99.0)),
                               collisions=rows, mechanism=mechanism())  # fmt: skip
    assert list(rebound_invariants.rebounds(run)) == []
    assert len(said) == 12 * 5
    assert (said[0][0].split(":")[0], said[-1][0].split(":")[0]) == ("collision 1", "collision 40")


def built(patch: pytest.MonkeyPatch, states: int, off: float, speed: float) -> tuple[Any, Any]:
    """A machine whose text has other masses, weight, speed and elements than itself."""
    rng = np.random.default_rng(3)
    one = rng.normal(size=(5, 5))
    M, h = one @ one.T, rng.normal(size=5)
    asked: list[Any] = []

    class Tree:
        gravity, masses = 9.0, np.array([1.0, 2.0, 0.0])
        moved = np.array([[1, 1, 1, 0, 0], [0, 1, 1, 0, 1], [1, 1, 1, 1, 0], [0, 0, 0, 0, 0]])

        @classmethod
        def of(cls, told: Any) -> Tree:
            assert told is machine
            return cls()

        def mass_matrix(self, q: Any) -> Any:
            asked.append(q)
            return M

        def inverse_dynamics(self, _: Any, v: Any, a: Any) -> Any:
            assert not np.any([v, a])
            return h

    def dynamics(q: Any, v: Any, a: Any) -> Any:
        assert not v.any()
        assert not a.any()
        return h + off * q

    machine = SimpleNamespace()
    body = SimpleNamespace(
        mass_matrix=lambda q: M - off * np.outer(q, q), inverse_dynamics=dynamics
    )
    q = rng.normal(size=(2 * states, 5))
    looked = [(None, SimpleNamespace(q=q[2 * k : 2 * k + 2]), None) for k in range(states)]
    patch.setattr(model_invariants, "PlanarTree", Tree)
    patch.setattr(model_invariants, "samples", lambda _: looked)
    told = {"spring s": (1.0, -2.0), "damper d": (3.0,)}
    found = {"spring s": (1.0 - 20.0 * EPS, -2.0 + 20.0 * EPS), "damper d": (3.0,)}
    patch.setattr(model_invariants, "_told", lambda item: told if item is machine else {})
    patch.setattr(model_invariants, "_found", lambda item: found if item is machine else {})
    said = watched(patch, model_invariants)
    run: Any = SimpleNamespace(
        mechanism=machine, system=SimpleNamespace(body=body), case=SimpleNamespace(speed_rpm=speed),
        shaft=SimpleNamespace(period=0.25),
    )  # fmt: skip
    assert list(model_invariants.built(run)) == []
    places = [np.flatnonzero((q == state).all(axis=1))[0] for state in asked]
    wanted: list[Said] = []
    for state in asked:
        share = abs(off) * max(
            abs(state[i] * state[j]) / np.sqrt(M[i, i] * M[j, j])
            for i in range(5) for j in range(5)
        )  # fmt: skip
        wanted.append(("mass matrix is not that of the text [share]", share, 1e-10))
        sizes = [9.0 * math.sqrt(m * M[k, k]) for k, m in enumerate([1.0, 3.0, 3.0, 0.0, 2.0])]
        size = [max(item, 1e-300) for item in sizes]
        share = max(abs(off * state[i]) / size[i] for i in range(5))
        wanted.append(("weight is not that of the text [share]", share, 1e-10))
    wanted.append(("period is not that of the speed [share]", abs(0.25 * speed / 60.0 - 1.0),
                   8.0 * EPS))  # fmt: skip
    limits = {"spring s": max((20.0 - 8.0) * EPS, (20.0 - 16.0) * EPS), "damper d": 0.0}
    for what, _, _ in said[len(wanted) :]:
        wanted.append((what, limits[what.removesuffix(" is not that of the text")], 0.0))
    assert len(wanted) == len(said)
    for (what, value, most), (other, right, limit) in zip(said, wanted, strict=True):
        assert (what, most) == (other, pytest.approx(limit, abs=0.0))
        assert value == pytest.approx(right, rel=1e-9, abs=0.0)
    return places, run


@pytest.mark.parametrize(
    ("states", "places"),
    [(1, [0, 1]), (3, [0, 1, 2, 3, 4, 5]), (5, [0, 2, 4, 6, 8]), (6, [0, 3, 6, 9])],
)
def test_limits_of_the_machine_that_was_built(
    monkeypatch: pytest.MonkeyPatch, states: int, places: list[int]
) -> None:
    """Masses and weight at some four of the states, speed and the numbers of all elements."""
    assert built(monkeypatch, states, 1e-3, 300.0)[0] == places


def test_elements_of_other_names(monkeypatch: pytest.MonkeyPatch) -> None:
    _, run = built(monkeypatch, 1, 0.5, 200.0)
    monkeypatch.setattr(model_invariants, "_told", lambda _: {"b": (1.0,), "a": (2.0,), "c": ()})
    monkeypatch.setattr(model_invariants, "_found", lambda _: {"d": (1.0,), "a": (2.0,), "c": ()})
    said = ["other elements than in the text: ['b', 'd']"]
    assert list(model_invariants.built(run)) == said

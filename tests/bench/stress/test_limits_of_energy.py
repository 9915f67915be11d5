"""Limits to which energy, jumps, times and outcomes are held, worked out anew."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from made_up_runs import EPS, STOPS, Body, compared, mechanism, watched

from benchmarks.stress.checks import invariants
from nipper_pin.hybrid.event import EventKind
from nipper_pin.hybrid.result.solution import Outcome

COLLISION, REST, RELEASE = EventKind.COLLISION, EventKind.REST, EventKind.RELEASE
# Which term of the limit is the largest.
ENERGIES: dict[str, dict[str, Any]] = {
    "round-off": {},
    "condition": {"condition": 1e7},
    "bad condition": {"condition": 1e13},
    "tolerance": {"tolerance": 1e-6},
    "struts": {"stiffness": (4e9, 3e9), "springs": 1e-6, "terms": 1e-9},
    "strong struts": {"stiffness": (4e15, 3e15), "springs": 0.0, "terms": 1e-12},
    "springs": {"springs": 1e3, "terms": 1e-3},
    "negative springs": {"springs": -1e12, "terms": 1e-3},
    "heights": {"weight": 1e3, "terms": 1e-3},
    "well conditioned": {"condition": 1e-3},
}


class Balance:
    """Energies of a run of three segments, of which the last two are copies of one turn."""

    def __init__(self, condition: float = 1.0, tolerance: float = 1e-14, springs: float = 1.0,
                 stiffness: tuple[float, ...] = (), terms: float = 1.0,
                 weight: float = 1.0) -> None:  # fmt: skip
        rng = np.random.default_rng(2)
        self.body = Body(6, reach_m=0.7)
        self.body.w *= weight
        self.tolerance, self.condition = tolerance, condition
        self.struts = [SimpleNamespace(stiffness=k) for k in stiffness]
        self.springs = springs
        panels = [
            SimpleNamespace(h=h, q=rng.normal(size=(n, 5)), a=object(), order=n)
            for h, n in ((0.3, 9), (0.1, 3), (0.2, 12), (0.5, 7), (0.4, 14))
        ]
        self.segments = [
            SimpleNamespace(closed=frozenset(closed), panels=panels[begin:end], source=source)
            for closed, begin, end, source in (
                ((), 0, 3, 0),
                (("low",), 3, 5, 1),
                (("low",), 3, 5, 1),
            )
        ]
        self.looked = [(self.segments[0], panels[0], None), (self.segments[1], panels[3], None)]
        self.asked: list[tuple[int, frozenset[str]]] = []
        self.states = [panels[k].q for k in (1, 4, 0, 3)]
        numbers = (terms * rng.normal(size=7)).tolist()
        names = ("drive_work", "drive_impulse_work", "gravity_work", "spring_change",
                 "kinetic_change", "impact_losses", "dissipated")  # fmt: skip
        self.energy = SimpleNamespace(**dict(zip(names, numbers, strict=True)),
                                      kinetic_peak=0.75 * terms, residual=-0.3)  # fmt: skip
        self.scale = sum(map(abs, numbers)) + 0.75 * terms

    def stored(self, q: Any) -> Any:
        return self.springs * ((q**2).sum(axis=1) - 0.5)

    def conditions(self, q: Any, closed: frozenset[str]) -> Any:
        for state in q:
            at = [(k, j) for k, rows in enumerate(self.states) for j in range(len(rows))
                  if np.array_equal(rows[j], state)]  # fmt: skip
            self.asked.append((*at[0], closed))
        return self.condition * (1.0 + np.abs(q).max(axis=1) + 7.0 * len(closed))

    @property
    def solution(self) -> Any:
        system = SimpleNamespace(body=self.body, spring_energy=self.stored,
                                 mechanism=mechanism(struts=self.struts))  # fmt: skip
        case = SimpleNamespace(resolution=SimpleNamespace(tolerance=self.tolerance))
        return SimpleNamespace(energy=self.energy, system=system, segments=self.segments, case=case)


@pytest.mark.parametrize("case", ENERGIES)
def test_limit_of_energy(monkeypatch: pytest.MonkeyPatch, case: str) -> None:
    """The shortest panel of each segment counts, copies once, and those that are looked at."""
    run = Balance(**ENERGIES[case])
    told = SimpleNamespace(condition=run.conditions)
    monkeypatch.setattr(invariants, "Equations", lambda _: told)
    monkeypatch.setattr(invariants, "samples", lambda _: run.looked)
    said = watched(monkeypatch, invariants)
    assert list(invariants._energy(run.solution)) == []
    counts = (range(3), range(0, 14, 3), range(0, 9, 2), range(7))
    low = frozenset({"low"})
    asked = [(k, j, low if k % 2 else frozenset()) for k in range(4) for j in counts[k]]
    assert run.asked == asked
    condition = max(run.conditions(run.states[k][j][None], closed)[0] for k, j, closed in asked)
    energies = np.concatenate([run.stored(q) for q in run.states])
    scale = max(run.scale, energies.max())
    heights = [float(q @ run.body.w) for rows in run.states for q in rows]
    scale += max(heights) - min(heights)
    panels = sum(4.0 * n for n in (9, 3, 12, 7, 14, 7, 14))
    lost = min(32.0 * EPS * max(condition, 1.0), 1e-5)
    most = (1e-8 + lost + (100.0 + panels) * run.tolerance) * scale
    stored = abs(energies).max()
    most += 64.0 * EPS * stored
    stiffness, blurred = sum(strut.stiffness for strut in run.struts), EPS * 0.7
    most += 1e4 * stiffness * blurred**2 + 4.0 * blurred * (2.0 * stiffness * stored) ** 0.5
    compared(said, [("energy that is left over [J]", 0.3, most)])


def test_energy_of_no_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    run = Balance()
    run.segments, run.looked = [], []
    monkeypatch.setattr(invariants, "Equations", lambda _: None)
    monkeypatch.setattr(invariants, "samples", lambda _: run.looked)
    said = watched(monkeypatch, invariants)
    assert list(invariants._energy(run.solution)) == []
    most = (1e-8 + 32.0 * EPS + 100.0 * run.tolerance) * run.scale
    compared(said, [("energy that is left over [J]", 0.3, most)])


class Jumps:
    """Segments of two and one panels, between which links jump."""

    def __init__(self, tolerance: float, size: float, opened: float, fast: float) -> None:
        rng = np.random.default_rng(7)
        self.q, self.v = rng.normal(size=(2, 2, 5))
        self.v[0, 2] = -9.0
        self.v *= fast
        self.tolerance, self.opened_by = tolerance, opened
        panels = [SimpleNamespace(q=-size * k * np.array([[1.0], [0.25]])) for k in (3, 1, 2)]
        names = ("a", "b")
        pieces = [[(panels[0], 0.0, 0.5), (panels[1], 0.5, 0.75)], [(panels[2], 0.8, 2.0)]]
        self.segments = [
            SimpleNamespace(closed=frozenset({name}), pieces=lambda parts=parts: iter(parts))
            for name, parts in zip(names, pieces, strict=True)
        ]
        self.times: list[Any] = []
        self.trajectory = SimpleNamespace(evaluate=self.evaluate)
        self.case = SimpleNamespace(resolution=SimpleNamespace(tolerance=tolerance))

    def evaluate(self, t: Any) -> Any:
        self.times.append(t.tolist())
        return SimpleNamespace(q=self.q, v=self.v)

    def opened(self, q: Any, closed: frozenset[str]) -> Any:
        return self.opened_by * np.abs(q) * (2.0 if closed == {"a"} else 5.0)


@pytest.mark.parametrize(
    "case", [(1e-6, 1.0, 0.0, 1.0), (1e-12, 1.0, 1e-3, 1.0), (1e-14, 1e-3, 1e-15, 1e12),
             (1e-14, 1e-3, 0.0, 0.0)],
    ids=["tolerance", "open", "fast", "round-off"],
)  # fmt: skip
def test_limits_of_jumps(monkeypatch: pytest.MonkeyPatch, case: tuple[float, ...]) -> None:
    run: Any = Jumps(*case)
    monkeypatch.setattr(invariants, "Equations", lambda _: SimpleNamespace(opened=run.opened))
    said = watched(monkeypatch, invariants)
    assert list(invariants._continuity(run)) == []
    before, then = np.nextafter(0.5, 0.0), np.nextafter(0.75, 0.0)
    assert run.times == [[before, 0.5], [then, 0.8]]
    jump = max(abs(run.q[1] - run.q[0]))
    sizes = case[1] * np.array([4.0, 3.0])
    fastest = np.abs(run.v).max()
    largest = [np.abs(q).max() * run.opened_by for q in run.q]
    wanted = []
    for end, size, factor in ((0.5, sizes[0], 2.0), (0.75, sizes[1], 5.0)):
        most = 10.0 * run.tolerance * size + 2.0 * largest[0] + factor * largest[1] + 1e-11
        most += (end - np.nextafter(end, 0.0)) * fastest
        wanted.append((f"jump at {end:.9g} s [rad or m]", jump, most))
    compared(said, wanted)


def test_borders_that_are_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of the first hundred segments, evenly chosen; of one panel there is none."""
    run: Any = Jumps(1e-12, 1.0, 1e-3, 1.0)
    monkeypatch.setattr(invariants, "Equations", lambda _: SimpleNamespace(opened=run.opened))
    asked: list[tuple[int, int]] = []
    monkeypatch.setattr(invariants, "some", lambda *numbers: asked.append(numbers) or [])
    for segments in (run.segments, run.segments[1:], [], 150 * run.segments[1:]):
        run.segments = segments
        assert list(invariants._continuity(run)) == []
    assert asked == [(2, 100), (0, 100), (0, 100), (99, 100)]


def segment(begin: float, end: float, *closed: str) -> Any:
    return SimpleNamespace(t_start=begin, t_end=end, closed=frozenset(closed))


def happened(number: int, t: float, kind: EventKind, **changes: Any) -> Any:
    given = {"stops": ("low",), "P_N": {}, "closed_before": frozenset(), "v_after": np.ones(5),
             "closed_after": frozenset(), "q": np.zeros(5), "v_before": np.ones(5)}  # fmt: skip
    return SimpleNamespace(number=number, t=t, kind=kind, **given | changes)


def test_order_of_times(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sixteen times the round-off of the end; a rest at the limit of a series may lie behind it."""
    said = watched(monkeypatch, invariants)
    run: Any = SimpleNamespace(
        segments=[segment(0.0, 2.0), segment(1.75, 3.0), segment(3.5, 8.0)],
        events=[happened(1, 1.0, COLLISION), happened(3, 9.0, REST), happened(3, 0.5, RELEASE)],
    )
    assert list(invariants._times(run)) == ["event 2 has number 3"]
    clock = 16.0 * EPS * 8.0
    begins, event = "segment at {:.9g} s runs backwards [s]", "event {} beyond the end [s]"
    compared(said, [
        ("gap between segments [s]", 0.25, clock), ("gap between segments [s]", 0.5, clock),
        (begins.format(0.0), -2.0, 0.0), (begins.format(1.75), -1.25, 0.0),
        (begins.format(3.5), -4.5, 0.0), (event.format(1), -7.0, clock),
        (event.format(3), -7.5, clock), ("event 3 before its predecessor [s]", -8.0, clock),
        ("event 3 before its predecessor [s]", 8.5, clock),
    ])  # fmt: skip
    said.clear()
    assert list(invariants._times(SimpleNamespace(segments=[], events=run.events[:1]))) == []  # type: ignore[arg-type]
    compared(said, [(event.format(1), 1.0, 0.0)])


def outcome(patch: pytest.MonkeyPatch, kind: Outcome, events: Any = (), **changes: Any) -> Any:
    """What is objected to, and what is compared with a limit."""
    said = watched(patch, invariants)
    case = SimpleNamespace(rest_rate=None, cycles=3, max_collisions=7)
    given = {"case": case, "events": events, "segments": [segment(0.0, 2.0), segment(2.0, 6.5)],
             "outcome": kind, "shaft": SimpleNamespace(period=2.0),
             "mechanism": mechanism(transition_stop="low")}  # fmt: skip
    run: Any = SimpleNamespace(**given | changes)
    return list(invariants._outcome(run)), said


def test_outcomes(monkeypatch: pytest.MonkeyPatch) -> None:
    low, high = happened(1, 1.0, REST), happened(2, 1.0, REST, stops=("high",))
    hit = happened(3, 2.0, COLLISION)
    wrong = ["at rest, but the last event is no rest of the transition stop"]
    at_rest = Outcome.AT_REST
    assert outcome(monkeypatch, at_rest, [hit, low]) == ([], [])
    for events in ([], [low, hit], [low, high]):
        assert outcome(monkeypatch, at_rest, events) == (wrong, [])
    text = "collisions wanted"
    many = outcome(monkeypatch, Outcome.TOO_MANY_COLLISIONS, [hit, low, hit])
    assert many == ([], [(text, 7.0, 2.0)])
    assert outcome(monkeypatch, Outcome.NO_REST, [hit]) == ([], [])
    text = "end away from that of the window [s]"
    objections, said = outcome(monkeypatch, Outcome.COMPLETED, [hit])
    assert objections == []
    compared(said, [(text, 0.5, 16.0 * EPS * 6.0)])
    compared(outcome(monkeypatch, Outcome.COMPLETED, segments=[])[1], [(text, 6.0, 96.0 * EPS)])


def test_what_never_comes_to_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    """A stop that loses nothing, unless it is met without a rate or a rate of rest is given."""
    stop = {s.name: s for s in STOPS} | {"hard": type(STOPS[0])(
        name="hard", index=1, sense=1.0, at=0.0, restitution=1.0
    )}  # fmt: skip
    machine = mechanism(transition_stop="low", stop=stop.__getitem__)
    hard = happened(4, 1.0, REST, stops=("low", "hard"))
    still = happened(5, 1.0, REST, stops=("hard",), v_before=np.zeros(5))
    hit = happened(6, 1.0, COLLISION, stops=("hard",))
    soft = happened(7, 1.0, REST)
    events = [hard, still, hit, soft]
    found = outcome(monkeypatch, Outcome.NO_REST, events, mechanism=machine)[0]
    assert found == ["event 4: ['hard'] came to rest with restitution 1"]
    case = SimpleNamespace(rest_rate=0.0)
    assert outcome(monkeypatch, Outcome.NO_REST, events, mechanism=machine, case=case)[0] == []


def phases(events: Any, segments: Any = (), kind: Outcome = Outcome.COMPLETED) -> list[str]:
    """Objections to events that follow a first phase with one closed stop, ``far``."""
    told = {2: SimpleNamespace(closed=frozenset({"far"}))}
    run: Any = SimpleNamespace(
        mechanism=mechanism(phase=told.__getitem__, initial_phase=2), events=events,
        segments=segments, outcome=kind,
    )  # fmt: skip
    return list(invariants._phases(run))


def sets(**names: str) -> dict[str, Any]:
    return {key: frozenset(value.split()) for key, value in names.items()}


def at(low: float = 1.0, high: float = 1.0, far: float = 1.0, size: float = 1.0) -> Any:
    """Gaps or rates: of the stops, the rest is of any size."""
    return np.array([size, low, -high, far, size])


PLACES = np.array([0.0, 0.3, -0.2, -4.0, 0.0])


def test_phases_follow_one_another() -> None:
    """A release opens what was closed, a rest and a collision close what they concern."""
    away = {"q": PLACES + at()}
    stands, still = {"q": PLACES + at(far=0.0)}, {"v_after": at(far=0.0)}
    far = sets(closed_before="far", closed_after="far")
    opens = sets(closed_before="far")
    release = happened(1, 1.0, RELEASE, stops=("far",), **opens, **stands)
    assert phases([release]) == []
    assert phases([happened(1, 1.0, RELEASE, stops=("low",), **opens, **stands)]) == [
        "event 1 (release): ['far'] to []"
    ]
    other, on_it = sets(closed_before="far", closed_after="low"), at(low=0.0)
    wider = happened(1, 1.0, RELEASE, stops=("far",), q=PLACES + on_it, v_after=on_it, **other)
    assert phases([wider]) == ["event 1 (release): ['far'] to ['low']"]
    kept = happened(1, 1.0, REST, stops=("low",), **far, **stands, **still)
    assert phases([kept]) == ["event 1 (rest): ('low',) not among ['far']"]
    assert phases([happened(1, 1.0, REST, stops=("far",), **far, **stands, **still)]) == []
    both = SimpleNamespace(**{**vars(kept), "stops": ("far", "low")})
    assert phases([both]) == ["event 1 (rest): ('far', 'low') not among ['far']"]
    strange = happened(1, 1.0, COLLISION, q=PLACES + on_it, v_after=on_it, **other)
    assert phases([strange]) == ["event 1 (collision): ['low'] closed without a contact"]
    strange.P_N = {"low": 1.0}
    assert phases([strange]) == []
    assert phases([happened(1, 1.0, COLLISION, **away)]) == [
        "event 1 (collision): closed [], before ['far']"
    ]


def test_gaps_and_rates_after_events() -> None:
    """Closed stops stand still in their places, and open ones are not entered."""
    far = sets(closed_before="far", closed_after="far")

    def objections(q: Any, v_after: Any, after: Any = (), kind: Any = Outcome.COMPLETED) -> Any:
        hit = happened(1, 1.0, COLLISION, q=PLACES + q, v_after=v_after, **far)
        return phases([hit, *after], kind=kind)

    closed = "event 1 (collision): closed stop far at {} with rate {}"
    assert objections(at(far=0.0), at(far=0.0)) == []
    assert objections(at(far=0.5), at(far=0.0)) == [closed.format("0.5", "0")]
    assert objections(at(far=0.0), at(far=0.25)) == [closed.format("0", "0.25")]
    enters = at(far=0.0, high=-2.0)
    beside, on = at(far=0.0, high=1.0), at(far=0.0, high=0.0)
    assert objections(beside, enters) == []
    assert objections(on, at(far=0.0, high=0.0)) == []
    told = ["event 1 (collision): open stop high enters its contact with -2"]
    assert objections(on, enters) == told
    # It is struck in the same instant, or would have been.
    assert objections(on, enters, kind=Outcome.TOO_MANY_COLLISIONS) == []
    rest = {"q": PLACES + at(far=0.0), "v_after": at(far=0.0), **far}
    for t, found in ((1.0, []), (1.5, told)):
        after = [happened(2, t, COLLISION, **rest)]
        for kind in (Outcome.COMPLETED, Outcome.TOO_MANY_COLLISIONS):
            assert objections(on, enters, after, kind) == found


def test_segments_follow_the_phases() -> None:
    """Each has the closed stops of one of them, in their order."""
    stands = {"q": PLACES + at(far=0.0), "v_after": at(far=0.0)}
    events = [
        happened(1, 1.0, RELEASE, stops=("far",), q=stands["q"], **sets(closed_before="far")),
        happened(2, 2.0, COLLISION, P_N={"far": 1.0}, **sets(closed_after="far"), **stands),
    ]
    far, free = (segment(0.0, 1.0, "far"), segment(1.0, 2.0))
    for right in ([far, free, far], [far, far], [free], [free, far], [far, free, free]):
        assert phases(events, right) == []
    wrong = segment(0.25, 2.0, "low")
    assert phases(events, [far, wrong, wrong]) == ["segment at 0.25 s: ['low'] out of turn"]
    assert phases(events, [far, free, far, free]) == ["segment at 1 s: [] out of turn"]


def test_what_is_determined_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    """A freedom below zero is told, and nothing else is looked at then."""
    freedom = {0: 1, 1: 0, 2: -2}
    told = SimpleNamespace(freedom=lambda closed: freedom[len(closed)])
    monkeypatch.setattr(invariants, "Equations", lambda _: told)
    monkeypatch.setattr(invariants, "CHECKS", {"a": lambda _: ["b", "c"], "d": lambda _: ["e"]})
    run: Any = SimpleNamespace(segments=[segment(0.0, 1.0), segment(1.0, 2.0, "low")])
    found = [(item.kind, item.detail) for item in invariants.violations(run)]
    assert found == [("a", "b"), ("a", "c"), ("d", "e")]
    run.segments.append(segment(2.5, 3.0, "low", "high"))
    found = [(item.kind, item.detail) for item in invariants.violations(run)]
    assert found == [("motion", "segment at 2.5 s: high, low closed, a freedom of -2")]


def test_names_of_checks() -> None:
    """They stand in verdicts and case files."""
    assert list(invariants.CHECKS) == [
        "model", "time order", "outcome", "phase logic", "impulse", "motion", "flights",
        "springs and dampers", "continuity", "energy", "tables",
    ]  # fmt: skip


def test_tables(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rebounds, phases and stated errors; of the first hundred collisions."""
    said = watched(monkeypatch, invariants)
    monkeypatch.setattr(invariants, "rebounds", lambda _: ["a rebound"])

    def hit(number: int, amplitude: float | None, time: float | None) -> Any:
        return SimpleNamespace(number=number, rebound_amplitude=amplitude, rebound_time=time)

    nan, inf = float("nan"), float("inf")
    right = SimpleNamespace(time=0.0, impulse=0.0)
    run: Any = SimpleNamespace(
        collisions=[hit(1, 0.0, 0.0), hit(2, None, None), hit(3, -1.0, inf), hit(4, nan, 2.0)],
        phases=[SimpleNamespace(t_start=1.0, t_end=3.5)], errors=[right],
    )  # fmt: skip
    assert list(invariants._tables(run)) == [
        "a rebound", "collision 3: rebound amplitude -1.0", "collision 3: rebound time inf",
        "collision 4: rebound amplitude nan",
    ]  # fmt: skip
    compared(said, [("phase runs backwards [s]", -2.5, 0.0)])
    run.collisions = [*(100 * [hit(1, 0.0, 0.0)]), hit(101, -1.0, -1.0)]
    assert list(invariants._tables(run)) == ["a rebound"]
    run.collisions = []
    for time, impulse in ((-1.0, 0.0), (inf, 0.0), (0.0, -1.0), (0.0, inf), (nan, 0.0), (0.0, nan)):
        run.errors = [right, *(2 * [SimpleNamespace(time=time, impulse=impulse)])]
        _, *told = invariants._tables(run)
        assert [text.split(":")[0] for text in told] == ["event 2"]

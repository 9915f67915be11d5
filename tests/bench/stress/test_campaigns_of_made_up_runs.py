"""How campaigns are run, and how two solutions are compared: made up."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks.stress import campaign
from benchmarks.stress.checks import agreement, engines
from benchmarks.stress.judging import TIME_LIMIT_S, Verdict
from benchmarks.stress.space import FAMILIES, trial
from nipper_pin import reduced
from nipper_pin.errors import InputError, SimulationError, UnknownNameError
from nipper_pin.hybrid.event import EventKind
from nipper_pin.study import processes
from nipper_pin.study.processes import WorkerError

EPS = 2.0**-52


def verdict(number: int, word: str = "right") -> Verdict:
    return Verdict(number, "spring", word, "AT_REST", "", f"f{number}", 0.5)


class Clock:
    """Each look at it is three seconds later."""

    def __init__(self) -> None:
        self.now = 100.0

    def perf_counter(self) -> float:
        self.now += 3.0
        return self.now


@pytest.fixture
def judged(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Any, int]]:
    """Jobs that come to the workers, and how many these are; the last one is done first."""
    asked: list[tuple[Any, int]] = []

    def judge_all(jobs: list[Any], workers: int) -> Any:
        asked.append((jobs, workers))
        return (verdict(job[1]) for job in reversed(jobs))

    monkeypatch.setattr(campaign, "_judged", judge_all)
    monkeypatch.setattr(campaign, "time", Clock())
    return asked


def test_a_part_of_a_campaign(judged: list[tuple[Any, int]]) -> None:
    """Trials from a number on, told as they come, and in order in the end."""
    seen: list[int] = []
    found = campaign.run_campaign(
        3, 5, 2, lambda item: seen.append(item.number), 9.0, ["spring"], first=4
    )
    assert judged == [([(5, n, 9.0, ("spring",)) for n in (4, 5, 6)], 2)]
    assert (found.seed, seen) == (5, [6, 5, 4])
    assert [item.number for item in found.verdicts] == [4, 5, 6]
    # One look at the clock at the start, and one at the end.
    assert found.wall_s == 3.0


@pytest.mark.usefixtures("judged")
def test_a_dead_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    """The error says how many are judged."""

    def one(jobs: list[Any], _: int) -> Any:
        yield verdict(jobs[0][1])
        message = "a worker process died"
        raise WorkerError(message)

    monkeypatch.setattr(campaign, "_judged", one)
    with pytest.raises(SimulationError, match="died; 1 of 3 trials are judged") as caught:
        campaign.run_campaign(3, 5, 2)
    assert caught.value.evidence == {"workers": 2, "judged": 1}


def test_usual_arguments(monkeypatch: pytest.MonkeyPatch, judged: list[tuple[Any, int]]) -> None:
    """Seed 1, all processors, the usual limit, all families."""
    monkeypatch.setattr(campaign.os, "cpu_count", lambda: 6)
    found = campaign.run_campaign(2)
    assert judged == [([(1, n, TIME_LIMIT_S, ()) for n in range(2)], 6)]
    assert (found.seed, len(found.verdicts), found.wall_s) == (1, 2, 3.0)
    monkeypatch.setattr(campaign.os, "cpu_count", lambda: None)
    campaign.run_campaign(0)
    assert judged[1] == ([], 1)


def test_work_of_the_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each job is handed on; what is not done when nobody listens any more is taken back."""
    asked: list[Any] = []
    handed: list[Any] = []
    cancelled: list[int] = []
    ends: list[Any] = []

    class Pool:
        def submit(self, task: Callable[[], Any]) -> Any:
            future: Any = Future()
            handed.append(future)
            future.cancel = lambda: cancelled.append(handed.index(future))
            future.set_result(task())
            return future

        def shutdown(self, **words: bool) -> None:
            ends.append(words)

    @contextmanager
    def fresh(workers: int, first: Any) -> Any:
        asked.append((workers, first()))
        yield Pool()

    monkeypatch.setattr(processes, "fresh_processes", fresh)
    monkeypatch.setattr(campaign, "trial", lambda *given: given)
    monkeypatch.setattr(campaign, "judge", lambda item, limit: (item, limit))
    jobs: Any = [(5, n, 9.0, ("spring",)) for n in range(3)]
    assert list(campaign._judged([], 3)) == []
    assert asked == []
    found: list[Any] = list(campaign._judged(jobs, 3))
    assert sorted(found) == [((5, n, ("spring",)), 9.0) for n in range(3)]
    assert asked == [(3, None)]
    assert (cancelled, ends) == ([], [])
    listening = campaign._judged(jobs, 3)
    next(listening)
    listening.close()  # type: ignore[attr-defined]
    assert ends == [{"cancel_futures": True}]
    assert len(cancelled) == 2
    assert set(cancelled) < {3, 4, 5}


def test_trials_of_families() -> None:
    """Those that are asked for in turn; a family may name a resolution of its own."""
    names = ["spring", "tolerance"]
    made = [trial(3, number, names) for number in range(4)]
    assert [item.family for item in made] == [*names, *names]
    assert [(item.number, item.seed) for item in made] == [(n, 3) for n in range(4)]
    assert made[0].case["resolution"] == {"tolerance": 1e-12}
    source, case = FAMILIES["tolerance"](np.random.default_rng([3, 1]))
    assert made[1].case == case
    assert made[1].source == source
    assert trial(3, len(FAMILIES) + 1).family == list(FAMILIES)[1]
    with pytest.raises(UnknownNameError, match="nothing"):
        trial(3, 0, ["spring", "nothing"])


# By the two engines, in units of what both state.
@pytest.mark.parametrize("off", [0.9, -0.9, 1.1, -1.1])
def test_engines_agree_within_what_they_state(monkeypatch: pytest.MonkeyPatch, off: float) -> None:
    stop = SimpleNamespace(restitution=0.4)
    springs = [SimpleNamespace(stiffness=k, preload=x) for k, x in ((5.0, 0.3), (7.0, 2.0))]
    machine = SimpleNamespace(
        transition_stop="jaw", springs=springs, stop=lambda name: {"jaw": stop}[name]
    )
    case = SimpleNamespace(drive="held", speed_rpm=300.0, rest_rate=1e-3, max_collisions=17)
    limit = 2.0 * (1e-9 + 3e-9) + 16.0 * EPS * (0.02 + 1e-6 * 1e9)
    direct: Any = SimpleNamespace(
        mechanism=machine, case=case, shaft=SimpleNamespace(period=1e9),
        transitions=[SimpleNamespace(duration=9.0), SimpleNamespace(duration=0.02)],
        events=[SimpleNamespace(number=n) for n in (1, 2, 3)],
        errors=[SimpleNamespace(time=x) for x in (7.0, 8.0, 1e-9)],
    )  # fmt: skip
    model, asked = object(), []
    status = {"is": reduced.Status.AT_REST, "unfit": None, "build": None}

    def run(of: Any, **given: Any) -> Any:
        asked.append((of, {key: np.asarray(value).tolist() for key, value in given.items()}))
        return SimpleNamespace(status=[int(status["is"])], duration=[0.02 + off * limit],
                               duration_error=[3e-9])  # fmt: skip

    def built(of: Any) -> Any:
        assert of is machine
        if status["build"]:
            raise InputError(status["build"])
        return model

    def unfit(of: Any, drive: Any) -> Any:
        assert (of, drive) == (machine, "held")
        return status["unfit"]

    for name, function in (("transitions", run), ("build", built), ("unfit", unfit)):
        monkeypatch.setattr(reduced, name, function)
    found = engines.engines_agree(direct, 1e-14)
    assert found is not None
    if abs(off) < 1.0:
        assert found == []
    else:
        (one,) = found
        text = f"durations differ by {abs(off) * limit:.3g} s, stated 8e-09 s"
        assert (one.kind, one.detail) == ("engines", text)
    given = {"speed_rpm": [300.0], "restitution": [0.4], "stiffness": [[5.0, 7.0]],
             "preload": [[0.3, 2.0]], "rest_rate": 1e-3, "tolerance": 1e-12,
             "max_collisions": 17}  # fmt: skip
    assert asked == [(model, given)]
    engines.engines_agree(direct, 1e-7)
    assert asked[1] == (model, {**given, "tolerance": 1e-7})
    for key, value in (
        ("is", reduced.Status.NOT_PRESSED),
        ("unfit", "a drive"),
        ("build", "refused"),
    ):
        kept, status[key] = status[key], value  # type: ignore[assignment]
        assert engines.engines_agree(direct, 1e-12) is None
        status[key] = kept
    direct.transitions = []
    assert engines.engines_agree(direct, 1e-12) is None


HIT, REST, RELEASE = EventKind.COLLISION, EventKind.REST, EventKind.RELEASE


def event(number: int, t: float, kind: EventKind = HIT, stops: str = "a", closed: str = "",
          **P_N: float) -> Any:  # fmt: skip
    return SimpleNamespace(
        number=number, t=t, kind=kind, stops=tuple(stops.split()), P_N=P_N or {stops: 1.0},
        closed_after=frozenset(closed.split()),
    )  # fmt: skip


def run_of(*events: Any, time: float = 1e-9, impulse: float = 1e-6, share: float = 0.0) -> Any:
    """A solution that states the same errors of all events; impulses of all stops."""
    errors = [
        SimpleNamespace(time=time, impulse=share, impulses=dict.fromkeys(item.P_N, impulse))
        for item in events
    ]
    return SimpleNamespace(events=events, errors=errors)


def told(one: Any, other: Any, mirrored: bool = False) -> list[str]:
    compare = agreement.mirror_images if mirrored else agreement.within_errors
    found = compare(one, other)
    assert {item.kind for item in found} <= {"mirror" if mirrored else "tolerance"}
    return [item.detail for item in found]


@pytest.mark.parametrize(("mirrored", "share"), [(False, 2.0), (True, 0.25)])
def test_times_and_impulses_of_two_runs(mirrored: bool, share: float) -> None:
    """Each may differ by a share of what both state, and by some round-off."""
    t, time, impulse = 2.0, 1e-9, 1e-6
    limit = share * (time + 3.0 * time) + 16.0 * EPS * t
    later = run_of(event(1, t + 0.9 * limit), time=3.0 * time)
    assert told(run_of(event(1, t)), later, mirrored) == []
    later = run_of(event(1, t + 1.1 * limit), time=3.0 * time)
    text = f"event 1: times differ by {1.1 * limit:.3g} s, stated {limit:.3g} s"
    assert told(run_of(event(1, t)), later, mirrored) == [text]
    assert told(later, run_of(event(1, t)), mirrored) == [text]
    limit = share * 4.0 * impulse + 64.0 * EPS
    for size, count in ((0.9, 0), (1.1, 1)):
        more = run_of(event(1, t, a=1.0 + size * limit), impulse=3.0 * impulse)
        for pair in ((run_of(event(1, t)), more), (more, run_of(event(1, t)))):
            assert len(told(*pair, mirrored)) == count
    # Of large impulses round-off is all that is allowed.
    for size, count in ((0.9, 0), (1.1, 1)):
        for sign in (1.0, -1.0):
            large = [run_of(event(1, t, a=sign * x), impulse=0.0)
                     for x in (1e9, 1e9 * (1.0 + size * 64.0 * EPS))]  # fmt: skip
            assert len(told(*large, mirrored)) == len(told(*large[::-1], mirrored)) == count


def test_what_is_said_of_impulses() -> None:
    """Each stop by itself; one that the other run does not have is none there."""
    first, second = run_of(event(1, 2.0, a=1.0, b=0.5)), run_of(event(1, 2.0, a=1.0))
    assert told(first, second) == ["event 1: impulses of b 0.5 and 0 differ by 0.5, stated 2e-06"]
    # Left over from a larger one in the same instant: 1e-9 of it.
    for t, P, count in ((2.0, 1e-9, 0), (2.0, 1.1e-9, 1), (2.0 + 1e-13, 1e-9, 1),
                        (2.0 + 15.0 * EPS * 2.0, 1e-9, 0)):  # fmt: skip
        runs = [run_of(event(1, 2.0, a=1.0), event(2, t, stops="b", b=sign * P), impulse=0.0)
                for sign in (1.0, -1.0)]  # fmt: skip
        assert len(told(*runs)) == count
    # At the very start, and of other kinds, impulses are not compared.
    runs = [run_of(event(1, 1e-15, a=x), event(2, 2.0)) for x in (1.0, 2.0)]
    assert told(*runs) == []
    runs = [run_of(event(1, 2.0, REST, a=x)) for x in (1.0, 2.0)]
    assert told(*runs) == []


def test_rates_that_are_all_error() -> None:
    """Nothing is compared from there on."""
    for share, count in ((0.99, 1), (1.0, 0)):
        for shares in ((share, 0.0), (0.0, share)):
            one, other = (run_of(event(1, t), share=x)
                          for t, x in zip((2.0, 3.0), shares, strict=True))  # fmt: skip
            assert len(told(one, other)) == count


def test_events_that_only_one_run_has() -> None:
    """Those of a series that the other one ends earlier; a last rest of fewer stops."""
    rest = event(1, 2.0, REST, "a b", closed="a b")
    series = [event(1, 1.5, stops="a"), event(2, 1.9, stops="b")]
    last = event(3, 2.0, REST, "a b", closed="a b")
    strange, release = event(1, 1.5, stops="c"), event(1, 2.5, RELEASE, "a")
    hit = event(4, 5.0)
    ended, whole = run_of(rest, hit), run_of(*series, last, hit)
    assert told(ended, whole) == told(whole, ended) == []
    assert told(run_of(rest, event(2, 6.0)), whole) != []
    parted = "event 1: rest of ('a', 'b') at 2 s, and collision of ('c',) at 1.5 s"
    assert told(ended, run_of(strange)) == [parted]
    # A rest of another set of stops in the other run, where this one goes on.
    fewer = event(1, 2.0, REST, "a b", closed="a")
    other = event(2, 2.1, REST, "a", closed="a")
    assert told(run_of(fewer, hit), run_of(other, last, hit)) == []
    for pair in (
        (run_of(rest, release), run_of(release)),
        (run_of(release), run_of(rest, release)),
    ):
        assert told(*pair) == []


def test_events_in_another_order() -> None:
    """As near to one another as ten times what both state; then nothing more is compared."""
    limit = 10.0 * (2.0 * 2e-9 + 16.0 * EPS * 2.0)
    for size, count in ((0.9, 0), (1.1, 1)):
        one = run_of(event(1, 2.0 - size * limit, stops="a"), event(2, 3.0))
        other = run_of(event(1, 2.0, stops="b"), event(2, 4.0))
        assert len(told(one, other)) == len(told(other, one)) == count
    assert told(run_of(event(1, 2.0, stops="a")), run_of()) == []


def test_bits_of_runs() -> None:
    """Every number counts, by all of its digits."""

    def run(end: float = 2.0, outcome: str = "AT_REST", **changes: Any) -> Any:
        given = {"kind": HIT, "stops": ("a",), "closed_after": frozenset({"c", "b"}), "t": 1.0,
                 "energy_lost": 2.0, "series_error": 3.0, "P_N": {"a": 4.0}, "q": np.ones(2),
                 "v_before": np.zeros(2), "v_after": np.ones(1), "P_g": np.ones(3)}  # fmt: skip
        one = SimpleNamespace(**given | changes)
        return SimpleNamespace(outcome=SimpleNamespace(name=outcome), events=[one],
                               segments=[SimpleNamespace(t_end=end)])  # fmt: skip

    parts = (b"AT_REST", b"0x1.0000000000000p+1", b"collision ('a',) ['b', 'c']",
             np.array([1.0, 2.0, 3.0, 4.0]).tobytes(), np.ones(2).tobytes(),
             np.zeros(2).tobytes(), np.ones(1).tobytes(), np.ones(3).tobytes())  # fmt: skip
    assert agreement.bits(run()) == b"\n".join(parts)
    assert agreement.same_bits(run(), run()) == []
    (one,) = agreement.same_bits(run(), run(energy_lost=2.0 + 4.0 * EPS))
    assert (one.kind, one.detail) == ("determinism", "a second run has other bits")

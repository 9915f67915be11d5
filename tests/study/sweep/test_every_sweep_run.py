"""How a run of a sweep goes on: what is stored, computed and told.

Store, clock and whoever computes are stand-ins; a chunk is a name and its first and last number.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from nipper_pin.errors import InputError, SimulationError
from nipper_pin.study.sweep import cluster, run
from nipper_pin.study.sweep.chunks import DefectError
from nipper_pin.study.sweep.results.chunk_file import DamageError

# What is read of a chunk: what a summary needs, the first quantity and all parameters.
COLUMNS = ("scenario", "engine", "outcome", "message", "premise_holds", "duration_s", "preload")
CHUNKS = [SimpleNamespace(number=n, start=10 * n, stop=10 * n + 4 + n) for n in range(4)]


class Store:
    """Chunks on disk."""

    def __init__(self, stored: set[int], damaged: set[int]) -> None:
        self.stored, self.damaged = stored, damaged
        self.written: list[int] = []
        self.plan = SimpleNamespace(
            job=SimpleNamespace(text=lambda: b"job", quantities=("duration_s",),
                                axes=(SimpleNamespace(name="preload"),)),
            rows=lambda chunks: ((chunk, f"rows {chunk.number}") for chunk in chunks),
        )  # fmt: skip

    def rows(self, chunk: Any) -> Any:
        if chunk.number in self.damaged:
            message = "it is damaged"
            raise DamageError(message, file=f"/somewhere/{chunk.number}.parquet")
        return f"stored {chunk.number}" if chunk.number in self.stored else None

    def write(self, chunk: Any, content: bytes) -> None:
        self.written.append(chunk.number)
        self.damaged.discard(chunk.number)
        assert content == f"computed {chunk.number}".encode()


class Run:
    """A run of the chunks, and what it told."""

    def __init__(self, patch: pytest.MonkeyPatch, **others: Any) -> None:
        self.told: list[tuple[int, int, int]] = []
        self.added: list[str] = []
        self.asked: list[Any] = []
        self.answers: dict[int, Any] = others.get("answers", {})
        self.store: Any = Store(*(set(others.get(k, ())) for k in ("stored", "damaged")))
        patch.setattr(run, "on_this_machine", self.compute)
        patch.setattr(cluster, "on_scheduler", self.compute)
        patch.setattr(run, "read", lambda content, columns: (content.decode(), columns))
        progress = (lambda *words: self.told.append(words)) if others.get("tells", True) else None
        self.run: Any = run._Run(
            self.store, others.get("workers", 2), others.get("scheduler"), list(CHUNKS), progress
        )
        self.run.tally = SimpleNamespace(add=self.added.append)
        self.seen: list[Any] = []
        self.run.extremes = SimpleNamespace(add=self.seen.append, columns=COLUMNS)

    def compute(self, text: bytes, tasks: Any, *words: Any) -> Any:
        self.asked.append((text, *words))
        for chunk, rows in tasks:
            assert rows == f"rows {chunk.number}"
            yield chunk, self.answers.get(chunk.number, f"computed {chunk.number}".encode())


def test_a_run_from_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every chunk is computed, stored, counted and told of."""
    made = Run(monkeypatch)
    made.run.complete()
    assert made.asked == [(b"job", 2)]
    assert made.store.written == [0, 1, 2, 3]
    assert made.added == [(f"computed {n}", COLUMNS) for n in range(4)]
    assert made.seen == made.added
    assert made.told == [(0, 0, 22), (4, 0, 22), (9, 0, 22), (15, 0, 22), (22, 0, 22)]
    assert (made.run.computed, made.run.total, made.run.chunks, made.run.count) == (22, 22, 4, 2)
    assert (made.run.damaged, made.run.defects) == ({}, [])


def test_a_run_that_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is stored is counted first; what is damaged is computed anew."""
    made = Run(monkeypatch, stored={0, 2}, damaged={3}, workers=7)
    made.run.complete()
    assert made.run.damaged == {3: "3.parquet"}
    assert made.added[:2] == ["stored 0", "stored 2"]
    assert made.seen == made.added
    assert made.told == [(10, 10, 22), (15, 10, 22), (22, 10, 22)]
    assert made.run.computed == 12
    # No more processes than chunks.
    assert made.asked == [(b"job", 2)]
    done = Run(monkeypatch, stored={0, 1, 2, 3})
    done.run.complete()
    assert (done.asked, done.told, done.run.computed) == ([], [(22, 22, 22)], 0)
    silent = Run(monkeypatch, tells=False)
    silent.run.complete()
    assert (silent.told, silent.run.computed) == ([], 22)


def test_a_run_on_a_scheduler(monkeypatch: pytest.MonkeyPatch) -> None:
    made = Run(monkeypatch, scheduler="tcp://here:1")
    made.run.complete()
    assert made.asked == [(b"job", "tcp://here:1", made.run._tell)]
    assert made.run.computed == 22


def test_defects_end_a_run_when_all_else_is_stored(monkeypatch: pytest.MonkeyPatch) -> None:
    defect = DefectError("it broke", scenario=11)
    made = Run(monkeypatch, answers={1: defect, 3: DefectError("again", scenario=31)})
    with pytest.raises(SimulationError, match="it broke; 2 of 4 chunks are not stored") as caught:
        made.run.complete()
    assert caught.value.evidence == {"scenario": 11}
    assert made.run.computed == 4 + 6
    assert made.store.written == [0, 2]
    assert [done for done, *_ in made.told] == [0, 4, 4, 10, 10]


def test_an_interrupted_run_counts_what_was_stored(monkeypatch: pytest.MonkeyPatch) -> None:
    made = Run(monkeypatch)

    def interrupted() -> None:
        made.store.stored = {1, 2}
        raise KeyboardInterrupt

    made.run._compute = interrupted
    with pytest.raises(KeyboardInterrupt):
        made.run.complete()
    assert made.told == [(0, 0, 22), (11, 0, 22)]


# Workers of a scheduler.


def test_addresses_of_schedulers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nipper_pin.extras.installed", lambda _: True)
    for address in ("tcp://a:1", "tls://a:1", "ws://a", "wss://a", "ucx://a", "a:8786"):
        cluster.check_address(address)
    with pytest.raises(InputError, match="http://a: no address of a scheduler") as caught:
        cluster.check_address("http://a")
    assert caught.value.evidence == {"scheduler": "http://a"}
    monkeypatch.setattr("nipper_pin.extras.installed", lambda name: name != "distributed")
    with pytest.raises(InputError, match="--scheduler needs distributed") as caught:
        cluster.check_address("tcp://a:1")
    assert caught.value.evidence == {"extra": "cluster", "packages": ("distributed",)}


def client(answer: Any, waits: Any = None) -> Any:
    def wait_for_workers(count: int, timeout: float) -> None:
        assert (count, timeout) == (1, cluster._CONNECT_S)
        if waits is not None:
            raise waits

    def ask(function: Any, on_error: str) -> Any:
        assert (function, on_error) == (cluster.versions, "return")
        if isinstance(answer, Exception):
            raise answer
        return answer

    return SimpleNamespace(wait_for_workers=wait_for_workers, run=ask)


def test_workers_that_lack_something(monkeypatch: pytest.MonkeyPatch) -> None:
    """None at all, one that does not answer, and others than here."""
    here = {"numpy": "2.0", "pin": "3.1", "python": "3.11"}
    monkeypatch.setattr(cluster, "versions", lambda: here)
    cluster._check_workers(client({"w1": dict(here), "w2": dict(here)}), "a")
    with pytest.raises(InputError, match="--scheduler a: has no workers") as caught:
        cluster._check_workers(client({}, TimeoutError()), "a")
    assert caught.value.evidence == {"scheduler": "a"}
    with pytest.raises(InputError, match="--scheduler a: a worker does not answer") as caught:
        cluster._check_workers(client(TimeoutError()), "a")
    assert caught.value.evidence == {"scheduler": "a"}
    other = {"w1": dict(here), "w2": {**here, "pin": "2.9"}, "w3": {"python": "3.11"}}
    words = r"2 of 3 workers .* such as w2 \(pin 2.9 instead of 3.1\); install"
    with pytest.raises(InputError, match=words) as caught:
        cluster._check_workers(client(other), "a")
    assert caught.value.evidence == {"scheduler": "a", "workers": ["w2", "w3"]}
    assert cluster._lacking({"python": "3.11"}) == (
        "numpy None instead of 2.0, pin None instead of 3.1"
    )
    gone = ModuleNotFoundError("No module")
    assert cluster._lacking(gone) == "the package is not installed there: No module"


def test_work_that_is_under_way_on_a_scheduler() -> None:
    """Three chunks a thread at a time; each is given once, and what failed is raised."""
    waiting: list[Any] = []
    most = 0

    def submit(_: Any, text: bytes, start: int, _rows: Any, *, pure: bool) -> Any:
        nonlocal most
        assert (text, pure) == (b"job", False)
        future = SimpleNamespace(key=f"k{start}", released=0)
        future.result = lambda: outcomes(start)

        def release() -> None:
            future.released += 1

        def done(put: Any) -> None:
            put(future)

        future.release, future.add_done_callback = release, done
        waiting.append(future)
        most = max(most, sum(not item.released for item in waiting))
        return future

    outcomes: Any = lambda start: f"done {start}".encode()  # noqa: E731
    scheduler = SimpleNamespace(nthreads=lambda: {"a": 1, "b": 1}, submit=submit, status="running")
    chunks = [SimpleNamespace(start=k) for k in range(20)]
    tasks: Any = [(chunk, np.zeros(1)) for chunk in chunks]
    work = cluster._Work(scheduler, "tcp://a", lambda: None)
    found = list(work.results(b"job", tasks))
    assert sorted((chunk.start, answer) for chunk, answer in found) == [
        (k, f"done {k}".encode()) for k in range(20)
    ]
    assert all(item.released == 1 for item in waiting)
    assert most == cluster._AHEAD * 2

    defect = DefectError("odd")

    def odd(start: int) -> bytes:
        if start == 1:
            raise defect
        if start == 2:
            message = "lost"
            raise OSError(message)
        return b"fine"

    outcomes = odd
    work = cluster._Work(scheduler, "tcp://a", lambda: None)
    answers = work.results(b"job", tasks[:3])
    assert [next(answers)[1] for _ in range(2)] == [b"fine", defect]
    with pytest.raises(OSError, match="lost"):
        next(answers)


def test_workers_that_are_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    """Looked for now and then; given up after a while without any, or at once without scheduler."""
    monkeypatch.setattr(cluster, "_LOOK_S", 1e-3)
    times = iter(np.arange(0.0, 1e4, 10.0))
    monkeypatch.setattr(cluster.time, "monotonic", lambda: float(next(times)))
    looks: list[int] = []
    threads = iter([{"a": 2}, {"a": 1}, {}, {"a": 4}, *[{}] * 50])
    scheduler: Any = SimpleNamespace(nthreads=lambda: next(threads), status="running")
    work = cluster._Work(scheduler, "tcp://a", lambda: looks.append(work._threads))
    assert work._threads == 2
    with pytest.raises(SimulationError, match="all workers of tcp://a were lost, and for 30") as no:
        work._answer()
    assert no.value.evidence == {"scheduler": "tcp://a"}
    assert looks[:5] == [2, 1, 0, 4, 0]
    # One look later than thirty seconds after the last worker.
    assert 7 <= len(looks) <= 9
    scheduler.status = "closed"
    with pytest.raises(cluster.CancelledError):
        work._answer()
    work._answers.put(("k", b"there"))
    assert work._answer() == ("k", b"there")

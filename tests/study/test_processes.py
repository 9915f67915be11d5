"""Processes of a study, and the same bits whatever the environment says of threads of BLAS."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from functools import partial
from multiprocessing import active_children, get_context
from pathlib import Path

import pytest
from programs import study_text

from nipper_pin.study.processes import WorkerError, Workers, fresh_processes
from tests.study.sweep.sweep_studies import COMMAND

# What OpenMP, OpenBLAS and MKL read when they are loaded.
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def test_results_in_order_and_as_they_come() -> None:
    """Of the same processes, which compute elsewhere."""
    with Workers(2) as pool:
        assert list(pool.in_order(abs, range(-7, 0), chunk=2)) == [7, 6, 5, 4, 3, 2, 1]
        tasks = ((k, partial(divmod, k, 3)) for k in range(7))
        assert dict(pool.as_completed(tasks)) == {k: divmod(k, 3) for k in range(7)}
        (elsewhere,) = pool.in_order(eval, ["__import__('os').getpid()"])
        assert elsewhere != os.getpid()
        # Samples of a long sweep are not all made before the first result.
        drawn: list[int] = []

        def drawing() -> Iterator[tuple[int, partial[int]]]:
            for k in range(50):
                drawn.append(k)
                yield k, partial(abs, k)

        key, result = next(pool.as_completed(drawing()))
        assert key == result
        assert len(drawn) <= 6


# Whether a process ignores Ctrl-C, and whether it began as a copy of the test's.
DEAF = "(s := __import__('signal')).SIGINT in s.pthread_sigmask(s.SIG_BLOCK, ())"
COPY = f"{__name__!r} in __import__('sys').modules"


def test_processes_begin_afresh(monkeypatch: pytest.MonkeyPatch) -> None:
    """Spawned, deaf to the keyboard and in one thread, whatever this one does and goes on to do."""
    for name, value in zip(THREADS, ("3", "2", "4"), strict=True):
        monkeypatch.setenv(name, value)
    with fresh_processes(1) as pool:
        assert list(pool.map(os.getenv, THREADS)) == ["1", "1", "1"]
        assert list(pool.map(eval, [DEAF, COPY])) == [True, False]
        assert list(map(eval, [DEAF, COPY])) == [False, True]
    assert [os.environ[name] for name in THREADS] == ["3", "2", "4"]


def test_a_worker_that_dies_is_an_error() -> None:
    """With what to do about it, whether results are asked for in order or as they come."""
    for ask in (
        lambda pool: list(pool.in_order(os._exit, [3])),
        lambda pool: list(pool.as_completed([(0, partial(os._exit, 3))])),
    ):
        with (
            pytest.raises(WorkerError, match=r"a worker process died, .* memory, alas") as caught,
            Workers(1, advice=", alas", apart=True) as pool,
        ):
            ask(pool)
        assert caught.value.evidence == {"workers": 1}


def test_a_worker_that_cannot_start_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those that did start are ended."""
    kind = get_context("spawn").Process
    start, before, started = kind.start, set(active_children()), []

    def second_fails(process: object) -> None:
        if started:
            raise BlockingIOError(11, "Resource temporarily unavailable")
        start(process)
        started.append(process)

    monkeypatch.setattr(kind, "start", second_fails)
    with (
        pytest.raises(WorkerError, match=r"2 worker processes cannot be started .*fewer") as caught,
        Workers(2) as pool,
    ):
        list(pool.in_order(abs, [1]))
    assert caught.value.evidence == {"workers": 2}
    (first,) = started
    first.join(30.0)
    assert first.exitcode is not None
    assert set(active_children()) <= before


def test_nothing_runs_after_a_failure() -> None:
    """Otherwise a process that ends at once complains of what still runs."""
    before = set(active_children())
    tasks = [(pause, partial(time.sleep, pause)) for pause in (0.0, 0.4, 0.5)]

    def failing() -> None:
        with Workers(2, apart=True) as pool:
            for _ in pool.as_completed(tasks):
                raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        failing()
    assert set(active_children()) <= before


FILMED = Path(__file__).resolve().parents[2] / "scripts" / "identify_camera.toml"
DESIGN = study_text("design_in_threads.toml")
OPTIMUM = """
from pathlib import Path
from nipper_pin.study.optimise import optimise, read_problem
found = optimise(read_problem(Path("design.toml")), starts=1, check=False, workers=1)
print(found.best, found.account)
"""


def said(threads: str, words: list[str], folder: Path) -> str:
    """What a program writes that is started with so many threads."""
    env = os.environ | dict.fromkeys(THREADS, threads)
    run = subprocess.run(
        [sys.executable, *words], env=env, cwd=folder, capture_output=True, text=True, check=False
    )
    assert run.stdout, run.stderr
    return run.stdout


@pytest.mark.campaign
@pytest.mark.parametrize(
    "words",
    [
        # One start, its deviations, and a profile: the last bits of all numbers.
        [*COMMAND[1:], "identify", str(FILMED), "--starts", "1", "--workers", "1", "--profiles",
         "1", "--json", "-"],
        # By a caller whose BLAS has several threads, too.
        ["-c", OPTIMUM],
        ["-m", "benchmarks", "paper", "--json", "-"],
    ],
    ids=["identify", "optimum", "published study"],
)  # fmt: skip
def test_threads_change_no_bit(words: list[str], tmp_path: Path) -> None:
    (tmp_path / "design.toml").write_text(DESIGN, encoding="utf-8")
    one, two = (said(threads, words, tmp_path) for threads in ("1", "2"))
    assert len(one) > 100
    assert one == two


def test_the_command_computes_in_one_thread(tmp_path: Path) -> None:
    """Whatever the environment says, and before numpy has read it."""
    program = (
        "import os; import nipper_pin.cli; "
        "from nipper_pin.study.processes import in_one_thread; "
        "print(in_one_thread(), os.environ['OPENBLAS_NUM_THREADS'])"
    )
    assert said("2", ["-c", program], tmp_path).split() == ["True", "1"]

"""Sweeps on a real Dask scheduler with real workers, and all that can go wrong there."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any

import pytest
from sweep_studies import GEOMETRY, chunk_files, started, stored, study, wait_for
from waiting import notes

from nipper_pin import read_sweep
from nipper_pin.cli import main
from nipper_pin.study.sweep import read_plan

MANY = GEOMETRY.replace("points = 5", "points = 12")


class Cluster:
    """A real scheduler and real workers on loopback, each a process of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.file = folder / "scheduler.json"
        self.running: list[subprocess.Popen[bytes]] = []
        self.start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
                   "--scheduler-file", str(self.file))  # fmt: skip
        # It is there before it is written.
        wait_for(lambda: self.file.exists() and self.file.read_text().rstrip().endswith("}"))
        self.address = json.loads(self.file.read_text())["address"]

    def start(self, *arguments: str, bare: bool = False) -> subprocess.Popen[bytes]:
        """A process of Dask; a bare one has all packages but this one, which is found by a site."""
        packages = sysconfig.get_path("purelib")
        with (self.folder / f"{len(self.running)}.log").open("wb") as log:
            process = subprocess.Popen(
                [sys.executable, *(["-S"] if bare else []), "-m", "dask", *arguments],
                stdout=log,
                stderr=log,
                cwd=self.folder,
                env={**os.environ, "PYTHONPATH": packages} if bare else None,
            )
        self.running.append(process)
        return process

    def worker(self, name: str, *, bare: bool = False) -> subprocess.Popen[bytes]:
        return self.start("worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard",
                          "--host", "127.0.0.1", "--name", name, bare=bare)  # fmt: skip

    def client(self) -> Any:
        """Of the tests: others that are collected with these do without its import."""
        from distributed import Client

        return Client(self.address)

    def __enter__(self) -> Cluster:
        return self

    def __exit__(self, *_: object) -> None:
        for process in self.running:
            process.kill()
            process.wait()


@pytest.mark.slow
def test_a_worker_of_a_cluster_dies(tmp_path: Path) -> None:
    """Nothing is lost and nothing is double when one of two workers is killed at work.

    When it is killed, chunks of its own are under way (the scheduler names them) and a part of all
    is stored; the other one has to do them again. The files are those of a local sweep to the last
    byte, so every scenario is there once.
    """
    path, out = study(tmp_path, MANY), tmp_path / "cluster"
    whole = chunk_files(stored(tmp_path / "local", read_plan(path)))
    assert len(whole) == 18

    def count() -> int:
        return len(list((out / "chunks").glob("*.parquet")))

    with Cluster(tmp_path) as cluster, cluster.client() as client:
        doomed, other = cluster.worker("doomed"), cluster.worker("other")
        client.wait_for_workers(2, timeout=180)
        names = {item["name"]: at for at, item in client.scheduler_info()["workers"].items()}
        command = started(path, "--out", str(out), "--scheduler", cluster.address)

        def at_work() -> bool:
            return count() >= 4 and len(client.processing()[names["doomed"]]) >= 1

        def stopped_at_work() -> bool:
            """What it has to compute when it is stopped it still has when it is killed."""
            if not at_work():
                return False
            doomed.send_signal(signal.SIGSTOP)
            if not at_work():
                doomed.send_signal(signal.SIGCONT)
                return False
            return True

        wait_for(lambda: stopped_at_work() or command.poll() is not None)
        before = count()
        doomed.kill()
        said, complained = command.communicate(timeout=120)
        left = [item["name"] for item in client.scheduler_info()["workers"].values()]
        assert other.poll() is None
    assert command.returncode == 0, complained
    assert "72 computed" in said
    assert 4 <= before < 16
    assert left == ["other"]
    assert chunk_files(out) == whole


@pytest.mark.slow
def test_a_cluster_that_is_not_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Neither an address where nobody listens nor a scheduler without workers waits for ever."""
    monkeypatch.setattr("nipper_pin.study.sweep.cluster._CONNECT_S", 1.0)
    path = study(tmp_path, GEOMETRY)
    with socket.socket() as taken:
        # Bound and not listening: nobody answers there, and nobody else can.
        taken.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{taken.getsockname()[1]}"
        arguments = ["sweep", path, "--out", str(tmp_path / "out"), "--scheduler"]
        assert main([*arguments, address]) == 2
    assert "cannot be reached" in capsys.readouterr().err
    assert main([*arguments, "nonsense"]) == 2
    capsys.readouterr()
    # No web server is asked to be a scheduler.
    monkeypatch.setattr("nipper_pin.study.sweep.cluster._client", None)
    for address in ("http://127.0.0.1:8786", "https://host", "8786://", "://"):
        assert main([*arguments, address]) == 2
        said = capsys.readouterr().err
        assert f"--scheduler {address}: no address of a scheduler" in said
        assert said.count("\n") == 1
    monkeypatch.undo()
    monkeypatch.setattr("nipper_pin.study.sweep.cluster._CONNECT_S", 1.0)
    with Cluster(tmp_path) as cluster:
        assert main([*arguments, cluster.address]) == 2
    assert "has no workers" in capsys.readouterr().err


# The command with a shorter patience; what it prints is all that anybody prints.
IMPATIENT = [
    sys.executable,
    "-c",
    "import sys; from nipper_pin.cli import main; from nipper_pin.study.sweep import cluster; "
    "cluster._LOST_S = 2.0; sys.exit(main())",
]


@pytest.mark.slow
def test_workers_without_the_package_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Whether it is the only one or one of two; nothing is computed, and nobody waits."""
    out = tmp_path / "out"
    arguments = ["sweep", study(tmp_path, GEOMETRY), "--out", str(out), "--scheduler"]
    with Cluster(tmp_path) as cluster, cluster.client() as client:
        cluster.worker("bare", bare=True)
        for workers in (1, 2):
            client.wait_for_workers(workers, timeout=180)
            assert main([*arguments, cluster.address]) == 2
            said = notes(capsys.readouterr().err)
            assert f"1 of {workers} workers cannot compute this, such as tcp://127.0.0.1:" in said
            assert "No module named 'nipper_pin'" in said
            assert "install the same versions everywhere" in said
            assert said.count("\n") == 1
            cluster.worker("right")
    assert not list((out / "chunks").iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("lost", ["workers", "scheduler"])
def test_a_cluster_is_lost(tmp_path: Path, lost: str) -> None:
    """One sentence and status 1 within seconds; what is finished is kept."""
    path, out = study(tmp_path, MANY), tmp_path / "out"
    with Cluster(tmp_path) as cluster, cluster.client() as client:
        doomed = [cluster.worker("one"), cluster.worker("two")]
        client.wait_for_workers(2, timeout=180)
        words = (path, "--out", str(out), "--scheduler", cluster.address)
        command = started(*words, command=IMPATIENT)
        wait_for(lambda: len(list(out.glob("chunks/*.parquet"))) >= 3 or command.poll() is not None)
        client.close()
        for process in doomed if lost == "workers" else cluster.running[:1]:
            process.kill()
            process.wait()
        # Dask would go on for half a minute, or for ever.
        said, complained = command.communicate(timeout=120)
    assert command.returncode == 1, complained
    sentence = {
        "workers": f"all workers of {cluster.address} were lost, and for 2 s none came",
        "scheduler": f"the scheduler {cluster.address} was lost",
    }[lost]
    complained = notes(complained)
    assert complained.startswith(f"nipper-pin: {sentence}; what is finished is kept")
    assert complained.count("\n") == 1
    assert said == ""
    assert 12 <= read_sweep(out).stored < 72

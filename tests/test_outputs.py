"""Output files and folders: complete or absent, and whatever their name is stays what it is."""

import os
import signal
import socket
import stat
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest

from nipper_pin import Case, InputError, load, load_solution, save, simulate
from nipper_pin.cli import main
from nipper_pin.outputs import check_file, complete_file, complete_folder, file, folder


def write(path: Path, text: str) -> None:
    with complete_file(path) as partial:
        partial.write_text(text)


def test_a_device_is_written_into(tmp_path: Path) -> None:
    """A node like that of /dev/null, which keeps no content, is still one afterwards."""
    device = Path("/dev/null")
    check_file(device)
    before = device.stat()
    write(device, "text")
    after = device.stat()
    assert stat.S_ISCHR(after.st_mode)
    assert (after.st_ino, after.st_rdev) == (before.st_ino, before.st_rdev)
    link = tmp_path / "link"
    link.symlink_to(device)
    write(link, "text")
    assert link.is_symlink()
    assert stat.S_ISCHR(link.stat().st_mode)


def test_a_fifo_passes_the_text_on(tmp_path: Path) -> None:
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    check_file(fifo)
    with ThreadPoolExecutor(1) as other:
        read = other.submit(fifo.read_text)
        write(fifo, "all of it")
        assert read.result(20.0) == "all of it"
    assert stat.S_ISFIFO(fifo.lstat().st_mode)
    assert [item.name for item in tmp_path.iterdir()] == ["fifo"]


def test_links_are_followed(tmp_path: Path) -> None:
    """Also one to a file that is not there yet."""
    place = tmp_path / "place"
    place.mkdir()
    for name in ("old", "new"):
        (tmp_path / name).symlink_to(place / name)
    (place / "old").write_text("before")
    for name in ("old", "new"):
        write(tmp_path / name, name)
        assert (tmp_path / name).is_symlink()
        assert (place / name).read_text() == name


@pytest.mark.parametrize("words", ["check --drawing /sys/a.svg", "simulate --out /sys/a"])
def test_where_nobody_may_write(words: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The kernel keeps its own folders, whoever asks."""
    assert main(words.split()) == 2
    said = capsys.readouterr()
    assert (said.out, said.err.count("\n")) == ("", 1)
    assert said.err.startswith("nipper-pin: /sys")
    assert " cannot be written (" in said.err


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o755])
def test_the_mode_of_a_file_is_kept_or_that_of_the_umask(tmp_path: Path, mode: int) -> None:
    """And nobody else may read what is to replace a private file, while it is written."""
    target = tmp_path / "file"
    before = os.umask(0o777 & ~mode)
    try:
        write(target, "before")
    finally:
        os.umask(before)
    assert stat.S_IMODE(target.stat().st_mode) == 0o666 & mode
    target.chmod(mode)
    with complete_file(target) as partial:
        assert stat.S_IMODE(partial.stat().st_mode) == 0o600
        partial.write_text("after")
    assert stat.S_IMODE(target.stat().st_mode) == mode
    assert target.read_text() == "after"


def test_content_is_on_the_disk_before_the_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The file is synchronised, then renamed, then the folder is."""
    done: list[str] = []
    replace, synchronise = Path.replace, file.synchronise

    def renamed(path: Path, target: Path) -> Path:
        done.append("renamed")
        return replace(path, target)

    def synced(path: Path) -> None:
        done.append("folder" if path.is_dir() else path.read_text())
        synchronise(path)

    monkeypatch.setattr(Path, "replace", renamed)
    monkeypatch.setattr(file, "synchronise", synced)
    write(tmp_path / "file", "content")
    assert done == ["content", "renamed", "folder"]


@pytest.mark.slow
def test_threads_that_save_one_path_harm_nobody(tmp_path: Path) -> None:
    """Eight of them, thirty times each, and a reader: every file read is one that was saved."""
    runs = [simulate(load("e62"), Case(speed_rpm=650.0, max_collisions=n)) for n in (1, 2, 3)]
    path = save(runs[0], tmp_path / "run")
    counts = {len(run.events) for run in runs}
    over = threading.Event()

    def read() -> int:
        times = 0
        while not over.is_set():
            assert len(load_solution(path).events) in counts
            times += 1
        return times

    with ThreadPoolExecutor(9) as pool:
        reader = pool.submit(read)
        saves = [pool.submit(save, runs[k % 3], path) for k in range(240)]
        for item in saves:
            item.result()
        over.set()
        assert reader.result() > 3
    assert [item.name for item in tmp_path.iterdir()] == ["run.npz"]


def fill(path: Path, files: dict[str, str], ours: tuple[str, ...] = ("a", "b", "c")) -> None:
    with complete_folder(path, ours) as new:
        for name, text in files.items():
            (new / name).write_text(text)


def content(path: Path) -> dict[str, str]:
    return {
        item.relative_to(path).as_posix(): item.read_text()
        for item in path.rglob("*")
        if item.is_file()
    }


def test_what_fails_stays_as_it_was(tmp_path: Path) -> None:
    """A file, and a folder with one; a folder does not replace a file."""
    target, path = tmp_path / "out", tmp_path / "file"
    fill(target, {"a": "1"})
    write(path, "1")

    def half(opened: AbstractContextManager[Path], name: str) -> None:
        with opened as new:
            (new / name).write_text("2")
            raise ZeroDivisionError

    for opened, name in ((complete_file(path), ""), (complete_folder(target, ("a",)), "a")):
        with pytest.raises(ZeroDivisionError):
            half(opened, name)
        assert content(tmp_path) == {"out/a": "1", "file": "1"}
    with pytest.raises(InputError, match="not a folder"):
        fill(path, {"b": "1"})
    assert content(tmp_path) == {"out/a": "1", "file": "1"}


def test_a_folder_may_be_written_inside_another(tmp_path: Path) -> None:
    """A function that writes a folder of its own is called while another one is written."""
    with complete_folder(tmp_path / "out", ("a",)) as new:
        fill(new, {"a": "1"})
        fill(new / "below", {"a": "2"})
        (new / "b").write_text("3")
    assert content(tmp_path) == {"out/a": "1", "out/below/a": "2", "out/b": "3"}


def killed(target: Path, how: str) -> Path:
    """What a killed process leaves: as it is written, without what is done at its end."""
    program = f"""
import os, signal
from pathlib import Path
from nipper_pin.outputs import complete_file, complete_folder
with {how} as partial:
    print(partial, flush=True)
    (partial / "a" if partial.is_dir() else partial).write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""
    done = subprocess.run(
        [sys.executable, "-c", program.replace("TARGET", repr(str(target)))],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == -signal.SIGKILL
    return Path(done.stdout.strip())


@pytest.mark.parametrize("how", ["complete_file(TARGET)", "complete_folder(TARGET, ())"])
def test_what_a_kill_leaves_goes_with_the_next_run(tmp_path: Path, how: str) -> None:
    """One hidden name at most, however many kills; that of a living process stays."""
    target = tmp_path / "out"
    act = write if how.startswith("complete_file") else (lambda path, text: fill(path, {"a": text}))
    for _ in range(3):
        assert killed(target, how).exists()
        assert [item.name for item in tmp_path.iterdir()] == [".out.0.partial"]
    act(target, "whole")
    assert [item.name for item in tmp_path.iterdir()] == ["out"]
    with complete_file(target) if target.is_file() else complete_folder(target, ()) as living:
        (living / "a" if living.is_dir() else living).write_text("later")
        act(target, "between")
        assert living.exists()
    assert [item.name for item in tmp_path.iterdir()] == ["out"]
    assert (target if target.is_file() else target / "a").read_text() == "later"


def test_hidden_files_of_others_are_left_alone(tmp_path: Path) -> None:
    """A link of such a name is not followed, and what is merely called alike stays."""
    (tmp_path / "mine").write_text("mine")
    (tmp_path / ".out.0.partial").symlink_to("mine")
    (tmp_path / ".out.partial").write_text("mine")
    write(tmp_path / "out", "text")
    assert content(tmp_path) == {
        "out": "text", "mine": "mine", ".out.0.partial": "mine", ".out.partial": "mine",
    }  # fmt: skip
    assert (tmp_path / ".out.0.partial").is_symlink()


@pytest.mark.parametrize("name", ["x" * 255, "\u4e2d" * 85])
def test_the_longest_names_can_be_written(tmp_path: Path, name: str) -> None:
    """255 bytes, the most that file systems allow, also of characters of three bytes."""
    write(tmp_path / name, "text")
    assert [item.name for item in tmp_path.iterdir()] == [name]


WRITER = """
import sys
from pathlib import Path
from nipper_pin.outputs import complete_folder
for turn in range(1, 10 ** 6):
    with complete_folder(sys.argv[1], [f"f{k}" for k in range(5)]) as new:
        for k in range(4 + turn % 2):
            (new / f"f{k}").write_text(str(turn))
    print(turn, flush=True)
"""


@pytest.mark.slow
def test_a_killed_process_leaves_one_whole_set(tmp_path: Path) -> None:
    """Sixty kills at random times: all files of one turn, the last one reported or the next."""
    target, rng = tmp_path / "out", np.random.default_rng(5)
    for _ in range(60):
        with subprocess.Popen(
            [sys.executable, "-c", WRITER, str(target)], stdout=subprocess.PIPE, text=True
        ) as process:
            assert process.stdout is not None
            process.stdout.readline()
            time.sleep(float(rng.uniform(0.0, 0.05)))
            process.send_signal(signal.SIGKILL)
            told = 1 + len(process.stdout.read().splitlines())
        found = content(target)
        (turn,) = {int(text) for text in found.values()}
        assert told <= turn <= told + 1
        assert sorted(found) == [f"f{k}" for k in range(4 + turn % 2)]


@pytest.fixture(params=["tmpfs", "bind"])
def mounted(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Path]:
    """A folder where something is mounted: a file system of its own, or another folder."""
    target, source = tmp_path / "out", tmp_path / "source"
    target.mkdir()
    source.mkdir()
    how = ["-t", "tmpfs", "tmpfs"] if request.param == "tmpfs" else ["--bind", str(source)]
    try:
        done = subprocess.run(["mount", *how, str(target)], capture_output=True, check=False)
    except FileNotFoundError:
        pytest.skip("there is no mount here, so nothing can be mounted")
    if done.returncode:
        pytest.skip(f"nothing may be mounted here: {done.stderr.decode().strip()}")
    yield target
    subprocess.run(["umount", str(target)], check=True)


def test_a_mount_point_is_written_in_itself(mounted: Path) -> None:
    """It cannot be exchanged: what it holds is replaced, or stays if a file cannot come."""
    for turn in ("1", "2"):
        fill(mounted, {"a": turn, "b": turn} if turn == "1" else {"a": turn})
        (mounted / "notes").write_text("mine")
    assert content(mounted) == {"a": "2", "notes": "mine"}
    (mounted / "b").mkdir()
    with pytest.raises(InputError, match="b in it is a folder"):
        fill(mounted, {"a": "3", "b": "3"})
    assert content(mounted) == {"a": "2", "notes": "mine"}
    assert sorted(item.name for item in mounted.parent.iterdir()) == ["out", "source"]
    assert not [item for item in mounted.iterdir() if item.name.endswith(".partial")]


def test_a_new_model_may_be_written_where_something_is_mounted(mounted: Path) -> None:
    assert main(["new", str(mounted)]) == 0
    assert load(str(mounted)).name == mounted.name
    assert sorted(item.name for item in mounted.parent.iterdir()) == ["out", "source"]


@pytest.mark.parametrize("moves", range(6))
def test_old_files_come_back_where_a_new_one_cannot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moves: int
) -> None:
    """In a folder that stays, whichever move fails."""
    target = tmp_path / "out"
    fill(target, {"a": "1", "b": "1"})
    monkeypatch.chdir(target)
    replace, count = Path.replace, iter(range(100))

    def failing(path: Path, other: Path) -> Path:
        if next(count) == moves:
            raise OSError(5, "the disk is broken")
        return replace(path, other)

    monkeypatch.setattr(Path, "replace", failing)
    with pytest.raises(InputError, match="the disk is broken"):
        fill(target, {"a": "2", "b": "2", "c": "2"})
    assert content(target) == {"a": "1", "b": "1"}


# What else an output folder holds stays what it is, links above all, however it is written.

# By name their permissions, and where they lead; beside the folder stand a file and a folder.
FILES = {
    "a file": 0o644, "a private file": 0o600, "a program": 0o755, ".hidden": 0o644,
    "a folder/one": 0o640, "a folder/two/three": 0o644,
}  # fmt: skip
LINKS = {
    "to a file": "../mine", "to a folder": "../ours", "to nothing": "nowhere",
    "to itself": "to itself", "upwards": "..", "a whole path": "/dev/null",
    "a folder/to a file": "../../mine", "a folder/to a folder": "../../ours", "a folder/no": "x",
    # By the name of a result: these are replaced, and what they lead to stays.
    "b": "../mine", "c": "../ours", "d": "nowhere",
}  # fmt: skip


def described(path: Path) -> dict[str, tuple[int, str]]:
    """Kind and permissions of everything in a folder, and the text or the target of each."""
    found = {}
    for item in sorted(path.rglob("*")):
        mode = item.lstat().st_mode
        content = item.readlink() if stat.S_ISLNK(mode) else ""
        content = item.read_text() if stat.S_ISREG(mode) else str(content)
        found[item.relative_to(path).as_posix()] = (mode, content)
    return found


@pytest.mark.parametrize("how", ["exchanged", "no hard links", "no such call", "working directory"])
def test_what_a_folder_holds_stays(
    how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Links are not followed, neither to be copied nor to be written, and nothing outside moves.

    An old file that is not made anew goes; the folder has the permissions that it had.
    """
    target = tmp_path / "out"
    for name, mode in {"a": 0o644, "../mine": 0o644, "../ours/one": 0o644, **FILES}.items():
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        (target / name).write_text(name)
        (target / name).chmod(mode)
    for name, to in LINKS.items():
        (target / name).symlink_to(to)
    (target / "an empty folder").mkdir()
    if how == "no hard links":
        monkeypatch.setattr(os, "link", Mock(side_effect=PermissionError(1, "no hard links here")))
    else:
        # Of what is no file and no link there is no copy, only another name.
        for name in ("a pipe", "a folder/pipe"):
            os.mkfifo(target / name)
        with socket.socket(socket.AF_UNIX) as place:
            # Names of sockets are short.
            here = os.open(target, os.O_RDONLY)
            place.bind(f"/proc/self/fd/{here}/a socket")
            os.close(here)
    target.chmod(0o750)
    if how == "no such call":
        monkeypatch.setattr(folder, "_swapped", lambda *_: False)
    elif how == "working directory":
        monkeypatch.chdir(target)
    kept = described(tmp_path)
    with complete_folder(target, tuple("abcde")) as new:
        for name in "bcde":
            (new / name).write_text("new")
    del kept["out/a"]
    assert described(tmp_path) == {**kept, **{f"out/{x}": (0o100644, "new") for x in "bcde"}}
    # Whoever is in the folder still is.
    assert how != "working directory" or {*os.listdir()} == {x.name for x in target.iterdir()}

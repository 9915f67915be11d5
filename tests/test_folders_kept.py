"""What else an output folder holds stays what it is, links above all, however it is written."""

from __future__ import annotations

import os
import socket
import stat
from collections.abc import Callable
from pathlib import Path

import pytest

from nipper_pin.outputs import complete_folder, folder


def text(content: str, mode: int = 0o644) -> Callable[[Path], None]:
    def make(path: Path) -> None:
        path.write_text(content)
        path.chmod(mode)

    return make


def link(to: str) -> Callable[[Path], None]:
    return lambda path: path.symlink_to(to)


def holding(**parts: Callable[[Path], None]) -> Callable[[Path], None]:
    def make(path: Path) -> None:
        path.mkdir()
        for name, part in parts.items():
            part(path / name)

    return make


def listening(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as place:
        # Names of sockets are short.
        here = os.open(path.parent, os.O_RDONLY)
        place.bind(f"/proc/self/fd/{here}/{path.name}")
        os.close(here)


# Outside stand a file and a folder, "mine" and "ours"; the output folder is beside them.
KEPT: dict[str, Callable[[Path], None]] = {
    "a file": text("kept"),
    "a private file": text("kept", 0o600),
    "a program": text("#!/bin/sh", 0o755),
    ".hidden": text("kept"),
    "an empty folder": holding(),
    "a folder": holding(one=text("1"), two=holding(three=text("3"))),
    "a link to a file": link("../mine"),
    "a link to a folder": link("../ours"),
    "a link to nothing": link("nowhere"),
    "a link to itself": link("a link to itself"),
    "a link upwards": link(".."),
    "a whole path": link("/dev/null"),
    "a folder of links": holding(one=link("../../mine"), two=link("../../ours"), three=link("x")),
    "a pipe": os.mkfifo,
    "a folder with a pipe": holding(pipe=os.mkfifo),
    "a socket": listening,
}


def described(path: Path) -> dict[str, tuple[int, str]]:
    """Kind and permissions of everything in a folder, and the text or the target of each."""
    found = {}
    for item in sorted(path.rglob("*")):
        mode = item.lstat().st_mode
        content = item.readlink() if stat.S_ISLNK(mode) else ""
        content = item.read_text() if stat.S_ISREG(mode) else str(content)
        found[item.relative_to(path).as_posix()] = (mode, content)
    return found


@pytest.fixture
def target(tmp_path: Path) -> Path:
    """An output folder with a file of ours, and what links in it lead to."""
    text("mine")(tmp_path / "mine")
    holding(one=text("1"), two=link("one"))(tmp_path / "ours")
    holding(a=text("old"))(tmp_path / "out")
    return tmp_path / "out"


def without_links(*_: object, **__: object) -> None:
    raise PermissionError(1, "no hard links here")


HOWS = ["exchanged", "no hard links", "no such call", "working directory"]


def prepared(how: str, target: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if how == "no hard links":
        monkeypatch.setattr(os, "link", without_links)
    elif how == "no such call":
        monkeypatch.setattr(folder, "_swapped", lambda *_: False)
    elif how == "working directory":
        monkeypatch.chdir(target)


# Of what is no file and no link there is no copy, only another name.
ONLY_NAMED = ("a pipe", "a folder with a pipe", "a socket")


@pytest.mark.parametrize(
    ("name", "how"),
    [(name, how) for name in KEPT for how in HOWS if (how, name in ONLY_NAMED) != (HOWS[1], True)],
)
def test_what_a_folder_holds_stays(
    name: str, how: str, target: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Links are not followed, neither to be copied nor to be written, and nothing outside moves.

    An old file that is not made anew goes; the folder has the permissions that it had.
    """
    KEPT[name](target / name)
    target.chmod(0o750)
    before, outside = described(target), described(target.parent / "ours")
    prepared(how, target, monkeypatch)
    with complete_folder(target, ("a", "b")) as new:
        (new / "b").write_text("new")
    del before["a"]
    assert described(target) == {**before, "b": (0o100644, "new")}
    assert stat.S_IMODE(target.stat().st_mode) == 0o750
    # Whoever is in the folder still is.
    assert how != "working directory" or set(os.listdir()) == {
        item.name for item in target.iterdir()
    }
    assert described(target.parent / "ours") == outside
    assert (target.parent / "mine").read_text() == "mine"
    assert sorted(item.name for item in target.parent.iterdir()) == ["mine", "ours", "out"]


@pytest.mark.parametrize("how", HOWS)
@pytest.mark.parametrize("to", ["../mine", "../ours", "nowhere"])
def test_a_link_by_the_name_of_a_result_is_replaced(
    to: str, how: str, target: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And what it leads to stays."""
    (target / "b").symlink_to(to)
    outside = described(target.parent / "ours")
    prepared(how, target, monkeypatch)
    with complete_folder(target, ("a", "b")) as new:
        (new / "b").write_text("new")
    assert described(target) == {"b": (0o100644, "new")}
    assert described(target.parent / "ours") == outside
    assert (target.parent / "mine").read_text() == "mine"

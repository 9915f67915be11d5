"""What is at a target, read with the standard library and numpy alone."""

from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

NONE, PART, OLD, NEW, SAME, WRONG = "none", "part", "old", "new", "old = new", "WRONG"
_TIMES = {"wall_s", "elapsed_s"}
_LOCKS = {"locks", "lock"}

Content = dict[str, bytes]
"""Bytes of files by their names, without what differs from run to run."""


def content(path: Path) -> Content:
    """Files of a result; hidden ones, locks and empty folders are none.

    Args:
        path: A file, or a folder.
    """
    if path.is_file():
        return _entries("", path)
    found: Content = {}
    for file in sorted(path.rglob("*")):
        name = file.relative_to(path)
        if file.is_file() and file.name not in _LOCKS and not _hidden(name):
            found |= _entries(name.as_posix(), file)
    return found


def _entries(name: str, file: Path) -> Content:
    """One entry a file; of a log one a line, since each is finished by itself.

    A line that is cut counts as none, as it does where the log is read.
    """
    if file.suffix != ".jsonl":
        return {name: _lasting(file)}
    found: Content = {}
    for line in file.read_bytes().splitlines():
        with contextlib.suppress(ValueError):
            found[f"{name}/{json.dumps(_untimed(json.loads(line)), sort_keys=True)}"] = b""
    return found


def leftovers(home: Path) -> list[str]:
    """Hidden files and folders, the outermost ones."""
    found = [item for item in sorted(home.rglob("*")) if item.name.startswith(".")]
    return [str(item.relative_to(home)) for item in found if not _hidden(item.parent, home)]


def state(found: Content, old: Content, new: Content, parts: str = "") -> str:
    """What a result is.

    Args:
        found: What is there.
        old: The result before.
        new: The result of an undisturbed run.
        parts: Pattern of files that may be there before the others are; each must be right alone.
    """
    if found == new:
        return SAME if found == old else NEW
    if found == old:
        return OLD if found else NONE
    kept, rest = split(found, parts)
    right = all(data in (old.get(name), new.get(name)) for name, data in kept.items())
    # What was finished before must not be lost, neither parts nor the rest.
    right = right and split(old, parts)[0].keys() <= kept.keys()
    return (
        PART if right and kept and rest in (split(old, parts)[1], split(new, parts)[1]) else WRONG
    )


def split(found: Content, parts: str) -> tuple[Content, Content]:
    """Files that are finished one by one, and the others.

    Args:
        found: All files.
        parts: Pattern of the former; there are none without it.
    """
    kept = {name for name in found if parts and re.fullmatch(parts, name)}
    return (
        {name: data for name, data in found.items() if name in kept},
        {name: data for name, data in found.items() if name not in kept},
    )


def _hidden(path: Path, home: Path | None = None) -> bool:
    names: Iterable[str] = (path.relative_to(home) if home else path).parts
    return any(name.startswith(".") for name in names)


def _lasting(file: Path) -> bytes:
    """Bytes of a file without the times that a run took."""
    if file.suffix == ".json":
        return json.dumps(_untimed(json.loads(file.read_bytes())), sort_keys=True).encode()
    if file.suffix == ".npz":
        with np.load(file, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in sorted(stored)}
        document = _untimed(json.loads(str(arrays.pop("document"))))
        words = [f"{name} {item.dtype} {item.shape} {item.tobytes().hex()}"
                 for name, item in arrays.items()]  # fmt: skip
        return "\n".join([json.dumps(document, sort_keys=True), *words]).encode()
    return file.read_bytes()


def _untimed(item: Any) -> Any:
    if isinstance(item, dict):
        return {key: _untimed(value) for key, value in item.items() if key not in _TIMES}
    return [_untimed(value) for value in item] if isinstance(item, list) else item

"""What an answer to bad input has to look like."""

from __future__ import annotations

import contextlib
import io
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from programs import main

from nipper_pin import NipperError

_T = TypeVar("_T")


def answer(arguments: Sequence[str]) -> tuple[int, str, str]:
    """Status, stdout and stderr of a command run in this process; tracebacks come through."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            status = main(list(arguments))
        except SystemExit as leaving:
            status = int(leaving.code or 0)
    return status, out.getvalue(), err.getvalue()


def assert_clear(arguments: Sequence[str], *allowed: int) -> int:
    """A command ends with an allowed status; if it fails, by one sentence and nothing else."""
    status, out, err = answer(arguments)
    assert status in (allowed or (0, 1, 2)), (status, err)
    if status:
        assert out == ""
        assert err.strip()
        assert "Traceback" not in err
        if "usage:" not in err:
            assert err.startswith("nipper-pin: ")
            assert err.count("\n") == 1, err
    return status


def one_line(read: Callable[..., _T], *arguments: object) -> _T | NipperError:
    """What a reader gives, or its refusal, which has to be one line; other errors come through."""
    try:
        return read(*arguments)
    except NipperError as error:
        refusal = error
    assert refusal.message.strip()
    assert len(refusal.message.splitlines()) == 1
    return refusal


def taken(use: Callable[[], object]) -> bool:
    """Whether an input was taken; refused it may be by one line alone."""
    return not isinstance(one_line(use), NipperError)


def stored_run(file: Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """The document of a saved run, and its arrays."""
    with np.load(file) as stored:
        arrays = {name: stored[name] for name in stored.files}
    return json.loads(str(arrays.pop("document"))), arrays


def packed(document: Any, arrays: dict[str, np.ndarray]) -> bytes:
    """A saved run of these."""
    stream = io.BytesIO()
    np.savez(stream, document=np.array(json.dumps(document)), **arrays)  # type: ignore[arg-type]
    return stream.getvalue()


def files(folder: Path) -> dict[str, bytes]:
    """Everything below a folder."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }

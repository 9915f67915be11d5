"""Compilation with numba, and validity of its cache."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TypeVar, cast

import numba

from ... import tolerances

_Function = TypeVar("_Function", bound=Callable[..., object])


def compiled(function: _Function) -> _Function:
    """Compile a function to machine code at its first call, cached on disk.

    IEEE arithmetic in the order of the source: no fast-math, so a case gives the same bits alone
    and in a batch.
    """
    wrapped = numba.njit(cache=True, error_model="numpy")(function)
    if getattr(wrapped, "stats", None) is not None:
        _folders.add(Path(str(wrapped.stats.cache_path)))
    return cast("_Function", wrapped)


_folders: set[Path] = set()
# Compiled functions hold the values of its constants.
_TOLERANCES = Path(tolerances.__file__).parent


def forget_stale(file: str) -> None:
    """Remove cached machine code that is older than a file of this folder or the tolerances.

    The cache of numba compares only the file of a function, not the files of the functions and
    constants that are compiled into it.

    Args:
        file: The source file whose code includes that of others.
    """
    source = Path(file)
    with suppress(OSError):
        sources = (*source.parent.glob("*.py"), *_TOLERANCES.glob("*.py"))
        newest = max(other.stat().st_mtime_ns for other in sources)
        for folder in _folders:
            for kept in folder.glob(f"{source.stem}.*.nb[ic]"):
                if kept.stat().st_mtime_ns < newest:
                    kept.unlink(missing_ok=True)

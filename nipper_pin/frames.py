"""Columns as a data frame of an installed library; none of them is a dependency."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from numpy.typing import NDArray

from .errors import InputError

Column = Sequence[Any] | NDArray[Any]
"""Values of a column: numbers as an array, all else as a list."""

_CONSTRUCTORS = {"pandas": "DataFrame", "polars": "DataFrame", "pyarrow": "table"}


def data_frame(columns: Mapping[str, Column], library: str | None = None) -> Any:
    """Make a data frame.

    Args:
        columns: Values by name, all of one length: arrays of numbers, or lists.
        library: "pandas", "polars" or "pyarrow"; by default the first of them that is installed.
            A table of pyarrow is taken by every library of frames (``__dataframe__`` and
            ``__arrow_c_stream__``).

    Raises:
        InputError: There is no such library, or it is not installed.
    """
    known = ", ".join(_CONSTRUCTORS)
    if library is not None and library not in _CONSTRUCTORS:
        message = f"to_frame: library = {library!r} cannot be used: {known}"
        raise InputError(message, library=library)
    wanted = tuple(_CONSTRUCTORS) if library is None else (library,)
    name = next((item for item in wanted if find_spec(item) is not None), None)
    if name is None:
        missing = known if library is None else library
        message = (
            f"to_frame needs a library of data frames, and {missing} is not installed: "
            f"pip install {library or 'pandas'}"
        )
        raise InputError(message, library=library)
    return getattr(import_module(name), _CONSTRUCTORS[name])(dict(columns))

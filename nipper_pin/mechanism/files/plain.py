"""Data with numbers and lists of Python in place of those of numpy, which print otherwise."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from numbers import Real
from typing import Any, TypeVar

import numpy as np

_T = TypeVar("_T")


def plain(data: _T) -> _T:
    """The same data, its numbers and arrays being those of Python.

    Args:
        data: Dataclasses, tables, lists, texts and numbers of any kind, in one another.
    """
    return _plain(data)  # type: ignore[no-any-return]


def _plain(data: Any) -> Any:
    if dataclasses.is_dataclass(data) and not isinstance(data, type):
        fields = {item.name: getattr(data, item.name) for item in dataclasses.fields(data)}
        return type(data)(**{name: _plain(value) for name, value in fields.items()})
    if isinstance(data, np.generic) or (isinstance(data, np.ndarray) and not data.ndim):
        return data.item()
    if isinstance(data, np.ndarray):
        # Places are members of sets.
        return tuple(_plain(value) for value in data)
    if isinstance(data, Mapping):
        return {str(key): _plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return type(data)(_plain(value) for value in data)
    if isinstance(data, Real) and not isinstance(data, int | float):
        return float(data)
    return data

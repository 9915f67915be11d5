"""Documents with one thing in them replaced or removed."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

from hypothesis import strategies as st

SCALARS = st.one_of(
    st.none(), st.booleans(), st.floats(), st.integers(-(10**30), 10**30), st.text(max_size=8),
    st.sampled_from([0, -0.0, 1e308, 5e-324, 2**70, "jaw", "steeve", "e62"]),
)  # fmt: skip
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=6), inner, max_size=3)
    ),
    max_leaves=5,
)
GONE = object()


def places(value: object, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Paths of everything inside a document."""
    if path:
        yield path
    items = value.items() if isinstance(value, dict) else ()
    for step, item in enumerate(value) if isinstance(value, list) else items:
        yield from places(item, (*path, step))


def holder(document: Any, path: tuple[Any, ...]) -> Any:
    """What holds the thing at a path."""
    for step in path[:-1]:
        document = document[step]
    return document


def changed(document: Any, path: tuple[Any, ...], value: object) -> Any:
    """The document with another value at a path, or without it."""
    document = copy.deepcopy(document)
    if value is GONE:
        del holder(document, path)[path[-1]]
    else:
        holder(document, path)[path[-1]] = value
    return document

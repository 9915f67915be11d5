"""Tables that a model file names by ``law``: those of the package, and those that users add."""

from __future__ import annotations

import functools
import operator
from collections.abc import Sequence
from typing import Any, Generic, TypeVar

from ...errors import InputError
from .toml_types import TomlTable

GROUP = "nipper_pin.extensions"
"""Entry points of installed packages; each names a module that registers laws when imported."""

_T = TypeVar("_T", bound=TomlTable)


class Register(Generic[_T]):
    """Tables of one section of a model file.

    Args:
        noun: What they describe, for messages.
        base: Class that each is derived from.
        built_in: Those of this package.
    """

    def __init__(self, noun: str, base: type[_T], built_in: Sequence[type[_T]]) -> None:
        """Begin with those of the package."""
        self._noun, self._base = noun, base
        self._tables = {str(kind.__struct_config__.tag): kind for kind in built_in}

    def add(self, kind: type[_T]) -> None:
        """Let model files name a table.

        Raises:
            InputError: It is no such table, or its name belongs to another one.
        """
        tag = getattr(getattr(kind, "__struct_config__", None), "tag", None)
        if not (isinstance(kind, type) and issubclass(kind, self._base) and tag):
            message = (
                f"{kind!r} is no table of a {self._noun}: derive it from {self._base.__name__} "
                'with frozen=True, kw_only=True and tag="name_of_the_law"'
            )
            raise InputError(message, kind=kind)
        other = self._tables.get(tag)
        if other is not None and (other.__module__, other.__qualname__) != (
            kind.__module__,
            kind.__qualname__,
        ):
            message = (
                f"a {self._noun} {tag!r} exists already ({other.__name__}); choose another tag"
            )
            raise InputError(message, tag=tag)
        self._tables[tag] = kind

    def known(self) -> dict[str, type[_T]]:
        """Return all tables by the name that a model file gives as ``law``."""
        return dict(self._tables)

    def union(self, wanted: object = None) -> Any:
        """Return the type of an entry, for reading a model file.

        Args:
            wanted: Name of a law; for one that is not known installed extensions are imported.

        Raises:
            InputError: An extension cannot be imported.
        """
        if isinstance(wanted, str) and wanted not in self._tables:
            _import_extensions()
        return functools.reduce(operator.or_, self._tables.values())


@functools.cache
def _import_extensions() -> None:
    """Import the modules that installed packages name as extensions, once a process."""
    # It brings archives and more, and few programs meet a law that is not there.
    from importlib.metadata import entry_points

    for point in entry_points(group=GROUP):
        try:
            point.load()
        except Exception as error:
            message = (
                f"extension {point.name!r} ({point.value}) cannot be imported: {error}; mend or "
                "remove the package that brings it"
            )
            raise InputError(message, extension=point.name) from error

"""Tables that a model file names by ``law``: those of the package, and those that users add.

A law of the package is a module of its room, of the same name as the law. It is imported when a
file names it.
"""

from __future__ import annotations

import functools
import pkgutil
from collections.abc import Callable
from importlib import import_module
from typing import Any, Generic, TypeVar

from ...errors import InputError
from .description import TomlTable
from .law_tables import DriveTable, ForceTable, RestitutionTable, StopTable

GROUP = "nipper_pin.extensions"
"""Entry points of installed packages; each names a module that registers laws when imported."""

_MECHANISM = __package__.rpartition(".")[0]
_T = TypeVar("_T", bound=type[TomlTable])


class Register(Generic[_T]):
    """Tables of one kind.

    Args:
        noun: What they describe, for messages.
        room: Folder of the modules beside this one's.
        base: The class that each is derived from.
    """

    def __init__(self, noun: str, room: str, base: type[TomlTable]) -> None:
        """Start empty: laws of the package are imported when a model names them."""
        self._noun, self._room, self._base = noun, f"{_MECHANISM}.{room}", base
        self._added: dict[str, type[TomlTable]] = {}

    def add(self, kind: _T) -> _T:
        """Register a table under the name of its law.

        Returns:
            The same class, so that this is a decorator.

        Raises:
            InputError: It is no such table, or its name, or that of its law, belongs to another
                one.
        """
        tag = getattr(getattr(kind, "__struct_config__", None), "tag", None)
        if not (isinstance(kind, type) and issubclass(kind, self._base) and isinstance(tag, str)):
            message = (
                f"{kind!r} is no table of a {self._noun}: derive it from {self._base.__name__} "
                'with frozen=True, kw_only=True and tag="name_of_the_law"'
            )
            raise InputError(message, kind=kind)
        other = self._table(tag)
        if other is not None and _place(other) != _place(kind):
            message = (
                f"a {self._noun} {tag!r} exists already ({other.__name__}); choose another tag"
            )
            raise InputError(message, tag=tag)
        _need_own_name(kind)
        self._added[tag] = kind
        return kind

    def names(self) -> list[str]:
        """Return the names of all laws, sorted."""
        return sorted({*self._built_in, *self._added})

    def tables(self) -> dict[str, Any]:
        """Return the tables of all laws by name."""
        return {name: self._table(name) for name in self.names()}

    def kind(self, wanted: object) -> Any:
        """Return the table of a law for reading a model file; None if there is none.

        Raises:
            InputError: An installed extension cannot be imported.
        """
        name = wanted if isinstance(wanted, str) else ""
        found = self._table(name)
        if found is None and name:
            _import_extensions()
            found = self._table(name)
        return found

    @functools.cached_property
    def _built_in(self) -> set[str]:
        return {item.name for item in pkgutil.iter_modules(import_module(self._room).__path__)}

    def _table(self, name: str) -> type[TomlTable] | None:
        """The table of a law; None if there is none."""
        if name in self._added:
            return self._added[name]
        if name not in self._built_in:
            return None
        module = import_module(f"{self._room}.{name}")
        return next(
            item
            for item in vars(module).values()
            if isinstance(item, type)
            and issubclass(item, TomlTable)
            and item.__struct_config__.tag == name
        )


def _need_own_name(kind: type[TomlTable]) -> None:
    """Refuse a class of the name of another table: the schema of model files goes by these."""
    from . import description

    tables = [*vars(description).values()]
    for register in (DRIVES, FORCES, RESTITUTIONS, STOPS):
        tables += register.tables().values()
    for other in tables:
        if not (isinstance(other, type) and issubclass(other, TomlTable)):
            continue
        if other.__name__ == kind.__name__ and _place(other) != _place(kind):
            message = (
                f"a class {kind.__name__} exists already among the tables of model files "
                f"({other.__module__}); give this one a name of its own"
            )
            raise InputError(message, kind=kind)


def _place(kind: type) -> tuple[str, str]:
    return kind.__module__, kind.__qualname__


@functools.cache
def _import_extensions() -> None:
    """Import the modules that installed packages name as extensions, once a process."""
    # importlib.metadata is slow to import, and only an unknown law needs it.
    from importlib.metadata import entry_points

    for point in entry_points(group=GROUP):
        load: Callable[[], object] = point.load
        try:
            load()
        except Exception as error:
            message = (
                f"extension {point.name!r} ({point.value}) cannot be imported: {error}; mend or "
                "remove the package that brings it"
            )
            raise InputError(message, extension=point.name) from error


DRIVES: Register[Any] = Register("drive law", "drives", DriveTable)
"""Drive laws."""
FORCES: Register[Any] = Register("force law", "forces", ForceTable)
"""Force laws."""
RESTITUTIONS: Register[Any] = Register("restitution law", "restitution", RestitutionTable)
"""Restitution laws."""
STOPS: Register[Any] = Register("law of a stop's place", "stops", StopTable)
"""Adjustable stops."""
register_drive, register_force = DRIVES.add, FORCES.add
register_restitution, register_stop = RESTITUTIONS.add, STOPS.add

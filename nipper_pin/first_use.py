"""Public names of a package whose modules are imported when a name is first asked for (PEP 562)."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module


def at_first_use(package: str, places: Mapping[str, Iterable[str]]) -> Callable[[str], object]:
    """Return the ``__getattr__`` of a package.

    Args:
        package: Its ``__name__``.
        places: Names by the module that they are in, as behind the dot of ``from .module import``.
    """
    place_of = {name: place for place, names in places.items() for name in names}

    def imported(name: str) -> object:
        if name not in place_of:
            message = f"module {package!r} has no attribute {name!r}"
            raise AttributeError(message)
        value: object = getattr(import_module(f".{place_of[name]}", package), name)
        setattr(sys.modules[package], name, value)
        return value

    return imported

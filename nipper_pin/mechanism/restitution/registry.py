"""Restitution laws that a model file may name: those of the package, and those that a user adds."""

from __future__ import annotations

from typing import TypeVar

from ..files.register import Register
from .falling import FallingRestitution
from .tables import RestitutionTable

BuiltInRestitution = FallingRestitution
"""Tables of the laws of this package."""

RESTITUTIONS: Register[RestitutionTable] = Register(
    "restitution law", RestitutionTable, [FallingRestitution]
)
"""All that are known."""

_T = TypeVar("_T", bound=type[RestitutionTable])


def register_restitution(kind: _T) -> _T:
    """Let model files name a restitution law of the user's; a decorator of its table.

    A worker process of a study knows the law only if it imports the module that registers it, as
    it does with an installed package that has an entry point ``nipper_pin.extensions``.

    Args:
        kind: Subclass of :class:`.law.RestitutionTable` with ``tag="name_of_the_law"``.

    Returns:
        The same class.

    Raises:
        InputError: It is no such class, or its name belongs to another law.
    """
    RESTITUTIONS.add(kind)
    return kind

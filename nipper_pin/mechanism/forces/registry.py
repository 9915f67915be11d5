"""Force laws that a model file may name: those of the package, and those that a user adds."""

from __future__ import annotations

from typing import TypeVar

from ..files.register import Register
from .orifice import OrificeForce
from .tables import ForceTable

BuiltInForce = OrificeForce
"""Tables of the laws of this package."""

FORCES: Register[ForceTable] = Register("force law", ForceTable, [OrificeForce])
"""All that are known."""

_T = TypeVar("_T", bound=type[ForceTable])


def register_force(kind: _T) -> _T:
    """Let model files name a force law of the user's; a decorator of its table.

    A worker process of a study knows the law only if it imports the module that registers it, as
    it does with an installed package that has an entry point ``nipper_pin.extensions``.

    Args:
        kind: Subclass of :class:`.law.ForceTable` with ``tag="name_of_the_law"``.

    Returns:
        The same class.

    Raises:
        InputError: It is no such class, or its name belongs to another law.
    """
    FORCES.add(kind)
    return kind

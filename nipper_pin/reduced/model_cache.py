"""Reduced models that are built once for a mechanism."""

from __future__ import annotations

from weakref import WeakKeyDictionary

from ..dynamics import DriveMode
from ..mechanism import Mechanism
from .model import ReducedModel
from .sampling import build

_KNOWN: WeakKeyDictionary[Mechanism, ReducedModel] = WeakKeyDictionary()


def reduced_model(mechanism: Mechanism, drive: DriveMode = DriveMode.HELD) -> ReducedModel:
    """Return the reduced model of a mechanism on its default domain, sampled at the first call.

    Mechanisms do not change and are known by identity: one with a single other number is another
    one, with tables of its own. A model lives as long as its mechanism.

    Args:
        drive: Behaviour of the driven shafts; only held ones can be reduced.

    Returns:
        What :func:`~nipper_pin.reduced.build` gives for it alone.

    Raises:
        InputError: The mechanism cannot be reduced, or not with these drives.
        SimulationError: A point of the domain cannot be reached or is singular.
    """
    known = _KNOWN.get(mechanism) if drive is DriveMode.HELD else None
    if known is None:
        known = _KNOWN[mechanism] = build(mechanism, drive=drive)
    return known

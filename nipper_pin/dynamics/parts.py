"""Parts of a machine that move on their own: an impact at one leaves the others alone."""

from __future__ import annotations

from collections.abc import Sequence
from weakref import WeakKeyDictionary

import numpy as np

from ..mechanism import Mechanism, Stop
from .system import System

_KNOWN: WeakKeyDictionary[Mechanism, dict[bool, list[int]]] = WeakKeyDictionary()


def apart(system: System, stops: Sequence[Stop]) -> list[list[Stop]]:
    """Stops in groups of one part each, in their order.

    Args:
        system: The system; parts that hang on held drives alone move on their own.
        stops: The stops.
    """
    if len(stops) < 2:
        return [list(stops)]
    part = parts(system)
    groups: dict[int, list[Stop]] = {}
    for stop in stops:
        groups.setdefault(part[stop.index], []).append(stop)
    return list(groups.values())


def parts(system: System) -> list[int]:
    """Number of the part that each coordinate belongs to.

    Coordinates are coupled by their mass matrix and by the closures that both move in, whatever the
    position is: one without any symmetry tells it.

    Args:
        system: The system.
    """
    known = _KNOWN.setdefault(system.mechanism, {})
    if system.held not in known:
        known[system.held] = _parts(system)
    return known[system.held]


def _parts(system: System) -> list[int]:
    body = system.body
    q = np.sin(np.arange(1.0, body.nv + 1.0))
    rows = np.abs(body.closures(q[None])[1][0])
    coupled = np.abs(body.mass_matrix(q)) + rows.T @ rows > 0.0
    held = list(system.held_coordinates)
    coupled[held] = coupled[:, held] = False
    found = np.arange(body.nv)
    for row in coupled:
        # All that one coordinate is coupled with becomes one part.
        joined = np.isin(found, found[row])
        found[joined] = found[joined].min(initial=body.nv)
    return [int(number) for number in found]

"""Parts of a machine that do not touch one another: which stops have to do with one another.

Two coordinates belong to one part if a link, a closure or a strut moves with both. What is driven
by a held shaft moves whatever the others do, and connects nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from weakref import WeakKeyDictionary

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ..mechanism import Mechanism
from ..mechanism.build.placements import supports

_KNOWN: WeakKeyDictionary[Mechanism, dict[bool, Mapping[str, frozenset[str]]]]
_KNOWN = WeakKeyDictionary()
_NUMBERS: WeakKeyDictionary[Mechanism, dict[bool, NDArray[np.intp]]] = WeakKeyDictionary()


def coupled_stops(mechanism: Mechanism, held: bool) -> Mapping[str, frozenset[str]]:
    """Names of the stops in the part of each stop, itself among them, by its name.

    Args:
        mechanism: The mechanism.
        held: True if the driven shafts are held, False if they have their inertia.
    """
    known = _KNOWN.setdefault(mechanism, {})
    if held not in known:
        part = parts(mechanism, held).tolist()
        stops: dict[int, set[str]] = {}
        for stop in mechanism.stops:
            stops.setdefault(part[stop.index], set()).add(stop.name)
        names = {place: frozenset(found) for place, found in stops.items()}
        known[held] = {stop.name: names[part[stop.index]] for stop in mechanism.stops}
    return known[held]


def parts(mechanism: Mechanism, held: bool) -> NDArray[np.intp]:
    """Number of the part of each coordinate, shape (nv,); arguments as :func:`coupled_stops`."""
    known = _NUMBERS.setdefault(mechanism, {})
    if held not in known:
        driven = {drive.index for drive in mechanism.drives} if held else set()
        known[held] = np.array(_parts(mechanism, driven), dtype=np.intp)
    return known[held]


def _parts(mechanism: Mechanism, held: set[int]) -> list[int]:
    """Number of the part of each coordinate."""
    model = mechanism.model
    part = list(range(int(model.nv)))

    def movers(joint: int) -> list[int]:
        columns = (int(model.joints[j].idx_v) for j in supports(model, joint))
        return [column for column in columns if column not in held]

    def join(columns: Iterable[int]) -> None:
        joined = {part[column] for column in columns}
        for column, own in enumerate(part):
            if own in joined:
                part[column] = min(joined)

    for joint in range(1, model.njoints):
        join(movers(joint))
    for item in (*mechanism.closures, *mechanism.struts):
        ends = (model.getFrameId(name, pin.FrameType.BODY) for name in (item.frame_a, item.frame_b))
        join(column for end in ends for column in movers(model.frames[end].parentJoint))
    return part

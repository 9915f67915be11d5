"""Parts of a machine that do not touch one another: an impact at one leaves the others alone.

Two coordinates belong to one part if a link, a closure, a coupling or a strut moves with both. What
is driven by a held shaft moves whatever the others do, and connects nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ..made_once import made_once
from ..mechanism import Mechanism, supports


class Parts(NamedTuple):
    """The parts of a machine.

    Attributes:
        number: Number of the part of each coordinate, shape (nv,); held shafts have their own.
        members: Coordinates of each part, those of held shafts that move it among them, by number.
        stops: Names of the stops in the part of each stop, itself among them, by its name.
        whole: True if all stops are in one part, as in most machines.
    """

    number: NDArray[np.intp]
    members: Mapping[int, NDArray[np.intp]]
    stops: Mapping[str, frozenset[str]]
    whole: bool


@made_once
def parts(mechanism: Mechanism, held: bool) -> Parts:
    """Find the parts of a machine.

    Args:
        held: True if the driven shafts are held, False if they have their inertia.
    """
    driven = {drive.index for drive in mechanism.drives} if held else set[int]()
    number, members = _parts(mechanism, driven)
    groups: dict[int, set[str]] = {}
    for stop in mechanism.stops:
        groups.setdefault(number[stop.index], set()).add(stop.name)
    names = {place: frozenset(group) for place, group in groups.items()}
    stops = {stop.name: names[number[stop.index]] for stop in mechanism.stops}
    return Parts(np.array(number, dtype=np.intp), members, stops, len(groups) < 2)


def _parts(mechanism: Mechanism, held: set[int]) -> tuple[list[int], dict[int, NDArray[np.intp]]]:
    model = mechanism.model
    part = list(range(int(model.nv)))
    moved: list[tuple[int, int]] = []

    def movers(joint: int) -> list[int]:
        return [int(model.joints[j].idx_v) for j in supports(model, joint)]

    def join(columns: Iterable[int]) -> None:
        together = set(columns)
        moved.extend((min(together - held), shaft) for shaft in together & held if together - held)
        joined = {part[column] for column in together - held}
        for column, own in enumerate(part):
            if own in joined:
                part[column] = min(joined)

    for joint in range(1, model.njoints):
        join(movers(joint))
    for coupling in mechanism.couplings:
        join((coupling.index, coupling.of))
    pairs = [(item.frame_a, item.frame_b) for item in mechanism.closures]
    pairs += [(item.frame_a, item.frame_b) for item in mechanism.struts]
    for pair in pairs:
        ends = (model.getFrameId(name, pin.FrameType.BODY) for name in pair)
        join(column for end in ends for column in movers(model.frames[end].parentJoint))
    members: dict[int, set[int]] = {}
    for column, shaft in [*enumerate(range(len(part))), *moved]:
        members.setdefault(part[column], set()).add(shaft)
    return part, {item: np.array(sorted(own), dtype=np.intp) for item, own in members.items()}

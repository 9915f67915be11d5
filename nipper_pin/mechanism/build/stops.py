"""Stops of a mechanism and starts of its joints: places, restitutions, contacts, checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ...errors import ModelError, looked_up
from ...units import M_PER_MM, RAD_PER_DEG, coordinate_text
from ..files.description import Description, InitialDescription, StopDescription
from ..files.law_tables import built
from ..parts import Drive, Joint, Start, Stop
from .contact import find_contact
from .tree import Tree

_MOST_CONTACTS = 100
# Keys of place and rate by the kind of joint, with their factors to SI units.
_KEYS = {
    "prismatic": (("at_mm", M_PER_MM), ("rate_mm_per_s", M_PER_MM)),
    "revolute": (("at_deg", RAD_PER_DEG), ("rate_rad_per_s", 1.0)),
}


def build_stops(
    description: Description, joints: Mapping[str, Joint], tree: Tree
) -> tuple[Stop, ...]:
    """Build the stops."""
    touching = sum(stop.contact is not None for stop in description.stops.values())
    if touching > _MOST_CONTACTS:
        allowed = f"at most {_MOST_CONTACTS} stops with a contact; leave it out where none is shown"
        raise ModelError(file=tree.file, key="stops", value=f"{touching} contacts", allowed=allowed)
    stops: list[Stop] = []
    driven = {drive.joint for drive in description.drives.values()}
    for name, stop in description.stops.items():
        key = f"stops.{name}.joint"
        joint = looked_up("joint", stop.joint, joints, f"{tree.file}: {key}")
        if stop.joint in driven:
            allowed = "a joint without a drive"
            raise ModelError(file=tree.file, key=key, value=stop.joint, allowed=allowed)
        found = _stop(name, stop, joint, tree)
        others = [item for item in stops if item.index == joint.index]
        _check_opposite(found, others, joint, tree.file)
        stops.append(found)
    _check_transition(description, tree.file)
    return tuple(stops)


def _stop(name: str, stop: StopDescription, joint: Joint, tree: Tree) -> Stop:
    """One stop, with the contact of its bodies."""
    law, table = None, stop.restitution_law
    if table is not None:
        where = f"stops.{name}.restitution_law"
        law = built(table.build, joint.kind, table, where, tree.file)
    found = Stop(
        name=name,
        index=joint.index,
        restitution=stop.restitution,
        contact=None,
        sense=1.0 if stop.side == "lower" else -1.0,
        at=_stop_place(name, stop, joint, tree.file),
        law=law,
    )
    if stop.contact is None:
        return found
    return replace(found, contact=find_contact(stop.contact, found, tree))


def _check_transition(description: Description, file: str) -> None:
    """The stop whose bouncing is the transition is one of the stops."""
    known, name = description.stops, description.transition_stop
    if known and not name:
        names = " or ".join(f'"{stop}"' for stop in known)
        allowed = (
            f"the file has the stop{'' if len(known) == 1 else 's'} {', '.join(known)}; write "
            f"transition_stop = {names} above the first table: the stop whose bouncing is the "
            "transition"
        )
        raise ModelError(file=file, key="transition_stop", value=None, allowed=allowed)
    if known:
        looked_up("stop", name, known, f"{file}: transition_stop")


def _stop_place(name: str, stop: StopDescription, joint: Joint, file: str) -> float:
    """Coordinate at which a stop is closed [rad or m]."""
    key, scale = _KEYS[joint.kind][0]
    for (other, _), _ in _KEYS.values():
        value = getattr(stop, other)
        if other != key and value is not None:
            allowed = f"the place of a stop on the {joint.kind} joint {joint.name} is {key}"
            raise ModelError(file=file, key=f"stops.{name}.{other}", value=value, allowed=allowed)
    if stop.adjusted is None:
        return scale * (getattr(stop, key) or 0.0)
    where = f"stops.{name}.adjusted"
    if getattr(stop, key) is not None:
        allowed = f"either {key} or adjusted: a stop has one place"
        raise ModelError(
            file=file, key=f"stops.{name}.{key}", value=getattr(stop, key), allowed=allowed
        )
    place: float = built(stop.adjusted.place, joint.kind, stop.adjusted, where, file)
    return place


def _check_opposite(stop: Stop, others: Sequence[Stop], joint: Joint, file: str) -> None:
    """A joint has room between two stops, the lower one below the upper one."""
    for other in others:
        allowed = ""
        if other.sense == stop.sense:
            allowed = (
                f"one lower and one upper stop on a joint; {other.name!r} is on this side of "
                f"{joint.name} already"
            )
        elif stop.sense * (other.at - stop.at) <= 0.0:
            allowed = (
                f"the lower stop below the upper one: {joint.name} has no room to move between "
                f"{stop.name!r} and {other.name!r}"
            )
        if allowed:
            raise ModelError(
                file=file,
                key=f"stops.{stop.name}",
                value=f"{'lower' if stop.sense > 0.0 else 'upper'} stop at "
                f"{coordinate_text(stop.at, joint.kind)}",
                allowed=allowed,
            )


def build_starts(
    initial: Mapping[str, InitialDescription],
    joints: Mapping[str, Joint],
    drives: Sequence[Drive],
    stops: Sequence[Stop],
    file: str,
) -> tuple[Start, ...]:
    """Check and convert the starts of a model file.

    Raises:
        UnknownNameError: There is no such joint.
        ModelError: A drive moves it, the keys are those of the other kind of joint, or it would
            start beyond a stop.
    """
    found = []
    for name, entry in initial.items():
        where = f"initial.{name}"
        joint = looked_up("joint", name, joints, f"{file}: initial")
        driven = next((item.name for item in drives if item.index == joint.index), None)
        if driven is not None:
            allowed = f"a joint without a drive; drive {driven} says where {name} starts"
            value = getattr(entry, _KEYS[joint.kind][0][0])
            raise ModelError(file=file, key=where, value=value, allowed=allowed)
        (at, scale), (rate, rate_scale) = _KEYS[joint.kind]
        for key in entry.__struct_fields__:
            value = getattr(entry, key)
            if value is not None and key not in (at, rate):
                allowed = f"the {joint.kind} joint {name} starts with {at} and {rate}"
                raise ModelError(file=file, key=f"{where}.{key}", value=value, allowed=allowed)
        place, speed = getattr(entry, at) or 0.0, getattr(entry, rate) or 0.0
        start = Start(joint=name, index=joint.index, at=scale * place, rate=rate_scale * speed)
        for stop in stops:
            beyond = -stop.sense * (start.at - stop.at)
            if stop.index == joint.index and beyond > 0.0:
                allowed = (
                    f"a place that stop {stop.name} leaves open; this is {beyond / scale:.6g} "
                    f"{at.partition('_')[2]} beyond it"
                )
                raise ModelError(file=file, key=f"{where}.{at}", value=place, allowed=allowed)
        found.append(start)
    return tuple(found)

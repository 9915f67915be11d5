"""Starts of joints that nothing prescribes, from the model file, checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...errors import ModelError, UnknownNameError
from ...units import M_PER_MM, RAD_PER_DEG
from ..files.description import InitialDescription
from ..parts import Drive, Joint, Start, Stop

_KEYS = {
    "prismatic": (("at_mm", M_PER_MM), ("rate_mm_per_s", M_PER_MM)),
    "revolute": (("at_deg", RAD_PER_DEG), ("rate_rad_per_s", 1.0)),
}


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
        if name not in joints:
            raise UnknownNameError(kind="joint", name=name, known=joints, where=f"{file}: initial")
        joint = joints[name]
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

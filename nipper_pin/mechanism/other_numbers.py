"""A mechanism with other numbers: what they do not touch is kept, with all that was built of it."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping
from dataclasses import replace

from .elements import Damper, Strut
from .mechanism import Mechanism
from .parts import Spring, Stop


def retuned(
    mechanism: Mechanism,
    *,
    restitution: Mapping[str, float] | None = None,
    stiffness: Iterable[float] | None = None,
    preload: Iterable[float] | None = None,
) -> Mechanism:
    """The mechanism with other restitutions and linear springs; its description is not changed.

    Args:
        restitution: e_N of stops by their names; the others keep theirs.
        stiffness: Of its springs, in their order [N/m or N m/rad].
        preload: Deflections in them at zero [m or rad].
    """
    e_N, springs = restitution or {}, mechanism.springs
    rates = [spring.stiffness for spring in springs] if stiffness is None else stiffness
    bent = [spring.preload for spring in springs] if preload is None else preload
    return with_parts(
        mechanism,
        springs=tuple(
            replace(spring, stiffness=float(k), preload=float(p))
            for spring, k, p in zip(springs, rates, bent, strict=True)
        ),
        stops=tuple(
            replace(stop, restitution=e_N[stop.name]) if stop.name in e_N else stop
            for stop in mechanism.stops
        ),
    )


def with_parts(
    mechanism: Mechanism,
    *,
    springs: tuple[Spring, ...] | None = None,
    dampers: tuple[Damper, ...] | None = None,
    struts: tuple[Strut, ...] | None = None,
    stops: tuple[Stop, ...] | None = None,
    description: Mapping[str, object] | None = None,
) -> Mechanism:
    """The mechanism with other parts in the place of its own.

    Args:
        springs: As many as it has, on the same coordinates, and so on.
        struts: Between the same points.
        stops: In the same places, with other restitutions.
    """
    given = {
        "springs": springs,
        "dampers": dampers,
        "struts": struts,
        "stops": stops,
        "description": description,
    }
    # Looked up before the copy, which then has the same one, as all else that is known already.
    _ = mechanism.shared
    changed = copy.copy(mechanism)
    vars(changed).update({key: value for key, value in given.items() if value is not None})
    return changed

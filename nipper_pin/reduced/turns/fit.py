"""Which mechanisms have turns that the reduced engine can follow."""

from __future__ import annotations

from ...mechanism import Mechanism


def unfit_turns(mechanism: Mechanism) -> str | None:
    """Return why the turns of a mechanism with held drives cannot be reduced.

    Returns:
        One sentence, or None if they can be.
    """
    free = mechanism.degrees_of_freedom - len(mechanism.drives)
    if free != 1:
        return f"the reduced engine needs one degree of freedom in flight, and {free} are left"
    driven = {item.index for item in mechanism.drives}
    for stop in mechanism.stops:
        if stop.leader:
            return f"the reduced engine has one stop where {stop.leader} and {stop.name} close both"
        if stop.law is not None:
            return f"the reduced engine has constant restitutions, and stop {stop.name!r} has a law"
        if stop.index in driven:
            return f"stop {stop.name!r} is on a driven coordinate: it cannot bounce"
    law = next((f"{item.kind} {item.name!r}" for item in mechanism.forces), None)
    if law is not None:
        return f"the reduced engine has springs and linear dampers only, no {law}"
    return None

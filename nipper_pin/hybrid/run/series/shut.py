"""Stops that come to rest together, whatever the series that ends."""

from __future__ import annotations

from ....dynamics import System, arrest
from ....errors import ImpactError, SingularConfigurationError
from ...contact.complementarity import Closed, pressed
from ...state import State
from .struck import Rest


def shut_together(
    system: System, state: State, names: Closed, t: float, error: float
) -> Rest | None:
    """Bring stops to rest; None if one of them is not pressed shut then.

    Args:
        state: State just after the last collision.
        names: Names of the stops, open ones and closed ones of their parts.
        t: When they rest [s].
        error: Estimated error of that [s].
    """
    part, closed = system.coupled(names), names | state.closed
    try:
        shut = [stop for stop in system.constraint_set(closed).shut if stop.name in part]
        impact = arrest(system, state.q, state.v, state.jacobian, shut)
    except (ImpactError, SingularConfigurationError):
        # Stops that depend on one another through the closures do not rest together.
        return None
    for name in state.closed - part:
        # Round-off in a part that the impact does not reach.
        impact.v_after[system.mechanism.stop(name).index] = 0.0
    stay = pressed(system, state.motion, state.q, impact.v_after, state.jacobian, closed, names)
    return Rest(t, error, sorted(names - state.closed), impact, closed) if stay == closed else None

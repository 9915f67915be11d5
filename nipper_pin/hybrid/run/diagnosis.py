"""Time and place at which a run failed, and the condition of the closures there."""

from __future__ import annotations

import numpy as np

from ...dynamics import System, weakest
from ...errors import ConvergenceError, SimulationError, SingularConfigurationError
from ..state import State

# From this condition of the closures on, a dead centre is worth a word.
_NEAR = 1e3


def located(error: SimulationError, system: System, state: State | None = None) -> SimulationError:
    """The error with the place and the state of the closures there in words and as evidence.

    Args:
        error: The error; its evidence may hold the time ``t`` and the configuration ``q``.
        state: State that the run goes on from; None before there is one.

    Returns:
        An error of the same type. Evidence: what the error had, ``t``, ``index``,
        ``cylinder_angle_rad``, the ``closure`` that stays open and, with a configuration,
        ``condition`` and ``joints``.
    """
    evidence = dict(error.evidence)
    t = float(evidence.get("t", 0.0 if state is None else state.t))
    angle = float(system.shaft.angle(t))
    index = system.mechanism.cylinder.index_from_angle(angle)
    evidence |= {"t": t, "index": index, "cylinder_angle_rad": angle}
    place = f"after t = {t:.6g} s" if state is not None else "at the start"
    message = f"{place} (index {index:.3f}): {error.message}"
    if "row" in evidence:
        mechanism = system.mechanism
        rows = [item.name for item in mechanism.closures for _ in "xz"]
        rows += [item.name for item in mechanism.couplings]
        evidence["closure"] = rows[evidence.pop("row")]
        message += f"; widest open is closure {evidence['closure']!r}"
    q = evidence.get("q", None if state is None else state.q)
    if q is not None and isinstance(error, ConvergenceError | SingularConfigurationError):
        phase = system.constraint_set(state.closed) if state is not None else None
        given = (*system.held_coordinates, *(phase.stops if phase is not None else ()))
        _, jacobian = system.body.closures(np.reshape(q, (-1, system.body.nv))[:1])
        if np.isfinite(jacobian).all():
            condition, coordinates = weakest(jacobian[0] * system.body.units, given)
            names = [joint.name for joint in system.mechanism.joints if joint.index in coordinates]
            evidence |= {"condition": condition, "joints": names}
            if condition > _NEAR:
                message += f"; the closures have condition {condition:.2g}, by {', '.join(names)}"
    return type(error)(message, **evidence)

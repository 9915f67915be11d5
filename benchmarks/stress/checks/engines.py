"""Check that the two engines give the same transition."""

from __future__ import annotations

import numpy as np

from nipper_pin.errors import InputError
from nipper_pin.hybrid import Solution

from ...tolerances import AGREED, EPS
from .invariants import Violation


def engines_agree(direct: Solution, tolerance: float) -> list[Violation] | None:
    """A transition by the reduced engine, within the errors that both state; None if it refuses."""
    from nipper_pin.reduced import Status, build, transitions, unfit

    mechanism, case = direct.mechanism, direct.case
    if unfit(mechanism, case.drive) is not None:
        return None
    stop = mechanism.transition_stop
    try:
        model = build(mechanism)
    except InputError:
        return None
    batch = transitions(
        model,
        speed_rpm=np.array([case.speed_rpm]),
        restitution=np.array([mechanism.stop(stop).restitution]),
        stiffness=np.array([[spring.stiffness for spring in mechanism.springs]]),
        preload=np.array([[spring.preload for spring in mechanism.springs]]),
        rest_rate=case.rest_rate,
        tolerance=max(tolerance, 1e-12),
        max_collisions=case.max_collisions,
    )
    if Status(int(batch.status[0])) is not Status.AT_REST or not direct.transitions:
        return None
    found = direct.transitions[-1].duration
    last = direct.events[-1]
    stated = AGREED * (direct.errors[last.number - 1].time + float(batch.duration_error[0]))
    off = abs(found - float(batch.duration[0]))
    if off <= stated + 16.0 * EPS * (found + 1e-6 * direct.shaft.period):
        return []
    return [Violation("engines", f"durations differ by {off:.3g} s, stated {stated:.3g} s")]

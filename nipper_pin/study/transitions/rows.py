"""A transition of the direct engine as rows of a table."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...hybrid.result.rebound_errors import rebound_error
from ...reduced.kernels import layout as rows
from ..true_transition import TrueTransition


def collision_rows(transition: TrueTransition) -> FloatArray:
    """Collisions of the transition stop, shape (rows, collisions)."""
    hits, errors = transition.collisions, transition.errors
    found = np.full((rows.COLUMNS, len(hits)), np.nan)
    for i, (hit, error) in enumerate(zip(hits, errors, strict=True)):
        found[rows.TIME, i] = hit.t - hits[0].t
        found[rows.ANGLE, i] = hit.cylinder_angle
        found[rows.APPROACH, i] = hit.approach_rate
        found[rows.SEPARATION, i] = hit.separation_rate
        found[rows.IMPULSE, i] = hit.impulse
        found[rows.ENERGY, i] = hit.energy_lost
        found[rows.TIME_ERROR, i] = error.time
        found[rows.RATE_ERROR, i] = error.impulse * abs(hit.approach_rate)
        found[rows.IMPULSE_ERROR, i] = error.impulse * abs(hit.impulse)
        if hit.rebound_amplitude is None or hit.rebound_time is None:
            continue
        rebound = rebound_error(transition.solution, hit)
        found[rows.AMPLITUDE, i] = hit.rebound_amplitude
        found[rows.REBOUND, i] = hit.rebound_time
        found[rows.AMPLITUDE_ERROR, i] = rebound.amplitude
        found[rows.REBOUND_ERROR, i] = rebound.time
    return found


def rest_numbers(transition: TrueTransition) -> tuple[float, float, float]:
    """Duration, its stated error and the share of the first two rebounds; NaN without rest."""
    found, error = transition.transition, transition.duration_error
    if found is None or error is None:
        return np.nan, np.nan, np.nan
    share = np.nan if found.first_two_share is None else found.first_two_share
    return found.duration, error, share

"""Deviations after impulses that pass from contact to contact, linear in those before them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...arrays import FloatArray
from ...dynamics import System
from ...dynamics.strike import strike
from ...mechanism import Stop
from ...tolerances.hybrid import DIFFERENCE_STEP
from .freedoms import Freedoms
from .variational import tangents

# Strikes of one impact that are followed at its neighbours; more are a series without an end.
_MOST_STRIKES = 1000


def sequence_map(
    system: System,
    q: FloatArray,
    v: FloatArray,
    contacts: Sequence[Stop],
    pushed: Sequence[Stop],
) -> tuple[FloatArray, FloatArray]:
    """Derivative of an impact whose strikes follow one another, by differences of the whole.

    Args:
        q: Configuration, shape (nv,).
        v: Velocity before, shape (nv,).
        contacts: Stops in contact, all of one part of the machine.
        pushed: Those whose impulses are asked for.

    Returns:
        What :func:`.saltation.impact_map` returns.

    Raises:
        SingularConfigurationError: The closures do not determine the dependent coordinates.
        ImpactError: A neighbour has no impulses, or too many strikes.
    """

    def outcome(q: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        jacobian = system.body.closures(q[None])[1][0]
        impact = strike(system, q, v, jacobian, contacts, most=_MOST_STRIKES)
        return impact.v_after, np.array([impact.P_N[stop.name] for stop in pushed])

    nv = system.body.nv
    _, jacobian = system.body.closures(q[None])
    columns = tuple(stop.index for stop in contacts)
    split = system.split(jacobian[0], system.held_coordinates, columns)
    along = Freedoms.struck(system, split, contacts)
    units, turned = (part[:, 0] for part in tangents(system, q[None], v[None], split, along))
    after, impulses = outcome(q, v)
    whole, pushes = np.zeros((2 * nv, 2 * nv)), np.zeros((len(pushed), 2 * nv))
    step = DIFFERENCE_STEP * float(np.abs(v[along.members[0]]).max())
    for k, unit, turn in zip(along.columns, units, turned, strict=True):
        size = max(float(np.abs(unit).max()), 1.0)
        aside, quick = DIFFERENCE_STEP / size, step / size
        moved = outcome(q + aside * unit, v + aside * turn)
        faster = outcome(q, v + quick * unit)
        whole[:nv, k] = unit
        whole[nv:, k], pushes[:, k] = (moved[0] - after) / aside, (moved[1] - impulses) / aside
        whole[nv:, nv + k] = (faster[0] - after) / quick
        pushes[:, nv + k] = (faster[1] - impulses) / quick
    return whole, pushes

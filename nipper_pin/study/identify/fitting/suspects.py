"""Measurements in another than the documented unit, recognised by their factor."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ....arrays import FloatArray
from ....errors import NipperError
from ....mechanism import Mechanism
from ....units import DEG_PER_RAD, MM_PER_M, MRAD_PER_RAD, MS_PER_S, US_PER_S
from .objective import Objective

_FAR = 5.0
# A fit as close as this needs no other unit, wherever its numbers are.
_MET = 2.0
# A model that is right to this factor tells degrees from millimetres at the lips of a comber.
_NEAR = 1.25


def suspected_units(objective: Objective, z: FloatArray, predicted: FloatArray) -> tuple[str, ...]:
    """Return the quantities whose targets differ from the model by the factor of a unit.

    The values are compared at the model's own numbers: a fit may have gone to its bounds to come
    nearer to a wrong unit.

    Args:
        z: Unit coordinates of the fit, shape (free,).
        predicted: Values of the targets there, shape (targets,).

    Returns:
        A sentence for each such quantity.
    """
    mechanism = objective.mechanism(z)
    try:
        expected = objective.predicted(objective.start)
    except NipperError:
        expected = predicted
    factors: dict[str, list[tuple[float, float]]] = {}
    for target, *values in zip(objective.problem.targets, expected, predicted, strict=True):
        if all(values) and target.value:
            name = target.quantity if target.since is None else f"change of {target.quantity}"
            first, last = (target.value / value for value in values)
            factors.setdefault(name, []).append((first, last))
    found = []
    for name, pairs in factors.items():
        factor, left = (float(x) for x in np.median(pairs, axis=0))
        if _beyond(factor, _FAR) and _beyond(left, _MET):
            known = _units(name, mechanism)
            about = float(f"{abs(factor):.2g}")
            found.append(f"{name} is wanted about {about:g} times {_question(factor, known)}")
    return tuple(found)


def _beyond(factor: float, limit: float) -> bool:
    return not 1.0 / limit < factor < limit


def _question(factor: float, units: Mapping[str, float]) -> str:
    """The rest of the sentence: which unit explains a factor best."""
    if factor < 0.0:
        return "what the model gives, with the other sign: a closing rate is negative."
    off = {unit: abs(math.log(factor / size)) for unit, size in units.items()}
    nearest = min(off, key=lambda unit: off[unit], default=None)
    if nearest is not None and off[nearest] < math.log(_NEAR):
        return f"what the model gives: is it in {nearest}?"
    if nearest is not None and off[nearest] < math.log(_FAR):
        likely = [unit for unit in off if off[unit] < math.log(_FAR)]
        return f"what the model gives: is it in {' or '.join(likely)}?"
    return "what the model gives: look at its unit."


def _units(name: str, mechanism: Mechanism) -> dict[str, float]:
    """Common units by their factor to the documented unit."""
    if name.startswith("change of") or name.endswith("share"):
        return {"percent": 100.0}
    if "amplitude" in name or "rate" in name:
        stop = mechanism.stop(mechanism.transition_stop)
        kinds = {joint.index: joint.kind for joint in mechanism.joints}
        per = " a second" if "rate" in name else ""
        if kinds[stop.index] != "revolute":
            return {f"millimetres{per}": MM_PER_M}
        units = {f"degrees{per}": DEG_PER_RAD, f"milliradians{per}": MRAD_PER_RAD}
        if stop.contact is not None:
            units[f"metres at the contact point{per}"] = stop.lever
            units[f"millimetres at the contact point{per}"] = MM_PER_M * stop.lever
        return units
    return {"milliseconds": MS_PER_S, "microseconds": US_PER_S}

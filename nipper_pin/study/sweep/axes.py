"""Parameters of a sweep: where each is written, and which values it takes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...arrays import FloatArray
from ...errors import UnknownNameError
from ...mechanism import Mechanism
from ..cases import spring_numbers

SPEED = "speed_rpm"

Kind = Literal["speed", "restitution", "stiffness", "preload", "model"]


@dataclass(frozen=True, kw_only=True)
class Target:
    """What a parameter changes.

    Attributes:
        kind: A column of the transition table, or "model": a mechanism of its own.
        path: Path of the number in the model; ``speed_rpm`` for the speed.
        spring: Place of the spring (stiffness and preload).
        scale: SI value by value of the parameter.
    """

    kind: Kind
    path: str
    spring: int = 0
    scale: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Axis:
    """One parameter.

    Attributes:
        name: Its name in the study and in the table of results.
        target: What it changes.
        low: Least value, in the unit of the model's file.
        high: Largest value.
        scale: Spacing of grid points, or distribution of samples.
        values: Grid values; empty for a sampled parameter.
    """

    name: str
    target: Target
    low: float
    high: float
    scale: Literal["linear", "log"]
    values: tuple[float, ...]

    def sampled(self, unit: FloatArray) -> FloatArray:
        """Values of samples.

        Args:
            unit: Places in [0, 1), shape (n,).

        Returns:
            Values between the bounds, shape (n,).
        """
        if self.scale == "log":
            low, high = math.log(self.low), math.log(self.high)
            return np.asarray(np.clip(np.exp(low + (high - low) * unit), self.low, self.high))
        return np.asarray(np.clip(self.low + (self.high - self.low) * unit, self.low, self.high))


def restitution_path(stop: str) -> str:
    """Path of a stop's restitution in the model."""
    return f"stops.{stop}.restitution"


def find_target(name: str, mechanism: Mechanism, *, turns: bool = False) -> Target:
    """Find what a name of a parameter changes: the speed, a shortcut of the model, or a path.

    Args:
        mechanism: The mechanism with everything at its base values.
        turns: Whether whole turns are followed; of these, every stop's restitution is a column.

    Raises:
        UnknownNameError: It is none of these.
        ModelError: The path leads to something that is not one number.
    """
    if name == SPEED:
        return Target(kind="speed", path=SPEED)
    path = mechanism.shortcuts.get(name, name)
    if "." not in path:
        known = (SPEED, *mechanism.shortcuts, "a path into the model, such as links.LINK.mass_kg")
        raise UnknownNameError(kind="parameter", name=name, known=known, where=mechanism.name)
    bounce = [
        stop.name for stop in mechanism.stops if turns or stop.name == mechanism.transition_stop
    ]
    if path in (restitution_path(stop) for stop in bounce):
        return Target(kind="restitution", path=path)
    for own, kind, place, scale in spring_numbers(mechanism):
        if path == own:
            return Target(kind=kind, path=path, spring=place, scale=scale)
    return Target(kind="model", path=path)

"""A design problem as plain data: free numbers, aims and limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import msgspec
import numpy as np

from ....arrays import FloatArray
from ....mechanism import Mechanism, from_sources
from ....tolerances.study import ACTIVE_LIMIT
from ...sweep.axes import SPEED, Target


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """A free number.

    Attributes:
        name: Its name in the file: a path, a shortcut of the model, or ``speed_rpm``.
        target: What it changes.
        low: Lower bound, in the unit of the model's file.
        high: Upper bound.
        start: Value in the model; it may lie outside the bounds.
    """

    name: str
    target: Target
    low: float
    high: float
    start: float

    def bound(self, side: Literal["low", "high"]) -> str:
        """One of its bounds in words."""
        return str(Limit(quantity=self.name, side=side, value=getattr(self, side)))


@dataclass(frozen=True, kw_only=True)
class Limit:
    """One side of what a quantity must keep to.

    Attributes:
        quantity: Name of the quantity.
        side: "low" or "high".
        value: The limit, in the unit of the quantity.
    """

    quantity: str
    side: Literal["low", "high"]
    value: float

    def __str__(self) -> str:
        """The limit in words."""
        return f"{self.quantity} {'>=' if self.side == 'low' else '<='} {self.value:.6g}"


@dataclass(frozen=True, kw_only=True)
class Aim:
    """A quantity to minimise or maximise.

    Attributes:
        quantity: Name of the quantity.
        sense: +1.0 to minimise it, -1.0 to maximise it.
    """

    quantity: str
    sense: float

    def __str__(self) -> str:
        """The aim in words."""
        return f"{'minimise' if self.sense > 0.0 else 'maximise'} {self.quantity}"


@dataclass(frozen=True, kw_only=True)
class Problem:
    """A design problem.

    Attributes:
        title: What it is about.
        model: Name or folder of the model, as ``load`` takes it.
        changes: What is fixed, by path: overrides of the model.
        name: Name of the machine.
        urdf: Its URDF text with these changes, without visuals.
        document: Its TOML document likewise.
        folder: Folder that its meshes start from.
        parameters: Free numbers.
        aims: One, or two for a Pareto front.
        limits: What has to hold.
        units: Units of the quantities of aims and limits by name.
        rest_rate: Separation rate at which a transition ends; None: at its limit.
        tolerance: Relative accuracy of the transitions.
    """

    title: str
    model: str
    changes: Mapping[str, object]
    name: str
    urdf: str = field(repr=False)
    document: Mapping[str, object] = field(repr=False)
    folder: str
    speed_rpm: float
    parameters: tuple[Parameter, ...]
    aims: tuple[Aim, ...]
    limits: tuple[Limit, ...]
    units: Mapping[str, str]
    rest_rate: float | None
    tolerance: float

    @cached_property
    def mechanism(self) -> Mechanism:
        """The machine with what is fixed."""
        return from_sources(self.name, self.urdf, self.document, self.folder)

    @property
    def low(self) -> FloatArray:
        """Lower bounds, shape (parameters,)."""
        return np.array([item.low for item in self.parameters])

    @property
    def width(self) -> FloatArray:
        """Widths of the ranges, shape (parameters,)."""
        return np.array([item.high - item.low for item in self.parameters])

    @property
    def start(self) -> FloatArray:
        """Unit coordinates of the model's own values, shape (parameters,)."""
        return (np.array([item.start for item in self.parameters]) - self.low) / self.width

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of all quantities in aims and limits of the file, each once.

        With one aim alone, too: a design that lacks the other quantity is none of the problem.
        """
        named = [aim.quantity for aim in self.aims] + [limit.quantity for limit in self.limits]
        return tuple(dict.fromkeys((*named, *self.units)))

    def numbers(self, z: FloatArray) -> dict[str, float]:
        """Values of the free numbers by name.

        Args:
            z: Unit coordinates, 0 at the lower bounds and 1 at the upper ones, shape (parameters,).
        """
        values = self.low + self.width * z
        return {item.name: float(x) for item, x in zip(self.parameters, values, strict=True)}

    def overrides(self, z: FloatArray) -> dict[str, object]:
        """Overrides of the model that ``load`` and ``--set`` take, what is fixed included."""
        numbers = self.numbers(z)
        free = {
            item.target.path: numbers[item.name]
            for item in self.parameters
            if item.target.kind != "speed"
        }
        return {**self.changes, **free}

    def speed(self, z: FloatArray) -> float:
        """Cylinder speed [r/min]."""
        return self.numbers(z).get(SPEED, self.speed_rpm)

    def bounds_at(self, z: FloatArray) -> tuple[str, ...]:
        """Names of the bounds that a design lies at."""
        found: list[str] = []
        for item, place in zip(self.parameters, z, strict=True):
            found += [item.bound("low")] * bool(place <= ACTIVE_LIMIT)
            found += [item.bound("high")] * bool(place >= 1.0 - ACTIVE_LIMIT)
        return tuple(found)

    def with_aim(self, aim: Aim, *limits: Limit) -> Problem:
        """Return the problem with one aim and more limits."""
        return replace(self, aims=(aim,), limits=(*self.limits, *limits))

    def text(self) -> bytes:
        """The problem as JSON; equal problems give equal texts."""
        return msgspec.json.encode(self, order="deterministic")


def read_text(text: bytes) -> Problem:
    """Rebuild a problem from what :meth:`Problem.text` gave."""
    return msgspec.json.decode(text, type=Problem)

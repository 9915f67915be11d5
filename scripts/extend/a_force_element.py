"""A rubber buffer as a force element: k x + h x^3. A box slides into a wall through it.

It starts at rest at x0 = 20 mm, so the wall is struck with m v^2 / 2 = k x0^2 / 2 + h x0^4 / 4,
which gives v = 0.979796 m/s.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

import nipper_pin as nip
from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism.forces import ForceTable, register_force


@dataclass(frozen=True, kw_only=True)
class Rubber:
    """Force k x + h x^3, energy k x^2 / 2 + h x^4 / 4, no heat."""

    k: float
    h: float
    knots: ClassVar[tuple[float, ...]] = ()

    def force(self, x: FloatArray, rate: FloatArray) -> FloatArray:
        """Force against the coordinate."""
        del rate
        return (self.k + self.h * x**2) * x

    def energy(self, x: FloatArray) -> FloatArray:
        """Energy that is stored."""
        return (0.5 * self.k + 0.25 * self.h * x**2) * x**2

    def heat(self, x: FloatArray, rate: FloatArray) -> FloatArray:
        """Nothing becomes heat."""
        del rate
        return np.zeros_like(x)


@register_force
class RubberForce(ForceTable, frozen=True, kw_only=True, tag="rubber"):
    """A rubber spring on a slide."""

    k_N_per_m: float
    h_N_per_m3: float
    acts_on: ClassVar[tuple[str, ...]] = ("prismatic",)

    def build(self, kind: str) -> Rubber:
        """The law, in SI units."""
        del kind
        return Rubber(k=self.k_N_per_m, h=self.h_N_per_m3)


BUFFER = nip.Drawing(
    {
        "title": "a box drawn to a wall by rubber",
        "speed_rpm": 600.0,
        "points": {"O": [-100.0, 0.0], "B": [0.0, 0.0]},
        "bodies": {
            "shaft": {"points": "O", "mass_kg": 1.0},
            "box": {"points": "B", "mass_kg": 0.5},
        },
        "joints": [
            {
                "slide": "turning",
                "parent": "frame",
                "child": "shaft",
                "at": "O",
                "along": [0.0, 1.0],
            },
            {"slide": "gap", "parent": "frame", "child": "box", "at": "B", "along": [1.0, 0.0]},
        ],
        "drives": {"turning": {"joint": "turning", "law": "fourier", "mean_mm": 0.0}},
        "forces": {
            "gap": {"joint": "gap", "law": "rubber", "k_N_per_m": 800.0, "h_N_per_m3": 2e6},
        },
        "initial": {"gap": {"at_mm": 20.0}},
        "stops": {"gap": {"joint": "gap", "restitution": 0.5}},
    },
    "buffer",
)
case = nip.Case(speed_rpm=600.0, window=nip.Window.CYCLE, cycles=2)
solution = nip.simulate(BUFFER.mechanism(), case)
print(solution.collisions[0].approach_rate)

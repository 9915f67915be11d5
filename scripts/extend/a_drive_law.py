"""A cam of constant jerk as a drive law: its acceleration falls evenly from a to -a and rises back.

A box lies loose on it, and leaves it after a third of the turn T = 0.1 s, where the acceleration is
-g. With z T the time since the end of the turn, the gap is g T^2 (5/54 - z/3 - 2 z^2 + 2 z^3): the
box lands at 1.155400 T.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

import nipper_pin as nip
from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism.drives import AnyTable, register_drive


@dataclass(frozen=True, kw_only=True)
class Jerk:
    """Lift times 12 u^2 - 16 u^3 up to half a turn, u the share of the turn, and back."""

    lift: float
    knots_rad: ClassVar[tuple[float, ...]] = (0.0, math.pi)

    def evaluate(self, psi: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Coordinate and its derivatives by the cylinder angle."""
        u = np.remainder(psi / math.tau, 1.0)
        sense = np.where(u < 0.5, 1.0, -1.0)
        u = np.minimum(u, 1.0 - u)
        return (
            self.lift * (12.0 - 16.0 * u) * u**2,
            self.lift * sense * (24.0 - 48.0 * u) * u / math.tau,
            self.lift * (24.0 - 96.0 * u) / math.tau**2,
        )


@register_drive
class JerkDrive(AnyTable, frozen=True, kw_only=True, tag="jerk"):
    """A cam whose acceleration changes evenly."""

    lift_mm: float
    moves: ClassVar[tuple[str, ...]] = ("prismatic",)

    def build(self) -> Jerk:
        """The law, in SI units."""
        return Jerk(lift=1e-3 * self.lift_mm)


# a = 24 lift / T^2 is 3 g at 600 r/min.
LIFT_MM = 3.0 * 9.81 * 0.1**2 / 24.0 * 1e3
SHAKER = nip.Drawing(
    {
        "title": "loose box on a cam",
        "speed_rpm": 600.0,
        "closed": ["gap"],
        "points": {"T": [0.0, 0.0], "B": [0.0, 30.0]},
        "bodies": {
            "table": {"points": "T", "mass_kg": 5.0},
            "box": {"points": "B", "mass_kg": 0.5},
        },
        "joints": [
            {
                "slide": "height",
                "parent": "frame",
                "child": "table",
                "at": "T",
                "along": [0.0, 1.0],
            },
            {"slide": "gap", "parent": "table", "child": "box", "at": "B", "along": [0.0, 1.0]},
        ],
        "drives": {"height": {"joint": "height", "law": "jerk", "lift_mm": LIFT_MM}},
        "stops": {"gap": {"joint": "gap", "restitution": 0.0}},
    },
    "shaker",
)
case = nip.Case(speed_rpm=600.0, window=nip.Window.CYCLE, cycles=2)
solution = nip.simulate(SHAKER.mechanism(), case)
print(solution.collisions[0].t, solution.collisions[0].approach_rate)

"""A coating that gives way to fast impacts as a restitution law: e = e0 / (1 + rate / v1).

A box falls on a table. The reciprocal of the rate grows evenly, 1/v_next = (1/v + 1/v1) / e0, and a
flight lasts 2 v / g, so all collisions are known, and the rest is the sum of the flights.
"""

from __future__ import annotations

from dataclasses import dataclass

import nipper_pin as nip
from nipper_pin.mechanism.restitution import RestitutionTable, register_restitution


@dataclass(frozen=True, kw_only=True)
class Softening:
    """e_0 / (1 + rate / v_1)."""

    v_1: float

    def coefficient(self, e_0: float, rate: float) -> float:
        """Restitution at a rate of approach."""
        return e_0 / (1.0 + rate / self.v_1)

    def slope(self, e_0: float, rate: float) -> float:
        """Its derivative by the rate."""
        return -e_0 / self.v_1 / (1.0 + rate / self.v_1) ** 2


@register_restitution
class SofteningRestitution(RestitutionTable, frozen=True, kw_only=True, tag="softening"):
    """A coating that gives way to fast impacts."""

    v_1_m_per_s: float

    def build(self, kind: str) -> Softening:
        """The law, in SI units."""
        del kind
        return Softening(v_1=self.v_1_m_per_s)


FALL = nip.Drawing(
    {
        "title": "a box falls on a table",
        "speed_rpm": 60.0,
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
                "along": [1.0, 0.0],
            },
            {"slide": "gap", "parent": "frame", "child": "box", "at": "B", "along": [0.0, 1.0]},
        ],
        "drives": {"turning": {"joint": "turning", "law": "fourier", "mean_mm": 0.0}},
        "initial": {"gap": {"at_mm": 20.0}},
        "stops": {
            "gap": {
                "joint": "gap",
                "restitution": 0.8,
                "restitution_law": {"law": "softening", "v_1_m_per_s": 0.5},
            },
        },
    },
    "fall",
)
case = nip.Case(speed_rpm=60.0, window=nip.Window.CYCLE)
solution = nip.simulate(FALL.mechanism(), case)
for hit in solution.collisions[:3]:
    print(hit.t, hit.approach_rate, hit.separation_rate)

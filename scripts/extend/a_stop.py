"""A stop on an eccentric disc: turned by the angle phi it is lifted by e (1 - cos phi).

Here by 7.5 mm, so the box falls 12.5 mm and meets it after sqrt(2 h / g) = 0.050482 s.
"""

from __future__ import annotations

import math

import nipper_pin as nip
from nipper_pin.mechanism.stops import StopTable, register_stop


@register_stop
class EccentricStop(StopTable, frozen=True, kw_only=True, tag="eccentric"):
    """A stop of a slide on an eccentric disc."""

    eccentricity_mm: float
    angle_deg: float

    def place(self, kind: str) -> float:
        """Coordinate at which the stop is closed [m]."""
        del kind
        return 1e-3 * self.eccentricity_mm * (1.0 - math.cos(math.radians(self.angle_deg)))


FALL = nip.Drawing(
    {
        "title": "a box falls on an adjusted stop",
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
            {"slide": "height", "parent": "frame", "child": "box", "at": "B", "along": [0.0, 1.0]},
        ],
        "drives": {"turning": {"joint": "turning", "law": "fourier", "mean_mm": 0.0}},
        "initial": {"height": {"at_mm": 20.0}},
        "stops": {
            "height": {
                "joint": "height",
                "restitution": 0.5,
                "adjusted": {"law": "eccentric", "eccentricity_mm": 5.0, "angle_deg": 120.0},
            },
        },
    },
    "fall",
)
solution = nip.simulate(FALL.mechanism(), nip.Case(speed_rpm=60.0, window=nip.Window.CYCLE))
print(solution.collisions[0].t, solution.collisions[0].approach_rate)

"""The lips close up: where a camera along the hinge stands in every frame, and how much it sees.

The camera moves with the lower lip, so that this one stands still in its picture, and what is on
the near side of the contact point is cut away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...units import MM_PER_M
from .arrows import arrow_body, arrow_place
from .film import Film, bouncing_stop, worlds
from .rebounds import highest_drawn

# Height of the picture by the largest gap of a rebound as it is drawn, and its least [m].
_BY_GAP, _LEAST_M = 4.0, 0.012
# Steps of the scale [mm].
_STEPS_MM = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)


@dataclass(frozen=True)
class CloseUp:
    """A camera that follows the lower lip; places are in the plane of the mechanism.

    Attributes:
        stop: Name of the stop.
        place: Contact point on the lower lip, shape (K, 2) [m].
        angle: Direction in which the upper lip opens, from x towards z, shape (K,) [rad].
        across: Place of the cut along the hinge [m].
        height: Height of what is seen [m].
        scale_mm: Length of the scale [mm].
    """

    stop: str
    place: FloatArray
    angle: FloatArray
    across: float
    height: float
    scale_mm: float

    def record(self) -> dict[str, object]:
        """As plain data for the page."""
        return {
            "stop": self.stop,
            "x": [float(f"{value:.7g}") for value in self.place[:, 0]],
            "z": [float(f"{value:.7g}") for value in self.place[:, 1]],
            "angle": [float(f"{value:.7g}") for value in self.angle],
            "across": self.across,
            "height": self.height,
            "scale_mm": self.scale_mm,
        }


def close_up(film: Film) -> CloseUp | None:
    """The close-up of the transition stop; None if it has no contact point."""
    mechanism = film.solution.mechanism
    stop = bouncing_stop(mechanism)
    if stop is None or stop.contact is None:
        return None
    body, local = arrow_body(mechanism, stop), arrow_place(mechanism, stop)
    opening = math.atan2(local[2, 1], local[0, 1])
    place = worlds(film.position, film.angle)[:, body, :2] @ [local[0, 3], local[2, 3], 1.0]
    turned = np.column_stack([film.angle, np.zeros(len(film.angle))])[:, body]
    gap = highest_drawn(film.solution, film.pace.machine, stop.gaps(film.drawn))
    height = max(_LEAST_M, _BY_GAP * stop.lever * gap)
    steps = [step for step in _STEPS_MM if step <= 0.3 * MM_PER_M * height]
    return CloseUp(
        stop.name, place, turned + opening, float(stop.contact.point[1]), height,
        steps[-1] if steps else _STEPS_MM[0],
    )  # fmt: skip

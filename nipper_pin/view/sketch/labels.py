"""Places of labels: beside what they name, and apart from one another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import FloatArray

# Places that are tried: directions and distances by the size of the drawing.
_DIRECTIONS = 16
_DISTANCES = (0.05, 0.08, 0.12, 0.17, 0.23, 0.3)
# Size of a character and of a line, by that of the drawing.
_WIDE, _HIGH, _PAD = 0.0125, 0.026, 0.006


@dataclass(frozen=True)
class Label:
    """A text and what it names.

    Attributes:
        at: What it names, shape (2,), in the unit of the drawing.
        colour: As in #RRGGBB.
        text_at: Middle of the text, shape (2,).
    """

    text: str
    at: FloatArray
    colour: str
    text_at: tuple[float, float] = (0.0, 0.0)


def placed(labels: Sequence[Label], low: FloatArray, high: FloatArray) -> list[Label]:
    """Labels with places: each at the nearest one that covers no other label and nothing named.

    Args:
        low: Lower left corner of the drawing, shape (2,).
        high: Upper right one.
    """
    size = float((high - low).max())
    named = np.array([label.at for label in labels])
    taken: list[FloatArray] = []
    found = []
    for label in labels:
        lines = label.text.splitlines()
        half = 0.5 * size * np.array([_WIDE * max(map(len, lines)), _HIGH * len(lines)])
        half += _PAD * size
        best, least = label.at, np.inf
        for distance in _DISTANCES:
            for turn in np.linspace(0.0, 2.0 * np.pi, _DIRECTIONS, endpoint=False):
                way = np.array([np.cos(turn), np.sin(turn)])
                middle = label.at + way * (distance * size + np.abs(way) * half)
                cost = _cost(middle, half, low, high, taken, named) + distance
                if cost < least:
                    best, least = middle, cost
        taken.append(np.array([best - half, best + half]))
        found.append(replace(label, text_at=(float(best[0]), float(best[1]))))
    return found


def _cost(
    middle: FloatArray,
    half: FloatArray,
    low: FloatArray,
    high: FloatArray,
    taken: list[FloatArray],
    named: FloatArray,
) -> float:
    """How many labels, named places and edges of the drawing a label there would cover."""
    begin, end = middle - half, middle + half
    cost = 3.0 * float((begin < low).any() or (end > high).any())
    cost += 2.0 * sum(float((begin < other[1]).all() and (end > other[0]).all()) for other in taken)
    return cost + float(((named > begin) & (named < end)).all(axis=1).sum())

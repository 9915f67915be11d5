"""Ratios of true to stated errors, and which events of two solutions are the same."""

from __future__ import annotations

import math
from typing import Any

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


class Ratios:
    """True over stated errors of one case, by engine, window, quantity and tolerance."""

    def __init__(self) -> None:
        """Begin with none."""
        self.rows: list[tuple[str, str, str, float, float]] = []
        self.notes: list[str] = []

    def add(self, where: tuple[str, str, float], what: str, true: Any, error: float) -> None:
        """One ratio; where nothing is wrong and nothing stated there is none."""
        engine, window, tolerance = where
        true = float(abs(true))
        if true == 0.0 and error == 0.0:
            return
        self.rows.append(
            (engine, window, what, tolerance, true / error if error > 0.0 else math.inf)
        )


def following(events: list[dict[str, Any]], place: int, kind: str, stop: str) -> int:
    """Place of the event that is meant; collisions before a rest that a run leaves out are passed.

    A series has infinitely many collisions: both solutions leave out the last ones.
    """
    while place < len(events):
        if (events[place]["kind"], events[place]["stop"]) == (kind, stop):
            return place
        if kind != "rest" or events[place]["kind"] != "collision":
            return -1
        place += 1
    return -1

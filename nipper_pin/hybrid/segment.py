"""Motion between two events, with one set of closed stops."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, replace

from ..arrays import FloatArray
from .motion.panel import Panel


@dataclass(frozen=True, eq=False)
class Segment:
    """Motion with one set of closed stops.

    Attributes:
        t_start: Start [s].
        t_end: End [s].
        panels: Panels in order of time; the last one may reach beyond the end.
        kinematic: True if the drives determine the motion.
        source: Place in the run of the segment that this one is a copy of; its own if it is none.
    """

    t_start: float
    t_end: float
    closed: frozenset[str]
    panels: tuple[Panel, ...]
    kinematic: bool
    source: int = 0

    def shifted(self, delay: float, wound: FloatArray) -> Segment:
        """Return the same motion at a later time; arguments as :meth:`Panel.shifted`."""
        return replace(
            self,
            t_start=self.t_start + delay,
            t_end=self.t_end + delay,
            panels=tuple(panel.shifted(delay, wound) for panel in self.panels),
        )

    def pieces(self) -> Iterator[tuple[Panel, float, float]]:
        """Panels with the part of each that belongs to the segment: begin and end [s]."""
        for panel in self.panels:
            begin, end = max(panel.t, self.t_start), min(panel.t + panel.h, self.t_end)
            if end > begin:
                yield panel, begin, end

    def panel_number(self, t: float) -> int:
        """Return the place of the panel that holds time t [s]."""
        return max(bisect_right(self.panels, t, key=lambda panel: panel.t) - 1, 0)

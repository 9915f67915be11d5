"""What is found of the panels of a run for all parts of a machine at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...dynamics import System
from ...errors import SingularConfigurationError
from ...tolerances.mechanics import EPS
from ..event import Event
from ..motion.panel import Panel
from ..segment import Segment
from .freedoms import free_coordinates
from .local_error import at_end, unresolved, unsure
from .variational import flight_map
from .zonotope import NOTHING_KNOWN, Deviations


class PanelMap(NamedTuple):
    """A panel of a flight, as far as it belongs to its segment.

    Attributes:
        matrix: Carries deviations to its end, shape (2 nv, 2 nv).
        made: Deviations there that its beginning and it make themselves, shape (2 nv, K).
        position: What each position is left unresolved by, shape (nv,).
    """

    matrix: FloatArray
    made: FloatArray
    position: FloatArray


class PanelMaps:
    """Maps of panels and ends of segments, each found once for all parts and copies of turns."""

    def __init__(self, system: System, events: Sequence[Event]) -> None:
        """Begin with none."""
        self.system = system
        self.events = events
        self._at: dict[float, list[Event]] = {}
        for event in events:
            self._at.setdefault(event.t, []).append(event)
        self._pieces: dict[int, list[PanelMap]] = {}
        self._ends: dict[int, Deviations] = {}
        self._free: dict[int, NDArray[np.bool_]] = {}

    def pieces(self, segment: Segment) -> list[PanelMap]:
        """The panels of a segment with freedom."""
        if segment.source not in self._pieces:
            pieces = segment.pieces()
            found = [self._piece(segment, panel, end - begin) for panel, begin, end in pieces]
            self._pieces[segment.source] = found
        return self._pieces[segment.source]

    def end(self, segment: Segment) -> Deviations:
        """Deviations at the end of a segment, where drives determine a part."""
        if segment.source not in self._ends:
            self._ends[segment.source] = at_end(self.system, segment)
        return self._ends[segment.source]

    def free(self, segment: Segment) -> NDArray[np.bool_]:
        """Whether coordinates of a segment are free, shape (nv,)."""
        if segment.source not in self._free:
            phase = self.system.constraint_set(segment.closed)
            found = self._free[segment.source] = np.zeros(self.system.body.nv, dtype=np.bool_)
            found[free_coordinates(phase, segment.panels[0].split)] = True
        return self._free[segment.source]

    def _piece(self, segment: Segment, panel: Panel, length: float) -> PanelMap:
        system, phase = self.system, self.system.constraint_set(segment.closed)
        nv, free = system.body.nv, free_coordinates(phase, panel.split)
        try:
            carried, lifted = flight_map(system, phase, panel, length)
        except (SingularConfigurationError, np.linalg.LinAlgError):
            # A motion that a step of 1e-6 takes to a dead centre is known by no derivative.
            lifted = np.full((2 * nv, 1), NOTHING_KNOWN)
            return PanelMap(np.zeros((2 * nv, 2 * nv)), lifted, lifted[:nv, 0])
        carried = np.clip(np.nan_to_num(carried), -NOTHING_KNOWN, NOTHING_KNOWN)
        position, velocity = unresolved(system, phase, panel)
        made = lifted * np.concatenate([position[free], velocity[free]])
        # Where panels meet a gap has the round-off of its coordinate, however small it is.
        loose = EPS * np.abs(panel.q[0, free])
        if panel is segment.panels[0]:
            loose = self._at_start(segment, loose, free)
        return PanelMap(carried, np.hstack([carried[:, free] * loose, made]), position)

    def _at_start(self, segment: Segment, loose: FloatArray, free: list[int]) -> FloatArray:
        """What the free coordinates are wrong by where a segment begins, shape (free,).

        That is the round-off of closures, of stops that have just opened nothing, and the round-off
        of the coordinate in a part that the event there does not reach.
        """
        system, panel = self.system, segment.panels[0]
        events = self._at.get(segment.t_start, [])
        reached = np.zeros(system.body.nv, dtype=np.bool_)
        reached[:] = not events
        for event in events:
            for name in event.stops:
                reached[system.members(system.mechanism.stop(name).index)] = True
        found = unsure(system, panel.split)
        # Any other gap that is zero there has been lost in the round-off of its coordinate.
        names = segment.closed.union(*((*event.stops, *event.closed_before) for event in events))
        for stop in map(system.mechanism.stop, names):
            if panel.q[0, stop.index] == stop.at:
                found[stop.index] = 0.0
        return np.where(reached[free], found[free], loose)

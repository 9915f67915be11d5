"""What a simulation returns: events, motion between them, and how the run ended."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..event import Event
from .simulated import Simulated

if TYPE_CHECKING:
    from .trajectory import Motion


class Solution(Simulated):
    """A simulated run as its users meet it: in one line, as a page, as a data frame."""

    def __repr__(self) -> str:
        """One line."""
        from .summary import line

        return line(self)

    def _repr_html_(self) -> str:
        from .summary import page

        return page(self)

    def to_frame(self, library: str | None = None) -> Any:
        """Collisions as a data frame, with the names and units of the JSON document.

        Args:
            library: "pandas", "polars" or "pyarrow"; by default the first that is installed.

        Raises:
            InputError: It is not installed.
        """
        from ...frames import data_frame
        from .summary import columns

        return data_frame(columns(self), library)

    def motion_at(self, event: Event) -> Motion:
        """State just after an event, at its own time; not computed before it is asked for.

        The limit of a series of bounces lies beyond the last collision that is computed, whose
        configuration and velocities ``event.q`` and ``event.v_after`` of a rest are. The motion is
        followed from there with the stop at rest.

        Args:
            event: One of the events of this solution.

        Returns:
            The state, with one row.

        Raises:
            SimulationError: The motion cannot be followed to the time of a rest.
        """
        from .event_state import motion_at

        return motion_at(self, event)

    def continued(self, to: float) -> Solution:
        """This run with the motion after its last event, until the next one or a later time.

        Args:
            to: The time [s].

        Returns:
            The same events, and motion that goes on behind the last of them.

        Raises:
            SimulationError: The motion cannot be followed.
        """
        from .event_state import continued

        return continued(self, to)

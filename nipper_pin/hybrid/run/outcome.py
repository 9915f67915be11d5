"""How a run ends."""

from __future__ import annotations

from enum import StrEnum


class Outcome(StrEnum):
    """How a run ended; the value is the sentence for the user."""

    COMPLETED = "The window was simulated to its end."
    AT_REST = "The transition ended with the stop at rest."
    STILL_BOUNCING = "The window ended while a stop was still bouncing; it came to no rest."
    NO_REST = (
        "The stop did not come to rest within one turn of the first collision: its bounces outlast "
        "the time in which it is pressed shut; lower the speed or the restitution."
    )
    TOO_MANY_COLLISIONS = (
        "The run was stopped at its largest number of collisions: the bounces are long, or stops "
        "keep throwing one another open; raise max_collisions, or let bounces slower than a rate "
        "end (rest_rate)."
    )

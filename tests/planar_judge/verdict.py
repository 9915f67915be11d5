"""Why the judge does not go on."""

from __future__ import annotations

from enum import StrEnum


class Reason(StrEnum):
    """Kinds of reason."""

    ASSEMBLY = "cannot be assembled"
    SINGULAR = "singular"
    DEPENDENT = "dependent stops"
    JAM = "jam"
    BEYOND = "beyond a stop"
    TABLE = "beyond a table"
    COLLISIONS = "collisions"
    SERIES = "series of collisions whose end the judge does not know"
    UNRESOLVED = "unresolved"


class Refusal(Exception):  # noqa: N818 - it is a verdict, not a mistake
    """The motion cannot be followed, for a reason of the machine."""

    def __init__(self, reason: Reason, detail: str) -> None:
        super().__init__(f"{reason.value}: {detail}")
        self.reason = reason

"""Common keys of the tables of adjustable stops in a model file."""

from __future__ import annotations

from ..files.description import TomlTable


class StopTable(TomlTable, frozen=True, kw_only=True, tag_field="law"):
    """Coordinate at which a stop is closed, from its adjustment."""

    def place(self, kind: str) -> float:
        """Return the coordinate at which the stop is closed [m or rad].

        Args:
            kind: Kind of the joint, ``revolute`` or ``prismatic``.

        Raises:
            InputError: The values give no place; its evidence ``key`` names the key to change.
        """
        raise NotImplementedError

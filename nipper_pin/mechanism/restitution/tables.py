"""Common keys of the tables of restitution laws in a model file."""

from __future__ import annotations

from ..files.description import TomlTable
from .law import RestitutionLaw


class RestitutionTable(TomlTable, frozen=True, kw_only=True, tag_field="law"):
    """Restitution that depends on the rate of approach."""

    def build(self, kind: str) -> RestitutionLaw:
        """Return the law in SI units.

        Args:
            kind: Kind of the joint, ``revolute`` or ``prismatic``.

        Raises:
            InputError: The values make no law; its evidence ``key`` names the key to change.
        """
        raise NotImplementedError

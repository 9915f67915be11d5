"""Common keys of the tables of force elements in a model file."""

from __future__ import annotations

from typing import ClassVar

from ..files.description import Name, TomlTable
from .law import ForceLaw

HINGE, SLIDE = "revolute", "prismatic"


class ForceTable(TomlTable, frozen=True, kw_only=True, tag_field="law"):
    """Keys of every force element.

    Attributes:
        joint: Joint it acts on.
    """

    joint: Name

    acts_on: ClassVar[tuple[str, ...]] = (HINGE, SLIDE)
    """Kinds of joints that it acts on."""

    def build(self, kind: str) -> ForceLaw:
        """Return the law in SI units.

        Args:
            kind: Kind of the joint, ``revolute`` or ``prismatic``.

        Raises:
            InputError: The values make no law; its evidence ``key`` names the key to change.
        """
        raise NotImplementedError

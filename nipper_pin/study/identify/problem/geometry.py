"""The two texts of a model as plain data, and where its links and points stand at touch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ....mechanism import Mechanism, from_sources
from ....mechanism.edit import Layout, read_layout
from ....mechanism.files import parse_xml


@dataclass(frozen=True, kw_only=True)
class Sources:
    """The two texts of a model.

    Attributes:
        document: The TOML document as plain data.
        folder: Folder that mesh and table files start from.
    """

    name: str
    urdf: str
    document: Mapping[str, object]
    folder: str

    @classmethod
    def of(cls, mechanism: Mechanism) -> Sources:
        """Return the texts that a mechanism was built from."""
        return cls(
            name=mechanism.name,
            urdf=mechanism.urdf,
            document=mechanism.description,
            folder=mechanism.mesh_folder,
        )

    def build(self) -> Mechanism:
        """Build the mechanism.

        Raises:
            InputError: The texts make no mechanism.
        """
        return from_sources(self.name, self.urdf, self.document, Path(self.folder))


def layout(sources: Sources) -> Layout:
    """Read where links and points stand at touch.

    Args:
        sources: A model's texts, already known to be valid.
    """
    file = f"{sources.name}.urdf"
    return read_layout(parse_xml(sources.urdf, file), sources.document, file)

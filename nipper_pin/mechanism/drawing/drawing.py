"""A machine that is drawn: its tables, from a file or from Python."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..files import read_toml, toml
from ..files.toml_text import plain
from ..load import from_sources
from ..mechanism import Mechanism
from ..model_files import new_model, read_model_text
from .document import drawn_sources
from .points import Place
from .read import read


@dataclass(frozen=True)
class Drawing:
    """A machine drawn in its touch configuration: points in mm, bodies through them, joints.

    Attributes:
        tables: What the TOML file of a drawing holds, as tables of plain data.
        name: Name of the machine.
    """

    tables: Mapping[str, Any]
    name: str = "drawing"

    def __post_init__(self) -> None:
        """Take numbers of numpy for plain ones; the layout need not be named in Python."""
        object.__setattr__(self, "tables", {"drawing": 1, **plain(dict(self.tables))})

    @classmethod
    def load(cls, file: str | Path) -> Drawing:
        """Read a drawing from its TOML file, whose name becomes the machine's.

        Raises:
            ModelError: The file cannot be read.
        """
        path = Path(file)
        return cls(read_toml(read_model_text(path), path.name), path.stem)

    @property
    def points(self) -> Mapping[str, Place]:
        """Places of its points (x, z) by name [mm]; errors as of ``mechanism``."""
        return read(self.tables, self.name).points

    def mechanism(self) -> Mechanism:
        """The machine, ready to be simulated.

        Raises:
            UnknownNameError: A name in a table of the model does not exist.
            ModelError: A value cannot be used, or the drawing does not hang together.
            AssemblyError: It does not close as drawn.
        """
        return from_sources(self.name, *self.sources(), ".")

    def sources(self) -> tuple[str, dict[str, Any]]:
        """The URDF of the machine, and its TOML document as plain data; errors as of the above."""
        return drawn_sources(self.tables, self.name)

    def save(self, target: str | Path) -> Path:
        """Write the drawing: one TOML file, alone or in a folder of its name.

        Args:
            target: ``NAME.toml``, or a folder to write.

        Returns:
            The file or folder, resolved.

        Raises:
            InputError: The name cannot be a model's, or it is there or cannot be written.
        """
        return new_model(target, toml(self.tables))

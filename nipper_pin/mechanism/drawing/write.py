"""A drawing as a mechanism, and as a model folder."""

from __future__ import annotations

from pathlib import Path

from ..export import export
from ..load import from_sources
from ..mechanism import Mechanism
from .parts import Drawing
from .tables import drawn_sources


def write_drawing(drawing: Drawing, folder: str | Path) -> Path:
    """Write a model folder; arguments, result and errors as of :func:`drawn_mechanism`, `export`.

    Args:
        folder: Folder to write; its name becomes the model's. It may exist if it is empty.
    """
    return export(drawn_mechanism(drawing), folder)


def drawn_mechanism(drawing: Drawing) -> Mechanism:
    """The mechanism of a drawing, without a folder.

    Raises:
        InputError: The drawing does not hang together.
        ModelError: A value in it cannot be used.
        AssemblyError: It does not close as drawn.
    """
    return from_sources(drawing.name, *drawn_sources(drawing), ".")

"""A drawing as the two texts of a model, as a model folder, and as a mechanism."""

from __future__ import annotations

from pathlib import Path
from textwrap import wrap

from ..files.schema import SCHEMA_FILE, schema_text
from ..files.toml_text import toml
from ..load import from_sources
from ..mechanism import Mechanism
from ..model_files import check_model_folder, new_folder
from .parts import Drawing
from .tables import document, drawn_sources
from .tree import grown
from .urdf_text import urdf_text


def drawn_texts(drawing: Drawing, name: str = "") -> dict[str, str]:
    """Texts of a model's files by their names.

    Args:
        name: Name of the model, if it is not that of the drawing.

    Raises:
        InputError: The drawing does not hang together.
    """
    name, tree = name or drawing.name, grown(drawing)
    words = [drawing.title, drawing.known, drawing.invented]
    heading = [line for text in words if text for line in wrap(f"{text}.", 96)]
    return {
        f"{name}.urdf": urdf_text(tree, name),
        f"{name}.toml": f"#:schema ./{SCHEMA_FILE}\n"
        + "".join(f"# {line}\n" for line in heading)
        + "\n"
        + toml(document(tree)),
        SCHEMA_FILE: schema_text(),
    }


def write_drawing(drawing: Drawing, folder: str | Path) -> Path:
    """Write a model folder.

    Args:
        folder: Folder to write; its name becomes the model's. It may exist if it is empty.

    Returns:
        The folder, resolved.

    Raises:
        InputError: The drawing does not hang together, or the folder cannot be written.
    """
    target = check_model_folder(folder)
    texts = drawn_texts(drawing, target.name)
    with new_folder(target) as partial:
        for file, text in texts.items():
            (partial / file).write_text(text, encoding="utf-8")
    return target


def drawn_mechanism(drawing: Drawing) -> Mechanism:
    """The mechanism of a drawing, without a folder.

    Raises:
        InputError: The drawing does not hang together.
        ModelError: A value in it cannot be used.
        AssemblyError: It does not close as drawn.
    """
    return from_sources(drawing.name, *drawn_sources(drawing), ".")

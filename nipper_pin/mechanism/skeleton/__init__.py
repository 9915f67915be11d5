"""A commented model to start from: the least machine that does what a comber's nipper does."""

from __future__ import annotations

from pathlib import Path

from ..files.schema import SCHEMA_FILE, schema_text
from ..model_files import check_model_folder, new_folder


def write_skeleton(folder: Path) -> Path:
    """Write a model that can be checked and simulated, with a comment for every decision in it.

    Args:
        folder: Folder to write; its name becomes the model's. It may exist if it is empty.

    Returns:
        The folder, resolved.

    Raises:
        InputError: The name cannot be a model's, or the folder cannot be written or is not empty.
    """
    target = check_model_folder(folder)
    with new_folder(target) as partial:
        for file, text in skeleton(target.name).items():
            (partial / file).write_text(text, encoding="utf-8")
    return target


def drawing_text() -> str:
    """A commented drawing."""
    return Path(__file__).with_name("drawing.toml").read_text(encoding="utf-8")


def skeleton(name: str) -> dict[str, str]:
    """Texts of the skeleton's files by their names."""
    here = Path(__file__).parent
    urdf, document = (
        (here / f"skeleton.{kind}").read_text(encoding="utf-8") for kind in ("urdf", "toml")
    )
    return {
        f"{name}.urdf": urdf.replace('<robot name="skeleton">', f'<robot name="{name}">'),
        f"{name}.toml": document,
        SCHEMA_FILE: schema_text(),
    }

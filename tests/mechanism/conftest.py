"""A model folder with mistakes in it."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from nipper_pin.mechanism import find_model

Change = tuple[str, str]
Spoil = Callable[..., Path]


@pytest.fixture
def spoil(tmp_path: Path) -> Spoil:
    """Copy the E62 model into a folder and replace text in its files."""

    def change(*, urdf: tuple[Change, ...] = (), toml: tuple[Change, ...] = ()) -> Path:
        folder = tmp_path / "e62"
        shutil.copytree(find_model("e62"), folder, dirs_exist_ok=True)
        for suffix, changes in ((".urdf", urdf), (".toml", toml)):
            path = folder / f"e62{suffix}"
            text = path.read_text(encoding="utf-8")
            for old, new in changes:
                assert old in text, f"{old!r} is not in {path.name}"
                text = text.replace(old, new, 1)
            path.write_text(text, encoding="utf-8")
        return folder

    return change

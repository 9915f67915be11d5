"""An optimum as files: the result, the overrides that ``load`` takes, and the case to simulate."""

from __future__ import annotations

import json
from pathlib import Path

from ...hybrid.files.npz import save_case
from ...mechanism import load
from ...outputs import complete_file
from ..folders import make_folder
from .result import Optimum


def write(optimum: Optimum, folder: str | Path) -> tuple[Path, ...]:
    """Write an optimum; every file appears only when it is complete.

    Args:
        optimum: The optimum.
        folder: Folder to write into; made if it does not exist.

    Returns:
        ``result.json``; ``overrides.json``, for ``load``; ``case.json``, for ``simulate --case``.

    Raises:
        InputError: A file cannot be written.
    """
    home = Path(folder)
    make_folder(home)
    problem = optimum.problem
    # A result of another run of the same problem must not stand beside a newer case.
    written = [save_case(load(problem.model, optimum.overrides), optimum.case, home / "case.json")]
    for name, document in (
        ("overrides.json", optimum.overrides),
        ("result.json", optimum.record()),
    ):
        with complete_file(home / name) as partial:
            text = json.dumps(document, indent=1, allow_nan=False) + "\n"
            partial.write_text(text, encoding="utf-8")
        written.append(home / name)
    return tuple(reversed(written))

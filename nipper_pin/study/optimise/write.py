"""An optimum as files: the result, the overrides that ``load`` takes, and the case to simulate."""

from __future__ import annotations

import json
from pathlib import Path

from ...hybrid.files.npz import save_case
from ...mechanism import load
from ...outputs import complete_folder
from .result import Optimum

RESULTS = ("result.json", "overrides.json", "case.json", "front.svg", "front.png")
"""Names of what a search writes; they change together."""


def write(optimum: Optimum, folder: str | Path) -> tuple[Path, ...]:
    """Write an optimum; its files take the place of those of an earlier one in one step.

    Args:
        folder: Folder to write into; made if it does not exist.

    Returns:
        ``result.json``; ``overrides.json``, for ``load``; ``case.json``, for ``simulate --case``.

    Raises:
        InputError: A file cannot be written.
    """
    with complete_folder(folder, RESULTS) as new:
        problem = optimum.problem
        documents = {"result.json": optimum.record(), "overrides.json": optimum.overrides}
        for name, document in documents.items():
            text = json.dumps(document, indent=1, allow_nan=False) + "\n"
            (new / name).write_text(text, encoding="utf-8")
        save_case(load(problem.model, optimum.overrides), optimum.case, new / "case.json")
    return tuple(Path(folder) / name for name in RESULTS[:3])

"""A solution as files: tables for other programs, dense motion, plots, and the case itself."""

from __future__ import annotations

import json
from pathlib import Path

from ...errors import InputError
from ...hybrid import Solution, need_sound
from ...hybrid.files.npz import save, save_case
from ...outputs import complete_file, complete_folder
from ..figure_file import write_figure
from .csv_tables import TABLES, tables
from .plots import PLOTS, figures

_CASE = "case.json"
_FILES = (*TABLES, "solution.npz", _CASE, *(f"{name}.png" for name in PLOTS))


def export(solution: Solution, folder: str | Path, units: str = "SI") -> list[Path]:
    """Write everything about a solution into a folder.

    Args:
        folder: Folder, made if it does not exist. Its files of an earlier run are replaced
            together, in one step; what else it holds stays.
        units: Of the CSV files: "SI", or "mm" for mm and degrees.

    Returns:
        The files: collisions, phases, link velocities and motion as CSV, the solution itself, the
        case (``nipper-pin simulate --case`` repeats it) and plots.

    Raises:
        InputError: The folder cannot be written.
        SelfCheckError: The run does not meet its closures or its energy balance.
    """
    with complete_folder(folder, _FILES) as target:
        need_sound(solution)
        written = [
            *(_write(target / name, text) for name, text in tables(solution, units)),
            save(solution, target / "solution.npz"),
            save_case(solution.mechanism, solution.case, target / _CASE),
            *(write_figure(figure, target / f"{name}.png")
              for name, figure in figures(solution).items()),
        ]  # fmt: skip
    return [Path(folder) / file.name for file in written]


def need_own_folder(folder: str, model: str) -> None:
    """Refuse a folder with the run of another model, which would be replaced.

    Raises:
        InputError: The case in it is of another model.
    """
    try:
        text = (Path(folder) / _CASE).read_text(encoding="utf-8")
        other = json.loads(text)["mechanism"]["name"]
    except (OSError, ValueError, KeyError, TypeError):
        # No run is there.
        return
    if other != model:
        message = (
            f"{folder} holds a run of {other}, and this one is of {model}: name another folder, or "
            "remove that one"
        )
        raise InputError(message, folder=folder)


def _write(path: Path, text: str) -> Path:
    with complete_file(path) as partial:
        partial.write_text(text, encoding="utf-8")
    return path

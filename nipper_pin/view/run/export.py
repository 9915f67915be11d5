"""A solution as files: tables for other programs, dense motion, plots, and the case itself."""

from __future__ import annotations

from pathlib import Path

from ...hybrid import Solution, need_sound
from ...hybrid.files.npz import save, save_case
from ...outputs import complete_file, complete_folder
from .csv_tables import TABLES, tables
from .plots import PLOTS, plot_solution

_FILES = (*TABLES, "solution.npz", "case.json", *(f"{name}.png" for name in PLOTS))


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
            save_case(solution.mechanism, solution.case, target / "case.json"),
            *plot_solution(solution, target),
        ]
    return [Path(folder) / file.name for file in written]


def _write(path: Path, text: str) -> Path:
    with complete_file(path) as partial:
        partial.write_text(text, encoding="utf-8")
    return path

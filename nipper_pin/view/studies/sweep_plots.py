"""Results of a sweep as figures in files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...errors import InputError, UnknownNameError
from ...outputs import complete_folder
from ...study.sweep import read_sweep
from ..figure_file import save_figure
from .sweep_columns import Parameter, Quantity
from .sweep_figures import level_lines, main_effects

# Rows that are read.
_MOST_ROWS = 1_000_000
# Columns that can be drawn beside quantities, where a sweep has them.
_COUNTS = ("collisions", "turns", "repeats_after")


def plot_sweep(
    folder: str | Path,
    *,
    quantities: Sequence[str] | None = None,
    across: str | None = None,
    upwards: str | None = None,
    kind: str = "svg",
    target: str | Path | None = None,
) -> list[Path]:
    """Write the figures of a sweep; they take the place of earlier ones in one step.

    Args:
        folder: Folder of the sweep.
        quantities: What to draw; by default the first quantity of the study.
        across: Parameter across, of the level lines; by default the first one left.
        upwards: Parameter upwards; by default the next one left.
        kind: "svg", "png" or "pdf".
        target: Folder of the figures; by default ``plots`` in that of the sweep.

    Returns:
        For each quantity ``main_effects_NAME`` and, with two parameters or more,
        ``level_lines_NAME``.

    Raises:
        InputError: There is no such sweep, parameter or quantity, or nothing to draw.
    """
    sweep = read_sweep(folder, _MOST_ROWS)
    chosen = list(quantities or sweep.quantities[:1])
    counts = [name for name in _COUNTS if name in sweep.table.column_names]
    known = (*counts, *sweep.quantities)
    for name in chosen:
        if name not in known:
            raise UnknownNameError(kind="quantity", name=name, known=known, where=str(folder))
    parameters = [Parameter.of(sweep, place) for place in range(len(sweep.axes))]
    pair = _pair(parameters, across, upwards, str(folder))
    written: list[Path] = []
    home = Path(target) if target is not None else Path(folder) / "plots"
    with complete_folder(home, ()) as new:
        for name in chosen:
            quantity = Quantity.of(sweep, name)
            if not np.isfinite(quantity.values).any():
                message = f"{folder}: no scenario has a value of {name}; see the column message"
                raise InputError(message, quantity=name)
            figures = {"main_effects": main_effects(sweep, parameters, quantity)}
            if pair is not None:
                figures["level_lines"] = level_lines(sweep, *pair, quantity)
            for subject, figure in figures.items():
                file = new / f"{subject}_{name}.{kind}"
                save_figure(figure, file, kind)
                written.append(home / file.name)
    return written


def _pair(
    parameters: Sequence[Parameter], across: str | None, upwards: str | None, where: str
) -> tuple[Parameter, Parameter] | None:
    """The two parameters of the level lines, or None if there are not two."""
    by_name = {item.name: item for item in parameters}
    for name in (across, upwards):
        if name is not None and name not in by_name:
            raise UnknownNameError(kind="parameter", name=name, known=by_name, where=where)
    if across is not None and across == upwards:
        message = f"--x and --y are both {across}; level lines need two parameters"
        raise InputError(message, parameter=across)
    left = [name for name in by_name if name not in (across, upwards)]
    first = across or (left.pop(0) if left else None)
    second = upwards or (left.pop(0) if left else None)
    if first is None or second is None:
        if across or upwards:
            message = (
                f"--x and --y: level lines need two parameters; {where} has only {first or second}"
            )
            raise InputError(message, parameter=across or upwards)
        return None
    return by_name[first], by_name[second]

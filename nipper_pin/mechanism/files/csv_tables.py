"""Tables in CSV files of a model folder, read into the document so that it stands on its own."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ...errors import InputError, ModelError
from ...given import read_number
from ...texts import MOST_TABLE, followed, is_path, no_file, read_text
from ...units import M_PER_MM, RAD_PER_DEG
from ..drives import Table
from ..elements import Characteristic

if TYPE_CHECKING:
    from _csv import Reader

Columns = tuple[str, str]
_DRIVE: Columns = ("cylinder_angle_deg", "coordinate_rad")
_DRIVE_OF_SLIDE: Columns = ("cylinder_angle_deg", "coordinate_mm")
_SLIDE: Columns = ("coordinate_mm", "force_N")
_HINGE: Columns = ("coordinate_deg", "torque_N_m")
_SI = {
    "cylinder_angle_deg": RAD_PER_DEG,
    "coordinate_deg": RAD_PER_DEG,
    "coordinate_mm": M_PER_MM,
}


def inline_tables(data: Mapping[str, object], folder: Path | None, file: str) -> dict[str, object]:
    """Read the CSV files of table drives and springs into the document.

    Args:
        folder: Where they lie; None for a saved run, which holds its tables and is given no file.

    Returns:
        The document with the columns in place of each file name.

    Raises:
        ModelError: A file is missing, lies outside the folder or is not such a table.
        InputError: A saved run names a file.
    """
    changed = dict(data)
    for section, choices in (("drives", (_DRIVE, _DRIVE_OF_SLIDE)), ("springs", (_SLIDE, _HINGE))):
        entries = data.get(section)
        if isinstance(entries, Mapping):
            changed[section] = {
                name: _inlined(entry, choices, folder, f"{section}.{name}", file)
                if _has_file(section, entry)
                else entry
                for name, entry in entries.items()
            }
    return changed


def _has_file(section: str, entry: object) -> bool:
    """True for a table that names a file; one of a wrong kind is left to the description."""
    if not isinstance(entry, Mapping) or "file" not in entry:
        return False
    return section == "springs" or entry.get("law") == "table"


def _inlined(entry: Mapping[str, object], choices: Sequence[Columns], folder: Path | None,
             where: str, file: str) -> dict[str, object]:  # fmt: skip
    """A table with the columns of its file in place of the name."""
    if folder is None:
        message = f"{where} names a file, and a saved run holds its tables; save it again"
        raise InputError(message, table=where.partition(".")[2])
    table = {key: value for key, value in entry.items() if key != "file"}
    for key in (key for columns in choices for key in columns if key in table):
        allowed = "a file or its columns written out, not both"
        raise ModelError(file=file, key=f"{where}.{key}", value=table[key], allowed=allowed)
    return {**table, **_read_csv(entry["file"], choices, folder, where, file)}


def _read_csv(
    name: object, choices: Sequence[Columns], folder: Path, where: str, file: str
) -> dict[str, list[float]]:
    """Read the two columns of a CSV file."""
    key = f"{where}.file"
    if not (
        isinstance(name, str)
        and is_path(name)
        and followed(folder / name).is_relative_to(followed(folder))
    ):
        raise ModelError(file=file, key=key, value=name, allowed="a CSV file in the model folder")
    path = folder / name
    if not path.is_file():
        known = ", ".join(sorted(item.name for item in folder.glob("*.csv"))) or "none"
        kind = no_file(path)
        allowed = f"a CSV file in the model folder {folder}; found there: {known}"
        allowed += f"; {name} is {kind}" if kind else ""
        raise ModelError(file=file, key=key, value=name, allowed=allowed)
    try:
        text = read_text(path, MOST_TABLE)
        reader = csv.reader(io.StringIO(text, newline=""), skipinitialspace=True)
        return _columns(reader, choices, name)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        allowed = "a readable CSV file"
        raise ModelError(file=file, key=key, value=str(error), allowed=allowed) from error


def _columns(reader: Reader, choices: Sequence[Columns], name: str) -> dict[str, list[float]]:
    """The two columns of a table, checked."""
    header = tuple(next(reader, []))
    if header not in choices:
        raise ModelError(
            file=name,
            key="first line",
            value=",".join(header),
            allowed=f"the column names {' or '.join(map(','.join, choices))}",
        )
    columns: dict[str, list[float]] = {column: [] for column in header}
    places = list(columns.items())
    for row in reader:
        if not row:
            continue
        for place, (column, values) in enumerate(places):
            text = row[place] if place < len(row) else None
            values.append(_number(text, name, f"line {reader.line_num} {column}"))
    # Judged in SI units, as the same rows are in the document.
    first, second = (
        tuple(_SI.get(column, 1.0) * value for value in columns[column]) for column in header
    )
    try:
        if header in (_DRIVE, _DRIVE_OF_SLIDE):
            Table(cylinder_angle_rad=first, coordinate=second)
        else:
            Characteristic(coordinate=first, force=second)
    except InputError as error:
        value = f"{len(first)} rows"
        raise ModelError(file=name, key="table", value=value, allowed=error.message) from error
    return columns


def _number(text: str | None, file: str, key: str) -> float:
    """Convert one CSV field to a finite number."""
    try:
        value = read_number(text or "")
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ModelError(file=file, key=key, value=text, allowed="a finite number")
    return value

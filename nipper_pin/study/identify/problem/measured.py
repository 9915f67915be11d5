"""Measured rebounds from a CSV file, as spreadsheets and cameras write it."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from ....errors import InputError, UnknownNameError
from ....hybrid.result.quantities import refuse_unknown
from ....texts import MOST_TABLE, is_path, read_text
from .targets import QUANTITIES, Condition, Target

_STIFFNESS = ("stiffness_N_per_m", "stiffness_N_m_per_rad")
_COLUMNS = ("speed_rpm", "restitution", *_STIFFNESS, "quantity", "value", "sigma")
_NEEDED = ("speed_rpm", "quantity", "value", "sigma")
_NUMBERS = tuple(name for name in _COLUMNS if name != "quantity")
_RANGES: dict[str, tuple[Callable[[float], bool], str]] = {
    "speed_rpm": (lambda x: x > 0.0, "finite and above zero"),
    "sigma": (lambda x: x > 0.0, "finite and above zero"),
    **dict.fromkeys(_STIFFNESS, (lambda x: x > 0.0, "finite and above zero")),
    "restitution": (lambda x: 0.0 <= x <= 1.0, "between 0 and 1"),
    "value": (math.isfinite, "finite"),
}
# Each of them is simulated in every step of a fit.
_MOST_LINES = 10_000
_NUMBER = re.compile(r"[-+]?([0-9]+[.,]?[0-9]*|[.,][0-9]+)([eE][-+]?[0-9]+)?")
_WHOLE = re.compile(r"[-+]?[0-9]+")
_FRACTION = re.compile(r"[0-9]+([eE][-+]?[0-9]+)?")
_DECIMAL_COMMA = "write numbers with a decimal point, or separate the fields by semicolons"


@dataclass(frozen=True)
class _Line:
    """One line: its fields by column, and where it stands."""

    fields: dict[str, str]
    where: str


def read_measured(path: str | Path, stiffness: str = _STIFFNESS[0]) -> tuple[Target, ...]:
    """Read measured rebounds, for example from a high-speed camera.

    Fields are separated by commas, or, as spreadsheets do where the comma is decimal, by
    semicolons; then numbers may have a decimal comma, all of them. A byte order mark is skipped.

    Args:
        path: CSV file with the columns speed_rpm, quantity, value, sigma and, if they differ from
            those of the model, restitution and stiffness; rebound amplitudes in rad (or m), times
            in s.
        stiffness: Name of the column of stiffness, which says the unit.

    Raises:
        UnknownNameError: A column or quantity does not exist.
        InputError: The file cannot be read, or a number cannot be used; line and column are named.
    """
    file = Path(path)
    if not is_path(str(path)):
        message = f"measured: {str(path)!r} is no path of a file"
        raise InputError(message, file=str(path))
    try:
        text = read_text(file, MOST_TABLE)
        heading = next((line for line in text.splitlines() if line.strip()), "")
        separator = ";" if ";" in heading and "," not in heading else ","
        lines = list(islice(_lines(text, separator, file.name), _MOST_LINES + 1))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        message = f"{file.name}: {error}; a readable CSV file is wanted"
        raise InputError(message, file=str(file)) from error
    if not lines:
        message = f"{file.name}: no measurement below the heading"
        raise InputError(message, file=str(file))
    if len(lines) > _MOST_LINES:
        message = f"{file.name}: more measurements than the {_MOST_LINES} that are read"
        raise InputError(message, file=str(file))
    if separator == ";":
        _check_marks(lines)
    for name in _STIFFNESS:
        if name != stiffness and name in lines[0].fields:
            message = f"{file.name}: the column {name}: with this model it is {stiffness}"
            raise InputError(message, file=str(file), column=name)
    return tuple(_target(line, separator, stiffness) for line in lines)


def _lines(text: str, separator: str, file: str) -> Iterator[_Line]:
    """Lines below the heading, empty ones left out."""
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, skipinitialspace=True)
    columns: list[str] = []
    for row in reader:
        fields = [field.strip() for field in row]
        if not any(fields):
            continue
        where = f"{file}, line {reader.line_num}"
        if not columns:
            columns = fields
            _check_heading(columns, file)
            continue
        _check_width(fields, columns, where)
        fields += [""] * (len(columns) - len(fields))
        yield _Line(dict(zip(columns, fields, strict=False)), where)
    if not columns:
        _check_heading(columns, file)


def _check_heading(columns: list[str], file: str) -> None:
    for column in columns:
        if column not in _COLUMNS:
            raise UnknownNameError(kind="column", name=column, known=_COLUMNS, where=file)
        if columns.count(column) > 1:
            message = f"{file}: the column {column} stands there twice"
            raise InputError(message, file=file, columns=columns)
    for column in _NEEDED:
        if column not in columns:
            needed = ", ".join(_NEEDED)
            message = f"{file}: the column {column} is missing; there must be {needed}"
            raise InputError(message, file=file, columns=columns)


def _check_width(fields: list[str], columns: list[str], where: str) -> None:
    """Refuse more fields than columns: a decimal comma makes two fields of a number."""
    if not any(fields[len(columns) :]):
        return
    pairs = zip(columns, fields[:-1], fields[1:], strict=False)
    for column, whole, fraction in pairs:
        if column in _NUMBERS and _WHOLE.fullmatch(whole) and _FRACTION.fullmatch(fraction):
            message = (
                f"{where}, column {column}: {whole},{fraction} looks like a decimal comma, which "
                f"separates fields here; {_DECIMAL_COMMA}"
            )
            raise InputError(message, column=column, fields=fields)
    message = f"{where}: {len(fields)} fields below {len(columns)} columns"
    raise InputError(message, fields=fields)


def _check_marks(lines: list[_Line]) -> None:
    """Refuse decimal commas beside decimal points: one of them may separate thousands."""
    seen: dict[str, str] = {}
    for line in lines:
        for column in _NUMBERS:
            text = line.fields.get(column, "")
            for mark in ".,":
                if mark in text:
                    seen.setdefault(mark, f"{line.where}, column {column}: {text}")
    if len(seen) == 2:
        message = (
            f"{seen[',']} has a comma and {seen['.'].rpartition(': ')[2]} elsewhere a point: "
            "write all numbers alike"
        )
        raise InputError(message, places=list(seen.values()))


def _target(line: _Line, separator: str, stiffness: str) -> Target:
    quantity = line.fields["quantity"]
    refuse_unknown([quantity], QUANTITIES, f"{line.where}, column quantity")
    speed = _number(line, "speed_rpm", separator)
    optional = {
        name: _number(line, name, separator) if line.fields.get(name) else None
        for name in ("restitution", stiffness)
    }
    at = Condition(speed, optional["restitution"], optional[stiffness])
    settings = [f"{speed:g} r/min"]
    settings += [f"e = {at.restitution:g}"] if at.restitution is not None else []
    settings += [f"k = {at.stiffness:g}"] if at.stiffness is not None else []
    return Target(
        name=", ".join([quantity, *settings]),
        quantity=quantity,
        at=at,
        value=_number(line, "value", separator),
        sigma=_number(line, "sigma", separator),
    )


def _number(line: _Line, column: str, separator: str) -> float:
    text = line.fields[column]
    where = f"{line.where}, column {column}: {column} = {text!r} cannot be used"
    if not _NUMBER.fullmatch(text):
        message = f"{where}: a number is wanted"
        raise InputError(message, column=column, value=text)
    if "," in text and separator == ",":
        message = f"{where}: {_DECIMAL_COMMA}"
        raise InputError(message, column=column, value=text)
    number = float(text.replace(",", "."))
    right, allowed = _RANGES[column]
    if not (math.isfinite(number) and right(number)):
        message = f"{where}: it has to be {allowed}"
        raise InputError(message, column=column, value=text)
    return number

"""Measurements from CSV files: what spreadsheets write is read as it is meant, or refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from nipper_pin import InputError
from nipper_pin.study.identify import Target, read_measured

PLAIN = """speed_rpm,restitution,quantity,value,sigma
650,0.25,rebound_amplitude_1,0.00531,5e-5
450,,rebound_time_s_1,5.44e-3,0.00003
"""


def read(folder: Path, text: str, encoding: str = "utf-8") -> tuple[Target, ...]:
    file = folder / "camera.csv"
    file.write_bytes(text.encode(encoding))
    return read_measured(file)


def test_what_is_read_is_what_stands_there(tmp_path: Path) -> None:
    first, second = read(tmp_path, PLAIN)
    assert (first.at, first.value, first.sigma) == ((650.0, 0.25, None), 0.00531, 5e-5)
    assert (second.at, second.value, second.sigma) == ((450.0, None, None), 0.00544, 3e-5)
    assert (first.quantity, second.quantity) == ("rebound_amplitude_1", "rebound_time_s_1")
    assert first.name == "rebound_amplitude_1, 650 r/min, e = 0.25"


@pytest.mark.parametrize(
    ("text", "encoding"),
    [
        (PLAIN, "utf-8-sig"),
        (PLAIN.replace("\n", "\r\n"), "utf-8-sig"),
        (PLAIN.replace("\n", "\n\n"), "utf-8"),
        (PLAIN.replace(",", ";"), "utf-8"),
        (PLAIN.replace(",", ";").replace(".", ","), "utf-8-sig"),
        (PLAIN.replace("0.00531", '"0.00531"').replace(",", " , "), "utf-8"),
        (PLAIN.replace("5e-5\n", "5e-5,,\n"), "utf-8"),
    ],
    ids=["mark", "mark and line ends", "empty lines", "semicolons", "decimal commas",
         "quotes and spaces", "empty fields"],
)  # fmt: skip
def test_the_same_numbers_in_other_dress(tmp_path: Path, text: str, encoding: str) -> None:
    """Spreadsheets: byte order mark, their separator, and decimal commas beside semicolons."""
    assert read(tmp_path, text, encoding) == read(tmp_path, PLAIN)


@pytest.mark.parametrize(
    ("old", "new", "where", "word"),
    [
        ("5.44e-3,0.00003", "0,00544,0,00003", "line 3, column value", "0,00544.*decimal comma"),
        ("0.00531", '"0,00531"', "line 2, column value", "decimal point"),
        ("450,,", "450,5,,", "line 3, column speed_rpm", "450,5.*decimal comma"),
        ("5.44e-3", "fast", "line 3, column value", "'fast'"),
        ("5.44e-3", "nan", "line 3, column value", "'nan'"),
        ("5.44e-3", "1e400", "line 3, column value", "finite"),
        ("5.44e-3", "1_000", "line 3, column value", "'1_000'"),
        ("5.44e-3", "", "line 3, column value", "''"),
        ("5e-5", "0", "line 2, column sigma", "above zero"),
        ("5e-5", "-1e-5", "line 2, column sigma", "above zero"),
        ("0.25", "1.25", "line 2, column restitution", "between 0 and 1"),
        ("650", "-650", "line 2, column speed_rpm", "above zero"),
        ("rebound_time_s_1", "bounce", "line 3, column quantity", "bounce"),
        ("rebound_time_s_1", "first_rebound_time", "line 3", "rebound_time_s_1"),
        ("5e-5", "5e-5,7", "line 2", "6 fields below 5 columns"),
        ("restitution", "colour", "camera.csv", "colour"),
        ("restitution", "sigma", "camera.csv", "twice"),
        (",sigma\n", "\n", "camera.csv", "sigma is missing"),
    ],
)
def test_nonsense_is_refused_where_it_stands(
    tmp_path: Path, old: str, new: str, where: str, word: str
) -> None:
    """In one sentence with the line, the column and what may stand there."""
    assert old in PLAIN
    with pytest.raises(InputError, match=f"(?s){where}.*{word}"):
        read(tmp_path, PLAIN.replace(old, new, 1))


@pytest.mark.parametrize("text", ["", "\n\n", "speed_rpm,quantity,value,sigma\n"])
def test_files_without_measurements_are_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(InputError, match=r"missing|no measurement"):
        read(tmp_path, text)


def test_points_beside_decimal_commas_are_refused(tmp_path: Path) -> None:
    """One of them may separate thousands: 1.234 r/min is no speed to guess at."""
    text = PLAIN.replace(",", ";").replace("0.00531", "0,00531")
    with pytest.raises(InputError, match=r"line 2, column value: 0,00531 has a comma.*0\.25"):
        read(tmp_path, text)


def test_what_is_no_text_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="readable CSV"):
        read(tmp_path, PLAIN, "utf-16")

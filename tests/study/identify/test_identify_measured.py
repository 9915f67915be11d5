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
    first, second = read(tmp_path, text, encoding)
    assert (first.at, first.value, first.sigma) == ((650.0, 0.25, None), 0.00531, 5e-5)
    assert (second.at, second.value, second.sigma) == ((450.0, None, None), 0.00544, 3e-5)
    assert (first.name, second.quantity) == (
        "rebound_amplitude_1, 650 r/min, e = 0.25", "rebound_time_s_1"
    )  # fmt: skip


def test_what_is_no_text_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="readable CSV"):
        read(tmp_path, PLAIN, "utf-16")

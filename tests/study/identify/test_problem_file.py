"""Every key of the file of an identification, and measurements as spreadsheets write them."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import pytest
from snapshots import Words

from nipper_pin import InputError, Mechanism
from nipper_pin.study import identify
from nipper_pin.study.identify import Condition, Target, read_measured
from nipper_pin.study.identify.problem.targets import conditions, with_settings
from tests.refusals.studies import FIT, SEEN


def written(folder: Path, text: str) -> Path:
    (folder / "seen.csv").write_text(SEEN, encoding="utf-8")
    file = folder / "study.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_the_file_of_an_identification(tmp_path: Path, e62: Mechanism, words: Words) -> None:
    """All keys, measurements included, and what stands there where a file says nothing."""
    plain = FIT[: FIT.index("[limits]")].replace('measured = "seen.csv"\n', "")
    for line in ("prior_weight = 0.5\n", "absolute_sigma = false\n",
                 "[case]\nrest_rate = 1e-3\ntolerance = 1e-4\n"):  # fmt: skip
        plain = plain.replace(line, "")
    said = []
    for text, tolerance in ((FIT, 1e-4), (plain, 1e-8)):
        found = identify.read_problem(written(tmp_path, text))
        record = {key: value for key, value in asdict(found).items() if key != "sources"}
        assert record.pop("tolerance") == tolerance
        sigmas = [target.sigma for target in found.targets]
        assert sigmas == [0.005, 0.125, 1e-5, 2e-5][: len(sigmas)]
        preload, _ = found.parameters
        assert preload.start == pytest.approx(1e3 * e62.springs[0].preload)
        record["conditions"] = conditions(found.targets)
        said.append(json.dumps(record, indent=1))
    words("\n".join(said) + "\n")
    stiff = Condition(650.0, 0.2, 9500.0)
    machine = with_settings(found.sources.build(), stiff)
    assert machine.stop("jaw").restitution == 0.2
    assert machine.stop("steeve").restitution == 0.25
    assert machine.springs[0].stiffness == 9500.0


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

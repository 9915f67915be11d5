"""Goodness of a fit: what is stated is true, and data that contradict the fit are no success."""

from __future__ import annotations

import copy
import io
import json
import re
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from identification_judge import Measured, Truth, mistakes, truth
from scipy.stats import qmc
from snapshots import Words

from nipper_pin.cli import main

SCRIPTS = Path(__file__).resolve().parents[3] / "scripts"


@dataclass(frozen=True)
class Run:
    """One identification by the command: its status, document and printed report."""

    status: int
    document: dict[str, Any]
    report: str
    complaint: str


def run(folder: Path, *more: str) -> Run:
    arguments = ["identify", str(folder / "identify_camera.toml"), "--workers", "1", *more]
    with redirect_stdout(io.StringIO()) as out, redirect_stderr(io.StringIO()) as complaint:
        status = main([*arguments, "--json", str(folder / "found.json")])
    document = json.loads((folder / "found.json").read_text(encoding="utf-8"))
    return Run(status, document, out.getvalue(), complaint.getvalue())


def filmed(folder: Path, change: Any = None) -> Path:
    """The example of the repository with changed measurements."""
    name = "identify_camera_measured.csv"
    (folder / "identify_camera.toml").write_text(
        (SCRIPTS / "identify_camera.toml").read_text(encoding="utf-8"), encoding="utf-8"
    )
    heading, *lines = (SCRIPTS / name).read_text(encoding="utf-8").split()
    rows = [line.split(",") for line in lines]
    if change is not None:
        rows = [change(place, row) for place, row in enumerate(rows)]
    text = "\n".join([heading, *(",".join(row) for row in rows)]) + "\n"
    (folder / name).write_text(text, encoding="utf-8")
    return folder


@pytest.fixture(scope="module", autouse=True)
def wide() -> Iterator[None]:
    """A terminal wide enough that no cell is folded."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("COLUMNS", "140")
        yield


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Run:
    folder = filmed(tmp_path_factory.mktemp("filmed"))
    return run(folder, "--starts", "1", "--profiles", "1")


@pytest.fixture(scope="module")
def right(found: Run) -> Truth:
    numbers = {item["path"]: item["identified"] for item in found.document["parameters"]}
    return truth(Measured.read(SCRIPTS / "identify_camera.toml"), numbers)


def leaves(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Places of all numbers of a document."""
    inner: Any = value.items() if isinstance(value, dict) else enumerate(value)
    for key, part in inner:
        if isinstance(part, dict | list):
            yield from leaves(part, (*path, key))
        elif isinstance(part, int | float) and not isinstance(part, bool):
            yield (*path, key)


CHECKED = re.compile(
    r"goodness\.(chi_square|degrees_of_freedom|probability|scale)|within_\d+_percent"
    r"|targets\.\d+\.(wanted|sigma|found|relative_deviation|residual_sigmas)"
    r"|parameters\.\d+\.(standard_deviation|standard_deviation_scaled|range_left)"
    r"|correlations\.\d+\.\d+"
)
"""Numbers of the document that the judge holds against whole simulations."""


@pytest.mark.slow
def test_stated_numbers_are_those_of_whole_simulations(found: Run, right: Truth) -> None:
    """All of them at once; and the judge refuses a document in which any one is off by 1 %."""
    assert mistakes(found.document, right) == []
    held = [path for path in leaves(found.document) if CHECKED.fullmatch(".".join(map(str, path)))]
    assert len(held) == 4 + 2 + 12 * 5 + 3 * 3 + 9
    for path in held:
        doctored = copy.deepcopy(found.document)
        inner: Any = doctored
        for key in path[:-1]:
            inner = inner[key]
        inner[path[-1]] *= 1.01
        assert ".".join(map(str, path)) in mistakes(doctored, right), path


def test_the_rest_of_the_document_follows_from_it(found: Run) -> None:
    """Verdict, outliers and what is determined, by their definitions."""
    good, free = found.document["goodness"], found.document["parameters"]
    assert found.status == 0
    assert good["verdict"] == "agrees"
    assert good["absolute_sigma"] is True
    assert good["outliers"] == []
    assert good["suspects"] == []
    assert [item["determined"] for item in free] == [item["range_left"] < 0.5 for item in free]
    cost = 0.5 * sum(item["residual_sigmas"] ** 2 for item in found.document["targets"])
    assert found.document["cost"] == pytest.approx(cost, rel=1e-6)
    values = np.array(found.document["singular_values"])
    assert found.document["identifiable_directions"] == np.count_nonzero(values > 6.0)
    # Singular values and directions are those of the stated deviations and correlations.
    width = np.array([item["high"] - item["low"] for item in free])
    deviation = np.array([item["standard_deviation"] for item in free]) / width
    rows = np.array([[row[item["path"]] for item in free] for row in found.document["directions"]])
    covariance = np.linalg.inv(rows.T @ np.diag(values**2) @ rows + 12.0 * np.eye(3))
    stated = np.outer(deviation, deviation) * np.array(found.document["correlations"])
    assert stated == pytest.approx(covariance, rel=1e-6, abs=1e-12)


def test_the_report(found: Run, words: Words) -> None:
    """Its tables have the numbers of the document, of which a part is confirmed above."""
    words(found.report.rpartition("Next:")[0])


@pytest.mark.slow
def test_starts_are_those_of_the_seed(tmp_path: Path) -> None:
    """SciPy's scrambled Sobol sequence of the seed itself, in the middle four fifths of ranges."""
    filmed(tmp_path)
    document = run(tmp_path, "--starts", "3", "--seed", "7", "--profiles", "0").document
    assert document["seed"] == 7
    points = qmc.Sobol(3, scramble=True, rng=np.random.default_rng(7)).random_base2(7)
    free = document["parameters"]
    low, high = (np.array([item[key] for item in free]) for key in ("low", "high"))
    own = [item["before"] for item in free]
    wanted = [own, *(low + (0.1 + 0.8 * points[[0, 64]]) * (high - low)).tolist()]
    begun = [list(item["from"].values()) for item in document["starts"]]
    assert np.array(sorted(begun)) == pytest.approx(np.array(sorted(wanted)), rel=1e-12)
    best = {item["path"]: item["identified"] for item in free}
    assert document["starts"][0]["to"] == pytest.approx(best, rel=1e-12)


def in_milliseconds(_: int, row: list[str]) -> list[str]:
    speed, quantity, value, sigma = row
    factor = 1e3 if "time" in quantity else 1.0
    return [speed, quantity, repr(factor * float(value)), repr(factor * float(sigma))]


def misread(place: int, row: list[str]) -> list[str]:
    """One picture counted too many, in one line."""
    speed, quantity, value, sigma = row
    return [speed, quantity, repr(float(value) + 5e-5 * (place == 5)), sigma]


def far_off(_: int, row: list[str]) -> list[str]:
    """Sigmas ten thousand times too small."""
    return [*row[:3], repr(1e-4 * float(row[3]))]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "said", "outliers"),
    [
        (in_milliseconds, ["rebound_time_s_1 is wanted about 1", "is it in milliseconds?"], None),
        (misread, ["Outliers: rebound_time_s_1, 450 r/min"], ["rebound_time_s_1, 450 r/min"]),
        (far_off, ["sigmas are too small"], None),
    ],
)
def test_data_that_contradict_the_fit_are_no_success(
    tmp_path: Path,
    change: Any,
    said: list[str],
    outliers: list[str] | None,
) -> None:
    """Status 1 and one sentence; the result is written all the same, and says it, too.

    The sum of squares without the change is 3.5 with 9 degrees of freedom. Far-off data begin
    beyond any fixed penalty for values that make no machine: they are fitted as all others.
    """
    out = tmp_path / "machine"
    filmed(tmp_path, change)
    found = run(tmp_path, "--starts", "1", "--profiles", "0", "--out", str(out))
    assert found.status == 1
    good = found.document["goodness"]
    assert good["verdict"] == "contradicted"
    assert good["probability"] < 1e-3
    assert "CONTRADICT" in found.complaint
    text = " ".join(found.report.split())
    heading = (out / "machine.toml").read_text(encoding="utf-8")
    for words in said:
        assert words in found.complaint
        assert words in text
        assert words in heading
    if outliers is not None:
        assert good["outliers"] == outliers

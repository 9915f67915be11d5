"""The machine of the documentation that was filmed: its numbers come back, with true deviations.

Data that contradict the fit are no success. Every key of the file of an identification, and
measurements as spreadsheets write them.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2, qmc
from snapshots import Words

from nipper_pin import InputError, Mechanism
from nipper_pin.cli import main
from nipper_pin.study.identify import (
    Condition,
    Fit,
    Problem,
    Target,
    determinability,
    identify,
    read_measured,
    read_problem,
)
from nipper_pin.study.identify.problem.targets import conditions, with_settings
from tests.refusals.bases import right

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "scripts/maintain/confirm"))

import make_camera_example as example

SCRIPTS = Path(example.__file__).parents[2]


ONCE = ["--workers", "1", "--profiles", "0"]


@pytest.mark.slow
def test_starts_are_those_of_the_seed(capsys: pytest.CaptureFixture[str]) -> None:
    """SciPy's scrambled Sobol sequence of the seed itself, in the middle four fifths of ranges."""
    words = [*ONCE, "--starts", "3", "--seed", "7", "--json", "-"]
    assert main(["identify", str(SCRIPTS / "identify_camera.toml"), *words]) == 0
    document = json.loads(capsys.readouterr().out)
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


@pytest.fixture(scope="module")
def problem() -> Problem:
    return read_problem(SCRIPTS / "identify_camera.toml")


def off(fit: Fit) -> np.ndarray:
    """Distances of the found numbers from the true ones, in stated standard deviations."""
    stated = determinability(fit.objective, fit.best.z).deviations
    return np.array([
        (fit.values[item.path] - example.TRUTH[item.path])
        / (stated[item.path] * (item.high - item.low))
        for item in fit.objective.problem.parameters
    ])  # fmt: skip


def test_the_file_in_the_repository_is_what_the_script_writes(tmp_path: Path) -> None:
    """No measurement was improved by hand."""
    example.main(tmp_path / "again.csv")
    kept = (SCRIPTS / "identify_camera_measured.csv").read_text(encoding="utf-8")
    assert (tmp_path / "again.csv").read_text(encoding="utf-8") == kept


@pytest.mark.slow
def test_the_numbers_of_the_filmed_machine_come_back(problem: Problem) -> None:
    """Within three and a half stated standard deviations, from starts all over the bounds.

    The model's own numbers, where the search begins, are ten of them away and more, so a search
    that stays or a deviation stated far too large fails.
    """
    fit = identify(problem, starts=3, seed=1, workers=1)
    assert np.abs(off(fit)).max() < 3.5
    stated = determinability(fit.objective, fit.best.z).deviations
    for item in problem.parameters:
        away = abs(item.start - example.TRUTH[item.path])
        assert away > 10.0 * stated[item.path] * (item.high - item.low)
    # The page that explains it shows these numbers.
    page = (SCRIPTS.parent / "docs" / "identification.md").read_text(encoding="utf-8")
    for item in problem.parameters:
        deviation = stated[item.path] * (item.high - item.low)
        row = f"| `{item.path}` | {example.TRUTH[item.path]:g} | {item.start:g} |"
        assert f"{row} {fit.values[item.path]:.5g} ± {deviation:.2g} |" in page
    # All starts find the same machine.
    costs = [item.cost for item in fit.descents]
    assert costs == pytest.approx([costs[0]] * 3, rel=1e-4)


@pytest.mark.slow
def test_stated_deviations_are_those_of_repeated_films(problem: Problem) -> None:
    """Eight films of one machine: errors and misfits are distributed as they should be.

    24 errors in units of their stated deviations have a sum of squares with 24 degrees of freedom
    (the three of one film are correlated, which widens it a little, but not beyond 99.9 %), the
    misfits of 8 times 12 measurements less 3 numbers one with 72. Deviations wrong by a half, or
    times counted in other units, are far outside of both.
    """
    errors, misfits = [], []
    for seed in range(100, 108):
        seen = example.measurements(seed)
        targets = tuple(
            replace(target, value=value, sigma=sigma)
            for target, (_, _, value, sigma) in zip(problem.targets, seen, strict=True)
        )
        fit = identify(replace(problem, targets=targets), starts=1, workers=1)
        errors.append(off(fit))
        misfits.append(2.0 * fit.best.cost)
    low, high = chi2.interval(0.999, 24)
    assert low < np.sum(np.square(errors)) < high
    low, high = chi2.interval(0.999, 72)
    assert low < np.sum(misfits) < high


# --- files ---------------------------------------------------------------------------------------


def written(folder: Path, text: str) -> Path:
    (folder / "seen.csv").write_text(right("seen.csv"), encoding="utf-8")
    file = folder / "study.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_the_file_of_an_identification(tmp_path: Path, e62: Mechanism, words: Words) -> None:
    """All keys, measurements included, and what stands there where a file says nothing."""
    whole = right("fit.toml")
    plain = whole.partition("[limits]")[0].replace('measured = "seen.csv"\n', "")
    for line in ("prior_weight = 0.5\n", "absolute_sigma = false\n",
                 "[case]\nrest_rate = 1e-3\ntolerance = 1e-4\n"):  # fmt: skip
        plain = plain.replace(line, "")
    said = []
    for text, tolerance in ((whole, 1e-4), (plain, 1e-8)):
        found = read_problem(written(tmp_path, text))
        record = {key: value for key, value in asdict(found).items() if key != "mechanism"}
        assert record.pop("tolerance") == tolerance
        sigmas = [target.sigma for target in found.targets]
        assert sigmas == [0.005, 0.125, 1e-5, 2e-5][: len(sigmas)]
        preload, _ = found.parameters
        assert preload.start == pytest.approx(1e3 * e62.springs[0].preload)
        record["conditions"] = conditions(found.targets)
        said.append(json.dumps(record, indent=1))
    words("\n".join(said) + "\n")
    stiff = Condition(650.0, 0.2, 9500.0)
    machine = with_settings(found.mechanism, stiff)
    assert machine.stop("jaw").restitution == 0.2
    assert machine.stop("steeve").restitution == 0.25
    assert machine.springs[0].stiffness == 9500.0


PLAIN = right("camera.csv")


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

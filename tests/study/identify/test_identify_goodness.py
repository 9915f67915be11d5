"""Goodness of a fit: what is stated is true, and data that contradict the fit are no success."""

from __future__ import annotations

import copy
import io
import json
import math
import re
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from identification_judge import Measured, Truth, mistakes, truth
from scipy.stats import qmc

from nipper_pin.cli import main
from nipper_pin.study.identify.fitting.goodness import Goodness, Verdict
from nipper_pin.study.identify.fitting.outliers import _refitted, leverages

SCRIPTS = Path(__file__).resolve().parents[3] / "scripts"


# Free numbers of the example: as people read them, and the factor from the unit of the file.
WORDS = {
    "stops.jaw.restitution": ("restitution of stop jaw", 1.0),
    "springs.steeve.preload_length_mm": ("preload length of spring steeve [mm]", 1.0),
    "cylinder.angle_at_touch_deg": ("cylinder angle at touch [deg]", 1.0),
}


QUANTITIES = re.compile(r"^rebound_(amplitude|time_s)_([12])(?=,)")


def in_words(match: re.Match[str]) -> str:
    """The quantity of a target without a name of its own, as people read it."""
    return f"{('first', 'second')[int(match[2]) - 1]} rebound {match[1].removesuffix('_s')}"


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


def last_digit(text: str) -> float:
    """Half a unit of the last digit of a number."""
    exponent = Decimal(text).as_tuple().exponent
    assert isinstance(exponent, int)
    return 0.5 * 10.0**exponent * (1.0 + 1e-9)


def cells(report: str, heading: str) -> list[list[str]]:
    """Rows of a printed table."""
    lines = report.splitlines()
    begin = next(i for i, line in enumerate(lines) if line.split()[:1] == [heading])
    rows = []
    for line in lines[begin + 2 :]:
        parts = [part for part in re.split(r"\s{2,}", line.strip()) if part]
        if len(parts) < 5 or parts[0] == "number":
            break
        rows.append(parts)
    return rows


def printed_mistakes(report: str, document: dict[str, Any]) -> list[str]:
    """Cells of the printed tables that say something else than the document."""
    wrong = []

    def hold(key: str, text: str, value: float, half: float) -> None:
        """``half`` a unit of the last digit that is shown."""
        number = float(text.rstrip("!*?% ").replace("%", ""))
        if abs(number - value) > half * (1.0 + 1e-9):
            wrong.append(key)

    def digits(value: float, count: int) -> float:
        return 0.5 * 10.0 ** (np.floor(np.log10(abs(value))) + 1 - count) if value else 0.0

    targets = cells(report, "target")
    if len(targets) != len(document["targets"]):
        wrong.append("targets")
    for row, item in zip(targets, document["targets"], strict=False):
        name, wanted, sigma, value, deviation, sigmas = row
        named = re.fullmatch(r"(.*?)(?: \[(ms|mdeg|%)\])?", name)
        if named is None or named[1] != QUANTITIES.sub(in_words, item["name"]):
            wrong.append("target.name")
        # Heights in rad and times in s are read in other units, changes in none.
        factor = {"ms": 1e3, "mdeg": 180e3 / math.pi, "%": 100.0, None: 1.0}[named and named[2]]
        for key, text in (("wanted", wanted), ("sigma", sigma), ("found", value)):
            read = factor * item[key]
            hold(f"target.{key}", text, read, digits(read, 2 if key == "sigma" else 5))
        hold("target.deviation", deviation, 100.0 * item["relative_deviation"], 0.005)
        hold("target.sigmas", sigmas, item["residual_sigmas"], 0.005)
        if sigmas.endswith("!") != item["outlier"]:
            wrong.append("target.outlier")
    free = cells(report, "number")
    if len(free) != len(document["parameters"]):
        wrong.append("free")
    for row, item in zip(free, document["parameters"], strict=False):
        path, before, value, plus, scaled, bounds, left = row
        if path != WORDS[item["path"]][0]:
            wrong.append("free.path")
        hold("free.before", before, item["before"], digits(item["before"], 5))
        hold("free.found", value, item["identified"], digits(item["identified"], 5))
        hold("free.plus", plus, item["standard_deviation"], digits(item["standard_deviation"], 2))
        second = item["standard_deviation_scaled"]
        hold("free.scaled", scaled, second, digits(second, 2))
        if [float(x) for x in bounds.split("..")] != [item["low"], item["high"]]:
            wrong.append("free.bounds")
        hold("free.left", left, 100.0 * item["range_left"], 0.5)
        if left.endswith("?") == item["determined"]:
            wrong.append("free.determined")
    text, good = " ".join(report.split()), document["goodness"]
    said = re.search(r"chi-square (\S+), degrees of freedom (\S+), probability (\S+)\.", text)
    if said is None:
        return [*wrong, "goodness"]
    for item in document["profiles"]:
        line = re.search(
            rf"profile of {re.escape(WORDS[item['path']][0])} .*? sigma = (\S+)\): (.*)", text
        )
        if line is None:
            return [*wrong, "profile"]
        hold("profile.sigma", line[1], item["sigma"], digits(item["sigma"], 3))
        points = re.findall(r"(\S+): (\S+) \((\S+)\)", line[2])
        columns = (item["values"], item["cost"], item["quadratic"])
        for point, numbers in zip(points, zip(*columns, strict=True), strict=True):
            hold("profile.values", point[0], numbers[0], digits(numbers[0], 4))
            hold("profile.cost", point[1], numbers[1], 0.005)
            hold("profile.quadratic", point[2], numbers[2], 0.005)
    for key, part, count in (("chi_square", 1, 4), ("degrees_of_freedom", 2, 3),
                             ("probability", 3, 2)):  # fmt: skip
        hold(key, said[part], good[key], digits(good[key], count))
    return wrong


def test_the_printed_tables_say_what_the_document_says(found: Run) -> None:
    """Every cell, to its last digit; each number of the document changed by 6 % is missed in it."""
    assert printed_mistakes(found.report, found.document) == []
    for path in leaves(found.document):
        key = ".".join(map(str, path))
        if not re.fullmatch(
            r"goodness\.(chi_square|degrees_of_freedom|probability)|"
            r"targets\.\d+\.(wanted|sigma|found|relative_deviation|residual_sigmas)|"
            r"profiles\.\d+\.(sigma|(values|cost|quadratic)\.\d+)|"
            r"parameters\.\d+\.(before|identified|low|high|standard_deviation\w*|range_left)", key
        ):  # fmt: skip
            continue
        doctored = copy.deepcopy(found.document)
        inner: Any = doctored
        for part in path[:-1]:
            inner = inner[part]
        inner[path[-1]] += math.copysign(0.06 * abs(inner[path[-1]]) + 0.012, inner[path[-1]])
        assert printed_mistakes(found.report, doctored), key


@pytest.mark.slow
def test_starts_are_those_of_the_seed(tmp_path: Path) -> None:
    """SciPy's scrambled Sobol sequence of the seed itself, in the middle four fifths of ranges."""
    filmed(tmp_path)
    for seed in (1, 7):
        more = ("--starts", "3", "--seed", str(seed), "--profiles", "0")
        document = run(tmp_path, *more).document
        assert document["seed"] == seed
        points = qmc.Sobol(3, scramble=True, rng=np.random.default_rng(seed)).random_base2(7)
        low, high = (
            np.array([item[key] for item in document["parameters"]]) for key in ("low", "high")
        )
        own = [item["before"] for item in document["parameters"]]
        wanted = [own, *(low + (0.1 + 0.8 * points[[0, 64]]) * (high - low)).tolist()]
        begun = [list(item["from"].values()) for item in document["starts"]]
        assert np.array(sorted(begun)) == pytest.approx(np.array(sorted(wanted)), rel=1e-12)
        best = {item["path"]: item["identified"] for item in document["parameters"]}
        assert document["starts"][0]["to"] == pytest.approx(best, rel=1e-12)


def in_milliseconds(_: int, row: list[str]) -> list[str]:
    speed, quantity, value, sigma = row
    factor = 1e3 if "time" in quantity else 1.0
    return [speed, quantity, repr(factor * float(value)), repr(factor * float(sigma))]


def in_degrees(_: int, row: list[str]) -> list[str]:
    speed, quantity, value, sigma = row
    factor = 180.0 / np.pi if "amplitude" in quantity else 1.0
    return [speed, quantity, repr(factor * float(value)), repr(factor * float(sigma))]


def noisier(place: int, row: list[str]) -> list[str]:
    """Errors three times as large as stated."""
    speed, quantity, value, sigma = row
    error = 3.0 * float(sigma) * np.random.default_rng([5, place]).standard_normal()
    return [speed, quantity, repr(float(value) + error), sigma]


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
        (in_degrees, ["rebound_amplitude_1 is wanted about", "is it in degrees"], None),
        (noisier, ["sigmas are too small"], None),
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


def test_scaled_deviations_follow_the_noise(tmp_path: Path, found: Run) -> None:
    """Noise tripled: deviations by the sigmas stay, those that are scaled grow as the misfit."""
    (tmp_path / "noisy").mkdir()
    filmed(tmp_path / "noisy", noisier)
    noisy = run(tmp_path / "noisy", "--starts", "1", "--profiles", "0").document
    ratio = noisy["goodness"]["scale"] / found.document["goodness"]["scale"]
    assert ratio > 1.5
    for before, after in zip(found.document["parameters"], noisy["parameters"], strict=True):
        assert after["standard_deviation"] == pytest.approx(before["standard_deviation"], rel=0.1)
        grown = after["standard_deviation_scaled"] / before["standard_deviation_scaled"]
        assert grown == pytest.approx(ratio, rel=0.1)


@pytest.mark.slow
def test_sigmas_that_are_weights_alone(tmp_path: Path) -> None:
    """All sigmas by one factor: the fit and its scaled deviations stay, and nothing is tested."""

    def wider(_: int, row: list[str]) -> list[str]:
        return [*row[:3], repr(1.7 * float(row[3]))]

    results = []
    for name, change in (("plain", None), ("wide", wider)):
        (tmp_path / name).mkdir()
        filmed(tmp_path / name, change)
        file = tmp_path / name / "identify_camera.toml"
        weights = "absolute_sigma = false\n[parameters"
        text = file.read_text(encoding="utf-8").replace("[parameters", weights, 1)
        file.write_text(text, encoding="utf-8")
        results.append(run(tmp_path / name, "--starts", "1", "--profiles", "0"))
    one, other = (item.document for item in results)
    assert [item.status for item in results] == [0, 0]
    assert one["goodness"]["verdict"] == "weights alone"
    assert one["goodness"]["probability"] is None
    assert one["goodness"]["scale"] / other["goodness"]["scale"] == pytest.approx(1.7, rel=1e-4)
    for a, b in zip(one["parameters"], other["parameters"], strict=True):
        stated = a["standard_deviation_scaled"]
        assert a["identified"] == pytest.approx(b["identified"], abs=1e-3 * stated)
        assert b["standard_deviation_scaled"] == pytest.approx(stated, rel=1e-3)
        assert b["standard_deviation"] / a["standard_deviation"] == pytest.approx(1.7, rel=1e-2)


def test_as_many_numbers_as_targets_test_nothing() -> None:
    """Two targets that determine two numbers leave nothing over, and the sentence says so.

    With a third target that misses by five of its sigmas the same words would be wrong.
    """
    common = {"probability": None, "outliers": (), "suspects": (), "absolute_sigma": True}
    none_left = Goodness(
        names=("a", "b"), residuals=np.zeros(2), chi_square=0.0, fitted=2.0, **common
    )
    assert none_left.verdict is Verdict.UNTESTED
    assert none_left.sentence().startswith("The targets (2) are no more than the numbers")
    one_left = Goodness(
        names=("a", "b", "c"), residuals=np.array([0.0, 0.0, 5.0]), chi_square=25.0, fitted=2.0,
        **{**common, "probability": 5.7e-7},
    )  # fmt: skip
    assert one_left.verdict is Verdict.CONTRADICTED
    assert "chi-square 25, degrees of freedom 1, probability 5.7e-07" in one_left.sentence()


@pytest.mark.parametrize("prior_weight", [0.5, 3.0])
def test_a_fit_without_a_target_knows_the_prior(prior_weight: float) -> None:
    """The step is the least squares of targets and prior rows, put under one another.

    The prior rows are the square roots of 12 (a range's variance) and of the weight's square; a
    weight that entered unsquared would differ by a tenth at 0.5, and more at 3.
    """
    rng = np.random.default_rng(5)
    rows, residuals = rng.normal(size=(5, 3)), rng.normal(size=5)
    stacked = np.vstack([rows, math.sqrt(12.0) * np.eye(3), prior_weight * np.eye(3)])
    wanted = np.concatenate([residuals, np.zeros(6)])
    expected = np.linalg.lstsq(stacked, wanted, rcond=None)[0]
    np.testing.assert_allclose(_refitted(residuals, rows, prior_weight), expected, rtol=1e-12)
    hat = np.array([
        rows[k] @ np.linalg.lstsq(stacked, np.eye(len(stacked))[k], rcond=None)[0] for k in range(5)
    ])  # fmt: skip
    np.testing.assert_allclose(leverages(rows, prior_weight), hat, rtol=1e-12)

"""What an identification states, held against whole simulations: shares no code with the fit.

Everything is found again from the problem's two files and the public door alone: values by
simulating the model with the identified numbers, derivatives by differences of such simulations,
covariance and correlations by numpy from those, and the probability of chi-square by mpmath.
"""

from __future__ import annotations

import csv
import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mpmath
import numpy as np

import nipper_pin as nip


@dataclass(frozen=True)
class Measured:
    """Rows of the measurements, and the ranges of the free numbers."""

    rows: tuple[dict[str, str], ...]
    model: str
    ranges: dict[str, tuple[float, float]]

    @classmethod
    def read(cls, problem: Path) -> Measured:
        document = tomllib.loads(problem.read_text(encoding="utf-8"))
        with (problem.parent / document["measured"]).open(encoding="utf-8") as stream:
            rows = tuple(csv.DictReader(stream))
        parameters = document["parameters"].items()
        ranges = {path: (item["low"], item["high"]) for path, item in parameters}
        return cls(rows, document["model"], ranges)

    def simulated(self, numbers: Mapping[str, float]) -> np.ndarray:
        """Values of all rows by simulation."""
        machine = nip.load(self.model, dict(numbers))
        runs = {
            speed: nip.simulate(machine, nip.Case(speed_rpm=speed)).collisions
            for speed in {float(row["speed_rpm"]) for row in self.rows}
        }
        found = []
        for row in self.rows:
            name, _, place = row["quantity"].rpartition("_")
            hit = runs[float(row["speed_rpm"])][int(place) - 1]
            value = {
                "rebound_amplitude": hit.rebound_amplitude,
                "rebound_time_s": hit.rebound_time,
            }[name]
            found.append(math.nan if value is None else value)
        return np.array(found)


@dataclass(frozen=True)
class Truth:
    """What an identification has to state."""

    wanted: np.ndarray
    sigma: np.ndarray
    found: np.ndarray
    covariance: np.ndarray
    scaled: np.ndarray
    fitted: float

    @property
    def residuals(self) -> np.ndarray:
        return (self.found - self.wanted) / self.sigma

    @property
    def chi_square(self) -> float:
        return float(sum(x * x for x in self.residuals.tolist()))

    @property
    def freedom(self) -> float:
        return len(self.wanted) - self.fitted

    @property
    def probability(self) -> float:
        """Upper incomplete gamma function, regularised."""
        half = mpmath.mpf(self.freedom) / 2
        return float(mpmath.gammainc(half, self.chi_square / 2, mpmath.inf, regularized=True))


def truth(measured: Measured, numbers: Mapping[str, float]) -> Truth:
    """Find again what an identification with these numbers has to state."""
    wanted = np.array([float(row["value"]) for row in measured.rows])
    sigma = np.array([float(row["sigma"]) for row in measured.rows])
    columns, widths = [], []
    for path, value in numbers.items():
        low, high = measured.ranges[path]
        step = 1e-3 * (high - low)
        ahead = measured.simulated({**numbers, path: value + step})
        behind = measured.simulated({**numbers, path: value - step})
        columns.append((ahead - behind) / (2.0 * step))
        widths.append(high - low)
    slopes = np.array(columns).T / sigma[:, None]
    known = np.diag(12.0 / np.square(widths))
    covariance = np.linalg.inv(slopes.T @ slopes + known)
    found = measured.simulated(numbers)
    fitted = float(np.trace(slopes @ covariance @ slopes.T))
    first = Truth(wanted, sigma, found, covariance, covariance, fitted)
    scale = first.chi_square / first.freedom
    scaled = np.linalg.inv(slopes.T @ slopes / scale + known)
    return Truth(wanted, sigma, found, covariance, scaled, fitted)


def mistakes(document: Mapping[str, Any], right: Truth) -> list[str]:
    """Keys of an identification that state something else than the truth.

    The fit is solved to 1e-8 and simulated to 1e-8, its derivatives are those of the same step:
    1e-4 of a standard deviation is generous, and far below the two digits that people read.
    """
    wrong: list[str] = []

    def hold(key: str, stated: float | None, true: float, rel: float, near: float = 0.0) -> None:
        if stated is None or not math.isclose(stated, true, rel_tol=rel, abs_tol=near):
            wrong.append(key)

    good = document["goodness"]
    hold("goodness.chi_square", good["chi_square"], right.chi_square, 1e-4)
    hold("goodness.degrees_of_freedom", good["degrees_of_freedom"], right.freedom, 1e-4)
    hold("goodness.probability", good["probability"], right.probability, 1e-3, 1e-12)
    hold("goodness.scale", good["scale"], math.sqrt(right.chi_square / right.freedom), 1e-4)
    for place, item in enumerate(document["targets"]):
        key = f"targets.{place}"
        hold(f"{key}.wanted", item["wanted"], right.wanted[place], 1e-12)
        hold(f"{key}.sigma", item["sigma"], right.sigma[place], 1e-12)
        hold(f"{key}.found", item["found"], right.found[place], 1e-7)
        hold(f"{key}.residual_sigmas", item["residual_sigmas"], right.residuals[place], 0.0, 1e-4)
        relative = right.found[place] / right.wanted[place] - 1.0
        hold(f"{key}.relative_deviation", item["relative_deviation"], relative, 0.0, 1e-7)
    off = np.abs(right.found / right.wanted - 1.0)
    for part, key in ((0.04, "within_4_percent"), (0.10, "within_10_percent")):
        hold(key, document[key], float(np.count_nonzero(off <= part)), 0.0)
    deviations = np.sqrt(np.diag(right.covariance))
    correlations = right.covariance / np.outer(deviations, deviations)
    for place, item in enumerate(document["parameters"]):
        key = f"parameters.{place}"
        width = item["high"] - item["low"]
        hold(f"{key}.standard_deviation", item["standard_deviation"], deviations[place], 1e-4)
        scaled = math.sqrt(right.scaled[place, place])
        hold(f"{key}.standard_deviation_scaled", item["standard_deviation_scaled"], scaled, 1e-4)
        hold(f"{key}.range_left", item["range_left"], deviations[place] / width * 12**0.5, 1e-4)
        for other, value in enumerate(document["correlations"][place]):
            hold(f"correlations.{place}.{other}", value, correlations[place, other], 0.0, 1e-4)
    return wrong

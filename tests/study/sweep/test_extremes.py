"""The smallest and the largest row of a sweep, against a search through all of its rows."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from msgspec.structs import replace
from sweep_studies import plan

from nipper_pin.study.sweep.job import Job
from nipper_pin.study.sweep.results.extremes import Extremes

AXES = ("speed_rpm", "preload")


@pytest.fixture(scope="module")
def job(tmp_path_factory: pytest.TempPathFactory) -> Job:
    axes = "".join(f"[parameters.{name}]\nvalues = [1.0]\n" for name in AXES)
    return plan(tmp_path_factory.mktemp("job"), axes).job


def extremes(job: Job, quantity: str, **units: str) -> Extremes:
    return Extremes(replace(job, quantities=(quantity, "another"), units={**job.units, **units}))


def table(scenarios: Any, values: Any, quantity: str = "duration_s") -> pa.Table:
    """Rows whose parameters follow from their number."""
    numbers = {name: [float(n * k) for n in scenarios] for k, name in enumerate(AXES, start=2)}
    return pa.table({"scenario": list(scenarios), quantity: values, **numbers})


@pytest.mark.parametrize("seed", range(5))
def test_the_rows_are_those_of_a_search(seed: int, job: Job) -> None:
    """In any order of chunks; values that are missing or occur twice are among the rows."""
    random = np.random.default_rng(seed)
    values = random.integers(0, 20, 60) / 8.0
    values[random.random(60) < 0.3] = math.nan
    # A chunk without a value changes nothing.
    values[10:20] = math.nan
    found = extremes(job, "duration_s")
    for chunk in random.permutation(6):
        rows = range(10 * chunk, 10 * chunk + 10)
        found.add(table(rows, values[rows.start : rows.stop]))
    known = [(value, n) for n, value in enumerate(values.tolist()) if not math.isnan(value)]
    low, high = min(known), max(known, key=lambda pair: (pair[0], -pair[1]))
    for item, (value, scenario) in ((found.smallest, low), (found.largest, high)):
        assert item is not None
        assert (item.value, item.scenario) == (value, scenario)
        assert item.numbers == {"speed_rpm": 2.0 * scenario, "preload": 3.0 * scenario}
    assert found.record() == {
        "quantity": "duration_s",
        **{
            word: {"scenario": n, "value": value,
                   "numbers": {"speed_rpm": 2.0 * n, "preload": 3.0 * n}}
            for word, (value, n) in (("smallest", low), ("largest", high))
        },
    }  # fmt: skip


def test_indices_are_ordered_along_the_turn(job: Job) -> None:
    """From the start of turns, at 24: a rest at 0.5 is later than one at 39.5."""
    found = extremes(job, "rest_index")
    found.add(table((1, 2, 3), [39.5, 0.5, 36.25], "rest_index"))
    found.add(table((4, 5), [0.25, 38.0], "rest_index"))
    assert found.smallest is not None
    assert found.largest is not None
    assert (found.smallest.value, found.largest.value) == (36.25, 0.5)


def test_rows_without_any_value(job: Job) -> None:
    """Nothing is said where no row has a value."""
    found = extremes(job, "duration_s")
    found.add(table(range(3), [math.nan, math.nan, None]))
    assert (found.smallest, found.largest, found.sentences()) == (None, None, [])
    assert found.record()["smallest"] is None


def test_quantities_that_are_no_floats(job: Job) -> None:
    """Counts, and whether the premise holds, which is not known of every row."""
    counts = extremes(job, "collisions")
    counts.add(table((4, 5, 6), [7, 3, 9], "collisions"))
    assert counts.sentences() == [
        "Smallest collisions: 3 (scenario 5: speed_rpm 10, preload 15)",
        "Largest collisions: 9 (scenario 6: speed_rpm 12, preload 18)",
    ]
    held = extremes(job, "premise_holds")
    held.add(table((4, 5, 6), [None, True, False], "premise_holds"))
    assert held.smallest is not None
    assert held.largest is not None
    assert (held.smallest.scenario, held.largest.scenario) == (6, 5)


@pytest.mark.parametrize(
    ("unit", "told"),
    [("rad", f"{18e4 / math.pi * 2.5e-5:.4g} mdeg"), ("m", "25.00 um")],
)
def test_values_are_told_in_the_units_that_people_read(unit: str, told: str, job: Job) -> None:
    """Of a hinge in mdeg, of a slide in um; parameters in the units of the study."""
    found = extremes(job, "rebound_amplitude_1", rebound_amplitude_1=unit)
    found.add(table((8,), [2.5e-5], "rebound_amplitude_1"))
    (smallest, largest) = found.sentences()
    assert smallest == (
        f"Smallest first rebound amplitude: {told} (scenario 8: speed_rpm 16, preload 24)"
    )
    assert largest == smallest.replace("Smallest", "Largest")

"""The reduced engine in the benchmark: work against precision, build time and throughput."""

from __future__ import annotations

from dataclasses import astuple
from typing import Any

import numpy as np

from nipper_pin.reduced import ReducedModel, build, transition, transitions
from nipper_pin.units import MS_PER_S

from ..tolerances import REDUCED_DEFAULT
from .certified import Certified
from .timing import Timing, timed
from .work_precision import Observed, Row, graded

_TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
_BATCH, _QUICK_BATCH = 50_000, 10_000
# Cases of a batch that is timed for a row.
_SHORT_BATCH = 1000
# A batch varies the speed by this fraction about the certified case.
_SPAN = 0.02
# A measurement is not repeated beyond this time [s].
_BUDGET_S, _QUICK_BUDGET_S = 3.0, 0.5


def reduced_work(
    reference: Certified, *, quick: bool, repeats: int
) -> tuple[list[Row], dict[str, Any]]:
    """Measure the reduced engine: called from Python case by case, and in a batch.

    Rows by tolerance come with what the engine is measured by: time to build its tables, of a first
    transition with its compilation, of one more, true error and its own bound.
    """
    mechanism, speed = reference.mechanism(), reference.speed_rpm
    budget = _QUICK_BUDGET_S if quick else _BUDGET_S
    building = timed(lambda: build(mechanism), repeats, budget)
    model = build(mechanism)
    summary: dict[str, Any] = {"build_ms": building.wall_ms, "build_first_ms": building.first_ms}
    rows = [_rows(model, reference, tolerance, repeats, budget) for tolerance in _TOLERANCES]
    single, batch, bound = rows[_TOLERANCES.index(REDUCED_DEFAULT)]
    summary |= {
        "transition_ms": single.wall_ms,
        "transition_in_batch_ms": batch.wall_ms,
        "error": single.error_worst,
        "stated_error": bound,
        "first_transition_ms": rows[0][0].first_ms,
    }
    count = _QUICK_BATCH if quick else _BATCH
    sweep = np.linspace((1.0 - _SPAN) * speed, (1.0 + _SPAN) * speed, count)
    timing = timed(lambda: transitions(model, speed_rpm=sweep), repeats, budget)
    summary |= {"batch": count, "transitions_per_s": MS_PER_S * count / timing.wall_ms}
    return [*(item[0] for item in rows), *(item[1] for item in rows)], summary


def _rows(
    model: ReducedModel, reference: Certified, tolerance: float, repeats: int, budget: float
) -> tuple[Row, Row, float]:
    """Work of one tolerance, called case by case and in a batch, and the error that is stated."""
    speed = reference.speed_rpm
    speeds = np.full(_SHORT_BATCH, speed)
    single = timed(
        lambda: transition(model, speed_rpm=speed, tolerance=tolerance), 100 * repeats, budget
    )
    batch = timed(
        lambda: transitions(model, speed_rpm=speeds, tolerance=tolerance), repeats, budget
    )
    first, median, fastest, spread = (time / _SHORT_BATCH for time in astuple(batch)[:4])
    each = Timing(first, median, fastest, spread, batch.runs)
    found = transition(model, speed_rpm=speed, tolerance=tolerance)
    observed = Observed(
        times=found.time,
        impulses=found.impulse,
        amplitudes=found.rebound_amplitude,
        transition_time=found.duration,
    )
    name = f"{tolerance:.0e}"
    return (
        graded("reduced", name, single, observed, reference),
        graded("reduced, batch", name, each, observed, reference),
        found.error_bound,
    )

"""Designs of problems that are written as a file, as a search reports them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from nipper_pin.study.optimise import Design, Problem, read_problem
from nipper_pin.study.optimise.points import Evaluator

MASS = Path(__file__).resolve().parents[2] / "verification" / "models" / "bouncing_mass"
# A ball on a table that rises by its lead in a second.
BALL = f"""
model = "{MASS}"
minimise = "duration_s"
maximise = "rebound_amplitude_1"
case = {{ speed_rpm = 60.0 }}
[parameters]
"stops.table.restitution" = {{ low = 0.05, high = 0.3 }}
"drives.table.lead_mm_per_turn" = {{ low = 20.0, high = 100.0 }}
"""


def study(folder: Path, text: str) -> Path:
    file = folder / "study.toml"
    file.write_text(f"format = 1\n{text}", encoding="utf-8")
    return file


def problem(folder: Path, text: str) -> Problem:
    return read_problem(study(folder, text))


def parameter(path: str, low: float, high: float) -> str:
    return f'[parameters."{path}"]\nlow = {low}\nhigh = {high}\n'


def design(found: Problem, numbers: Any, **changes: Any) -> Design:
    """The design of some numbers, with their values; changed afterwards where that is wanted."""
    source = Evaluator(found)
    z = (np.array(numbers) - found.low) / found.width
    point = source.at(z)
    assert point.usable, point.why
    made = Design(
        z=tuple(z.tolist()), numbers=found.numbers(z), values=dict(point.values),
        errors=source.errors(z), slacks=point.slacks, inside=True, holding=(), engine=point.engine,
    )  # fmt: skip
    return replace(made, **changes)

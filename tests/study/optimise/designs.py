"""Designs of problems that are written as a file, as a search reports them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from nipper_pin.study.optimise import Design, Problem, read_problem
from nipper_pin.study.optimise.points import Evaluator

MASS = Path(__file__).resolve().parents[2] / "verification" / "models" / "bouncing_mass"


def problem(folder: Path, text: str) -> Problem:
    """The problem of a text."""
    file = folder / "study.toml"
    file.write_text(text, encoding="utf-8")
    return read_problem(file)


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

"""Quantities of whole turns in a design problem, by both engines, and their control."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from designs import design, problem

from nipper_pin.study.optimise import optimise
from nipper_pin.study.optimise.points import Evaluator
from nipper_pin.study.optimise.problem import quantities

pytest.importorskip("numba", reason="numba is not installed (extra `study`)")

NAMES = [name for name, item in quantities.QUANTITIES.items() if item.source == "turn"]
HEAD = """
model = "e62"
maximise = "clamped_share"
[case]
speed_rpm = 700.0
"""
LIMITS = "[limits]\n" + "".join(f"{name} = {{ low = 0.0 }}\n" for name in NAMES)
PRELOAD = "[parameters.preload]\nlow = 7.0\nhigh = 16.0\n"
RATIO = '[parameters."drives.tension.ratio"]\nlow = 2.1\nhigh = 2.3\n'
SPEED = "[parameters.speed_rpm]\nlow = 300.0\nhigh = 2000.0\n"


def test_a_machine_that_changes_takes_the_direct_engine(tmp_path: Path) -> None:
    """And has the same turn at the same numbers, within what both state."""
    own = problem(tmp_path, HEAD + PRELOAD + LIMITS)
    free = problem(tmp_path, HEAD + RATIO + LIMITS)
    one, other = design(own, [11.0]), design(free, [2.2])
    assert (one.engine, other.engine) == ("reduced_turn", "turn")
    for name in NAMES:
        allowed = one.errors[name] + other.errors[name]
        assert abs(one.values[name] - other.values[name]) <= allowed, name


@pytest.mark.slow
def test_turns_without_a_quantity_or_a_period_are_no_usable_machine(tmp_path: Path) -> None:
    """Above 1,545 r/min the jaw has no rest; at 1,900 r/min every second turn is the same."""
    source = Evaluator(problem(tmp_path, HEAD + SPEED + LIMITS))

    def at(speed: float) -> Any:
        return source.at(np.array([(speed - 300.0) / 1700.0]))

    assert at(600.0).usable
    assert "the turn has no rest_index, rest_margin" in at(1600.0).why
    assert "turns differ from one another" in at(1900.0).why


@pytest.mark.slow
def test_a_search_for_the_longest_clamping(tmp_path: Path) -> None:
    """More preload shortens the bounces, so the limit on the force binds, and the turn confirms."""
    limits = "[limits]\nlargest_clamping_force_N = { high = 120.0 }\n"
    limits += "closing_index = { low = 30.0 }\n"
    found = optimise(problem(tmp_path, HEAD + PRELOAD + limits), starts=1, check=False, workers=1)
    assert found.contradiction == ""
    assert found.best.engine == "reduced_turn"
    assert set(found.engines) == {"reduced_turn"}
    assert found.best.values["largest_clamping_force_N"] == pytest.approx(120.0, abs=1e-3)
    assert found.case.window.value == "cycle"

"""Every key of the file of a design, as it is read."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from designs import parameter, problem
from snapshots import Words

from nipper_pin import Mechanism
from nipper_pin.study.optimise.problem.problem import read_text
from tests.refusals.studies import DESIGN


def test_the_file_of_a_design(tmp_path: Path, e62: Mechanism, words: Words) -> None:
    """All keys, and what stands there where a file says nothing; the text of it is the same."""
    found = problem(tmp_path, DESIGN.replace("format = 1\n", ""))
    plain = problem(tmp_path, 'minimise = "duration_s"\n' + parameter("restitution", 0.1, 0.3))
    said = []
    for item in (found, plain):
        record = {key: value for key, value in asdict(item).items() if key != "sources"}
        record["asked"] = [str(one) for one in (*item.aims, *item.limits)]
        assert record.pop("tolerance") == (1e-6 if item is found else 1e-10)
        assert read_text(item.text()) == item
        said.append(json.dumps(record, indent=1, default=dict))
    words("\n".join(said) + "\n")
    assert "<visual" not in found.sources.urdf
    own = 1e3 * e62.springs[0].preload
    assert found.start == pytest.approx([(own - 9.0) / 4.0, 112.5 / 200.0, -1.0 / 3.0])
    z = np.full(3, 0.5)
    mass = {"links.top_nipper.mass_kg": pytest.approx(1.45)}
    assert found.numbers(z) == {"preload": 11.0, "speed_rpm": 500.0, **mass}
    assert found.overrides(z) == {
        "stops.jaw.restitution": 0.25, "springs.steeve.preload_length_mm": 11.0, **mass,
    }  # fmt: skip
    assert (found.speed(z), plain.speed(plain.start)) == (500.0, 450.0)
    asked = plain.with_aim(found.aims[1], *found.limits[:1])
    assert (asked.aims, asked.limits) == (found.aims[1:], found.limits[:1])

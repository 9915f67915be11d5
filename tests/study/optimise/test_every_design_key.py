"""Every key of the file of a design, as it is read."""

from __future__ import annotations

from pathlib import Path

import pytest

from nipper_pin.mechanism import Mechanism
from nipper_pin.study.optimise import read_problem
from nipper_pin.study.optimise.problem.problem import Aim, Limit, read_text
from tests.refusals.studies import DESIGN


def written(folder: Path, text: str) -> Path:
    file = folder / "study.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_the_file_of_a_design(tmp_path: Path, e62: Mechanism) -> None:
    found = read_problem(written(tmp_path, DESIGN))
    assert (found.title, found.model, found.speed_rpm) == ("mine", "e62", 512.5)
    assert (found.rest_rate, found.tolerance) == (1e-3, 1e-6)
    assert found.changes == {"stops.jaw.restitution": 0.25}
    assert found.aims == (Aim(quantity="rebound_amplitude_1", sense=1.0),
                          Aim(quantity="clamping_force_N", sense=-1.0))  # fmt: skip
    assert [str(item) for item in found.aims] == [
        "minimise rebound_amplitude_1", "maximise clamping_force_N",
    ]  # fmt: skip
    limits = [("duration_s", "low", 1e-3), ("duration_s", "high", 2.0),
              ("opening_index", "high", 40.0), ("closing_index", "low", 0.0)]  # fmt: skip
    assert found.limits == tuple(Limit(quantity=a, side=b, value=c) for a, b, c in limits)  # type: ignore[arg-type]
    assert [str(item) for item in found.limits][:2] == ["duration_s >= 0.001", "duration_s <= 2"]
    assert found.units == {"rebound_amplitude_1": "rad", "clamping_force_N": "N",
                           "duration_s": "s", "opening_index": "", "closing_index": ""}  # fmt: skip
    preload, speed, mass = found.parameters
    assert (preload.name, preload.target.kind, preload.low, preload.high) == (
        "preload", "preload", 9.0, 13.0,
    )  # fmt: skip
    assert preload.start == pytest.approx(1e3 * e62.springs[0].preload)
    assert (speed.start, speed.target.path, mass.start) == (512.5, "speed_rpm", 1.2)
    z = (found.start * 0.0) + 0.5
    assert found.start == pytest.approx([(preload.start - 9.0) / 4.0, 112.5 / 200.0, -1.0 / 3.0])
    assert found.numbers(z) == {
        "preload": 11.0, "speed_rpm": 500.0, "links.top_nipper.mass_kg": pytest.approx(1.45),
    }  # fmt: skip
    assert found.overrides(z) == {
        "stops.jaw.restitution": 0.25, "springs.steeve.preload_length_mm": 11.0,
        "links.top_nipper.mass_kg": pytest.approx(1.45),
    }  # fmt: skip
    assert found.speed(z) == 500.0
    assert found.quantities == (
        "rebound_amplitude_1", "clamping_force_N", "duration_s", "opening_index", "closing_index",
    )  # fmt: skip
    assert "<visual" not in found.sources.urdf
    assert read_text(found.text()) == found
    plain = read_problem(written(tmp_path, 'format = 1\nminimise = "duration_s"\n[parameters.'
                                           "restitution]\nlow = 0.1\nhigh = 0.3\n"))  # fmt: skip
    assert (plain.title, plain.model, plain.speed_rpm) == (e62.title, "e62", 450.0)
    assert (plain.rest_rate, plain.tolerance, plain.limits, plain.changes) == (None, 1e-10, (), {})
    assert plain.speed(plain.start) == 450.0
    asked = plain.with_aim(found.aims[1], *found.limits[:1])
    assert (asked.aims, asked.limits) == (found.aims[1:], found.limits[:1])

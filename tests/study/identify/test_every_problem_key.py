"""Every key of the file of an identification and of its measurements, as it is read."""

from __future__ import annotations

from pathlib import Path

import pytest

from nipper_pin.mechanism import Mechanism
from nipper_pin.study import identify
from nipper_pin.study.identify.problem.targets import (
    Condition,
    Target,
    conditions,
    with_settings,
)
from tests.refusals.studies import FIT, SEEN


def written(folder: Path, text: str) -> Path:
    (folder / "seen.csv").write_text(SEEN, encoding="utf-8")
    file = folder / "study.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_the_file_of_an_identification(tmp_path: Path, e62: Mechanism) -> None:
    found = identify.read_problem(written(tmp_path, FIT))
    assert (found.title, found.prior_weight, found.absolute_sigma) == ("mine", 0.5, False)
    assert (found.rest_rate, found.tolerance) == (1e-3, 1e-4)
    preload, restitution = found.parameters
    assert (preload.path, preload.low, preload.high, preload.why) == (
        "springs.steeve.preload_length_mm", 9.0, 13.0, "it was measured",
    )  # fmt: skip
    assert preload.start == pytest.approx(1e3 * e62.springs[0].preload)
    assert preload.width == 4.0
    assert (restitution.path, restitution.why) == ("stops.jaw.restitution", "")
    stiff = Condition(650.0, 0.2, 9500.0)
    assert found.targets[:2] == (
        Target(name="one", quantity="duration_s", at=stiff, since=Condition(450.0), value=-0.25,
               sigma=0.005),
        Target(name="two", quantity="rebound_time_s_2", at=Condition(550.0), value=0.0,
               sigma=0.125),
    )  # fmt: skip
    assert found.targets[2:] == (
        Target(name="duration_s, 650 r/min, e = 0.5, k = 9500", quantity="duration_s",
               at=Condition(650.0, 0.5, 9500.0), value=6.5e-3, sigma=1e-5),
        Target(name="rebound_amplitude_1, 450 r/min", quantity="rebound_amplitude_1",
               at=Condition(450.0), value=0.007, sigma=2e-5),
    )  # fmt: skip
    assert conditions(found.targets) == (
        stiff, Condition(450.0), Condition(550.0), Condition(650.0, 0.5, 9500.0),
    )  # fmt: skip
    limits = found.limits
    assert limits is not None
    assert limits.at == Condition(600.0, None, 8000.0)
    assert (limits.closing_index, limits.opening_index) == ((0.0, 35.0), (7.0, 40.0))
    assert (limits.stop_force_N, limits.jaw_opening_deg) == (12.0, 25.0)
    machine = with_settings(found.sources.build(), stiff)
    assert machine.stop("jaw").restitution == 0.2
    assert machine.stop("steeve").restitution == 0.25
    assert machine.springs[0].stiffness == 9500.0
    plain = FIT[: FIT.index("[limits]")].replace('measured = "seen.csv"\n', "")
    for line in ("prior_weight = 0.5\n", "absolute_sigma = false\n"):
        plain = plain.replace(line, "")
    bare = plain.replace("[case]\nrest_rate = 1e-3\ntolerance = 1e-4\n", "")
    found = identify.read_problem(written(tmp_path, bare))
    assert (found.limits, found.prior_weight, found.absolute_sigma) == (None, 0.0, True)
    assert (found.rest_rate, found.tolerance, len(found.targets)) == (None, 1e-8, 2)

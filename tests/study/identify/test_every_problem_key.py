"""Every key of the file of an identification and of its measurements, read and refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from nipper_pin.errors import InputError, ModelError, UnknownNameError
from nipper_pin.mechanism import Mechanism
from nipper_pin.study import identify
from nipper_pin.study.identify.problem.measured import read_measured
from nipper_pin.study.identify.problem.targets import (
    Condition,
    Target,
    conditions,
    with_settings,
)

FIT = """
format = 1
title = "mine"
model = "e62"
prior_weight = 0.5
absolute_sigma = false
measured = "seen.csv"
[case]
rest_rate = 1e-3
tolerance = 1e-4
[set]
"stops.steeve.restitution" = 0.25
[parameters.preload]
low = 9.0
high = 13.0
why = "it was measured"
[parameters.restitution]
low = 0.1
high = 0.3
[[targets]]
name = "one"
quantity = "duration_s"
at = { speed_rpm = 650.0, restitution = 0.2, stiffness_N_per_m = 9500.0 }
since = { speed_rpm = 450.0 }
value = -0.25
relative_sigma = 0.02
[[targets]]
name = "two"
quantity = "rebound_time_s_2"
at = { speed_rpm = 550.0 }
value = 0.0
sigma = 0.125
[limits]
at = { speed_rpm = 600.0, stiffness_N_per_m = 8000.0 }
closing_index = { low = 0.0, high = 35.0 }
opening_index = { low = 7.0, high = 40.0 }
stop_force_N = { low = 12.0 }
jaw_opening_deg = { low = 25.0 }
"""
SEEN = """speed_rpm;quantity;stiffness_N_per_m;value;sigma;restitution
650;duration_s;9500;6,5e-3;1e-5;0,5
450;rebound_amplitude_1;;+,007;0,00002;
"""


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


@pytest.mark.parametrize(
    ("old", "new", "key", "value"),
    [
        ("relative_sigma = 0.02", "sigma = 1.0\nrelative_sigma = 0.02", "targets: one", 1.0),
        ("sigma = 0.125", "", "targets: two", None),
        ("sigma = 0.125", "relative_sigma = 0.1", "targets: two: value", 0.0),
        ("value = -0.25", "value = nan", "targets: one: value", None),
        ("stiffness_N_per_m = 9500.0", "stiffness_N_m_per_rad = 9.0",
         "targets: one: at.stiffness_N_m_per_rad", 9.0),
        ("{ speed_rpm = 450.0 }", "{ speed_rpm = 450.0, stiffness_N_m_per_rad = 9.0 }",
         "targets: one: since.stiffness_N_m_per_rad", 9.0),
        ("stiffness_N_per_m = 8000.0", "stiffness_N_m_per_rad = 8.0",
         "limits.at.stiffness_N_m_per_rad", 8.0),
        ("low = 0.0, high = 35.0", "low = -1.0, high = 35.0", "limits.closing_index", [-1.0, 35.0]),
        ("low = 0.0, high = 35.0", "low = 35.0, high = 35.0", "limits.closing_index", [35.0, 35.0]),
        ("high = 40.0", "high = 40.5", "limits.opening_index", [7.0, 40.5]),
        ("high = 13.0", "high = 9.0", "parameters.springs.steeve.preload_length_mm", [9.0, 9.0]),
        ("high = 13.0", "high = inf", "parameters.springs.steeve.preload_length_mm", None),
        ("high = 13.0", "high = 9.5", "parameters.springs.steeve.preload_length_mm", [9.0, 9.5]),
        ('"stops.steeve.restitution"', "restitution", "parameters.restitution",
         "stops.jaw.restitution"),
        ('"stops.steeve.restitution" = 0.25', "", None, None),
    ],
)  # fmt: skip
def test_identifications_that_are_refused(
    tmp_path: Path, old: str, new: str, key: str | None, value: Any
) -> None:
    assert old in FIT
    text = FIT.replace(old, new, 1)
    if key is None:
        identify.read_problem(written(tmp_path, text))
        return
    with pytest.raises(ModelError) as caught:
        identify.read_problem(written(tmp_path, text))
    evidence = caught.value.evidence
    assert (evidence["file"], evidence["key"]) == ("study.toml", key)
    if value is not None:
        assert evidence["value"] == value


def test_files_without_targets_or_numbers(tmp_path: Path) -> None:
    bare = FIT[: FIT.index("[[targets]]")].replace('measured = "seen.csv"\n', "")
    with pytest.raises(InputError, match=r"study\.toml: nothing to aim at") as caught:
        identify.read_problem(written(tmp_path, bare))
    assert caught.value.evidence == {"file": str(tmp_path / "study.toml")}
    none = FIT.replace(
        '[parameters.preload]\nlow = 9.0\nhigh = 13.0\nwhy = "it was measured"\n', ""
    )
    none = none.replace("[parameters.restitution]\nlow = 0.1\nhigh = 0.3\n", "[parameters]\n")
    with pytest.raises(InputError, match=r"study\.toml: nothing is free"):
        identify.read_problem(written(tmp_path, none))
    with pytest.raises(UnknownNameError, match=r"study\.toml: targets: two"):
        identify.read_problem(written(tmp_path, FIT.replace("rebound_time_s_2", "beauty")))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (SEEN.replace("_N_per_m", "_N_m_per_rad"), "column stiffness_N_m_per_rad: with this model"),
        (SEEN.replace("9500", "0"), "line 2, column stiffness_N_per_m: .* finite and above zero"),
        (SEEN.replace("0,5\n", "1,01\n"), "line 2, column restitution: .* between 0 and 1"),
        (SEEN.replace("0,5\n", "-0,01\n"), "line 2, column restitution: .* between 0 and 1"),
        (SEEN.replace("450;", "0;"), "line 3, column speed_rpm: .* finite and above zero"),
        (SEEN.replace("1e-5", "0"), "line 2, column sigma: .* finite and above zero"),
        (SEEN.replace("450;", "4.5e2;"), "seen.csv, line 2, column restitution: 0,5 has a comma "
                                         "and 4.5e2 elsewhere a point"),
    ],
)  # fmt: skip
def test_measurements_that_are_refused(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "seen.csv"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=words):
        read_measured(file)


@pytest.mark.parametrize("value", ["0", "1", "0,0"])
def test_restitutions_at_their_ends(tmp_path: Path, value: str) -> None:
    file = tmp_path / "seen.csv"
    file.write_text(SEEN.replace("0,5\n", f"{value}\n"), encoding="utf-8")
    first, second = read_measured(file)
    assert first.at.restitution == float(value.replace(",", "."))
    assert second.at.restitution is None

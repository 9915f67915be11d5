"""A shortcut of a model serves wherever a path does, and means the same number."""

from __future__ import annotations

from pathlib import Path

import pytest

from nipper_pin import InputError, Mechanism, load
from nipper_pin.mechanism import with_numbers
from nipper_pin.study import identify, optimise
from nipper_pin.study.sweep import read_plan

PATH = "springs.steeve.preload_length_mm"
SWEEP = "format = 1\n[set]\n{fixed} = 9.25\n[parameters.{free}]\nvalues = [0.1, 0.2]\n"
OPTIMISE = """format = 1
minimise = "duration_s"
set = {{ {fixed} = 9.25 }}
[parameters.{free}]
low = 0.05
high = 0.3
"""
IDENTIFY = """format = 1
title = "t"
model = "e62"
set = {{ {fixed} = 9.25 }}
[parameters.{free}]
low = 0.05
high = 0.3
[[targets]]
name = "one"
quantity = "first_two_share"
at = {{ speed_rpm = 650.0 }}
value = 0.8
sigma = 0.1
"""
NAMES = [("preload", "restitution"), (f'"{PATH}"', '"stops.jaw.restitution"')]


def preload_m(mechanism: Mechanism) -> float:
    return mechanism.springs[0].preload


@pytest.mark.parametrize("name", ["preload", PATH])
def test_overrides_of_a_model(name: str, e62: Mechanism) -> None:
    for value in (9.25, "9.25"):
        assert preload_m(load("e62", {name: value})) == pytest.approx(9.25e-3, rel=1e-15)
    assert preload_m(with_numbers(e62, {name: 9.25})) == pytest.approx(9.25e-3, rel=1e-15)
    assert preload_m(e62) == pytest.approx(11e-3, rel=1e-15)


def test_studies_read_both_as_the_same(tmp_path: Path) -> None:
    """Files that differ in the name alone are the same problem, to the hash or the last number."""

    def written(text: str, names: tuple[str, str]) -> str:
        fixed, free = names
        place = tmp_path / "study.toml"
        place.write_text(text.format(fixed=fixed, free=free), encoding="utf-8")
        return str(place)

    sweeps = [read_plan(written(SWEEP, names)) for names in NAMES]
    assert sweeps[0].job.document == sweeps[1].job.document
    assert sweeps[0].axes[0].target == sweeps[1].axes[0].target
    designs = [optimise.read_problem(written(OPTIMISE, names)) for names in NAMES]
    assert designs[0].changes == designs[1].changes == {PATH: 9.25}
    assert designs[0].parameters[0].target == designs[1].parameters[0].target
    fits = [identify.read_problem(written(IDENTIFY, names)) for names in NAMES]
    assert fits[0] == fits[1]
    assert preload_m(fits[0].sources.build()) == pytest.approx(9.25e-3, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (IDENTIFY, "a path that set.preload does not give already"),
        (SWEEP, "a path that set.preload does not give already"),
        (OPTIMISE, "a path that set.preload does not give already"),
    ],
)
def test_a_number_is_fixed_or_free(text: str, words: str, tmp_path: Path) -> None:
    place = tmp_path / "study.toml"
    place.write_text(text.format(fixed="preload", free="preload"), encoding="utf-8")
    readers = {IDENTIFY: identify.read_problem, OPTIMISE: optimise.read_problem, SWEEP: read_plan}
    with pytest.raises(InputError, match=words):
        readers[text](str(place))


def test_a_number_given_twice_is_refused() -> None:
    with pytest.raises(InputError, match=r"preload = 9\.25 gives the same one"):
        load("e62", {"preload": 9.25, PATH: 10.0})
    with pytest.raises(InputError, match=r"no key or shortcut named .preloda..*preload"):
        load("e62", {"preloda": 9.25})

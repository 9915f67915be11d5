"""The table of terms: the page of notation says units and words, which are reviewed there.

The factors between units, held against what they are made of, and units that people type.
"""

from __future__ import annotations

import math
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from snapshots import Words, blocks
from units_shown import factor

from nipper_pin import Mechanism, changed, units
from nipper_pin.cli import main
from nipper_pin.mechanism import number_of
from nipper_pin.mechanism.edit import by_path
from nipper_pin.terms import TERMS, Term, named, shown_in, term_of
from nipper_pin.written_units import number_in, unit_of_key

ROOT = Path(__file__).parents[1]
sys.path.append(str(ROOT / "scripts/maintain/figures"))

from write_quantity_page import page  # noqa: E402

NOTATION = (ROOT / "docs/notation.md").read_text(encoding="utf-8")
COUNTS = ("collisions", "turns", "repeats_after")


@pytest.mark.parametrize("gap", ["rad", "m"])
@pytest.mark.parametrize("term", TERMS.values(), ids=TERMS)
def test_what_people_read(term: Term, gap: str) -> None:
    """The factor of the two units of the page, and digits that say the number again."""
    shown = term.shown(gap)
    by = factor(term.unit.format(gap=gap), shown.unit)
    assert shown.factor == pytest.approx(by, rel=1e-14)
    assert shown.label == (f"{term.words} [{shown.unit}]" if shown.unit else term.words)
    value = 0.0123456
    assert shown.value(value) == pytest.approx(by * value, rel=1e-14)
    np.testing.assert_allclose(shown.value(np.array([value, -1.0])), [by * value, -by])
    text = shown.text(value)
    least = 0.51 * 10.0**-term.decimals if term.decimals is not None else 0.0
    assert float(text) == pytest.approx(by * value, rel=0.0 if least else 5.1e-4, abs=least)
    assert shown.phrase(value) == f"{text} {shown.unit}".rstrip()
    assert shown.text(None) == shown.text(math.nan) == "-"


@pytest.mark.parametrize("term", TERMS.values(), ids=TERMS)
def test_a_name_ends_with_its_unit(term: Term) -> None:
    """If that is not the unit of the stop's coordinate."""
    ending = term.unit.replace(" ", "_").replace("r/min", "rpm")
    if "{gap}" not in ending:
        found = re.search(r"_((N|N_m)(_s)?|rad|deg|rpm|mm|J|s)$", term.name)
        assert (found[1] if found else "") == ending


def test_decimals_stand_where_digits_would_say_less() -> None:
    """Places in time and in the turn have three decimals, counts none."""
    fixed = {name: term.decimals for name, term in TERMS.items() if term.decimals is not None}
    places = {"t_s", "time_s", "cylinder_angle_rad", "rest_margin"}
    places |= {name for name in TERMS if re.search(r"(^|_)index$", name)}
    assert fixed == {**dict.fromkeys(places, 3), **dict.fromkeys(COUNTS, 0)}


def test_units_that_are_not_in_the_table_stay_as_they_are() -> None:
    assert shown_in("kg") == ("kg", 1.0)
    assert shown_in("N/m") == ("N/mm", pytest.approx(1e-3))
    assert shown_in("N", small=True) == ("N", 1.0)
    assert shown_in("s", small=True) == ("ms", 1e3)


def test_symbols_are_explained_above_the_tables() -> None:
    explained = set(re.findall(r"`(\w+)`", NOTATION.partition("### A collision")[0]))
    assert {term.symbol for term in TERMS.values()} - {""} <= explained


def test_names_in_words(words: Words) -> None:
    """Quantities of a collision, a stop or a drive, and numbers of a model; units and factors."""
    text = ""
    for line in (item.name for item in blocks(__file__, "test_names_in_words")):
        shown = named(*line.split())
        text += f"{line}\n    {shown.label}, times {shown.factor:.12g}\n"
    words(text, masked=False)


def test_names_that_are_no_terms() -> None:
    """Nothing is the zeroth collision, and a path is no quantity."""
    assert term_of("rebound_time_s_12") == (TERMS["rebound_time_s"], 12)
    for name in ("rebound_time_s_0", "rebound_time_s_01", "rebound", "jaw_1", "springs.a"):
        with pytest.raises(KeyError):
            term_of(name)


def test_the_page_is_written_from_the_table() -> None:
    """`python scripts/maintain/figures/write_quantity_page.py` writes it anew."""
    assert page() == NOTATION


def test_each_name_stands_once() -> None:
    """Names of documents and files; transitions and stops in a turn both count collisions."""
    found = re.findall(r"`([a-zA-Z_]+)`", page().partition("### A collision")[2])
    assert sorted([*set(found), "collisions"]) == sorted(found)
    assert {"t_s", "time_s", "rebound_amplitude", "duration_s", "clamped_share"} <= set(found)


# What each unit of a name is, in the smallest unit of its kind.
SIZE = {
    "M": 1e6, "MM": 1e3, "UM": 1.0,
    "S": 1e6, "MS": 1e3, "US": 1.0, "MIN": 60e6, "H": 3600e6,
    "TURN": math.tau, "RAD": 1.0, "DEG": math.tau / 360.0, "MRAD": 1e-3, "MDEG": math.tau / 360e3,
    "J": 1.0, "MJ": 1e-3,
}  # fmt: skip
NAMES = [name for name in vars(units) if "_PER_" in name]


@pytest.mark.parametrize("name", NAMES)
def test_a_factor_is_what_its_name_says(name: str) -> None:
    """So many of the first unit are one of the second, but for two roundings."""
    first, second = name.split("_PER_")
    assert getattr(units, name) == pytest.approx(SIZE[second] / SIZE[first], rel=4.5e-16)


def test_angles_are_those_of_the_standard_library() -> None:
    """To the last bit: files that were written with one are read with the other."""
    assert math.degrees(1.0) == units.DEG_PER_RAD
    assert math.radians(1.0) == units.RAD_PER_DEG


# --- numbers that are typed with a unit of their own ---------------------------------------------


@pytest.mark.parametrize(
    ("text", "key", "number"),
    [
        ("9N/mm", "stiffness_N_per_m", 9000.0), ("9.5e3", "stiffness_N_per_m", 9500.0),
        (" 2 kN/m ", "stiffness_N_per_m", 2000.0), ("0.925cm", "preload_length_mm", 9.25),
        ("9.25mm", "preload_length_mm", 9.25), ("1in", "x_mm", 25.4),
        ("0.5rad", "preload_deg", math.degrees(0.5)), ("1r", "at_deg", 360.0),
        ("50 N mm/deg", "stiffness_N_m_per_rad", 0.05 * math.degrees(1.0)),
        ("50Nmm/deg", "stiffness_N_m_per_rad", 0.05 * math.degrees(1.0)),
        ("3e4 kg*mm^2", "reflected_inertia_kg_m2", 0.03), ("300 g", "mass_kg", 0.3),
        ("650rpm", "rated_speed_rpm", 650.0), ("60 deg/s", "speed_rpm", 10.0),
        ("9810 mm/s2", "gravity_m_s2", 9.81), ("20 g/cm", "density_kg_m", 2.0),
        ("4 N s2/m2", "c_N_s2_per_m2", 4.0), ("3 N ms/mm", "damping_N_s_per_m", 3.0),
        ("50Hz", "shaft_frequency_hz", 50.0), ("7 cm/r", "lead_mm_per_turn", 70.0),
        ("0.2", "restitution", 0.2),
    ],
)  # fmt: skip
def test_a_unit_is_taken_into_that_of_the_key(text: str, key: str, number: float) -> None:
    assert number_in(text, unit_of_key(key)) == pytest.approx(number, rel=4e-16)


def test_of_one_unit_no_digit_is_lost() -> None:
    for key in ("preload_length_mm", "preload_deg", "stiffness_N_m_per_rad", "rated_speed_rpm"):
        unit = unit_of_key(key)
        assert number_in(f"0.1234567890123456 {unit}", unit) == 0.1234567890123456


@pytest.mark.parametrize(
    ("key", "value", "read", "own", "number"),
    [
        ("stiffness_N_per_mm", 9, 9.0, "stiffness_N_per_m", 9000.0),
        ("stiffness_N_per_mm", "8 kN/m", 8.0, "stiffness_N_per_m", 8000.0),
        ("preload_length_cm", "0.9", 0.9, "preload_length_mm", 9.0),
    ],
)
def test_a_path_may_end_in_another_unit(
    e62: Mechanism, key: str, value: object, read: float, own: str, number: float
) -> None:
    """It is the number of the key that the table has, given and read; it counts once."""
    spring = "springs.steeve"
    machine = changed(e62, {f"{spring}.{key}": value})
    assert number_of(machine, f"{spring}.{own}") == pytest.approx(number, rel=4e-16)
    assert number_of(machine, f"{spring}.{key}") == pytest.approx(read, rel=4e-16)


def test_so_may_that_of_a_number_that_is_not_written(e62: Mechanism) -> None:
    found = by_path({"stops.jaw.at_rad": -0.01}, e62.description, "e62.toml")
    assert found == {"stops.jaw.at_deg": pytest.approx(math.degrees(-0.01), rel=4e-16)}


def test_commands_take_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    said = []
    for words in (
        ["--speed", "650", "--stiffness", "9500", "--set", "preload=9.25"],
        ["--speed", "650rpm", "--stiffness", "9.5N/mm", "--set", "preload=0.925cm"],
    ):
        assert main(["simulate", "e62", *words, "--json", "-"]) == 0
        said.append(capsys.readouterr().out)
    assert said[0].partition('"work"')[0] == said[1].partition('"work"')[0]

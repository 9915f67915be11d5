"""The table of terms: the page of notation says units and words, which are reviewed there.

And the factors between units, held against what they are made of.
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

from nipper_pin import units
from nipper_pin.terms import TERMS, Term, named, shown_in, term_of

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

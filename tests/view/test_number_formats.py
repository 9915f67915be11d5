"""Numbers as people read them: digits, signs and bounds of each way to write one."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from nipper_pin.terms import Shown, digits, fixed
from nipper_pin.view.compare.words import percent_text
from nipper_pin.view.studies.sweep_figures.columns import short

MM = Shown(words="gap", unit="mm", factor=1e3)
TENTHS = Shown(words="gap", unit="mm", factor=1e3, decimals=1)
BARE = Shown(words="ratio", unit="")

FORMATS: dict[str, tuple[Callable[[Any], str], dict[Any, str]]] = {
    # Four digits; powers of ten below a thousandth and from a million on.
    "digits": (digits, {
        None: "-", 0.0: "0", 1.0: "1.000", -12.34567: "-12.35", 123.456: "123.5",
        1234.56: "1235", 12345.6: "12346", 999_999.4: "999999", 1e6: "1.000e6",
        0.00123456: "0.001235", 1e-3: "0.001000", 9.99e-4: "9.990e-4", 1.23456e-12: "1.235e-12",
        -4.5e15: "-4.500e15",
    }),
    "fixed": (partial(fixed, decimals=2), {
        0.0: "0.00", -1e-9: "0.00", -0.004: "0.00", -0.006: "-0.01", 2.675: "2.67", 1e3: "1000.00",
    }),
    "no decimals": (partial(fixed, decimals=0), {0.4: "0", -0.4: "0", 1.6: "2", -1.6: "-2"}),
    # Beside an axis: three digits, whole numbers from a thousand to a million.
    "short": (short, {
        0.0: "0", 0.12345: "0.123", 12.345: "12.3", 999.4: "999", 1e3: "1000", -1234.5: "-1234",
        999_999.0: "999999", 1e6: "1e+06", 1.2345e-5: "1.23e-05",
    }),
    # Differences: as many decimals as leave three digits.
    "difference": (percent_text, {
        0.0: "< 0.01 %", -0.00499: "< 0.01 %", 0.0051: "+0.01 %", -9.994: "-9.99 %",
        10.04: "+10.0 %", -999.94: "-999.9 %", 1000.4: "+1000 %",
    }),
    "text": (MM.text, {None: "-", math.nan: "-", 0.00123456: "1.235", -2e-7: "-2.000e-4"}),
    "phrase": (TENTHS.phrase, {None: "- mm", 0.00126: "1.3 mm", -1e-5: "0.0 mm"}),
    "no unit": (BARE.phrase, {0.5: "0.5000", None: "-"}),
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "value", "wanted"),
    [(name, value, text) for name, (_, table) in FORMATS.items() for value, text in table.items()],
)
def test_a_number_as_it_is_read(name: str, value: float | None, wanted: str) -> None:
    assert FORMATS[name][0](value) == wanted

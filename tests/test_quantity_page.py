"""The page of quantities is the table of terms."""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.append(str(ROOT / "scripts/maintain/figures"))

from write_quantity_page import page  # noqa: E402


def test_the_page_is_written_from_the_table() -> None:
    """`python scripts/maintain/figures/write_quantity_page.py` writes it anew."""
    assert page() == (ROOT / "docs/notation.md").read_text(encoding="utf-8")


def test_each_name_stands_once() -> None:
    """Every name of the JSON document and of the files of a run is explained there."""
    found = re.findall(r"`([a-zA-Z_]+)`", page().partition("### A collision")[2])
    assert len(found) == len(set(found))
    assert {"t_s", "time_s", "rebound_amplitude", "duration_s", "clamped_share"} <= set(found)

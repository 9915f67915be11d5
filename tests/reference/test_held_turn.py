"""The 80-bit turn against the certified turns in 60 digits: forces, times and losses."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from held_turn import HeldTurn, quantities  # noqa: E402

pytestmark = pytest.mark.skipif(
    np.finfo(np.longdouble).eps > 1e-18, reason="numpy.longdouble has no 80 bits on this machine"
)
CASES = json.loads((HERE / "e62_cycle.json").read_text(encoding="utf-8"))["cases"]


@pytest.mark.parametrize("name", CASES)
def test_certified_quantities(name: str) -> None:
    """To the round-off of 80-bit numbers; sums lack what the certified ones leave out."""
    case = CASES[name]
    turn = HeldTurn({"speed_rpm": f"{name}.0", **case["changes"]})
    found = quantities(turn, 0.0)
    held = next(row for row in case["phases"] if row["closed"] == "jaw")
    rest = next(row for row in case["rests"] if row["stop"] == "jaw")
    for key, wanted, within in (
        ("least_force", held["lip_force_min_N"], 1e-15),
        ("most_force", held["lip_force_max_N"], 1e-15),
        ("rests_at", rest["time_s"], 1e-15),
        ("opened_at", held["end_s"], 1e-16),
        ("energy_lost", case["energy_lost_total_J"], 1e-14),
    ):
        assert abs(found[key] / np.longdouble(wanted) - 1) <= within, key
    stretch = np.longdouble(held["end_s"]) - np.longdouble(held["start_s"])
    assert abs(found["clamped"] / stretch - 1) <= 1e-15
    rows = [row for row in case["collisions"] if row["stop"] == "steeve"]
    total: Any = sum(np.longdouble(row["impulse"]) for row in rows)
    assert 0.0 < found["impulse_sum_steeve"] / total - 1 <= 1e-7


def test_time_above_a_level_is_that_of_a_fine_grid() -> None:
    """Where the force passes the level twice, or once."""
    turn = HeldTurn({"speed_rpm": "650.0"})
    (hold,) = turn.holds
    times = np.linspace(hold.start, hold.end, 20001, dtype=np.longdouble)
    force = turn.force(times)
    for level in (55.0, 90.0, 95.0):
        share = (force >= level).mean() * (hold.end - hold.start)
        assert abs(turn.clamped(level) - share) <= 2.0 * (times[1] - times[0])
    least, most = turn.extremes() or (0, 0)
    assert force.min() >= least
    assert force.max() <= most

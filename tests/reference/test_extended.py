"""The 80-bit solution of the planar machine against the certified one, of 25 digits."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from extended import COLLISION, REST, Extended, Happening, cycle, transition  # noqa: E402
from taylor import first_root  # noqa: E402

L = np.longdouble
pytestmark = pytest.mark.skipif(
    np.finfo(L).eps > 1e-18, reason="numpy.longdouble has no 80 bits on this machine"
)
# A hundred roundings of 1e-19; rates after a release, which begins like t^3, have ten times that.
AGREEMENT, AFTER_RELEASE = 1e-17, 1e-16
KEYS = {
    "time": "time_s", "approach": "approach_rate", "separation": "separation_rate",
    "impulse": "impulse", "amplitude": "rebound_amplitude", "rebound": "rebound_time_s",
}  # fmt: skip


def cases(name: str) -> dict[str, Any]:
    return json.loads((HERE / name).read_text())["cases"]


def apart(found: Any, decimal: str) -> float:
    return float(abs(found / L(decimal) - 1))


def compared(hits: list[Happening], rows: list[dict[str, Any]]) -> float:
    """Greatest relative difference of collisions from their certified rows."""
    differences = [0.0]
    for hit, row in zip(hits, rows, strict=False):
        assert hit.stop == row["stop"]
        for key, name in KEYS.items():
            value = getattr(hit, key)
            if value is not None and float(row[name] or 0.0) != 0.0:
                differences.append(apart(value, row[name]))
    return max(differences)


@pytest.mark.parametrize("name", cases("e62_transition.json"))
def test_transitions(name: str) -> None:
    case = cases("e62_transition.json")[name]
    *events, rest = transition(case["changes"])
    hits = [event for event in events if event.kind == COLLISION]
    assert len(hits) > 8
    assert compared(hits, case["collisions"]) < AGREEMENT
    assert rest.kind == REST
    assert apart(rest.time, case["rest_time_s"]) < AGREEMENT


@pytest.mark.parametrize("name", cases("e62_cycle.json"))
def test_turns(name: str) -> None:
    case = cases("e62_cycle.json")[name]
    events = cycle(case["changes"])
    rests = [place for place, event in enumerate(events) if event.kind == REST]
    assert [events[place].stop for place in rests] == [row["stop"] for row in case["rests"]]
    start = 0
    for series, (place, row) in enumerate(zip(rests, case["rests"], strict=True), start=1):
        hits = [event for event in events[start:place] if event.kind == COLLISION]
        rows = [item for item in case["collisions"] if item["series"] == series]
        assert len(hits) >= len(rows)
        assert compared(hits, rows) < AFTER_RELEASE
        assert apart(events[place].time, row["time_s"]) < AGREEMENT
        start = place + 1
    released = [event.time for event in events if event.kind == "release"]
    ends = [phase["end_s"] for phase in case["phases"] if phase["ended_by"] == "release"]
    assert len(released) == len(ends)
    for time, end in zip(released, ends, strict=True):
        assert apart(time, end) < AGREEMENT


def test_a_gap_that_only_just_falls_below_zero_is_found() -> None:
    """Between two of the places at which a gap is looked at: (x - 0.7)^2 - 1e-12."""
    root = first_root([L("0.49") - L("1e-12"), L("-1.4"), L(1)], L(1), Extended)
    assert root is not None
    assert abs(root - (L("0.7") - L("1e-6"))) < 1e-12

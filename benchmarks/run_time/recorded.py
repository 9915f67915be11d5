"""What became slower than in the recorded run; the unit is the peers of both, on any machine."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from nipper_pin.errors import InputError

RECORDED = Path(__file__).with_name("recorded.json")
# A setting that takes longer by this factor became slower; less is what machines differ by.
ALLOWED = 1.1
_TIMES = {"engines": "fastest_ms", "turns": "wall_ms", "peers": "fastest_ms"}


@dataclass(frozen=True)
class Slower:
    """A setting of an engine that takes longer.

    Attributes:
        ratio: Its time by that of the recorded run, both in times of the peers.
    """

    engine: str
    setting: str
    ratio: float


def record(document: Mapping[str, Any]) -> dict[str, Any]:
    """What is kept of a run: its day, and the time of each engine and peer at each setting [ms]."""
    found: dict[str, Any] = {"date": document["environment"]["date"]}
    for kind, time in _TIMES.items():
        found[kind] = [[row["engine"], row["setting"], row[time]] for row in document[kind]]
    return found


def slower(document: Mapping[str, Any], recorded: Mapping[str, Any]) -> list[Slower]:
    """Settings that both runs have and that became slower, the worst first.

    Raises:
        InputError: The runs have no peer in common.
    """
    now = record(document)
    peers = _ratios(now["peers"], recorded["peers"])
    if not peers:
        message = "no peer of the recorded run is installed; pip install 'nipper-pin[peers]'"
        raise InputError(message, date=recorded["date"])
    pace = median(peers.values())
    found = [
        Slower(engine, setting, ratio / pace)
        for kind in ("engines", "turns")
        for (engine, setting), ratio in _ratios(now[kind], recorded[kind]).items()
    ]
    return sorted((item for item in found if item.ratio > ALLOWED), key=lambda item: -item.ratio)


def read_record() -> dict[str, Any]:
    """The recorded run."""
    found: dict[str, Any] = json.loads(RECORDED.read_text(encoding="utf-8"))
    return found


def _ratios(now: list[list[Any]], before: list[list[Any]]) -> dict[tuple[str, str], float]:
    """Times by those before, by engine and setting."""
    times = {(engine, setting): ms for engine, setting, ms in before}
    return {
        (engine, setting): ms / times[engine, setting]
        for engine, setting, ms in now
        if (engine, setting) in times
    }

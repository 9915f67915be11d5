"""The control of premises: a few of its random cases, and a lie that it has to notice."""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from nipper_pin.hybrid.result.premise import Premise

sys.path.append(str(Path(__file__).parents[2] / "scripts/maintain/measure"))

import measure_premise as premises
from measure_premise import draw, judged


@pytest.mark.slow
def test_none_is_wrongly_called_true() -> None:
    """Of random transitions, some true and some false, none that differs is called true."""
    found = [
        item
        for mechanism, drawn in draw(2 * premises.GROUP, 4)
        for item in judged(mechanism, drawn[:8])
    ]
    assert not [item for item in found if item.wrong]
    told = Counter((item.engine, item.holds) for item in found)
    for engine in ("direct", "reduced"):
        assert told[engine, True] >= 3
        assert told[engine, False] >= 2
    # A verdict "false" is not given to be safe: those transitions differ.
    assert all(item.apart > 1.0 for item in found if item.holds is False)


@pytest.mark.parametrize("lie", ["direct", "reduced"])
def test_a_lie_is_noticed(lie: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """An engine that calls everything true is found wrong, and only that one."""
    ((mechanism, drawn),) = draw(6, 12)
    fast = [replace(one, speed_rpm=740.0, preload=0.007) for one in drawn[:3]]
    if lie == "direct":
        monkeypatch.setattr(
            "nipper_pin.hybrid.result.premise.premise_of", lambda *_: Premise(True, "a lie")
        )
    else:
        real = premises.transitions

        def lying(*given: object, **named: object) -> object:
            batch = real(*given, **named)  # type: ignore[arg-type]
            return replace(batch, tell=lambda: 1 + 0 * batch.premise)

        monkeypatch.setattr(premises, "transitions", lying)
    wrong = {item.engine for item in judged(mechanism, fast) if item.wrong}
    assert wrong == {lie}

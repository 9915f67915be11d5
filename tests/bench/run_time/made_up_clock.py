"""A clock that says which measurement it was, and what was called in it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import pytest

from benchmarks.run_time.timing import Timing


@dataclass
class Measurement:
    """One call of ``timed``: its arguments, and the calls and the result of one run."""

    number: int
    repeats: int
    budget_s: float
    calls: list[tuple[str, tuple[Any, ...], dict[str, Any]]] = field(default_factory=list)
    result: object = None

    def named(self, name: str) -> list[tuple[Any, ...]]:
        """Arguments of the calls of one function."""
        return [arguments for called, arguments, _ in self.calls if called == name]


class Clock:
    """Takes the place of ``timed``; measurement n has a median of n ms, and of n / 8 at best."""

    def __init__(self) -> None:
        """Nothing is measured yet."""
        self.all: list[Measurement] = []
        self._watched: list[tuple[str, tuple[Any, ...], dict[str, Any]]] = []

    def timed(
        self, function: Callable[[], object], repeats: int, budget_s: float = math.inf
    ) -> Timing:
        """Run once."""
        found = Measurement(len(self.all) + 1, repeats, budget_s)
        self._watched = found.calls
        found.result = function()
        self._watched = []
        self.all.append(found)
        n = float(found.number)
        return Timing(100.0 + n, n, n / 8.0, n / 64.0, repeats)

    def of(self, median_ms: float) -> Measurement:
        """The measurement with this median."""
        return self.all[round(median_ms) - 1]

    def watch(self, monkeypatch: pytest.MonkeyPatch, place: Any, name: str) -> None:
        """Note the calls of a function that is found at a place."""
        real = getattr(place, name)

        def called(*arguments: Any, **named: Any) -> Any:
            self._watched.append((name, arguments, named))
            return real(*arguments, **named)

        monkeypatch.setattr(place, name, called)

"""Result of an optimisation: the optimum, its active limits, and the front."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ...hybrid import Case, Window
from ..transitions import REDUCED_TURN, TURN
from .control import Control
from .design import Design
from .problem.problem import Problem
from .search.binding import Account
from .search.descend import Descent
from .search.samples import Found

CAUTION = (
    "A result of the model, and as good as its numbers; those of the E62 are an estimate "
    "identified from published ratios, never the maker's data."
)


@dataclass(frozen=True, kw_only=True)
class Optimum:
    """Result of an optimisation.

    Attributes:
        seed: Seed of starts and of the global check.
        before: The model's own numbers; None if they make no machine that can be simulated.
        best: The best design by the first aim.
        account: What holds it back.
        descents: Descents by the first aim, the best first.
        screened: Samples of the screen.
        no_machine: Why some of these made no machine: the first reason of each kind.
        check: Result of differential evolution; None without a global check.
        check_gain: Relative improvement of the first aim that it brought beyond the descents.
        engines: Numbers of usable points by the engine that found their transition or turn:
            "reduced", "direct", "reduced_turn", or "turn" for the direct engine on whole turns.
        why_engine: Why the reduced engine was taken, or not.
        control: What simulated turns say of the best design.
        front: Designs of the Pareto front by the second aim, the best by the first aim first; empty
            with one aim.
        front_controls: What simulated turns say of each of these.
        evaluations: Points that were evaluated, all parts together.
        wall_s: Wall time [s].
    """

    problem: Problem
    seed: int
    before: Design | None
    best: Design
    account: Account
    descents: tuple[Descent, ...]
    screened: int
    no_machine: tuple[str, ...]
    check: Found | None
    check_gain: float
    engines: Mapping[str, int]
    why_engine: str
    control: Control
    front: tuple[Design, ...]
    front_controls: tuple[Control, ...]
    evaluations: int
    wall_s: float

    @property
    def contradiction(self) -> str:
        """Differences from simulated turns, with both numbers; empty if all are confirmed."""
        found = self.control.contradictions
        if found:
            return f"the simulated turn contradicts the optimum: {'; '.join(found)}"
        for number, item in enumerate(self.front_controls, start=1):
            if not item.confirmed:
                words = "; ".join(item.contradictions)
                return f"the simulated turn contradicts point {number} of the front: {words}"
        return ""

    @property
    def overrides(self) -> dict[str, object]:
        """Overrides of the model that give the best design, for ``load``."""
        return self.problem.overrides(np.array(self.best.z))

    @property
    def command(self) -> str:
        """The command that simulates the best design, ready to be pasted.

        Its last transition is the one that is reported.
        """
        case = self.case
        words = ["nipper-pin", "simulate", self.problem.model, "--speed", repr(case.speed_rpm)]
        if case.window is Window.CYCLE:
            words += ["--window", "cycle", "--cycles", str(case.cycles)]
        if case.rest_rate is not None:
            words += ["--rest-rate", repr(case.rest_rate)]
        for path, value in self.overrides.items():
            words += ["--set", f"{path}={_text(value)}"]
        return shlex.join(words)

    @property
    def case(self) -> Case:
        """The case that simulates the best design.

        Turns, if its transition is one of theirs, or if they contradict it.
        """
        case = Case(
            speed_rpm=self.problem.speed(np.array(self.best.z)), rest_rate=self.problem.rest_rate
        )
        if self.control.confirmed and self.best.engine not in (TURN, REDUCED_TURN):
            return case
        return replace(case, window=Window.CYCLE, cycles=self.control.turns + 1)

    @property
    def gain(self) -> float | None:
        """Relative change of the first aim from the model's own numbers; None without them."""
        name = self.problem.aims[0].quantity
        if self.before is None or self.before.values[name] == 0.0:
            return None
        return self.best.values[name] / self.before.values[name] - 1.0

    def record(self) -> dict[str, Any]:
        """The result as plain data for JSON."""
        return {
            "title": self.problem.title,
            "model": self.problem.model,
            "caution": CAUTION,
            "aims": [str(item) for item in self.problem.aims],
            "limits": [str(item) for item in self.problem.limits],
            "parameters": [
                {
                    "name": item.name,
                    "path": item.target.path,
                    "low": item.low,
                    "high": item.high,
                    "before": item.start,
                    "optimum": self.best.numbers[item.name],
                }
                for item in self.problem.parameters
            ],
            "before": None if self.before is None else self.before.record(),
            "optimum": self.best.record(),
            "relative_change": self.gain,
            "holding": [asdict(item) for item in self.account.bindings],
            "first_order_residual": self.account.residual,
            "control": self.control.record(),
            "contradiction": self.contradiction or None,
            "front": [
                {**item.record(), "control": seen.record()}
                for item, seen in zip(self.front, self.front_controls, strict=True)
            ],
            "overrides": self.overrides,
            "command": self.command,
            "search": {
                "seed": self.seed,
                "engines": dict(self.engines),
                "why_engine": self.why_engine,
                "screened": self.screened,
                "no_machine": list(self.no_machine),
                "descents": [asdict(item) for item in self.descents],
                "check": None if self.check is None else asdict(self.check),
                "check_gain": self.check_gain,
            },
            "work": {"evaluations": self.evaluations, "wall_s": self.wall_s},
        }


def _text(value: object) -> str:
    """A value as ``--set`` takes it, to its last digit."""
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, float) else str(value)

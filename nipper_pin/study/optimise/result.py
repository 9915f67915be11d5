"""What an optimisation found: the optimum, what holds it back, and the front."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from .binding import Account
from .descend import Descent
from .problem import Problem
from .search import Found

CAUTION = (
    "A result of the model, and as good as its numbers; those of the E62 are an estimate "
    "identified from published ratios, never the maker's data."
)


@dataclass(frozen=True, kw_only=True)
class Design:
    """One set of numbers.

    Attributes:
        z: Unit coordinates.
        numbers: Values of the free numbers by name.
        values: Quantities by name.
        slacks: Slack of every limit, in the order of the problem.
        inside: Whether all limits hold, to the tolerance of the search.
    """

    z: tuple[float, ...]
    numbers: Mapping[str, float]
    values: Mapping[str, float]
    slacks: tuple[float, ...]
    inside: bool


@dataclass(frozen=True, kw_only=True)
class Optimum:
    """What was found.

    Attributes:
        problem: The problem.
        seed: Seed of starts and of the global check.
        before: The model's own numbers; None if they make no machine that can be simulated.
        best: The best design by the first aim.
        account: What holds it back.
        descents: Descents by the first aim, the best first.
        screened: Samples of the screen.
        no_machine: Of these, those that made no machine, and why, each reason once.
        check: Result of differential evolution; None without a global check.
        check_gain: Relative improvement of the first aim that it brought beyond the descents.
        engine: Engine of the search.
        other_engine: Engine of the control.
        control: Quantities of the best design in other ways; None for one that has no other way.
        front: Designs of the Pareto front by the second aim, the best by the first aim first; empty
            with one aim.
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
    engine: str
    other_engine: str
    control: Mapping[str, float | None]
    front: tuple[Design, ...]
    evaluations: int
    wall_s: float

    @property
    def overrides(self) -> dict[str, object]:
        """Overrides of the model that give the best design, for ``load``."""
        return self.problem.overrides(np.array(self.best.z))

    @property
    def command(self) -> str:
        """The command that simulates the best design."""
        speed = self.problem.speed(np.array(self.best.z))
        words = ["nipper-pin", "simulate", self.problem.model, "--speed", repr(speed)]
        for path, value in self.overrides.items():
            words += [
                "--set",
                f"{path}={value!r}" if isinstance(value, float) else f"{path}={value}",
            ]
        return shlex.join(words)

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
                    "lower": item.lower,
                    "upper": item.upper,
                    "before": item.start,
                    "optimum": self.best.numbers[item.name],
                }
                for item in self.problem.parameters
            ],
            "before": None if self.before is None else _design(self.before),
            "optimum": _design(self.best),
            "relative_change": self.gain,
            "holding": [asdict(item) for item in self.account.bindings],
            "first_order_residual": self.account.residual,
            "control": {"engine": self.other_engine, "values": dict(self.control)},
            "front": [_design(item) for item in self.front],
            "overrides": self.overrides,
            "command": self.command,
            "search": {
                "seed": self.seed,
                "engine": self.engine,
                "screened": self.screened,
                "no_machine": list(self.no_machine),
                "descents": [asdict(item) for item in self.descents],
                "check": None if self.check is None else asdict(self.check),
                "check_gain": self.check_gain,
            },
            "work": {"evaluations": self.evaluations, "wall_s": self.wall_s},
        }


def _design(item: Design) -> dict[str, Any]:
    return {
        "numbers": dict(item.numbers),
        "values": {
            key: value if math.isfinite(value) else None for key, value in item.values.items()
        },
        "slacks": list(item.slacks),
        "inside": item.inside,
    }

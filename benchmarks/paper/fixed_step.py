"""Error of the published scheme, a fixed step of 0.01 us, against ours."""

from __future__ import annotations

from dataclasses import asdict, astuple, dataclass
from typing import Any

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.hybrid import Case, simulate
from nipper_pin.mechanism import Mechanism

from ..peers import fixed_steps
from ..peers.protocol import Setting
from .published import Published

STEPS_S = (1e-6, 3e-7, 1e-7, 3e-8, 1e-8)
RULES = ("forward", "semi-implicit")
_QUANTITIES = ["rebound_time_s_1", "rebound_time_s_2", "rebound_amplitude_1", "duration_s"]


@dataclass(frozen=True)
class Rule:
    """Errors of one explicit rule, "forward" (Euler) or "semi-implicit".

    Attributes:
        relative_errors: By step and quantity.
        order: Slope of the transition time's error over the step, by least squares on logarithms.
        extrapolated_errors: By quantity, of what the two smallest steps extrapolate to with order
            one: that the limit is ours.
    """

    name: str
    steps_s: FloatArray
    relative_errors: FloatArray
    order: float
    extrapolated_errors: FloatArray


@dataclass(frozen=True)
class FixedStep:
    """The published scheme beside ours: its steps at the published step, our evaluations.

    Which of the two explicit rules the study uses is not stated.
    """

    speed_rpm: float
    steps_taken: int
    our_evaluations: int
    our_error_s: float
    rules: tuple[Rule, ...]

    def record(self) -> dict[str, Any]:
        """Return the errors as plain data."""
        return {
            **{key: value for key, value in asdict(self).items() if key != "rules"},
            "quantities": _QUANTITIES,
            "rules": [
                {
                    key: value.tolist() if isinstance(value, np.ndarray) else value
                    for key, value in asdict(rule).items()
                }
                for rule in self.rules
            ],
        }


def fixed_step(mechanism: Mechanism, conditions: Published) -> FixedStep:
    """Run the published scheme of an E62 with several steps, at the common speed."""
    speed = conditions.common_speed_rpm
    solution = simulate(mechanism, Case(speed_rpm=speed))
    first, second = solution.collisions[:2]
    end = solution.transitions[0].duration
    exact = np.array([first.rebound_time, second.rebound_time, first.rebound_amplitude, end])
    run = fixed_steps.prepare(mechanism, speed)
    rules, taken = [], 0
    for name in RULES:
        runs = [run(Setting(name, step, method=name)) for step in STEPS_S]
        taken = runs[-1].evaluations
        values = np.array([astuple(item)[: len(_QUANTITIES)] for item in runs])
        rules.append(_rule(name, np.array(STEPS_S), values, exact))
    error = float(solution.errors[-1].time)
    return FixedStep(speed, taken, solution.evaluations, error, tuple(rules))


def _rule(name: str, steps: FloatArray, values: FloatArray, exact: FloatArray) -> Rule:
    errors = values / exact - 1.0
    slope = np.polyfit(np.log(steps), np.log(np.abs(errors[:, -1])), 1)[0]
    coarse, fine = values[-2:]
    limit = fine + (fine - coarse) / (steps[-2] / steps[-1] - 1.0)
    return Rule(name, steps, errors, float(slope), limit / exact - 1.0)

"""One descent: sequential quadratic programming from one start, inside bounds and limits.

Bounces and kinematics are smooth in the free numbers as long as the same stops take part, and the
limits of a good design bind: SciPy's SLSQP follows curved limits with a few dozen points, where a
search without derivatives needs thousands. Derivatives are central differences.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ....arrays import FloatArray
from ....errors import SimulationError
from ....tolerances.study import DESCENT_END, DESCENT_GAIN, FEASIBLE
from ..points import evaluator
from .trace import Scales, Trace

_MOST_STEPS = 40
_ROUNDS = 3
# Scaled value of numbers that make no machine: the line search turns back from them.
_UNUSABLE = 1e3


@dataclass(frozen=True, kw_only=True)
class Descent:
    """One start and the end of its descent.

    Attributes:
        start: Unit coordinates of the start.
        z: Unit coordinates of the best point on the way: the least aim inside the limits, or else
            the least violation.
        aim: Value of the aim there, in its unit, negative if it is maximised.
        violation: Largest scaled violation there.
        evaluations: Points that were evaluated.
        failures: Of these, those that made no machine.
        engines: Numbers of the others by the engine that found them.
        converged: Whether the last run ended by its tolerance.
    """

    start: tuple[float, ...]
    z: tuple[float, ...]
    aim: float
    violation: float
    evaluations: int
    failures: int
    engines: Mapping[str, int]
    converged: bool

    @property
    def feasible(self) -> bool:
        """Whether all limits hold."""
        return self.violation <= FEASIBLE

    @property
    def rank(self) -> tuple[float, float]:
        """Smaller is better: inside the limits by the aim, outside by the violation."""
        return (0.0, self.aim) if self.feasible else (self.violation, self.aim)


def descend(text: bytes, scales: Scales, start: tuple[float, ...]) -> Descent:
    """Minimise the first aim of a problem from the unit coordinates of a usable point."""
    return _run(Trace(evaluator(text), scales), start, _minimise)


def restore(text: bytes, scales: Scales, start: tuple[float, ...]) -> Descent:
    """Make the largest violation of a problem's limits as small as it can be, likewise."""
    return _run(Trace(evaluator(text), scales), start, _mend)


def _run(
    trace: Trace, start: tuple[float, ...], method: Callable[[Trace, FloatArray], bool]
) -> Descent:
    """Repeat a method from the best point so far: each run forgets the curvature of the last."""
    z = np.clip(np.array(start), 0.0, 1.0)
    trace.at(z)
    rank = (np.inf, np.inf)
    converged = False
    for _ in range(_ROUNDS):
        try:
            converged = method(trace, z)
        except SimulationError:
            # However short its step, the line search met no machine: it stands at such an edge.
            converged = False
        point, violation = trace.best()
        now = (max(violation - FEASIBLE, 0.0), trace.aim(point) / trace.scales.aim)
        if now[0] >= rank[0] - DESCENT_GAIN and now[1] >= rank[1] - DESCENT_GAIN:
            break
        z, rank = point.z, now
    point, violation = trace.best()
    evaluations, failures = trace.counts
    return Descent(
        start=start,
        z=tuple(point.z.tolist()),
        aim=trace.aim(point),
        violation=violation,
        evaluations=evaluations,
        failures=failures,
        engines=trace.engines,
        converged=converged,
    )


def _minimise(trace: Trace, z: FloatArray) -> bool:
    from scipy.optimize import minimize

    size = np.array(trace.scales.limits)[list(trace.at(z).owners)]

    def value(x: FloatArray) -> float:
        point = trace.at(x)
        return trace.aim(point) / trace.scales.aim if point.usable else _UNUSABLE

    def rows(x: FloatArray) -> FloatArray:
        point = trace.at(x)
        return point.rows / size if point.usable else np.full(len(size), -_UNUSABLE)

    def value_slopes(x: FloatArray) -> FloatArray:
        return np.asarray(trace.slopes(x)[0] / trace.scales.aim)

    def row_slopes(x: FloatArray) -> FloatArray:
        return np.asarray(trace.slopes(x)[1] / size[:, None])

    found = minimize(
        value,
        z,
        jac=value_slopes,
        method="SLSQP",
        bounds=[(0.0, 1.0)] * len(z),
        constraints=[{"type": "ineq", "fun": rows, "jac": row_slopes}] if len(size) else [],
        options={"ftol": DESCENT_END, "maxiter": _MOST_STEPS},
    )
    return bool(found.success)


def _mend(trace: Trace, z: FloatArray) -> bool:
    """Least t with every scaled row above -t: the elastic form of the limits."""
    from scipy.optimize import minimize

    size = np.array(trace.scales.limits)[list(trace.at(z).owners)]
    begin = trace.scales.violation(trace.at(z))

    def rows(x: FloatArray) -> FloatArray:
        point = trace.at(x[:-1])
        inside = point.rows / size if point.usable else np.full(len(size), -_UNUSABLE)
        return np.asarray(inside + x[-1])

    def row_slopes(x: FloatArray) -> FloatArray:
        inner = trace.slopes(np.clip(x[:-1], 0.0, 1.0))[1] / size[:, None]
        return np.column_stack([inner, np.ones(len(size))])

    only_last = np.append(np.zeros(len(z)), 1.0)
    found = minimize(
        lambda x: float(x[-1]),
        np.append(z, begin),
        jac=lambda _: only_last,
        method="SLSQP",
        bounds=[*[(0.0, 1.0)] * len(z), (0.0, None)],
        constraints=[{"type": "ineq", "fun": rows, "jac": row_slopes}],
        options={"ftol": DESCENT_END, "maxiter": _MOST_STEPS},
    )
    return bool(found.success)

"""An identification whose targets are linear in the numbers: all of it in closed form."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from nipper_pin.errors import SimulationError
from nipper_pin.hybrid.result.premise import Premise
from nipper_pin.mechanism import Mechanism, load
from nipper_pin.study.identify.fitting.fit import Descent, Fit
from nipper_pin.study.identify.fitting.objective import Objective
from nipper_pin.study.identify.problem.geometry import Sources
from nipper_pin.study.identify.problem.problem import Parameter, Problem
from nipper_pin.study.identify.problem.targets import Condition, Target

PATHS = ("springs.steeve.preload_length_mm", "stops.jaw.restitution", "drives.tension.ratio")
RANGES = ((8.0, 16.0), (0.1, 0.3), (1.8, 2.6))
STARTS = (11.0, 0.15, 2.0)
AT = Condition(650.0)


@cache
def _e62() -> Mechanism:
    return load("e62")


class At:
    """The E62, which remembers the unit coordinates that it was made of."""

    def __init__(self, z: np.ndarray) -> None:
        self.z = z
        self._mechanism = _e62()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._mechanism, name)


@dataclass(frozen=True)
class Linear(Objective):
    """Targets ``slopes @ z + offset``; no machine where a coordinate exceeds ``edge``."""

    matrix: Any = None
    offset: Any = None
    edge: float = 2.0

    def mechanism(self, z: np.ndarray) -> Any:
        """The machine of these coordinates."""
        if z.max(initial=0.0) > self.edge:
            message = "no machine"
            raise SimulationError(message)
        return At(np.array(z))

    def _predicted(self, mechanism: Any) -> np.ndarray:
        return np.asarray(self.matrix @ mechanism.z + self.offset)


def problem(
    wanted: np.ndarray, sigma: np.ndarray, quantities: tuple[str, ...] = (), **others: Any
) -> Problem:
    """Targets of these values, and three free numbers of the E62."""
    names = quantities or ("duration_s",) * len(wanted)
    return Problem(
        title="a line",
        sources=Sources.of(_e62()),
        parameters=tuple(
            Parameter(path=path, low=low, high=high, start=start, why=f"because of {path}")
            for path, (low, high), start in zip(PATHS, RANGES, STARTS, strict=True)
        ),
        targets=tuple(
            Target(name=f"t{n}", quantity=name, at=AT, value=float(value), sigma=float(s))
            for n, (name, value, s) in enumerate(zip(names, wanted, sigma, strict=True))
        ),
        **others,
    )


def fitted(objective: Objective, *z: float, **others: Any) -> Fit:
    """A fit that ended at these coordinates."""
    end = np.array(z)
    start = 0.5 * np.ones(len(end))
    rows = objective.residuals(end)
    cost = 0.5 * float(rows @ rows)
    given: dict[str, Any] = {
        "objective": objective, "seed": 7, "values": objective.values(end),
        "descents": (Descent(start, end, cost, 12, converged=True),),
        "predicted": objective.predicted(end), "excess": np.zeros(0),
        "premises": {AT: Premise(True, "as assumed")},
    }  # fmt: skip
    return Fit(**{**given, **others})

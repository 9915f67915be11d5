"""An identification whose targets are linear in the numbers: all of it in closed form."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from nipper_pin import Mechanism, SimulationError, load
from nipper_pin.hybrid.result.premise import Premise
from nipper_pin.study.identify import (
    Condition,
    Descent,
    Fit,
    Objective,
    Parameter,
    Problem,
    Target,
)

PATHS = ("springs.steeve.preload_length_mm", "stops.jaw.restitution",
         "springs.steeve.stiffness_N_per_m")  # fmt: skip
RANGES = ((8.0, 16.0), (0.1, 0.3), (6000.0, 12000.0))
STARTS = (11.0, 0.15, 7500.0)
AT = Condition(650.0)


@cache
def _e62() -> Mechanism:
    return load("e62")


@dataclass(frozen=True)
class Linear(Objective):
    """Targets ``slopes @ z + offset`` of a machine's three numbers.

    Where one of them exceeds ``edge`` in unit coordinates the machine cannot be simulated.
    """

    matrix: Any = None
    offset: Any = None
    edge: float = 2.0

    def mechanism(self, z: np.ndarray) -> Mechanism:
        """The E62 with these numbers, not built anew."""
        machine, numbers = _e62(), self.values(z)
        preload, restitution, stiffness = (
            numbers.get(path, start) for path, start in zip(PATHS, STARTS, strict=True)
        )
        (spring,) = machine.springs
        jaw = replace(machine.stop("jaw"), restitution=restitution)
        return replace(
            machine,
            springs=(replace(spring, preload=1e-3 * preload, stiffness=stiffness),),
            stops=tuple(jaw if stop.name == "jaw" else stop for stop in machine.stops),
        )

    def _predicted(self, mechanism: Mechanism) -> np.ndarray:
        (spring,) = mechanism.springs
        numbers = (1e3 * spring.preload, mechanism.stop("jaw").restitution, spring.stiffness)
        by_path = dict(zip(PATHS, numbers, strict=True))
        # Of a number that is none of the three no target knows.
        asked = np.array([by_path.get(item.path, item.low) for item in self.problem.parameters])
        z = (asked - self.low) / self.width
        if z.max(initial=0.0) > self.edge:
            message = "no machine"
            raise SimulationError(message)
        return np.asarray(self.matrix @ z + self.offset)


def problem(
    wanted: np.ndarray, sigma: np.ndarray, quantities: tuple[str, ...] = (), **others: Any
) -> Problem:
    """Targets of these values, and three free numbers of the E62."""
    names = quantities or ("duration_s",) * len(wanted)
    return Problem(
        title="a line",
        mechanism=_e62(),
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

"""Parts of solutions whose numbers are all made up, and the limits that checks hold them to.

The numbers have both signs and many sizes, and no equation holds between them: each term of a limit
is then seen in it, whatever it is worth in the solution of a real machine.
"""

from __future__ import annotations

from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

EPS = 2.0**-52
Said = tuple[str, float, float]
"""What is looked at, what is found, the most that is allowed."""


def watched(patch: pytest.MonkeyPatch, module: ModuleType) -> list[Said]:
    """All that a file of checks finds, and its limits, whether they are met or not."""
    said: list[Said] = []

    def beyond(what: str, found: float, most: float) -> list[str]:
        said.append((what, float(found), float(most)))
        return []

    patch.setattr(module, "beyond", beyond)
    return said


def compared(said: list[Said], wanted: list[Said]) -> None:
    """The same limits in the same order, to round-off of numbers that are no small differences."""
    assert [item[0] for item in said] == [item[0] for item in wanted]
    for (what, found, most), (_, other, limit) in zip(said, wanted, strict=True):
        assert found == pytest.approx(other, rel=1e-11, abs=1e-300), f"{what}: found"
        assert most == pytest.approx(limit, rel=1e-11, abs=1e-300), f"{what}: at most"


class Stop(SimpleNamespace):
    """A stop on one coordinate."""

    def gap(self, q: Any) -> float:
        return float(self.sense * (q[self.index] - self.at))

    def gaps(self, q: Any) -> Any:
        return self.sense * (q[:, self.index] - self.at)

    def rate(self, v: Any) -> float:
        return float(self.sense * v[self.index])


STOPS = (
    Stop(name="low", index=1, sense=1.0, at=0.3, restitution=0.25, lever=1.0),
    Stop(name="high", index=2, sense=-1.0, at=-0.2, restitution=0.75, lever=2.0),
    Stop(name="far", index=3, sense=1.0, at=-4.0, restitution=0.0, lever=1.0),
)


def mechanism(**changes: Any) -> Any:
    """Three stops, and nothing else that is not asked for."""
    of_name = {stop.name: stop for stop in STOPS}
    given: dict[str, Any] = {
        "stops": STOPS,
        "struts": (),
        "springs": (),
        "dampers": (),
        "simultaneous": "newton",
    }
    given |= {"tabulated_springs": (), "stop": of_name.__getitem__}
    return SimpleNamespace(**given | changes)


class Body(SimpleNamespace):
    """Dynamics of five coordinates that are none of any machine."""

    def __init__(self, seed: int, **changes: Any) -> None:
        rng = np.random.default_rng(seed)
        super().__init__(
            reach_m=0.7, M=rng.normal(size=(5, 5)), G=rng.normal(size=(2, 5)),
            A=rng.normal(size=(5, 5)), B=rng.normal(size=(5, 5)), w=rng.normal(size=5),
        )  # fmt: skip
        self.M[np.diag_indices(5)] = rng.uniform(1.0, 5.0, 5)
        self.__dict__.update(changes)

    def mass_matrix(self, q: Any) -> Any:
        return self.M * (1.0 + q[0] ** 2)

    def closures(self, q: Any) -> Any:
        rows = self.G * (1.0 + np.abs(q[:, 1:2, None]))
        return np.full((len(q), 2), np.nan), rows

    def inverse_dynamics(self, q: Any, v: Any, a: Any) -> Any:
        return a @ self.A + v**2 @ self.B + np.cos(q) * self.w

    def kinetic_energy(self, q: Any, v: Any) -> Any:
        return (v**2).sum(axis=1) * (1.0 + q[:, 0] ** 2)

    def gravity_energy(self, q: Any) -> Any:
        return q @ self.w

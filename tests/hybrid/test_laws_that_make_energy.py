# ruff: noqa: ARG002
"""Laws of users are looked at while they run: no rebound and no force makes energy from nothing."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest
from small_machines import link, machine, slide

from nipper_pin import Case, ElementError, ImpactError, simulate
from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism.files.register import FORCES, RESTITUTIONS
from nipper_pin.mechanism.forces import ForceTable
from nipper_pin.mechanism.restitution import RestitutionTable

RETURNED: dict[str, Any] = {
    "gains": 1.17,
    "gains a little": 1.0 + 1e-9,
    "negative": -0.1,
    "no number": math.nan,
    "nothing": None,
    "text": "0.5",
    "whole": 1,
    "numpy": np.float64(0.5),
    "zero": 0.0,
}
GOOD = ("whole", "numpy", "zero")


@dataclass(frozen=True, kw_only=True)
class Returning:
    """A coefficient of any kind."""

    name: str

    def coefficient(self, e_0: float, rate: float) -> Any:
        return RETURNED[self.name]

    def slope(self, e_0: float, rate: float) -> float:
        return 0.0


class ReturningRestitution(RestitutionTable, frozen=True, kw_only=True, tag="returning"):
    """A restitution of any kind."""

    name: str

    def build(self, kind: str) -> Returning:
        return Returning(name=self.name)


@dataclass(frozen=True, kw_only=True)
class Rubbing:
    """Force c x_dot and as much heat, from some rate on with the wrong sign."""

    c: float
    knots: ClassVar[tuple[float, ...]] = ()

    def force(self, x: FloatArray, rate: FloatArray) -> FloatArray:
        return self.c * rate

    def energy(self, x: FloatArray) -> FloatArray:
        return np.zeros_like(x)

    def heat(self, x: FloatArray, rate: FloatArray) -> FloatArray:
        return self.c * rate**2


class RubbingForce(ForceTable, frozen=True, kw_only=True, tag="rubbing"):
    """A damper of any sign."""

    c: float

    def build(self, kind: str) -> Rubbing:
        return Rubbing(c=self.c)


@pytest.fixture(autouse=True)
def registered(monkeypatch: pytest.MonkeyPatch) -> None:
    """The laws are known in these tests alone."""
    for register, table in ((RESTITUTIONS, ReturningRestitution), (FORCES, RubbingForce)):
        monkeypatch.setattr(register, "_added", dict(register._added))
        register.add(table)


def falling(**tables: Any) -> Any:
    """A ball that falls from 0.2 m; it strikes the floor at sqrt(2 g h) = 1.98 m/s."""
    parts = [link("ball"), slide("height", "frame", "ball", (0.0, 1.0))]
    stop = {"joint": "height", "restitution": 0.5, **tables.pop("stop", {})}
    return machine(
        parts,
        1,
        gravity=9.81,
        stops={"floor": stop},
        initial={"height": {"at_mm": 200.0}},
        **tables,
    )


CASE = Case(speed_rpm=60.0, window="cycle", rest_rate=0.1)


@pytest.mark.parametrize("name", RETURNED)
def test_a_coefficient_is_a_number_from_zero_to_one(name: str) -> None:
    """Any other one is refused where it is met."""
    ball = falling(stop={"restitution_law": {"law": "returning", "name": name}})
    if name in GOOD:
        first = simulate(ball, CASE).collisions[0]
        assert first.separation_rate == pytest.approx(-float(RETURNED[name]) * first.approach_rate)
        return
    with pytest.raises(ImpactError) as caught:
        simulate(ball, CASE)
    message = caught.value.message
    assert "Returning of stop 'floor'" in message
    assert f"returns {RETURNED[name]!r}" in message
    assert f"after t = {math.sqrt(2 * 0.2 / 9.81):.6g} s" in message
    assert caught.value.evidence["rate"] == pytest.approx(math.sqrt(2 * 9.81 * 0.2))


def test_heat_below_zero_is_refused_while_it_runs() -> None:
    ball = falling(forces={"rub": {"law": "rubbing", "joint": "height", "c": -0.25}})
    with pytest.raises(ElementError) as caught:
        simulate(ball, CASE)
    message, evidence = caught.value.message, caught.value.evidence
    assert "force rub (Rubbing, law 'rubbing')" in message
    assert f"its heat is {evidence['heat']:.6g} W" in message
    # v = (m g / c) (exp(c t / m) - 1) with c = 0.25 N s/m, downwards.
    rate = 9.81 / 0.25 * math.expm1(0.25 * evidence["t"])
    assert evidence["heat"] == pytest.approx(-0.25 * rate**2, rel=1e-6)
    # Where it is none by round-off it is taken.
    ball = falling(forces={"rub": {"law": "rubbing", "joint": "height", "c": 0.25}})
    assert abs(simulate(ball, CASE).energy.residual) < 1e-9

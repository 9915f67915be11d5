"""Units that measurements may be in by mistake: which factor is told as which unit."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from linear_problem import Linear, fitted, problem

from nipper_pin.errors import SimulationError
from nipper_pin.study.identify.fitting import suspects
from nipper_pin.study.identify.fitting.fit import Fit
from nipper_pin.study.identify.fitting.suspects import suspected_units


def of_fit(fit: Fit) -> tuple[str, ...]:
    return suspected_units(fit.objective, fit.best.z, fit.predicted)


@pytest.mark.parametrize(
    ("name", "factor", "words"),
    [
        ("duration_s", 1000.0, "about 1000 times what the model gives: is it in milliseconds?"),
        ("duration_s", 1.2e6, "about 1.2e+06 times what the model gives: is it in microseconds?"),
        ("duration_s", 3000.0, "what the model gives: is it in milliseconds?"),
        ("duration_s", 60.0, "about 60 times what the model gives: look at its unit."),
        ("duration_s", 5.1, "about 5.1 times what the model gives: look at its unit."),
        ("duration_s", 1 / 5.1, "about 0.2 times what the model gives: look at its unit."),
        ("duration_s", 4.9, None), ("duration_s", 1 / 4.9, None),
        ("first_two_share", 100.0, "is it in percent?"),
        ("rebound_time_s_1", 1000.0, "is it in milliseconds?"),
        ("rebound_amplitude_1", 57.0, "is it in degrees?"),
        ("rebound_amplitude_1", 1000.0, "is it in milliradians?"),
        ("rebound_amplitude_1", 20.0, "is it in degrees or millimetres at the contact point?"),
        ("approach_rate_1", 57.3, "is it in degrees a second?"),
        ("approach_rate_1", -20.0, "about 20 times what the model gives, with the other sign: a "
                                   "closing rate is negative."),
    ],
)  # fmt: skip
def test_units_that_were_mistaken(name: str, factor: float, words: str | None) -> None:
    """The median of a quantity's targets by what the model gives, at its start and at the fit."""
    values = np.array([0.5, 0.25, 2.0])
    wanted = factor * values * np.array([1.0, 0.9, 1.3])
    objective = Linear(
        problem(wanted, np.abs(wanted), (name,) * 3), matrix=np.zeros((3, 3)), offset=values
    )
    found = of_fit(fitted(objective, 0.5, 0.5, 0.5))
    if words is None:
        assert found == ()
    else:
        assert len(found) == 1
        assert found[0].startswith(f"{name} is wanted about ")
        assert words in found[0]


def test_no_unit_is_suspected_of_what_a_fit_meets() -> None:
    """Ten times off at the start and within a factor of two at the fit; changes are fractions."""
    slope = np.array([[10.0, 0.0, 0.0]])
    for end, told in ((0.55, False), (0.45, True), (1.9, False), (2.1, True)):
        objective = Linear(problem(np.array([10.0]), np.array([1.0])), matrix=slope,
                           offset=np.array([1.0 - 3.75]), edge=9.0)  # fmt: skip
        # 1 at the model's own value, 0.375 of the range, so 10 times less than wanted.
        fit = fitted(objective, end, 0.5, 0.5)
        fit = replace(fit, predicted=np.array([{0.55: 5.1, 0.45: 4.9, 1.9: 19.0, 2.1: 21.0}[end]]))
        assert bool(of_fit(fit)) is told
    base = problem(np.array([25.0]), np.array([1.0]))
    (target,) = base.targets
    change = replace(base, targets=(replace(target, since=target.at._replace(speed_rpm=450.0)),))
    objective = Linear(change, matrix=np.zeros((1, 3)), offset=np.array([0.25]))
    assert of_fit(fitted(objective, 0.5, 0.5, 0.5)) == (
        "change of duration_s is wanted about 100 times what the model gives: is it in percent?",
    )


def test_units_of_a_slide() -> None:
    """Of a stop on a slide there are no angles; without a contact no way of the lips."""

    def machine(kind: str, contact: object) -> Any:
        stop = SimpleNamespace(index=0, contact=contact, lever=0.07)
        joint = SimpleNamespace(index=0, kind=kind)
        return SimpleNamespace(transition_stop="s", stop=lambda _: stop, joints=[joint])

    assert suspects._units("rebound_amplitude_1", machine("prismatic", None)) == {
        "millimetres": 1e3
    }
    assert suspects._units("approach_rate_1", machine("prismatic", None)) == {
        "millimetres a second": 1e3
    }
    degree = 180.0 / math.pi
    assert suspects._units("rebound_amplitude_1", machine("revolute", None)) == pytest.approx(
        {"degrees": degree, "milliradians": 1e3}
    )
    assert suspects._units("approach_rate_1", machine("revolute", object())) == pytest.approx(
        {"degrees a second": degree, "milliradians a second": 1e3,
         "metres at the contact point a second": 0.07,
         "millimetres at the contact point a second": 70.0}
    )  # fmt: skip


def test_units_are_suspected_by_the_fit_where_the_model_itself_fails(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A thousand times what is found, though nothing is known of the model's own numbers."""
    monkeypatch.setattr(suspects, "_units", lambda *_: {})
    monkeypatch.setattr(suspects, "_question", lambda factor, _: f"what? {factor:g}")

    def predicted(_: Any) -> Any:
        message = "it jams"
        raise SimulationError(message)

    aims = problem(np.array([4.0, 6.0]), np.ones(2)).targets
    objective: Any = SimpleNamespace(mechanism=lambda _: None, predicted=predicted, start=None,
                                     problem=SimpleNamespace(targets=aims))  # fmt: skip
    (told,) = suspects.suspected_units(objective, np.zeros(0), np.array([4e-3, 6e-3]))
    assert told == "duration_s is wanted about 1000 times what? 1000"

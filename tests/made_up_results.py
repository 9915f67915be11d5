"""Made-up results of an identification and of an optimisation: each number is another one."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
from rich.console import Console

from nipper_pin.study.identify.fitting.goodness import Verdict
from nipper_pin.study.optimise.problem.problem import Aim, Limit, Parameter
from nipper_pin.view.studies import identify_report

PATHS = ("springs.a.rate_N_per_m", "stops.b")


def identified(verdict: Verdict, **others: Any) -> Callable[[Console], None]:
    """What is printed of a fit of two numbers to two targets."""
    targets = [SimpleNamespace(name=others.get("name", "one"), value=5.25, sigma=0.5, since=0.0),
               SimpleNamespace(name="two", value=80.0, sigma=2.5, since=0.0)]  # fmt: skip
    parameters = [SimpleNamespace(path=PATHS[0], start=11.0, low=4.0, high=20.0, width=16.0),
                  SimpleNamespace(path=PATHS[1], start=0.25, low=0.125, high=0.5,
                                  width=0.375)]  # fmt: skip
    given: dict[str, Any] = {
        "objective": SimpleNamespace(
            problem=SimpleNamespace(title="made up", targets=targets, parameters=parameters)
        ),
        "descents": [SimpleNamespace(cost=2.0)], "best": SimpleNamespace(cost=2.0), "seed": 3,
        "within": lambda part: 1 if part < 0.05 else 2, "predicted": np.array([5.375, 76.0]),
        "deviations": np.array([0.025, -0.05]), "values": {PATHS[0]: 12.25, PATHS[1]: 0.5},
        "at_bounds": {PATHS[1]: "high"}, "premises": {}, "broken_limits": {},
        "excess": np.zeros(0), **others,
    }  # fmt: skip
    fit: Any = SimpleNamespace(**given)
    judged: Any = SimpleNamespace(
        verdict=verdict, sentence=lambda: f"It is {verdict.value}.", scale=others.get("scale", 2.0),
        residuals=np.array([0.25, -1.6]), outliers=(1,),
    )  # fmt: skip
    known: Any = SimpleNamespace(
        paths=PATHS, identifiable_directions=1, singular_values=[9.5, 0.25], determined=(),
        ranked=lambda: [(PATHS[0], 0.25), (PATHS[1], 0.5)],
        deviations={PATHS[0]: 0.125, PATHS[1]: 0.2},
        scaled_deviations=lambda scale: {PATHS[0]: 0.0625 * scale, PATHS[1]: 0.29 * scale},
        strongest=lambda _: [],
    )  # fmt: skip
    return lambda console: identify_report.print_fit(fit, judged, known, (), console)


LIMITS = (
    Limit(quantity="duration_s", side="high", value=0.5),
    Limit(quantity="rebound_amplitude_1", side="low", value=2e-6),
    Limit(quantity="duration_s", side="low", value=0.125),
)  # fmt: skip


def design(scale: float, *, inside: bool = True) -> Any:
    return SimpleNamespace(
        values={"duration_s": 0.25 * scale, "rebound_amplitude_1": 3.0 * scale},
        numbers={"springs.a.rate": 7.0 * scale, "springs.b.rate_N_per_m": 90.0 * scale,
                 "stops.c": 0.5 * scale},
        inside=inside, slacks=np.array([0.5, -0.5, 0.0]),
    )  # fmt: skip


def optimum(**others: Any) -> Any:
    """Three numbers, two quantities."""
    names = ("springs.a.rate", "springs.b.rate_N_per_m", "stops.c")
    paths = (*names[:2], "springs.c.stiffness_N_per_m")
    targets: list[Any] = [SimpleNamespace(path=path) for path in paths]
    problem = SimpleNamespace(
        title="made up", quantities=("duration_s", "rebound_amplitude_1"),
        aims=[Aim(quantity="duration_s", sense=1.0),
              Aim(quantity="rebound_amplitude_1", sense=-1.0)],
        units={"duration_s": "s", "rebound_amplitude_1": "m"}, limits=LIMITS,
        parameters=[Parameter(name=name, start=float(k), low=-1.0 * k, high=10.0 * k,
                              target=target)
                    for k, (name, target) in enumerate(zip(names, targets, strict=True), 1)],
    )  # fmt: skip
    descents = [SimpleNamespace(feasible=fits, aim=aim)
                for aim, fits in ((0.25, True), (0.25 * (1 + 9e-7), True), (0.2, False),
                                  (0.25 * (1 + 1.1e-6), True))]  # fmt: skip
    given: dict[str, Any] = {
        "problem": problem, "gain": -0.125, "best": design(1.0), "before": design(2.0),
        "account": SimpleNamespace(residual=0.0, bindings=[
            SimpleNamespace(name=str(LIMITS[0]), kind="limit", active=True, price=0.5),
            SimpleNamespace(name=str(LIMITS[1]), kind="limit", active=False, price=0.0),
            SimpleNamespace(name="stops.c <= 30", kind="bound", active=True, price=0.25)]),
        "control": SimpleNamespace(values={"duration_s": 0.375}, turns=4, confirmed=True),
        "contradiction": "",
        "descents": descents, "seed": 7, "evaluations": 5000, "wall_s": 1.5,
        "engines": {"reduced": 3000, "direct": 900, "turn": 80}, "check": None, "check_gain": 0.0,
        "no_machine": (), "front": (), "command": "do it", **others,
    }  # fmt: skip
    return SimpleNamespace(**given)

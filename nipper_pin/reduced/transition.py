"""Transitions of a reduced model: one, or a batch of them as arrays."""

from __future__ import annotations

import math
from functools import cache, partial
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import FloatArray
from ..errors import InputError, NipperError, SimulationError
from ..extras import require
from ..given import LARGEST, column, number
from ..units import S_PER_MIN
from .inputs import check_run, of_all_cases, one_row, speed_of, speeds_of, spring_rows
from .kernels.layout import Cases, Settings
from .model import ReducedModel
from .results import REASONS, ReducedTransition, Status, TransitionBatch

_AT_REST = int(Status.AT_REST)
_ENGINE = "the reduced engine"
# Gravity of one case by that of the model.
_ALL = np.ones(1)


def transition(
    model: ReducedModel,
    *,
    speed_rpm: float,
    restitution: float | None = None,
    stiffness: ArrayLike | None = None,
    preload: ArrayLike | None = None,
    gravity: float | None = None,
    rest_rate: float | None = None,
    tolerance: float = 1e-10,
    max_collisions: int = 256,
    assumed: bool = True,
) -> ReducedTransition:
    """Solve one transition.

    Args:
        restitution: e_N of the transition stop; by default that of the mechanism.
        stiffness: Spring rates, one number or shape (springs,) [N/m or N m/rad].
        preload: Deflections in the springs at zero, likewise [m or rad].
        gravity: Gravity along -z [m/s^2].
        rest_rate: None: the limit of the series. A number: rest at the first slower rebound.
        tolerance: Relative accuracy of flights and of the limit.
        max_collisions: Largest number of collisions.
        assumed: Whether the transition starts in the initial phase even if the machine does not
            arrive so; else it is then that of the turn.

    Returns:
        The transition.

    Raises:
        InputError: A parameter is out of range, or the case leaves the domain of the model.
        SimulationError: The stop does not come to rest, or another stop takes part; or the
            tables do not determine how the machine arrives at the transition of the turn.
    """
    check_run(rest_rate, tolerance, max_collisions)
    e_N = model.restitution if restitution is None else restitution
    cases = Cases(
        np.array([speed_of(speed_rpm) * (math.tau / S_PER_MIN)]),
        np.full((1, _stops(model)), number("restitution", e_N, 0.0, 1.0)),
        one_row("stiffness", stiffness, model.stiffness, 0.0),
        one_row("preload", preload, model.preload, -LARGEST),
        _ALL if gravity is None else _weight(model, gravity)[:1],
    )
    found, tell = _solved(model, cases, rest_rate, tolerance, assumed, max_collisions)
    status, count = found.told[0].tolist()
    if status != _AT_REST:
        raise _refusal(model, Status(status), count, speed_rpm, max_collisions)
    duration, error, share, bound = found.rest[0].tolist()
    table = found.table[0, :count].T.copy()
    return ReducedTransition(model.name, count, duration, error, share, bound, table, tell)


def transitions(
    model: ReducedModel,
    *,
    speed_rpm: ArrayLike,
    restitution: ArrayLike | None = None,
    stiffness: ArrayLike | None = None,
    preload: ArrayLike | None = None,
    gravity: ArrayLike | None = None,
    rest_rate: float | None = None,
    tolerance: float = 1e-10,
    max_collisions: int = 32,
    assumed: bool = True,
) -> TransitionBatch:
    """Solve many transitions in compiled code; a case is the same to the last bit alone.

    Args:
        speed_rpm: Cylinder speeds [r/min], a number or shape (n,); so are all the others.
        stiffness: Spring rates, shape (n,) with one spring or (n, springs) [N/m or N m/rad].
        preload: Deflections in the springs at zero, likewise [m or rad].
        max_collisions: Largest number of collisions of a case, and columns of the tables.
        assumed: Whether transitions start in the initial phase even if the machine does not arrive
            so; else they are then those of the turn, and cases whose arrival the tables cannot
            tell are marked ``UNTOLD``.

    All others are those of :func:`transition`.

    Returns:
        The batch; cases that did not come to rest are marked by their status.

    Raises:
        InputError: A parameter is out of range, or numba is not installed.
    """
    cases = _cases(model, speed_rpm, restitution, stiffness, preload, gravity)
    require("study", "numba", what=_ENGINE)
    check_run(rest_rate, tolerance, max_collisions)
    found, tell = _solved(model, cases, rest_rate, tolerance, assumed, max_collisions)
    status, counts = found.told.T.copy()
    table = found.table[:, :max_collisions].swapaxes(1, 2)
    return TransitionBatch(model.name, status, counts, found.rest, table, tell)


def _stops(model: ReducedModel) -> int:
    return 1 + len(model.other_stops)


def _solved(
    model: ReducedModel, cases: Cases, rest_rate: float | None, tolerance: float, assumed: bool,
    most: int,
) -> tuple[Any, partial[NDArray[np.int64]]]:  # fmt: skip
    """Transitions of checked cases, and what tells their premise."""
    kernel, arrival = _kernel(), model.arrival
    settings = Settings(0.0 if rest_rate is None else float(rest_rate), float(tolerance))
    angle = model.touch_angle_rad, float(model.sense)
    machine = kernel.Machine(model.charts, arrival.charts, arrival.turn, angle)
    found = kernel.solve(machine, cases, settings, most, assumed)
    return found, partial(_premise, machine, cases, settings, found)


def _premise(machine: Any, cases: Cases, settings: Settings, found: Any) -> NDArray[np.int64]:
    """Whether machines arrive in their initial phase."""
    if found.premise is None:
        rests = cases.speed * found.rest[:, 0]
        return np.asarray(_kernel().premise_of(machine, cases, settings, found.told, rests))
    return np.asarray(found.premise)


def _cases(
    model: ReducedModel,
    speed_rpm: ArrayLike,
    restitution: ArrayLike | None,
    stiffness: ArrayLike | None,
    preload: ArrayLike | None,
    gravity: ArrayLike | None,
) -> Cases:
    """Numbers of n cases, checked."""
    springs = len(model.springs)
    speed = speeds_of(speed_rpm)
    e_N = column("restitution", model.restitution if restitution is None else restitution,
                  0.0, 1.0)  # fmt: skip
    weight = _weight(model, gravity)
    rates = spring_rows(
        "stiffness", model.stiffness if stiffness is None else stiffness, springs, 0.0
    )
    lengths = spring_rows(
        "preload", model.preload if preload is None else preload, springs, -LARGEST
    )
    speed, e_N, weight, rates, lengths = of_all_cases(speed, e_N, weight, rates, lengths)
    e_N = np.repeat(e_N[:, None], _stops(model), axis=1)
    return Cases(speed * (math.tau / S_PER_MIN), e_N, rates, lengths, weight)


@cache
def _kernel() -> ModuleType:
    """The compiled functions; numba is loaded here."""
    require("study", "numba", what=_ENGINE)
    from .kernels import kernel

    return kernel


def _refusal(
    model: ReducedModel, status: Status, count: int, speed_rpm: float, most: int
) -> NipperError:
    """The error of a transition that did not come to rest."""
    reason = REASONS[status].format(
        travel=model.travel_rad,
        gap=model.gap_max,
        most=most,
        why=model.arrival.why or "its flight before the touch leaves them",
    )
    outside = status in (Status.LEFT_TRAVEL, Status.LEFT_GAP)
    kind = InputError if outside else SimulationError
    message = f"{model.name} at {speed_rpm:g} r/min, after {count} collisions: {reason}"
    return kind(message, status=status.name, collisions=count, speed_rpm=speed_rpm)


def _weight(model: ReducedModel, gravity: ArrayLike | None) -> FloatArray:
    """Gravity by that of the model."""
    if gravity is None:
        return np.ones(1)
    values = column("gravity", gravity, -math.inf, math.inf)
    if model.gravity_m_s2 == 0.0:
        if values.any():
            message = "the model was sampled without gravity; build it from a mechanism that has it"
            raise InputError(message, gravity=gravity)
        return np.zeros(1)
    return np.asarray(values / model.gravity_m_s2)

"""Transitions of a reduced model: one, or a batch of them as arrays."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import FloatArray
from ..errors import InputError, SimulationError
from .model import ReducedModel

ENGINE = "reduced"


class Status(IntEnum):
    """How a transition ended."""

    AT_REST = 0
    """The stop came to rest: the only status with a duration."""
    LEFT_TRAVEL = 1
    """Still bouncing at the largest travel of the model."""
    LEFT_GAP = 2
    """A rebound went beyond the largest gap of the model."""
    OTHER_STOP = 3
    """Another stop closed, or nearly did."""
    NOT_PRESSED = 4
    """The stop came to rest, and nothing presses it shut."""
    TOO_MANY_COLLISIONS = 5
    """More collisions than asked for."""
    UNRESOLVED = 6
    """A flight could not be resolved."""


_REASONS = {
    Status.LEFT_TRAVEL: (
        "the stop is not at rest at the end of the reduced model, a travel of {travel:.4g} rad; "
        "build it with a larger travel_rad, or use the direct engine"
    ),
    Status.LEFT_GAP: (
        "a rebound leaves the reduced model, whose largest gap is {gap:.4g}; build it with a "
        "larger gap_max, or use the direct engine"
    ),
    Status.OTHER_STOP: "another stop closes during the transition; use the direct engine",
    Status.NOT_PRESSED: "the stop is not pressed shut when it is at rest; use the direct engine",
    Status.TOO_MANY_COLLISIONS: (
        "the stop is not at rest after {most} collisions; raise max_collisions, or end the series "
        "by a rate (rest_rate)"
    ),
    Status.UNRESOLVED: "a flight cannot be resolved; use the direct engine",
}


@dataclass(frozen=True, kw_only=True)
class TransitionBatch:
    """Transitions of n cases; entries beyond the last collision of a case are NaN.

    Attributes:
        model: Name of the model.
        status: :class:`Status` of each case, shape (n,).
        collisions: Number of collisions computed, shape (n,).
        duration: Time from the first collision to rest [s], NaN without rest, shape (n,).
        duration_error: Bound on its error [s], shape (n,).
        share: Share of the first two rebounds in the duration, shape (n,).
        error_bound: Bound on the worst relative error of the first two rebound times, the first
            amplitude and the duration, shape (n,).
        time: Times of the collisions from the first one [s], shape (n, most).
        cylinder_angle: psi there [rad], shape (n, most).
        approach_rate: Rate before [rad/s or m/s], negative, shape (n, most).
        separation_rate: Rate after, shape (n, most).
        impulse: Normal impulse at the contact point [N s], shape (n, most).
        energy_lost: Kinetic energy lost [J], shape (n, most).
        rebound_amplitude: Largest coordinate of the rebound after it, shape (n, most).
        rebound_time: Its time [s], shape (n, most).
        time_error: Bound on the error of ``time`` [s], shape (n, most).
        rate_error: Bound on the error of ``approach_rate``, shape (n, most).
        impulse_error: Bound on the error of ``impulse`` [N s], shape (n, most).
        amplitude_error: Bound on the error of ``rebound_amplitude``, shape (n, most).
        rebound_error: Bound on the error of ``rebound_time`` [s], shape (n, most).
        engine: The engine that computed it.
    """

    model: str
    status: NDArray[np.int64]
    collisions: NDArray[np.int64]
    duration: FloatArray
    duration_error: FloatArray
    share: FloatArray
    error_bound: FloatArray
    time: FloatArray = field(repr=False)
    cylinder_angle: FloatArray = field(repr=False)
    approach_rate: FloatArray = field(repr=False)
    separation_rate: FloatArray = field(repr=False)
    impulse: FloatArray = field(repr=False)
    energy_lost: FloatArray = field(repr=False)
    rebound_amplitude: FloatArray = field(repr=False)
    rebound_time: FloatArray = field(repr=False)
    time_error: FloatArray = field(repr=False)
    rate_error: FloatArray = field(repr=False)
    impulse_error: FloatArray = field(repr=False)
    amplitude_error: FloatArray = field(repr=False)
    rebound_error: FloatArray = field(repr=False)
    engine: str = ENGINE


@dataclass(frozen=True, kw_only=True)
class ReducedTransition:
    """One transition that came to rest; arrays of shape (collisions,), else as in a batch.

    Attributes:
        model: Name of the model.
        collisions: Number of collisions computed.
        duration: Time from the first collision to rest [s].
        duration_error: Bound on its error [s].
        share: Share of the first two rebounds in the duration; NaN with fewer.
        error_bound: Bound on the worst relative error of the first two rebound times, the first
            amplitude and the duration.
        time: Times of the collisions [s].
        cylinder_angle: psi there [rad].
        approach_rate: Rate before [rad/s or m/s], negative.
        separation_rate: Rate after.
        impulse: Normal impulse at the contact point [N s].
        energy_lost: Kinetic energy lost [J].
        rebound_amplitude: Largest coordinate of the rebound after it.
        rebound_time: Its time [s].
        time_error: Bound on the error of ``time`` [s].
        rate_error: Bound on the error of ``approach_rate``.
        impulse_error: Bound on the error of ``impulse`` [N s].
        amplitude_error: Bound on the error of ``rebound_amplitude``.
        rebound_error: Bound on the error of ``rebound_time`` [s].
        engine: The engine that computed it.
    """

    model: str
    collisions: int
    duration: float
    duration_error: float
    share: float
    error_bound: float
    time: FloatArray
    cylinder_angle: FloatArray
    approach_rate: FloatArray
    separation_rate: FloatArray
    impulse: FloatArray
    energy_lost: FloatArray
    rebound_amplitude: FloatArray
    rebound_time: FloatArray
    time_error: FloatArray
    rate_error: FloatArray
    impulse_error: FloatArray
    amplitude_error: FloatArray
    rebound_error: FloatArray
    engine: str = ENGINE


_ROWS = (
    "time", "cylinder_angle", "approach_rate", "separation_rate", "impulse", "energy_lost",
    "rebound_amplitude", "rebound_time", "time_error", "rate_error", "impulse_error",
    "amplitude_error", "rebound_error",
)  # fmt: skip


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
) -> ReducedTransition:
    """Solve one transition.

    Args:
        model: The reduced model.
        speed_rpm: Cylinder speed [r/min].
        restitution: e_N of the transition stop; by default that of the mechanism.
        stiffness: Spring rates, one number or shape (springs,) [N/m or N m/rad].
        preload: Deflections in the springs at zero, likewise [m or rad].
        gravity: Gravity along -z [m/s^2].
        rest_rate: None: the limit of the series. A number: rest at the first slower rebound.
        tolerance: Relative accuracy of flights and of the limit.
        max_collisions: Largest number of collisions.

    Returns:
        The transition.

    Raises:
        InputError: A parameter is out of range, or the case leaves the domain of the model.
        SimulationError: The stop does not come to rest, or another stop takes part.
    """
    batch = transitions(
        model,
        speed_rpm=np.array([speed_rpm]),
        restitution=restitution,
        stiffness=None if stiffness is None else np.atleast_1d(np.asarray(stiffness))[None],
        preload=None if preload is None else np.atleast_1d(np.asarray(preload))[None],
        gravity=gravity,
        rest_rate=rest_rate,
        tolerance=tolerance,
        max_collisions=max_collisions,
    )
    status, count = Status(int(batch.status[0])), int(batch.collisions[0])
    if status is not Status.AT_REST:
        reason = _REASONS[status].format(
            travel=model.travel_rad, gap=model.gap_max, most=max_collisions
        )
        outside = status in (Status.LEFT_TRAVEL, Status.LEFT_GAP)
        kind = InputError if outside else SimulationError
        message = f"{model.name} at {speed_rpm:g} r/min, after {count} collisions: {reason}"
        raise kind(message, status=status.name, collisions=count, speed_rpm=speed_rpm)
    return ReducedTransition(
        model=model.name,
        collisions=count,
        duration=float(batch.duration[0]),
        duration_error=float(batch.duration_error[0]),
        share=float(batch.share[0]),
        error_bound=float(batch.error_bound[0]),
        **{name: getattr(batch, name)[0, :count] for name in _ROWS},
    )


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
) -> TransitionBatch:
    """Solve many transitions in compiled code; a case is the same to the last bit alone.

    Args:
        model: The reduced model.
        speed_rpm: Cylinder speeds [r/min], a number or shape (n,); so are all the others.
        restitution: e_N of the transition stop.
        stiffness: Spring rates, shape (n,) with one spring or (n, springs) [N/m or N m/rad].
        preload: Deflections in the springs at zero, likewise [m or rad].
        gravity: Gravity along -z [m/s^2].
        rest_rate: None: the limit of the series. A number: rest at the first slower rebound.
        tolerance: Relative accuracy of flights and of the limit.
        max_collisions: Largest number of collisions of a case, and columns of the tables.

    Returns:
        The batch; cases that did not come to rest are marked by their status.

    Raises:
        InputError: A parameter is out of range.
    """
    # numba is loaded by those who compute, not by those who import.
    from . import kernel, machine
    from .layout import COLUMNS

    springs = len(model.springs)
    speed = _column("speed_rpm", speed_rpm, 0.0, math.inf, open_low=True)
    e_N = _column("restitution", model.restitution if restitution is None else restitution,
                  0.0, 1.0)  # fmt: skip
    weight = _weight(model, gravity)
    rates = _springs("stiffness", model.stiffness if stiffness is None else stiffness, springs, 0.0)
    lengths = _springs("preload", model.preload if preload is None else preload, springs, -math.inf)
    if not 1e-13 <= tolerance <= 1e-3 or max_collisions < 1:
        message = "tolerance must lie in 1e-13 to 1e-3, and max_collisions be at least 1"
        raise InputError(message, tolerance=tolerance, max_collisions=max_collisions)
    if rest_rate is not None and not (math.isfinite(rest_rate) and rest_rate > 0.0):
        message = f"rest_rate = {rest_rate!r} cannot be used: a finite rate above 0, or none"
        raise InputError(message, rest_rate=rest_rate)
    try:
        (n,) = np.broadcast_shapes(speed.shape, e_N.shape, weight.shape, rates.shape[:1],
                                   lengths.shape[:1])  # fmt: skip
    except ValueError as error:
        message = f"the arrays of a batch need the same number of cases: {error}"
        raise InputError(message) from error
    table = np.full((n, COLUMNS, max_collisions), np.nan)
    status, counts = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64)
    rest = np.empty((n, 2))
    kernel.run_batch(
        machine.grids(),
        machine.tables(model),
        machine.work(model, max_collisions),
        _full(speed * (math.tau / 60.0), (n,)),
        _full(e_N, (n,)),
        _full(rates, (n, springs)),
        _full(lengths, (n, springs)),
        _full(weight, (n,)),
        0.0 if rest_rate is None else float(rest_rate),
        tolerance,
        table,
        status,
        counts,
        rest,
    )
    return _batch(model, table, status, counts, rest)


def _batch(
    model: ReducedModel,
    table: FloatArray,
    status: NDArray[np.int64],
    counts: NDArray[np.int64],
    rest: FloatArray,
) -> TransitionBatch:
    """Name the rows of the table and add what follows from them."""
    rows = {name: table[:, row] for row, name in enumerate(_ROWS)}
    rows["cylinder_angle"] = model.touch_angle_rad + model.sense * rows["cylinder_angle"]
    for name in ("impulse", "impulse_error"):
        rows[name] = rows[name] / model.lever
    rest = np.where((status == Status.AT_REST)[:, None], rest, np.nan)
    duration, error = rest[:, 0], rest[:, 1]
    share = np.full(len(status), np.nan)
    if table.shape[2] > 2:
        moving = (duration > 0.0) & (counts > 2)
        share[moving] = rows["time"][moving, 2] / duration[moving]
    pairs = [(error, duration), (rows["amplitude_error"][:, 0], rows["rebound_amplitude"][:, 0])]
    pairs += [
        (rows["rebound_error"][:, i], rows["rebound_time"][:, i])
        for i in range(min(2, table.shape[2]))
    ]
    bound = np.where(status == Status.AT_REST, 0.0, np.nan)
    for absolute, value in pairs:
        known = value > 0.0
        bound[known] = np.maximum(bound[known], absolute[known] / value[known])
    return TransitionBatch(
        model=model.name,
        status=status,
        collisions=counts,
        duration=duration,
        duration_error=error,
        share=share,
        error_bound=bound,
        engine=ENGINE,
        **rows,
    )


def _weight(model: ReducedModel, gravity: ArrayLike | None) -> FloatArray:
    """Gravity by that of the model."""
    if gravity is None:
        return np.ones(1)
    values = _column("gravity", gravity, -math.inf, math.inf)
    if model.gravity_m_s2 == 0.0:
        if values.any():
            message = "the model was sampled without gravity; build it from a mechanism that has it"
            raise InputError(message, gravity=gravity)
        return np.zeros(1)
    return np.asarray(values / model.gravity_m_s2)


def _column(
    key: str, value: ArrayLike, low: float, high: float, *, open_low: bool = False
) -> FloatArray:
    """One number a case, checked, shape (1,) or (n,)."""
    found = np.atleast_1d(np.asarray(value, dtype=np.float64))
    right = np.isfinite(found) & (found <= high) & ((found > low) if open_low else (found >= low))
    if found.ndim != 1 or not right.all():
        bound = "above" if open_low else "from"
        allowed = f"finite numbers {bound} {low:g} to {high:g}, one a case"
        message = f"{key} = {value!r} cannot be used: {allowed}"
        raise InputError(message, key=key, value=value, allowed=allowed)
    return found


def _springs(key: str, value: ArrayLike, springs: int, low: float) -> FloatArray:
    """One row of spring values a case, checked, shape (1 or n, springs)."""
    found = np.asarray(value, dtype=np.float64)
    if found.ndim == 0:
        found = np.full((1, springs), float(found))
    elif found.ndim == 1:
        found = found[:, None] if springs == 1 else found[None]
    if (
        found.ndim != 2
        or found.shape[1] != springs
        or not np.isfinite(found).all()
        or (found < low).any()
    ):
        allowed = f"finite numbers from {low:g}, one for each of {springs} springs"
        message = f"{key} = {value!r} cannot be used: {allowed}"
        raise InputError(message, key=key, value=value, allowed=allowed)
    return found


def _full(values: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    return np.ascontiguousarray(np.broadcast_to(values, shape))

"""Sensitivities of bounces and forces to every number of a model, found in two ways.

What is asked is the relative change of a quantity by a number of the model, at the model's own
values. Directly: transitions by the direct engine, forces by kinematics and inverse dynamics, and
central differences with Richardson's extrapolation. For control: transitions by the reduced engine
(other tables, other solver), forces from a simulated cycle, and one-step central differences of
half the step. The two agree to the truncation of the second.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..errors import SimulationError
from ..given import MOST_WORKERS, number, whole
from ..hybrid import FASTEST_RPM, Case, Window, simulate
from ..mechanism import Mechanism, changed, layout_of, numbers_of, rad_s_from_rpm
from ..reduced import build, transition
from ..tolerances.study import DOUBTFUL, SMALL_EFFECT, STUDY_TOLERANCE
from .identify.problem.targets import Condition, transition_quantities
from .identify.problem.working_cycle import middle_half, working_cycle
from .processes import mapped
from .steps import step_of

QUANTITIES = ("rebound_amplitude_1", "duration_s", "clamping_force_N")
"""Amplitude of the first rebound; time from the first collision to rest; mean lip force over the
middle half of the closed phase."""

SPEED = "speed_rpm"
"""The path of the cylinder speed, which is a setting and no number of the model."""


_SAMPLES = 48
# What the tables of the reduced engine cover, by what the transition needs.
_ROOM = 1.5
# Numbers of the document that neither bounces nor lip forces see while the drives are held, and
# places of shafts, which go with their points.
_UNSEEN = (
    "crank_axis_mm",
    "guide_axis_mm",
    "rated_speed_rpm",
    "reference_angle_deg",
    "reference_index",
    "reflected_inertia_kg_m2",
    "reflected_mass_kg",
    "shaft_damping_ratio",
    "shaft_frequency_hz",
)


@dataclass(frozen=True, kw_only=True)
class Sensitivity:
    """How quantities change with one number of the model.

    Attributes:
        path: The number.
        unit: Unit of ``per``: "mm", "deg", "%" of the value for all others, or an amount (such as
            "0.01" of a restitution) where the value is smaller than that.
        per: Relative change of each of :data:`QUANTITIES` for one unit more [%], as a function of
            the first order, shape (3,).
        control: The same, found in the other way, shape (3,).
    """

    path: str
    value: float
    unit: str
    per: FloatArray
    control: FloatArray

    @property
    def disagreement(self) -> float:
        """Largest difference between the two ways [% per unit]."""
        return float(np.abs(self.per - self.control).max())

    @property
    def doubtful(self) -> bool:
        """Whether the two ways disagree by more than the truncation of either explains."""
        largest = max(SMALL_EFFECT, float(np.abs(self.per).max()))
        return not self.disagreement <= DOUBTFUL * largest


@dataclass(frozen=True, kw_only=True)
class Sensitivities:
    """Sensitivities of one model at one speed.

    Attributes:
        model: Name of the model.
        stop: Name of its transition stop.
        premise_holds: Whether the machine arrives as a transition assumes; where it does not,
            amplitude and time are those of the turn.
        amplitude_rad: First rebound amplitude [rad].
        transition_time_s: Time from the first collision to rest [s].
        clamping_force_N: Mean lip force over the middle half of the closed phase [N].
        rows: One for every number, in the order of the model.
    """

    model: str
    stop: str
    speed_rpm: float
    premise_holds: bool | None
    amplitude_rad: float
    transition_time_s: float
    clamping_force_N: float
    rows: tuple[Sensitivity, ...]

    def ranked(self, quantity: str) -> tuple[Sensitivity, ...]:
        """Rows by the size of their effect on a quantity, the largest first."""
        place = QUANTITIES.index(quantity)
        return tuple(sorted(self.rows, key=lambda row: -abs(row.per[place])))

    def record(self) -> dict[str, Any]:
        """Return the sensitivities as plain data."""
        return {
            "model": self.model,
            "speed_rpm": self.speed_rpm,
            "premise_holds": self.premise_holds,
            "rebound_amplitude_1": self.amplitude_rad,
            "duration_s": self.transition_time_s,
            "mean_clamping_force_N": self.clamping_force_N,
            "percent_per_unit": [
                {
                    "path": row.path,
                    "value": row.value,
                    "unit": row.unit,
                    **dict(zip(QUANTITIES, row.per.tolist(), strict=True)),
                    "disagreement_of_two_ways": row.disagreement,
                    "doubtful": row.doubtful,
                }
                for row in self.rows
            ],
        }


def every_path(mechanism: Mechanism) -> tuple[str, ...]:
    """Paths of all numbers of a model that bounces and lip forces can depend on."""
    found = layout_of(mechanism)
    paths = [SPEED]
    for table in ("cylinder", "drives", "springs", "dampers", "forces", "stops"):
        paths.extend(_numbers(mechanism.description.get(table), table))
    driven = {mechanism.joints[drive.index].name for drive in mechanism.drives}
    for name, pin in found.meeting.items():
        # A closure is one pin with two names; the second one is used.
        if len(pin) == 1 or name == pin[-1]:
            crank = len(pin) > 1 and found.carried_by(name) in driven
            axes = ("radius_mm", "angle_deg") if crank else ("x_mm", "z_mm")
            paths.extend(f"points.{name}.{axis}" for axis in axes)
    for link in mechanism.links:
        keys = ("mass_kg", "gyration_mm", "com_x_mm", "com_z_mm")
        paths.extend(f"links.{link}.{key}" for key in keys)
    return tuple(paths)


def _numbers(value: object, path: str) -> list[str]:
    """Paths of the numbers below a path of the document."""
    if isinstance(value, Mapping):
        inner = value.items()
        return [item for key, part in inner for item in _numbers(part, f"{path}.{key}")]
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return [path] if number and path.rsplit(".", 1)[-1] not in _UNSEEN else []


def sensitivities(
    mechanism: Mechanism,
    speed_rpm: float,
    paths: Sequence[str] | None = None,
    progress: Callable[[int, int], None] | None = None,
    workers: int = 1,
) -> Sensitivities:
    """Find the sensitivities of a model.

    Args:
        mechanism: The model; the values in it are the baseline.
        paths: Numbers to ask for; by default :func:`every_path`.
        progress: Called with (numbers done, numbers in all).
        workers: Processes; 1: one. Neither their number nor that of threads of BLAS changes a bit
            of the result.

    Raises:
        UnknownNameError: A path leads nowhere.
        InputError: The model has no working cycle of two phases without freedom.
        SimulationError: The model cannot be simulated, or not with slightly changed numbers.
    """
    speed_rpm = number("speed_rpm", speed_rpm, 0.0, FASTEST_RPM, open_low=True)
    whole("workers", workers, 1, MOST_WORKERS)
    chosen = every_path(mechanism) if paths is None else tuple(paths)
    inner = [path for path in chosen if path != SPEED]
    values = dict(zip(inner, numbers_of(mechanism, inner), strict=True))
    values[SPEED] = speed_rpm
    ((premise, here),) = mapped(partial(_baseline, mechanism), [speed_rpm], 1)
    if not (here > 0.0).all():
        none = [name for name, value in zip(QUANTITIES, here, strict=True) if not value > 0.0]
        message = (
            f"{mechanism.name} at {speed_rpm:g} r/min: {', '.join(none)} is zero or does not "
            "exist, so that nothing changes it by a percentage; change the model or the speed"
        )
        raise SimulationError(message, quantities=none)
    find = partial(_row, mechanism, speed_rpm, here, premise is False)
    rows = []
    for row in mapped(find, [(path, values[path]) for path in chosen], workers):
        rows.append(row)
        if progress is not None:
            progress(len(rows), len(chosen))
    return Sensitivities(
        model=mechanism.name,
        stop=mechanism.transition_stop,
        speed_rpm=speed_rpm,
        premise_holds=premise,
        amplitude_rad=float(here[0]),
        transition_time_s=float(here[1]),
        clamping_force_N=float(here[2]),
        rows=tuple(rows),
    )


def _baseline(mechanism: Mechanism, speed_rpm: float) -> tuple[bool | None, FloatArray]:
    """Whether the premise of a transition holds, and the quantities."""
    premise = simulate(mechanism, Case(speed_rpm=speed_rpm)).premise_holds
    return premise, _direct(mechanism, speed_rpm, true=premise is False)


def _row(
    mechanism: Mechanism,
    speed_rpm: float,
    here: FloatArray,
    true: bool,
    number: tuple[str, float],
) -> Sensitivity:
    """Find the effect of one number, in both ways."""
    path, value = number
    step = step_of(path, value)
    control = replace(step, half_width=0.5 * step.half_width)

    def at(find: Callable[[Mechanism, float], FloatArray], x: float) -> FloatArray:
        if path == SPEED:
            return find(mechanism, x)
        return find(changed(mechanism, {path: x}), speed_rpm)

    scale = 100.0 * step.amount / here
    return Sensitivity(
        path=path,
        value=value,
        unit=step.unit,
        per=scale * step.extrapolated(partial(at, partial(_direct, true=true)), value),
        control=scale * control.slope(partial(at, partial(_other, near=here, true=true)), value),
    )


def _direct(mechanism: Mechanism, speed_rpm: float, *, true: bool) -> FloatArray:
    """The quantities by the direct engine, of the turn or as assumed, and by kinematics."""
    found = transition_quantities(mechanism, Condition(speed_rpm), STUDY_TOLERANCE, None, true=true)
    force = working_cycle(mechanism, speed_rpm).clamping_force
    return np.array([found["rebound_amplitude_1"], found["duration_s"], force])


def _other(mechanism: Mechanism, speed_rpm: float, near: FloatArray, *, true: bool) -> FloatArray:
    """The quantities by the reduced engine and from a simulated cycle.

    Args:
        near: Quantities of a mechanism nearby, shape (3,); they say how much to tabulate.
        true: Whether to solve the transition of the turn.
    """
    # Only tables of a whole turn determine how the machine arrives.
    travel = min(_ROOM * rad_s_from_rpm(speed_rpm) * float(near[1]), math.tau)
    model = (
        build(mechanism)
        if true
        else build(mechanism, travel_rad=travel, gap_max=_ROOM * float(near[0]), turn=False)
    )
    found = transition(model, speed_rpm=speed_rpm, assumed=not true)
    solution = simulate(mechanism, Case(speed_rpm=speed_rpm, window=Window.CYCLE))
    stop = mechanism.transition_stop
    closing = next(item.t for item in solution.collisions if item.stop == stop)
    opening = next(
        event.t
        for event in solution.events
        if stop in event.closed_before and stop not in event.closed_after
    )
    places, weights = middle_half(closing, opening)
    force = float(weights @ solution.trajectory.reactions(places).contacts[stop])
    return np.array([found.rebound_amplitude[0], found.duration, force])

"""Sensitivities of bounces and forces to every number of a model, found in two ways.

What is asked is the relative change of a quantity by a number of the model, at the model's own
values. Directly: transitions by the direct engine, forces by kinematics and inverse dynamics, and
central differences with Richardson's extrapolation. For control: transitions by the reduced engine
(other tables, other solver), forces from a simulated cycle, and one-step central differences of
half the step. The two agree to the truncation of the second.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..hybrid.case import Case, Window
from ..hybrid.simulate import simulate
from ..mechanism import Mechanism
from ..reduced import build, transition
from .identify.geometry import Sources, layout
from .identify.parameters import read_values, with_values
from .identify.targets import Condition, transition_quantities
from .identify.working import middle_half, working_cycle
from .processes import mapped

QUANTITIES = ("first_rebound_amplitude", "transition_time", "clamping_force")
"""Amplitude of the first rebound; time from the first collision to rest; mean lip force over the
middle half of the closed phase."""

SPEED = "speed_rpm"
"""The path of the cylinder speed, which is a setting and no number of the model."""

_TOLERANCE = 1e-12
_SAMPLES = 48
# Half widths of the differences: of a length [mm], of an angle [deg], of all others by their value.
_STEPS = {"_mm": 0.05, "_deg": 0.05}
_RELATIVE_STEP = 2e-3
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
        value: Its value.
        unit: Unit of ``per``: "mm", "deg", or "%" of the value for all others.
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


@dataclass(frozen=True, kw_only=True)
class Sensitivities:
    """Sensitivities of one model at one speed.

    Attributes:
        model: Name of the model.
        speed_rpm: Cylinder speed [r/min].
        amplitude_rad: First rebound amplitude [rad].
        transition_time_s: Time from the first collision to rest [s].
        clamping_force_N: Mean lip force over the middle half of the closed phase [N].
        rows: One for every number, in the order of the model.
    """

    model: str
    speed_rpm: float
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
            "first_rebound_amplitude_rad": self.amplitude_rad,
            "transition_time_s": self.transition_time_s,
            "mean_clamping_force_N": self.clamping_force_N,
            "percent_per_unit": [
                {
                    "path": row.path,
                    "value": row.value,
                    "unit": row.unit,
                    **dict(zip(QUANTITIES, row.per.tolist(), strict=True)),
                    "disagreement_of_two_ways": row.disagreement,
                }
                for row in self.rows
            ],
        }


def every_path(mechanism: Mechanism) -> tuple[str, ...]:
    """Paths of all numbers of a model that bounces and lip forces can depend on.

    Args:
        mechanism: The model.
    """
    sources = Sources.of(mechanism)
    found = layout(sources)
    paths = [SPEED]
    for table in ("cylinder", "drives", "springs", "stops"):
        paths.extend(_numbers(sources.document.get(table), table))
    driven = {mechanism.joints[drive.index].name for drive in mechanism.drives}
    for name, pin in found.meeting.items():
        # A closure is one pin under two names: the second one is asked for.
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
        speed_rpm: Cylinder speed [r/min].
        paths: Numbers to ask for; by default :func:`every_path`.
        progress: Called with (numbers done, numbers in all).
        workers: Processes; 1: this process alone. Their number does not change a bit of the result.

    Raises:
        UnknownNameError: A path leads nowhere.
        InputError: The model has no working cycle of two phases without freedom.
        SimulationError: The model cannot be simulated, or not with slightly changed numbers.
    """
    chosen = every_path(mechanism) if paths is None else tuple(paths)
    sources = Sources.of(mechanism)
    inner = [path for path in chosen if path != SPEED]
    values = dict(zip(inner, read_values(sources, inner), strict=True))
    values[SPEED] = speed_rpm
    here = _direct(mechanism, speed_rpm)
    find = partial(_row, sources, speed_rpm, here)
    rows = []
    for row in mapped(find, [(path, values[path]) for path in chosen], workers):
        rows.append(row)
        if progress is not None:
            progress(len(rows), len(chosen))
    return Sensitivities(
        model=mechanism.name,
        speed_rpm=speed_rpm,
        amplitude_rad=float(here[0]),
        transition_time_s=float(here[1]),
        clamping_force_N=float(here[2]),
        rows=tuple(rows),
    )


def _row(
    sources: Sources, speed_rpm: float, here: FloatArray, number: tuple[str, float]
) -> Sensitivity:
    """Find the effect of one number, in both ways."""
    path, value = number
    unit, step = _unit(path, value)

    def at(find: Callable[[Mechanism, float], FloatArray], x: float) -> FloatArray:
        if path == SPEED:
            return find(sources.build(), x)
        return find(with_values(sources, {path: x}).build(), speed_rpm)

    narrow, wide = (
        (at(_direct, value + h) - at(_direct, value - h)) / (2.0 * h) for h in (step, 2.0 * step)
    )
    h = 0.5 * step
    control = (at(_other, value + h) - at(_other, value - h)) / (2.0 * h)
    # 1 % of the value, or one unit, in percent of the quantity.
    scale = (value if unit == "%" else 100.0) / here
    return Sensitivity(
        path=path,
        value=value,
        unit=unit,
        per=scale * (4.0 * narrow - wide) / 3.0,
        control=scale * control,
    )


def _unit(path: str, value: float) -> tuple[str, float]:
    """Unit of one number and the half width of its differences."""
    for ending, step in _STEPS.items():
        if path.endswith(ending):
            return ending[1:], step
    return "%", _RELATIVE_STEP * abs(value)


def _direct(mechanism: Mechanism, speed_rpm: float) -> FloatArray:
    """The quantities by the direct engine and by kinematics."""
    found = transition_quantities(mechanism, Condition(speed_rpm), _TOLERANCE, None)
    force = working_cycle(mechanism, speed_rpm).clamping_force
    return np.array([found["first_rebound_amplitude"], found["transition_time"], force])


def _other(mechanism: Mechanism, speed_rpm: float) -> FloatArray:
    """The quantities by the reduced engine and from a simulated cycle."""
    found = transition(build(mechanism), speed_rpm=speed_rpm)
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


_WORDS = {
    "points": {
        "x_mm": "pin {} forward",
        "z_mm": "pin {} upward",
        "radius_mm": "distance of pin {} from its shaft",
        "angle_deg": "angle of pin {} about its shaft",
    },
    "links": {
        "mass_kg": "mass of {}",
        "gyration_mm": "radius of gyration of {}",
        "com_x_mm": "centre of mass of {} forward",
        "com_z_mm": "centre of mass of {} upward",
    },
}
_SAID = ("first bounce", "transition", "clamping force")
_FEW = 3
_NOTHING = 1e-6
_GAIN = 10.0
# Larger changes than these are no longer small, and the sentences would not hold.
_SMALL = {"mm": 5.0, "deg": 5.0, "%": 20.0}


def label(path: str) -> str:
    """A number of the model in words.

    Args:
        path: Its path.
    """
    steps = path.split(".")
    if len(steps) == 3 and steps[2] in _WORDS.get(steps[0], {}):
        return _WORDS[steps[0]][steps[2]].format(steps[1].replace("_", " ").removesuffix(" pin"))
    last = steps[-1]
    for ending in ("_N_per_m", "_N_m_per_rad", "_mm", "_deg", "_rpm"):
        last = last.removesuffix(ending)
    words = last.replace("_", " ")
    if len(steps) == 3:
        return f"{words} of {steps[0].removesuffix('s')} {steps[1].replace('_', ' ')}"
    return f"cylinder {words}" if steps[0] in (SPEED, "cylinder") else words


def conclusions(found: Sensitivities) -> tuple[str, ...]:
    """What the sensitivities mean to whoever designs or sets the machine, in sentences.

    Args:
        found: The sensitivities.

    Returns:
        Sentences made from the numbers; they hold for small changes of one number at a time.
    """
    bounce, lasts, clamp = (
        1e3 * found.amplitude_rad,
        1e3 * found.transition_time_s,
        found.clamping_force_N,
    )
    text = [
        f"{found.model} at {found.speed_rpm:g} r/min: the first bounce opens the jaw by "
        f"{bounce:.3g} mrad, it is at rest after {lasts:.3g} ms, and the lips then press with "
        f"{clamp:.3g} N."
    ]
    by_path = {row.path: row for row in found.rows}
    if SPEED in by_path:
        faster = by_path[SPEED].per
        text.append(
            f"1 % more speed makes the first bounce {_more(faster[0], 'higher', 'lower')}, the "
            f"transition {_more(faster[1], 'longer', 'shorter')} and the clamping force "
            f"{_more(faster[2], 'larger', 'smaller')}."
        )
    for place, quantity in enumerate(QUANTITIES):
        for unit, one in (("mm", "1 mm"), ("deg", "1 degree"), ("%", "1 %")):
            text.extend(_strongest(found, quantity, place, unit, one))
    gain = [row for row in found.rows if _helps(row)]
    if gain:
        text.append(
            "These calm the bounce and press harder at the same time: "
            + "; ".join(_dose(row) for row in sorted(gain, key=_worth)[:_FEW])
            + "."
        )
    still = [row.path for row in found.rows if np.abs(row.per).max() < _NOTHING]
    if still:
        links = sorted({path.split(".")[1] for path in still if path.startswith("links.")})
        others = [label(path) for path in still if not path.startswith("links.")]
        named = [*others, *(f"mass and inertia of {link.replace('_', ' ')}" for link in links)]
        text.append(
            "Without any effect while the shafts hold their speed: " + ", ".join(named) + "."
        )
    return tuple(text)


def _strongest(
    found: Sensitivities, quantity: str, place: int, unit: str, one: str
) -> tuple[str, ...]:
    """The sentence on the numbers of one unit that change a quantity most."""
    rows = [
        row
        for row in found.ranked(quantity)
        if row.unit == unit and row.path != SPEED and abs(row.per[place]) >= _NOTHING
    ][:_FEW]
    if not rows:
        return ()
    items = ", ".join(f"{label(row.path)} {row.per[place]:+.2g} %" for row in rows)
    return (f"What {one} more changes the {_SAID[place]} by, the strongest first: {items}.",)


def _more(percent: float, up: str, down: str) -> str:
    return f"{abs(percent):.2g} % {up if percent > 0.0 else down}"


def _helps(row: Sensitivity) -> bool:
    """Whether a small change lowers bounce and time by enough, and raises the force."""
    bounce, lasts, clamp = row.per
    sense = -1.0 if bounce > 0.0 else 1.0
    small = abs(bounce) * _SMALL[row.unit] >= _GAIN
    adjustable = row.path != SPEED and not row.path.startswith("stops.")
    return bool(small and adjustable and sense * lasts < 0.0 < sense * clamp)


def _worth(row: Sensitivity) -> float:
    """Gain of clamping force, negative, for a first bounce lower by a given part."""
    return float(row.per[2] / row.per[0])


def _dose(row: Sensitivity) -> str:
    change = -_GAIN / row.per[0]
    unit = {"deg": "degrees"}.get(row.unit, row.unit)
    return (
        f"{label(row.path)} {change:+.2g} {unit} for a bounce lower by {_GAIN:g} % "
        f"(clamping force {change * row.per[2]:+.2g} %)"
    )

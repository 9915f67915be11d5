"""Numbers of a mechanism that the sliders set, with their units and ranges."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ...errors import InputError
from ...hybrid.result.quantities import coordinate_unit
from ...mechanism import Mechanism, Spring, retuned
from ...units import M_PER_MM, MM_PER_M, RAD_PER_DEG

SPEED = "speed"
LARGER = "larger"
RESTITUTION = "restitution"
_MOST_RESTITUTION = 0.8
_MOST_LARGER = 50.0
# A range ends at these parts of the value that the model has.
_SPEED_RANGE = (0.4, 2.0)
_SPRING_RANGE = (0.25, 2.5)
_STEPS_OF_VALUE = 50.0
# Scale of a preload that is zero in the model: an angle, or a part of the mechanism's reach.
_PRELOAD_ANGLE = math.radians(10.0)
_PRELOAD_STROKE = 0.02


@dataclass(frozen=True, kw_only=True)
class Knob:
    """One number that a slider sets, in the unit that people read.

    Attributes:
        key: Name of the number among the values of a setting.
        unit: Unit of the values below.
        factor: SI value of one unit.
        low: Left end.
        high: Right end.
        start: Where the slider stands at first.
    """

    key: str
    name: str
    unit: str
    factor: float
    low: float
    high: float
    step: float
    start: float

    @property
    def label(self) -> str:
        """What the slider is called, unit included."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


def knobs(mechanism: Mechanism, speed_rpm: float) -> tuple[Knob, ...]:
    """Sliders of a mechanism: speed, restitution, and rate and preload of every spring.

    Args:
        mechanism: The mechanism; its values are where the sliders start.
        speed_rpm: Speed at which the slider starts [r/min].

    Raises:
        InputError: The mechanism has no transition that could be shown, or the speed cannot be
            used.
    """
    if not any(stop.name == mechanism.transition_stop for stop in mechanism.stops):
        message = (
            f"{mechanism.name} has no transition stop, so there are no rebounds that could follow "
            "a slider; name one in its TOML file (transition_stop)"
        )
        raise InputError(message, model=mechanism.name)
    if not mechanism.drives:
        message = (
            f"{mechanism.name} has no drive that closes its stop in the touch configuration, where "
            "a transition starts, so there are no rebounds that could follow a slider: view it in "
            "whole turns (nipper-pin view, window cycle)"
        )
        raise InputError(message, model=mechanism.name)
    if not (math.isfinite(speed_rpm) and speed_rpm > 0.0):
        message = f"--speed {speed_rpm:g} cannot be used: a finite speed above 0 r/min"
        raise InputError(message, speed_rpm=speed_rpm)
    rated = mechanism.cylinder.rated_speed_rpm
    stop = mechanism.stop(mechanism.transition_stop)
    found = [
        _knob(SPEED, "speed", "r/min", 1.0, rated, _SPEED_RANGE, speed_rpm),
        Knob(
            key=RESTITUTION, name=f"restitution of the {stop.name}", unit="", factor=1.0, low=0.0,
            high=max(_MOST_RESTITUTION, stop.restitution), step=0.01, start=stop.restitution,
        ),
    ]  # fmt: skip
    for spring in mechanism.springs:
        found += _spring_knobs(mechanism, spring)
    return tuple(found)


def larger_knob(start: float) -> Knob:
    """How much larger rebounds are drawn, at first by a factor."""
    return Knob(
        key=LARGER, name="rebounds drawn larger", unit="times", factor=1.0, low=1.0,
        high=max(start, _MOST_LARGER), step=1.0, start=start,
    )  # fmt: skip


def changed(mechanism: Mechanism, values: Mapping[str, float]) -> Mechanism:
    """The mechanism with the values of a setting; its tree is not built again.

    Args:
        values: Values in SI units, by key of the knobs.
    """
    return retuned(
        mechanism,
        restitution={mechanism.transition_stop: values[RESTITUTION]},
        stiffness=[
            values.get(_key(spring, "stiffness"), spring.stiffness) for spring in mechanism.springs
        ],
        preload=[values[_key(spring, "preload")] for spring in mechanism.springs],
    )


def _spring_knobs(mechanism: Mechanism, spring: Spring) -> list[Knob]:
    """Rate, unless the model has none to start from, and preload of one spring."""
    turns = coordinate_unit(mechanism, spring.index) == "rad"
    of = "" if len(mechanism.springs) == 1 else f" of spring {spring.name}"
    rate, length = ("N m/rad", "deg") if turns else ("N/mm", "mm")
    rate_factor, length_factor = (1.0, RAD_PER_DEG) if turns else (MM_PER_M, M_PER_MM)
    found = []
    if spring.stiffness > 0.0:
        found.append(
            _knob(_key(spring, "stiffness"), f"stiffness{of}", rate, rate_factor,
                  spring.stiffness, _SPRING_RANGE, spring.stiffness)
        )  # fmt: skip
    scale = spring.preload or (_PRELOAD_ANGLE if turns else _PRELOAD_STROKE * mechanism.reach_m)
    found.append(
        _knob(_key(spring, "preload"), f"preload{of}", length, length_factor,
              scale, (0.0, _SPRING_RANGE[1]), spring.preload)
    )  # fmt: skip
    return found


def _key(spring: Spring, what: str) -> str:
    return f"{spring.name}.{what}"


def _knob(
    key: str,
    name: str,
    unit: str,
    factor: float,
    scale: float,
    ends: tuple[float, float],
    start: float,
) -> Knob:
    """A knob whose ends and step are round numbers; the ends hold the start between them.

    Args:
        unit: Unit that people read.
        factor: SI value of one unit.
        scale: Usual value, SI.
        ends: Ends of the range, in parts of the usual value.
        start: First value, SI.
    """
    shown, first = scale / factor, start / factor
    step = _round_step(abs(shown) / _STEPS_OF_VALUE)
    low, high = sorted(part * shown for part in ends)
    # Twelve digits drop what binary fractions add to a multiple of the step.
    low, high, first = (
        float(f"{value:.12g}")
        for value in (step * math.floor(low / step), step * math.ceil(high / step), first)
    )
    return Knob(
        key=key,
        name=name,
        unit=unit,
        factor=factor,
        low=min(low, first),
        high=max(high, first),
        step=step,
        start=first,
    )


def _round_step(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above a value."""
    power = 10.0 ** math.floor(math.log10(value))
    return float(f"{power * max(part for part in (1, 2, 5) if part * power <= value):.12g}")
